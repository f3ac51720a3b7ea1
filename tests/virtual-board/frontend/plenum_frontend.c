// SPDX-License-Identifier: GPL-2.0
/*
 * An emulated analog front end: what a board's converters look like to the kernel, with the chambers behind a door.
 *
 *   plenum-adc.0  label "pressure"  8 inputs, samples in the order of bytes of the processor
 *   plenum-adc.1  label "position"  8 inputs, big-endian samples
 *   plenum-adc.2  label "supply"    1 input
 *   plenum-dac    label "valve"     8 outputs, powered down until told otherwise
 *
 * The inputs have the form of AD7606 converters that share one conversion start: 16 bits of two's complement over
 * +-10 V, sampled together, one trigger and one triggered buffer a device. The shared clock is an hrtimer; its rate is
 * the sampling_frequency of any of the three. The outputs have the form of an AD5755: 16 bits over 0..10 V, with
 * powerdown. What stands at the pins is plant_door.h's.
 *
 * Faults on demand: writing 1 to the parameter `stalled` stops the conversions, while the chambers' time goes on; a
 * device vanishes by unbinding it from its driver in sysfs.
 */
#include <linux/gpio/driver.h>
#include <linux/hrtimer.h>
#include <linux/iio/buffer.h>
#include <linux/iio/iio.h>
#include <linux/iio/trigger.h>
#include <linux/iio/trigger_consumer.h>
#include <linux/iio/triggered_buffer.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/property.h>
#include <linux/uaccess.h>
#include <linux/units.h>
#include <linux/wait.h>

#include "tests/virtual-board/frontend/plant_door.h"

#define ADCS 3
#define ADC_MAX_INPUTS 8
#define BITS 16
#define FASTEST_HZ 20000

static char *power_chip = "9030000.pl061";
module_param(power_chip, charp, 0444);
MODULE_PARM_DESC(power_chip, "label of the gpiochip whose line switches the valves' supply");
static unsigned int power_line;
module_param(power_line, uint, 0444);
MODULE_PARM_DESC(power_line, "offset of that line");
static unsigned int stop_line = 3;
module_param(stop_line, uint, 0444);
MODULE_PARM_DESC(stop_line, "offset of the line of the emergency stop, which is only looked at");
static bool stalled;
module_param(stalled, bool, 0644);
MODULE_PARM_DESC(stalled, "1: no conversion is made");
static ulong missed;
module_param(missed, ulong, 0444);
MODULE_PARM_DESC(missed, "conversions that were not made because the processor was late");

struct adc {
	struct iio_trigger *trigger;
	unsigned int first; /* of its inputs, in plant_door_world */
	unsigned int inputs;
	bool big_endian;
	bool converting; /* under front.lock */
	struct {
		u16 sample[ADC_MAX_INPUTS];
		s64 timestamp __aligned(8);
	} scan;
};

/* What the devices, the clock and the door share. */
static struct {
	spinlock_t lock;
	struct hrtimer clock;
	ktime_t period;
	u64 elapsed_ns; /* since the last read at the door */
	struct plant_door_world world;
	struct adc *adc[ADCS];
	u16 output[PLANT_DOOR_OUTPUTS];
	u8 powered_down; /* a bit an output */
	wait_queue_head_t converted;
	unsigned long door_open;
	struct gpio_chip *power;
} front = {
	.lock = __SPIN_LOCK_UNLOCKED(front.lock),
	.period = NSEC_PER_MSEC,
	.powered_down = 0xff,
};

/* ---- clock */

static enum hrtimer_restart convert(struct hrtimer *clock)
{
	unsigned long flags;
	unsigned int i;
	u64 periods;

	spin_lock_irqsave(&front.lock, flags);
	periods = hrtimer_forward_now(clock, front.period);
	front.elapsed_ns += periods * front.period;
	missed += periods - 1;
	for (i = 0; i < ADCS && !stalled; i++)
		if (front.adc[i] && front.adc[i]->converting)
			iio_trigger_poll(front.adc[i]->trigger);
	spin_unlock_irqrestore(&front.lock, flags);
	wake_up_interruptible(&front.converted);
	return HRTIMER_RESTART;
}

static int set_rate(int rate_hz)
{
	unsigned long flags;

	if (rate_hz < 1 || rate_hz > FASTEST_HZ)
		return -EINVAL;
	spin_lock_irqsave(&front.lock, flags);
	front.period = NSEC_PER_SEC / rate_hz;
	spin_unlock_irqrestore(&front.lock, flags);
	return 0;
}

/* ---- inputs */

static int adc_read_raw(struct iio_dev *indio_dev, const struct iio_chan_spec *chan, int *val, int *val2, long mask)
{
	const struct adc *adc = iio_priv(indio_dev);
	unsigned long flags;

	switch (mask) {
	case IIO_CHAN_INFO_RAW:
		spin_lock_irqsave(&front.lock, flags);
		*val = front.world.input[adc->first + chan->channel];
		spin_unlock_irqrestore(&front.lock, flags);
		return IIO_VAL_INT;
	case IIO_CHAN_INFO_SCALE:
		*val = PLANT_DOOR_INPUT_SPAN_V * MILLI;
		*val2 = BITS;
		return IIO_VAL_FRACTIONAL_LOG2;
	case IIO_CHAN_INFO_SAMP_FREQ:
		*val = div64_s64(NSEC_PER_SEC, front.period);
		return IIO_VAL_INT;
	default:
		return -EINVAL;
	}
}

static int adc_write_raw(struct iio_dev *indio_dev, const struct iio_chan_spec *chan, int val, int val2, long mask)
{
	if (mask != IIO_CHAN_INFO_SAMP_FREQ || val2)
		return -EINVAL;
	return set_rate(val);
}

static int adc_write_raw_get_fmt(struct iio_dev *indio_dev, const struct iio_chan_spec *chan, long mask)
{
	return IIO_VAL_INT_PLUS_MICRO;
}

static const struct iio_info adc_info = {
	.read_raw = adc_read_raw,
	.write_raw = adc_write_raw,
	.write_raw_get_fmt = adc_write_raw_get_fmt,
};

/* In the hard interrupt that convert() raises, and so under front.lock. */
static irqreturn_t adc_scan(int irq, void *poll_func)
{
	struct iio_poll_func *poll = poll_func;
	struct iio_dev *indio_dev = poll->indio_dev;
	struct adc *adc = iio_priv(indio_dev);
	unsigned int i;

	for (i = 0; i < adc->inputs; i++) {
		u16 code = front.world.input[adc->first + i];

		adc->scan.sample[i] = adc->big_endian ? (__force u16)cpu_to_be16(code) : code;
	}
	iio_push_to_buffers_with_timestamp(indio_dev, &adc->scan, iio_get_time_ns(indio_dev));
	iio_trigger_notify_done(indio_dev->trig);
	return IRQ_HANDLED;
}

static int adc_set_converting(struct iio_trigger *trigger, bool converting)
{
	struct adc *adc = iio_trigger_get_drvdata(trigger);
	unsigned long flags;

	spin_lock_irqsave(&front.lock, flags);
	adc->converting = converting;
	spin_unlock_irqrestore(&front.lock, flags);
	return 0;
}

static const struct iio_trigger_ops adc_trigger_ops = {
	.set_trigger_state = adc_set_converting,
	.validate_device = iio_trigger_validate_own_device,
};

static int adc_describe(struct device *dev, struct iio_dev *indio_dev)
{
	const struct adc *adc = iio_priv(indio_dev);
	struct iio_chan_spec *chan;
	unsigned long *masks;
	unsigned int i;

	chan = devm_kcalloc(dev, adc->inputs + 1, sizeof(*chan), GFP_KERNEL);
	masks = devm_kcalloc(dev, 2, sizeof(*masks), GFP_KERNEL);
	if (!chan || !masks)
		return -ENOMEM;
	for (i = 0; i < adc->inputs; i++)
		chan[i] = (struct iio_chan_spec){
			.type = IIO_VOLTAGE,
			.indexed = 1,
			.channel = i,
			.info_mask_separate = BIT(IIO_CHAN_INFO_RAW),
			.info_mask_shared_by_type = BIT(IIO_CHAN_INFO_SCALE),
			.info_mask_shared_by_all = BIT(IIO_CHAN_INFO_SAMP_FREQ),
			.scan_index = i,
			.scan_type = {
				.sign = 's',
				.realbits = BITS,
				.storagebits = BITS,
				.endianness = adc->big_endian ? IIO_BE : IIO_CPU,
			},
		};
	chan[i] = (struct iio_chan_spec)IIO_CHAN_SOFT_TIMESTAMP(i);
	masks[0] = GENMASK(adc->inputs - 1, 0);
	indio_dev->channels = chan;
	indio_dev->num_channels = adc->inputs + 1;
	indio_dev->available_scan_masks = masks;
	return 0;
}

static void adc_leave(void *data)
{
	struct platform_device *pdev = data;
	unsigned long flags;

	spin_lock_irqsave(&front.lock, flags);
	front.adc[pdev->id] = NULL;
	spin_unlock_irqrestore(&front.lock, flags);
}

static int adc_probe(struct platform_device *pdev)
{
	struct device *dev = &pdev->dev;
	struct iio_dev *indio_dev;
	struct adc *adc;
	unsigned long flags;
	int ret;

	indio_dev = devm_iio_device_alloc(dev, sizeof(*adc));
	if (!indio_dev)
		return -ENOMEM;
	adc = iio_priv(indio_dev);
	adc->big_endian = device_property_present(dev, "big-endian");
	ret = device_property_read_u32(dev, "first", &adc->first);
	if (!ret)
		ret = device_property_read_u32(dev, "inputs", &adc->inputs);
	if (!ret)
		ret = adc_describe(dev, indio_dev);
	if (ret)
		return ret;
	indio_dev->name = "plenum-adc";
	indio_dev->modes = INDIO_DIRECT_MODE;
	indio_dev->info = &adc_info;

	adc->trigger = devm_iio_trigger_alloc(dev, "plenum-adc-dev%d", iio_device_id(indio_dev));
	if (!adc->trigger)
		return -ENOMEM;
	adc->trigger->ops = &adc_trigger_ops;
	iio_trigger_set_drvdata(adc->trigger, adc);
	ret = devm_iio_trigger_register(dev, adc->trigger);
	if (ret)
		return ret;
	ret = iio_trigger_set_immutable(indio_dev, adc->trigger);
	if (ret)
		return ret;
	ret = devm_iio_triggered_buffer_setup(dev, indio_dev, adc_scan, NULL, NULL);
	if (ret)
		return ret;
	spin_lock_irqsave(&front.lock, flags);
	front.adc[pdev->id] = adc;
	spin_unlock_irqrestore(&front.lock, flags);
	ret = devm_add_action_or_reset(dev, adc_leave, pdev);
	if (ret)
		return ret;
	return devm_iio_device_register(dev, indio_dev);
}

static struct platform_driver adc_driver = {
	.driver = { .name = "plenum-adc" },
	.probe = adc_probe,
};

/* ---- outputs */

static int dac_read_raw(struct iio_dev *indio_dev, const struct iio_chan_spec *chan, int *val, int *val2, long mask)
{
	switch (mask) {
	case IIO_CHAN_INFO_RAW:
		*val = READ_ONCE(front.output[chan->channel]);
		return IIO_VAL_INT;
	case IIO_CHAN_INFO_SCALE:
		*val = PLANT_DOOR_OUTPUT_SPAN_V * MILLI;
		*val2 = BITS;
		return IIO_VAL_FRACTIONAL_LOG2;
	case IIO_CHAN_INFO_OFFSET:
		*val = 0;
		return IIO_VAL_INT;
	default:
		return -EINVAL;
	}
}

static int dac_write_raw(struct iio_dev *indio_dev, const struct iio_chan_spec *chan, int val, int val2, long mask)
{
	if (mask != IIO_CHAN_INFO_RAW || val2 || val < 0 || val >= BIT(BITS))
		return -EINVAL;
	WRITE_ONCE(front.output[chan->channel], val);
	return 0;
}

static ssize_t dac_powerdown_show(struct iio_dev *indio_dev, uintptr_t private, const struct iio_chan_spec *chan, char *buf)
{
	return sysfs_emit(buf, "%d\n", !!(front.powered_down & BIT(chan->channel)));
}

static ssize_t dac_powerdown_store(struct iio_dev *indio_dev, uintptr_t private, const struct iio_chan_spec *chan,
				   const char *buf, size_t len)
{
	unsigned long flags;
	bool down;
	int ret = kstrtobool(buf, &down);

	if (ret)
		return ret;
	spin_lock_irqsave(&front.lock, flags);
	if (down)
		front.powered_down |= BIT(chan->channel);
	else
		front.powered_down &= ~BIT(chan->channel);
	spin_unlock_irqrestore(&front.lock, flags);
	return len;
}

static const struct iio_info dac_info = {
	.read_raw = dac_read_raw,
	.write_raw = dac_write_raw,
};

static const struct iio_chan_spec_ext_info dac_ext_info[] = {
	{ .name = "powerdown", .shared = IIO_SEPARATE, .read = dac_powerdown_show, .write = dac_powerdown_store },
	{}
};

#define OUTPUT(number) {						\
	.type = IIO_VOLTAGE,						\
	.indexed = 1,							\
	.output = 1,							\
	.channel = (number),						\
	.info_mask_separate = BIT(IIO_CHAN_INFO_RAW) |			\
			      BIT(IIO_CHAN_INFO_SCALE) |		\
			      BIT(IIO_CHAN_INFO_OFFSET),		\
	.ext_info = dac_ext_info,					\
}

static const struct iio_chan_spec dac_channels[PLANT_DOOR_OUTPUTS] = {
	OUTPUT(0), OUTPUT(1), OUTPUT(2), OUTPUT(3), OUTPUT(4), OUTPUT(5), OUTPUT(6), OUTPUT(7),
};

static int dac_probe(struct platform_device *pdev)
{
	struct iio_dev *indio_dev = devm_iio_device_alloc(&pdev->dev, 0);

	if (!indio_dev)
		return -ENOMEM;
	indio_dev->name = "plenum-dac";
	indio_dev->modes = INDIO_DIRECT_MODE;
	indio_dev->info = &dac_info;
	indio_dev->channels = dac_channels;
	indio_dev->num_channels = ARRAY_SIZE(dac_channels);
	return devm_iio_device_register(&pdev->dev, indio_dev);
}

static struct platform_driver dac_driver = {
	.driver = { .name = "plenum-dac" },
	.probe = dac_probe,
};

/* ---- the door */

static int door_open(struct inode *inode, struct file *file)
{
	if (test_and_set_bit(0, &front.door_open))
		return -EBUSY;
	spin_lock_irq(&front.lock);
	front.elapsed_ns = 0;
	spin_unlock_irq(&front.lock);
	return stream_open(inode, file);
}

static int door_release(struct inode *inode, struct file *file)
{
	clear_bit(0, &front.door_open);
	return 0;
}

static ssize_t door_read(struct file *file, char __user *to, size_t size, loff_t *offset)
{
	struct plant_door_board board = {};
	unsigned int i;
	int ret;

	if (size != sizeof(board))
		return -EINVAL;
	spin_lock_irq(&front.lock);
	ret = wait_event_interruptible_lock_irq(front.converted, front.elapsed_ns, front.lock);
	board.elapsed_ns = front.elapsed_ns;
	front.elapsed_ns = 0;
	for (i = 0; i < PLANT_DOOR_OUTPUTS; i++)
		board.output[i] = front.powered_down & BIT(i) ? 0 : READ_ONCE(front.output[i]);
	spin_unlock_irq(&front.lock);
	if (ret)
		return ret;
	board.valve_power = front.power->get(front.power, power_line) > 0;
	board.emergency_stop = front.power->get(front.power, stop_line) > 0;
	return copy_to_user(to, &board, sizeof(board)) ? -EFAULT : sizeof(board);
}

static ssize_t door_write(struct file *file, const char __user *from, size_t size, loff_t *offset)
{
	struct plant_door_world world;

	if (size != sizeof(world))
		return -EINVAL;
	if (copy_from_user(&world, from, sizeof(world)))
		return -EFAULT;
	spin_lock_irq(&front.lock);
	front.world = world;
	spin_unlock_irq(&front.lock);
	return sizeof(world);
}

static const struct file_operations door_operations = {
	.owner = THIS_MODULE,
	.open = door_open,
	.release = door_release,
	.read = door_read,
	.write = door_write,
	.llseek = no_llseek,
};

static struct miscdevice door = {
	.minor = MISC_DYNAMIC_MINOR,
	.name = "plenum-plant",
	.fops = &door_operations,
};

/* ---- the module */

static const struct property_entry pressure[] = {
	PROPERTY_ENTRY_STRING("label", "pressure"), PROPERTY_ENTRY_U32("first", 0), PROPERTY_ENTRY_U32("inputs", 8), {}
};
static const struct property_entry position[] = {
	PROPERTY_ENTRY_STRING("label", "position"), PROPERTY_ENTRY_U32("first", 8), PROPERTY_ENTRY_U32("inputs", 8),
	PROPERTY_ENTRY_BOOL("big-endian"), {}
};
static const struct property_entry supply[] = {
	PROPERTY_ENTRY_STRING("label", "supply"), PROPERTY_ENTRY_U32("first", 16), PROPERTY_ENTRY_U32("inputs", 1), {}
};
static const struct property_entry valve[] = { PROPERTY_ENTRY_STRING("label", "valve"), {} };

static const struct {
	const char *driver;
	int id;
	struct software_node node;
} devices[] = {
	{ "plenum-adc", 0, { .properties = pressure } },
	{ "plenum-adc", 1, { .properties = position } },
	{ "plenum-adc", 2, { .properties = supply } },
	{ "plenum-dac", PLATFORM_DEVID_NONE, { .properties = valve } },
};

/*
 * Nodes of our own, as properties given to the platform device would not outlive its second unbinding: the IIO device shares
 * its parent's node, and when it goes the kernel lets go of a node that it has made itself once more than it took it.
 */
static const struct software_node *nodes[] = {
	&devices[0].node, &devices[1].node, &devices[2].node, &devices[3].node, NULL
};

static struct platform_device *fitted[ARRAY_SIZE(devices)];
static struct platform_driver *const drivers[] = { &adc_driver, &dac_driver };

static int is_power_chip(struct gpio_chip *chip, void *label)
{
	return !strcmp(chip->label, label);
}

static void unfit(void)
{
	unsigned int i;

	for (i = 0; i < ARRAY_SIZE(devices); i++)
		platform_device_unregister(fitted[i]); /* passes over NULL */
	software_node_unregister_node_group(nodes);
}

static int fit(void)
{
	unsigned int i;
	int ret = software_node_register_node_group(nodes);

	if (ret)
		return ret;
	for (i = 0; i < ARRAY_SIZE(devices); i++) {
		struct platform_device *device = platform_device_register_full(&(struct platform_device_info){
			.name = devices[i].driver,
			.id = devices[i].id,
			.fwnode = software_node_fwnode(&devices[i].node),
		});

		if (IS_ERR(device)) {
			unfit();
			return PTR_ERR(device);
		}
		fitted[i] = device;
	}
	return 0;
}

static int __init frontend_init(void)
{
	int ret;

	front.power = gpiochip_find(power_chip, is_power_chip);
	if (!front.power || max(power_line, stop_line) >= front.power->ngpio) {
		pr_err("plenum_frontend: no gpiochip '%s' with a line %u\n", power_chip, max(power_line, stop_line));
		return -ENODEV;
	}
	init_waitqueue_head(&front.converted);
	hrtimer_init(&front.clock, CLOCK_MONOTONIC, HRTIMER_MODE_REL);
	front.clock.function = convert;
	ret = misc_register(&door);
	if (ret)
		return ret;
	ret = platform_register_drivers(drivers, ARRAY_SIZE(drivers));
	if (ret)
		goto no_door;
	ret = fit();
	if (ret)
		goto no_drivers;
	hrtimer_start(&front.clock, front.period, HRTIMER_MODE_REL);
	return 0;

no_drivers:
	platform_unregister_drivers(drivers, ARRAY_SIZE(drivers));
no_door:
	misc_deregister(&door);
	return ret;
}

static void __exit frontend_exit(void)
{
	unfit();
	platform_unregister_drivers(drivers, ARRAY_SIZE(drivers));
	hrtimer_cancel(&front.clock);
	misc_deregister(&door);
}

module_init(frontend_init);
module_exit(frontend_exit);

MODULE_DESCRIPTION("Emulated analog front end of a Plenum board");
MODULE_LICENSE("GPL");
