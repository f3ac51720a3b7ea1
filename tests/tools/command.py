"""What tests of the program as its user runs it have in common.

Each file that imports it is called with: the program, the top of the tree, the name of a test case, and what writes recordings
of components."""

import csv
import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAM, TOP = sys.argv[1:3]
SMALL = ["--chambers", "2"]


def run():
    unittest.main(argv=[sys.argv[0], sys.argv[3]], verbosity=2)


class CommandTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def serve(self, *arguments):
        """A rig that another program serves in real time: its process; self.bus says where it is."""
        serving = subprocess.Popen([PROGRAM, "sim", "--bus", "socketcand:127.0.0.1:0/can0", *map(str, arguments)], cwd=self.folder,
                                   stdout=subprocess.PIPE, text=True)
        self.addCleanup(serving.stdout.close)
        self.addCleanup(serving.wait)
        self.addCleanup(serving.terminate)
        self.bus = ["--bus", re.search(r"socketcand:127\.0\.0\.1:\d+/can0", serving.stdout.readline())[0]]
        return serving

    def plenum(self, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=900)

    def done(self, *arguments):
        """Runs to exit code 0, silent on standard error, which is no terminal here."""
        ran = self.plenum(*arguments)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""), arguments)
        return ran.stdout

    def refused(self, code, *arguments, says):
        """One line on standard error, nothing on standard output, nothing left behind."""
        before = self.listing()
        ran = self.plenum(*arguments)
        self.assertEqual(ran.returncode, code, ran.stderr)
        self.assertEqual(ran.stdout, "")
        self.assertRegex(ran.stderr, r"\Aplenum[^\n]*\n\Z", "one line")
        for part in says:
            self.assertIn(part, ran.stderr)
        self.assertEqual(self.listing(), before, "a refused command changed files")

    def listing(self):
        return {path.relative_to(self.folder): path.is_file() and path.read_bytes() for path in self.folder.rglob("*")}

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")
        return name

    def rows(self, name):
        with open(self.folder / name, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))


def model(chamber=1, **changed):
    """An admissible model; the joint conditions hold by hand: c9 > 0.1 (1 - sqrt(1 - 0.1^2)), c3 > 0."""
    parameters = {"c1_V": 5.02, "c2_per_V": 0.7, "c3_per_V3": 1.3, "c4_kPa_s_per_mL": -0.05, "c5_per_mL": 0.3, "c6_per_mL": 0.2,
                  "c7_per_V_s": 90, "c8": 0.1, "c9_V": 0.3, "c_gamma_V": 0.1, "supply_kPa": 700, "ambient_kPa": 101.325}
    parameters.update(changed)
    return json.dumps({"schema": "plenum-model/1", "kind": "tassa9", "chamber": chamber, "parameters": parameters, "fit": {}})


def greybox(chamber=1, **changed):
    """An admissible grey-box model of a valve of 60 mL/s a volt."""
    parameters = {"open_above_V": 5.08, "exhaust_below_V": 4.92, "inlet_conductance_mL_per_s_V": 60, "exhaust_conductance_mL_per_s_V": 64,
                  "inlet_leak_mL_per_s": 0.1, "exhaust_leak_mL_per_s": 0.1, "transition_mL_per_s": 1, "inlet_slope": 0, "inlet_curve": 0,
                  "inlet_bend": 0, "exhaust_slope": 0, "exhaust_curve": 0, "exhaust_bend": 0, "critical_ratio": 0.53,
                  "subsonic_index": 0.5, "cracking_ratio": 1, "discharge_slope": 0, "dead_volume_mL": 0, "volume_exponent": 1.4,
                  "chamber_leak_mL_per_s": 0, "dead_time_s": 0, "spool_period_s": 0, "spool_damping": 0.8, "hysteresis_V": 0,
                  "sensor_lag_s": 0, "supply_kPa": 700, "ambient_kPa": 101.325}
    parameters.update(changed)
    return json.dumps({"schema": "plenum-model/1", "kind": "greybox", "chamber": chamber, "parameters": parameters, "fit": {}})
