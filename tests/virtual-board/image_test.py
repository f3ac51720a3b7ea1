"""The image of board/image: that it boots by itself, what its libiio, libgpiod and can-utils make of the devices, and what plenumd does."""

import os
import re
import socket
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from machine import IMAGE, Machine

DISK = IMAGE / "plenum-arm64.img"
PRESSURE = "/sys/bus/iio/devices/iio:device0"

BOARD = """
[can]
interface = "can0"
[analog_input]
rate_Hz = 1000
[store]
folder = "/var/lib/plenum"
""" + "".join(f"""
[[chamber]]
pressure = {{ device = "pressure", channel = "voltage{c}" }}
position = {{ device = "position", channel = "voltage{c}" }}
command = {{ device = "valve", channel = "voltage{c}" }}
""" for c in range(8))


class ImageByFirmware(unittest.TestCase):
    @unittest.skipUnless(Path(Machine.FIRMWARE).exists(), "SKIP: no UEFI for arm64: apt-get install qemu-efi-aarch64")
    def test_it_boots_by_uefi_to_a_login_lets_root_in_at_the_console_and_has_taken_all_of_its_card(self):
        card = Path(self.enterContext(tempfile.TemporaryDirectory())) / "card"
        subprocess.run(["cp", "--sparse=always", DISK, card], check=True)
        os.truncate(card, 2 << 30)
        with Machine(disk=card, firmware=True) as board:
            board.expect("plenum login: ", Machine.BOOT_s)
            board.serial.send("root\n")
            board.expect("root@plenum:~# ", Machine.COMMAND_s)
            board.serial.send("[ $(findmnt -no LABEL /) = plenum ] && [ $(findmnt -no LABEL /boot/efi) = PLENUM-EFI ]; echo mounted=$?\n")
            board.expect("mounted=0", Machine.COMMAND_s)
            # It has begun at the start, and this waits until it is through.
            board.serial.send("systemctl start systemd-growfs@-; [ $(findmnt -bno SIZE /) -gt $((1700 << 20)) ]; echo grown=$?\n")
            board.expect("grown=0", Machine.COMMAND_s)


class ImageAndFrontEnd(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.board = Machine(disk=DISK)
        cls.addClassCleanup(cls.board.close)
        cls.state, _ = cls.board.status("systemctl is-system-running --wait", Machine.BOOT_s)
        cls.board.run("until [ -e /sys/class/net/can1 ]; do :; done")

    def test_systemd_comes_up_with_nothing_failed(self):
        self.assertEqual(self.state, 0, self.board.run("systemctl --failed"))

    def test_wired_ethernet_has_its_address_by_dhcp(self):
        told = self.board.run("networkctl status eth0")
        self.assertIn("Network File: /etc/systemd/network/90-ethernet.network", told)
        self.assertRegex(told, r"Address: 10\.0\.2\.15 \(DHCP4")

    def test_it_has_an_editor_and_what_brings_a_package_and_nothing_listens_on_a_network(self):
        self.board.run("nano --version && /usr/lib/apt/apt-helper --version && modprobe -n vfat && modprobe -n usb_storage")
        listening = [row.split()[4] for row in self.board.run("ss -Hltun").splitlines()]
        dhcp = re.compile(":(68|546)$")
        self.assertEqual([local for local in listening if not dhcp.search(local)], ["0.0.0.0:29536"], "can_door's, and no other")

    def test_libiio_finds_each_device_by_its_label(self):
        told = self.board.run("iio_attr -d pressure sampling_frequency; iio_attr -c -i position voltage7 scale; iio_attr -c -o valve voltage0 powerdown")
        self.assertIn("1000", told)
        self.assertIn("0.305175781", told)

    def test_libiio_captures_scans_of_every_converter_at_once(self):
        for label, inputs in (("pressure", 8), ("position", 8), ("supply", 1)):
            channels = " ".join(f"voltage{i}" for i in range(inputs))
            size = self.board.run(f"iio_readdev -b 100 -s 100 {label} {channels} 2>/dev/null | wc -c")
            self.assertEqual(int(size), 100 * 2 * inputs, label)

    def check(self):
        """What `plenumd --check` says of the inputs, a line each."""
        self.board.write("/run/board.toml", BOARD)
        _, page = self.board.status("plenumd --config /run/board.toml --check")
        return [line for line in page.decode().splitlines() if "analog input" in line]

    def test_plenumd_reads_what_libiio_reads_whatever_was_left_switched_on(self):
        """As a program leaves it that was killed: scans of two other inputs and the time stamp go on, and nobody takes them."""
        self.board.run("systemctl kill --kill-whom=main -s STOP virtual-board-chambers")
        self.addCleanup(self.board.run, "systemctl kill --kill-whom=main -s CONT virtual-board-chambers")
        elements = " ".join(f"{PRESSURE}/scan_elements/in_{element}_en" for element in ("voltage3", "voltage5", "timestamp"))
        self.board.run(f"for element in {elements}; do echo 1 >$element; done; echo 1 >{PRESSURE}/buffer/enable")
        page = "\n".join(self.check())
        for device in ("pressure", "position"):
            for c in range(8):
                raw, scale = (float(self.board.run(f"iio_attr -c -i {device} voltage{c} {attribute}")) for attribute in ("raw", "scale"))
                told = re.search(rf"[(]{device} voltage{c}[)]: .*[(](-?[0-9.]+) V", page)
                self.assertIsNotNone(told, page)
                self.assertAlmostEqual(float(told[1]), raw * scale / 1000, delta=0.00051, msg=f"{device} voltage{c} [V]")
        self.assertEqual(self.board.run(f"cat {PRESSURE}/buffer/enable"), "0", "a capture is left running")

    def test_plenumd_leaves_alone_a_converter_that_another_captures_from(self):
        self.board.run("(iio_readdev -b 100 -s 4000 pressure voltage0 voltage1 >/run/scans 2>/dev/null; : >/run/scanned) & "
                       f"until [ $(cat {PRESSURE}/buffer/enable) = 1 ]; do :; done")
        lines = self.check()
        self.assertEqual([line for line in lines if line.startswith("FAIL")],
                         ["FAIL  analog input   iio:iio:device0: capture: Device or resource busy, expected a device that has a trigger, "
                          "that no other program captures from, and that is open to this user"])
        self.assertEqual(len([line for line in lines if "(position voltage" in line]), 8)
        self.board.run("until [ -e /run/scanned ]; do sleep 0.1; done")
        self.assertEqual(int(self.board.run("stat -c %s /run/scans")), 4000 * 2 * 2, "the other's capture was cut short")

    def test_libgpiod_sees_the_power_key_as_one_rising_and_one_falling_edge(self):
        self.board.run("gpiomon -n 2 -F %e gpiochip0 3 >/run/edges 2>&1 & until gpioinfo gpiochip0 | grep -q 'line *3:.*gpiomon'; do :; done")
        self.board.power_key()
        self.board.run("until [ $(wc -l </run/edges) = 2 ]; do :; done")
        self.assertEqual(self.board.run("cat /run/edges").split(), ["1", "0"])

    def test_frames_cross_from_one_controller_to_the_other_and_through_the_door(self):
        board = self.board
        board.run("ip link show can0 | grep -q ',UP' || ip link set can0 up type can bitrate 1000000")
        board.run("systemctl start virtual-board-door")
        with socket.create_connection(("127.0.0.1", board.door_port()), Machine.COMMAND_s) as door:
            door.settimeout(Machine.COMMAND_s)
            stream = door.makefile("rw", newline="")

            def told():
                message = ""
                while not message.endswith(">"):
                    message += stream.read(1)
                return message.strip()

            def ask(message):
                stream.write(message)
                stream.flush()

            self.assertEqual(told(), "< hi >")
            ask("< open can1 >")
            self.assertEqual(told(), "< ok >")
            ask("< rawmode >")
            self.assertEqual(told(), "< ok >")
            board.run("cansend can0 123#C0FFEE")
            self.assertRegex(told(), r"^< frame 123 [0-9.]+ C0FFEE >$")
            board.run("candump -n 1 -L can0 >/run/frame & until grep -q can0 /proc/net/can/rcvlist_all; do :; done")
            ask("< send 12345678 2 ab cd >")
            board.run("until [ -s /run/frame ]; do :; done")
            self.assertTrue(board.run("cat /run/frame").endswith("can0 12345678#ABCD"))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
