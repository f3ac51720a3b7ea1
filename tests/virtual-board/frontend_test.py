"""What the emulated front end is to the kernel and to the chambers, in a guest without a root file system (3 to 6 s to boot)."""

import struct
import sys
import unittest

from machine import Machine

ADC = [f"/sys/bus/iio/devices/iio:device{i}" for i in range(3)]
DAC = "/sys/bus/iio/devices/iio:device3"
STALLED = "/sys/module/plenum_frontend/parameters/stalled"
INPUTS = [8, 8, 1]
CODES_PER_V = 65536 / 20
FULL = 65535  # 10 V at an output


class FrontEnd(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.guest = Machine()
        cls.addClassCleanup(cls.guest.close)
        cls.guest.run("for module in kvaser_pci can_raw; do modprobe $module; done")
        base = int(cls.guest.run("cat /sys/class/gpio/gpiochip*/base"))
        cls.power, cls.stop = f"/sys/class/gpio/gpio{base}", f"/sys/class/gpio/gpio{base + 3}"
        cls.guest.run(f"echo {base} >/sys/class/gpio/export; echo {base + 3} >/sys/class/gpio/export; echo out >{cls.power}/direction")

    def numbers(self, files):
        return [int(word) for word in self.guest.run(f"cat {files}").split()]

    def until(self, condition):
        """The guest looks until the condition holds; machine.py's limit of a command ends it otherwise."""
        self.guest.run(f"until {condition}; do :; done")

    def capture(self, adc, scans):
        """Whole scans of all inputs of a converter and the time stamp, as the kernel's buffer gives them."""
        inputs = INPUTS[ADC.index(adc)]
        size = -(-2 * inputs // 8) * 8 + 8
        raw = self.guest.run_bytes(
            f"cd {adc}/scan_elements && for element in *_en; do echo 1 >$element; done && cd ../buffer && echo {scans} >length && echo 1 >enable "
            f"&& dd if=/dev/{adc.rsplit('/', 1)[1]} bs={size * scans} count=1 iflag=fullblock 2>/dev/null; status=$?; echo 0 >enable; exit $status")
        self.assertEqual(len(raw), size * scans)
        order = "<" if self.guest.run(f"cat {adc}/scan_elements/in_voltage0_type").startswith("le") else ">"
        return [(struct.unpack_from(f"{order}{inputs}h", raw, size * i), struct.unpack_from("<q", raw, size * (i + 1) - 8)[0]) for i in range(scans)]

    def test_each_converter_says_what_it_is(self):
        self.assertEqual(self.guest.run("cat " + " ".join(f"{d}/label" for d in [*ADC, DAC])).split(), ["pressure", "position", "supply", "valve"])
        types = self.guest.run("cat " + " ".join(f"{adc}/scan_elements/in_voltage0_type" for adc in ADC)).split()
        self.assertEqual(types, ["le:s16/16>>0", "be:s16/16>>0", "le:s16/16>>0"])
        self.assertEqual(self.guest.run(f"cat {ADC[0]}/in_voltage_scale {DAC}/out_voltage0_scale").split(), ["0.305175781", "0.152587890"])
        self.assertEqual(self.guest.run(f"cat {ADC[1]}/trigger/current_trigger"), "plenum-adc-dev1")

    def test_a_scan_holds_every_input_in_its_order_and_order_of_bytes(self):
        self.guest.run("killall -STOP plantd")
        self.addCleanup(self.guest.run, "killall -CONT plantd")
        for adc, inputs in zip(ADC, INPUTS):
            still = tuple(self.numbers(" ".join(f"{adc}/in_voltage{i}_raw" for i in range(inputs))))
            scans = self.capture(adc, 50)
            self.assertEqual({codes for codes, _ in scans}, {still}, adc)
            times = [time for _, time in scans]
            self.assertEqual(times, sorted(set(times)), f"{adc}: the time stamps do not rise")

    def test_one_rate_holds_for_the_three_converters(self):
        self.addCleanup(self.guest.run, f"echo 1000 >{ADC[0]}/sampling_frequency")
        self.guest.run(f"echo 500 >{ADC[1]}/sampling_frequency")
        self.assertEqual(self.numbers(" ".join(f"{adc}/sampling_frequency" for adc in ADC)), [500, 500, 500])
        for refused in ("0", "20001", "0.5"):
            self.assertNotEqual(self.guest.status(f"echo {refused} >{ADC[0]}/sampling_frequency")[0], 0, refused)

    def test_a_stalled_converter_gives_nothing_while_the_chambers_move_on(self):
        self.addCleanup(self.guest.run, f"echo 0 >{ADC[0]}/buffer/enable; echo 0 >{STALLED}")
        self.guest.run(f"echo 1 >{STALLED}; echo 1 >{ADC[0]}/scan_elements/in_voltage0_en; echo 1 >{ADC[0]}/buffer/enable")
        before = self.numbers(f"{ADC[1]}/in_voltage0_raw")[0]
        self.until(f"[ $(cat {ADC[1]}/in_voltage0_raw) != {before} ]")
        self.assertEqual(self.numbers(f"{ADC[0]}/buffer0/data_available"), [0])
        self.guest.run(f"echo 0 >{STALLED}")
        self.until(f"[ $(cat {ADC[0]}/buffer0/data_available) -gt 0 ]")

    def test_a_command_fills_a_chamber_only_with_power_on_the_valves_and_the_output(self):
        """5 V of pressure is 5 bar: more than a resting chamber has, less than the supply of 7 bar. The position crosses 5 V twice
        a swing, which takes more than a second; the chamber fills in a tenth of one."""
        high, low, middle = (round(volts * CODES_PER_V) for volts in (5.5, 1.5, 5))
        self.addCleanup(self.guest.run, f"echo 1 >{DAC}/out_voltage2_powerdown; echo 0 >{self.power}/value")
        pressure = f"$(cat {ADC[0]}/in_voltage2_raw)"
        self.assertEqual(self.numbers(f"{DAC}/out_voltage2_powerdown"), [1], "an output starts powered down")
        self.guest.run(f"echo {FULL} >{DAC}/out_voltage2_raw; echo 1 >{self.power}/value")
        self.until(f"[ {pressure} -lt {low} ]")
        self.guest.run(f"echo 0 >{DAC}/out_voltage2_powerdown")
        self.until(f"[ {pressure} -gt {high} ]")
        self.guest.run(f"echo 1 >{DAC}/out_voltage2_powerdown")
        self.until(f"[ {pressure} -lt {low} ]")
        self.guest.run(f"echo 0 >{self.power}/value; echo 0 >{DAC}/out_voltage2_powerdown")
        self.until(f"[ $(cat {ADC[1]}/in_voltage2_raw) -gt {middle} ]; do :; done; until [ $(cat {ADC[1]}/in_voltage2_raw) -lt {middle} ]")
        self.assertLess(self.numbers(f"{ADC[0]}/in_voltage2_raw")[0], high)

    def test_an_output_refuses_what_is_no_code(self):
        for refused in ("-1", "65536", "0.5"):
            self.assertNotEqual(self.guest.status(f"echo {refused} >{DAC}/out_voltage7_raw")[0], 0, refused)

    def test_a_converter_that_is_taken_away_ends_its_readers_and_comes_back(self):
        driver = "/sys/bus/platform/drivers/plenum-adc"
        self.guest.run(f"echo 1 >{ADC[1]}/scan_elements/in_voltage0_en; echo 1 >{ADC[1]}/buffer/enable; "
                       "(cat /dev/iio:device1 >/dev/null; echo $? >/run/reader) & echo plenum-adc.1 >" + driver + "/unbind")
        self.until("[ -s /run/reader ]")
        self.assertNotEqual(self.guest.status(f"test -e {ADC[1]}")[0], 0)
        self.guest.run(f"echo plenum-adc.1 >{driver}/bind")
        self.assertEqual(self.guest.run(f"cat {ADC[1]}/label"), "position")

    def test_the_power_key_is_a_pulse_on_line_3(self):
        self.guest.run(f"echo rising >{self.stop}/edge")
        self.assertEqual(self.guest.run(f"cat {self.stop}/value"), "0")
        self.guest.power_key()
        self.until("grep -q ' [1-9][0-9]* .*gpiolib' /proc/interrupts")

    def test_only_one_may_stand_at_the_door(self):
        record = "dd if=/dev/plenum-plant bs=32 count=1 of=/dev/null"
        self.assertNotEqual(self.guest.status(record)[0], 0)
        self.guest.run("killall plantd")
        self.addCleanup(self.guest.run, "/run-extra/virtual-board/plantd >/dev/null 2>&1 &")
        self.until(f"{record}")

    def test_two_can_controllers_are_there(self):
        self.assertEqual(self.guest.run("ls /sys/class/net").split(), ["can0", "can1", "lo"])


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
