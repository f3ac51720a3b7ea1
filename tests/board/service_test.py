"""The unit of plenumd: what systemd-analyze makes of it, without a running systemd."""

import re
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

SERVICE = Path(sys.argv.pop(1)) / "board/service"
UNIT = SERVICE / "plenumd.service"
BUS = SERVICE / "plenumd-bus.service"
MOST_EXPOSED = 2.5


def text():
    return UNIT.read_text(encoding="utf-8")


class PlenumdService(unittest.TestCase):
    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd-analyze here: apt-get install systemd")
    def test_it_is_little_exposed(self):
        for unit in UNIT, BUS:
            run = subprocess.run(["systemd-analyze", "security", "--offline=true", "--no-pager", str(unit)],
                                 capture_output=True, text=True, check=True)
            level = re.search(r"Overall exposure level for \S+: ([0-9.]+)", run.stdout)
            self.assertIsNotNone(level, run.stdout + run.stderr)
            self.assertLess(float(level.group(1)), MOST_EXPOSED, run.stdout)

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd-analyze here: apt-get install systemd")
    def test_systemd_understands_every_line(self):
        run = subprocess.run(["systemd-analyze", "verify", "--man=no", str(UNIT), str(BUS)], capture_output=True, text=True)
        # the program and its user are not installed on the machine that builds
        said = [line for line in run.stderr.splitlines() if re.search(r"plenumd(-bus)?[.]service", line) and "not executable" not in line]
        self.assertEqual(said, [])

    def test_the_outputs_go_safe_however_it_ends_and_wait_for_no_sandbox(self):
        self.assertRegex(text(), r"(?m)^ExecStopPost=[+]/usr/bin/plenumd .*--safe$")

    def test_the_guard_is_left_alive_when_the_loop_has_died(self):
        self.assertRegex(text(), r"(?m)^KillMode=control-group$")

    def test_a_group_of_devices_that_it_may_open_is_there_when_it_starts(self):
        built_in = {"gpiochip"}
        module = {"iio": "industrialio", "watchdog": "watchdog"}
        for group in set(re.findall(r"(?m)^DeviceAllow=char-(\S+)", text())) - built_in:
            for order in "Wants", "After":
                self.assertRegex(text(), rf"(?m)^{order}=(.* )?modprobe@{module[group]}[.]service( |$)")

    def test_it_stores_where_check_takes_its_folder_to_be(self):
        self.assertRegex(text(), r"(?m)^StateDirectory=plenum$")

    def test_its_interface_is_set_up_when_it_appears_and_not_when_the_board_alone_starts_anew(self):
        self.assertNotRegex(text(), r"(?m)^(Wants|Requires|BindsTo)=.*plenumd-bus[.]service")
        self.assertRegex(text(), r"(?m)^After=plenumd-bus[.]service ")
        bus = BUS.read_text(encoding="utf-8")
        self.assertRegex(bus, r"(?m)^ExecStart=/usr/bin/plenumd .*--set-bit-rate$")
        rules = (SERVICE / "60-plenum.rules").read_text(encoding="utf-8")
        self.assertRegex(rules, r'(?m)^ACTION=="add", SUBSYSTEM=="net", ATTR{type}=="280", .*ENV{SYSTEMD_WANTS}[+]="plenumd-bus[.]service"$')
        # nobody else sets the rate that a board was told
        network = (SERVICE / "80-can0.network").read_text(encoding="utf-8")
        self.assertRegex(network, r"(?m)^Unmanaged=yes$")

    def test_it_is_not_root_and_holds_no_capability(self):
        self.assertRegex(text(), r"(?m)^User=(?!root$).+$")
        self.assertRegex(text(), r"(?m)^CapabilityBoundingSet=$")


unittest.main()
