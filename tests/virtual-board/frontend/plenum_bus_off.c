// SPDX-License-Identifier: GPL-2.0
/*
 * Brings a CAN controller to bus-off: echo can0 >/sys/module/plenum_bus_off/parameters/interface
 *
 * qemu's bus has no errors, and its SJA1000 no count of them. So this plays what the chip does by itself when that count runs
 * over: it goes into its reset mode, in which nothing comes in or goes out, and says so in an interrupt. The driver asks the
 * registers what it was, and is answered from here while it does. All that follows is the driver's and the kernel's own: the error
 * frame, the carrier that goes, the restart, which takes the chip out of its reset mode again.
 */
#include <linux/interrupt.h>
#include <linux/irq_work.h>
#include <linux/kprobes.h>
#include <linux/module.h>
#include <linux/netdevice.h>
#include <linux/pci.h>
#include <linux/string.h>

/* Of kvaser_pci: the registers' place. Of the SJA1000: registers, and what they hold. */
#define REGISTERS_BAR 1
#define MODE 0
#define MODE_RESET 0x01
#define STATUS 2
#define STATUS_BUS_OFF 0x80
#define STATUS_ERRORS 0x40 /* more than 95 */
#define INTERRUPT 3
#define INTERRUPT_ERRORS 0x04 /* one of the two bits of the status has changed */

irqreturn_t sja1000_interrupt(int irq, void *dev_id); /* declared in no header but the driver's own */

static struct net_device *struck;
static void __iomem *registers; /* of its chip */
static bool telling, told;      /* its driver of the bus-off */

static int on_read(struct kretprobe_instance *read, struct pt_regs *regs)
{
	*(int *)read->data = (int)regs_get_kernel_argument(regs, 1);
	return !telling || regs_get_kernel_argument(regs, 0) != (unsigned long)netdev_priv(struck);
}

static int on_answer(struct kretprobe_instance *read, struct pt_regs *regs)
{
	switch (*(int *)read->data) {
	case STATUS:
		regs_set_return_value(regs, STATUS_BUS_OFF | STATUS_ERRORS);
		break;
	case INTERRUPT:
		regs_set_return_value(regs, told ? 0 : INTERRUPT_ERRORS);
		told = true;
		break;
	}
	return 0;
}

static struct kretprobe reads = {
	.kp.symbol_name = "kvaser_pci_read_reg",
	.entry_handler = on_read,
	.handler = on_answer,
	.data_size = sizeof(int),
};

/* In the hard interrupt, as the driver is used to. */
static void bus_off(struct irq_work *work)
{
	iowrite8(MODE_RESET, registers + MODE);
	told = false;
	telling = true;
	sja1000_interrupt(struck->irq, struck);
	telling = false;
}

static int strike(const char *value, const struct kernel_param *param)
{
	struct irq_work work = IRQ_WORK_INIT_HARD(bus_off);
	char name[IFNAMSIZ];
	int ret = -EINVAL;

	strscpy(name, value, sizeof(name));
	struck = dev_get_by_name(&init_net, strim(name));
	if (!struck)
		return -ENODEV;
	if (struck->dev.parent && dev_is_pci(struck->dev.parent) && netif_running(struck)) {
		registers = pci_iomap(to_pci_dev(struck->dev.parent), REGISTERS_BAR, 0);
		ret = registers ? 0 : -ENOMEM;
	}
	if (!ret) {
		irq_work_queue(&work);
		irq_work_sync(&work);
		pci_iounmap(to_pci_dev(struck->dev.parent), registers);
	}
	dev_put(struck);
	return ret;
}

static const struct kernel_param_ops strike_ops = { .set = strike };
module_param_cb(interface, &strike_ops, NULL, 0200);
MODULE_PARM_DESC(interface, "what is written here is the name of an interface whose controller goes off the bus");

static int __init bus_off_init(void)
{
	return register_kretprobe(&reads);
}

static void __exit bus_off_exit(void)
{
	unregister_kretprobe(&reads);
}

module_init(bus_off_init);
module_exit(bus_off_exit);

MODULE_DESCRIPTION("Bus-off on demand for a Kvaser PCI controller");
MODULE_LICENSE("GPL");
