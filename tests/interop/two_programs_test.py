"""Two `plenum` at once on one board: each gets what it would get alone, or is refused with the reason.

Usage: two_programs_test.py PLENUM
"""

import json
import subprocess
import sys
import unittest

from served_rig import ServedRig

PROGRAM = sys.argv.pop()
CHAMBERS = range(1, 9)
ROUNDS = 3
PARAMETERS = {"c1_V": 5.02, "c2_per_V": 2.5, "c3_per_V3": 4.0, "c4_kPa_s_per_mL": -0.05, "c5_per_mL": 0.003, "c6_per_mL": 0.02,
              "c7_per_V_s": 40, "c8": 0.1, "c9_V": 0.08, "c_gamma_V": 0.1, "supply_kPa": 620, "ambient_kPa": 101.325}


def at_once(rig, *commands):
    """Exit code, output and error of each."""
    running = [subprocess.Popen([PROGRAM, command, "--bus", rig.bus, *map(str, arguments)], cwd=rig.folder.name, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE) for command, *arguments in commands]
    said = [one.communicate(timeout=60) for one in running]
    return [(one.returncode, *text) for one, text in zip(running, said)]


class TwoPrograms(unittest.TestCase):
    def test_both_read_what_the_board_has(self):
        with ServedRig(PROGRAM, "--chambers", 8) as rig:
            for _ in range(ROUNDS):
                both = at_once(rig, ("info", "--json", "-"), ("info", "--json", "-"))
                self.assertEqual([(code, error) for code, _, error in both], [(0, "")] * 2)
                settings = [json.loads(text)["settings"] for _, text, _ in both]
                self.assertEqual(*settings)

    def test_of_two_uploads_one_is_whole_and_the_other_is_refused_or_comes_after_it(self):
        with ServedRig(PROGRAM, "--chambers", 8) as rig:
            volts = {"a": 5.02, "b": 4.9}
            for name, c1_V in volts.items():
                for chamber in CHAMBERS:
                    rig.path(f"{name}{chamber}.json").write_text(json.dumps(
                        {"schema": "plenum-model/1", "kind": "tassa9", "chamber": chamber, "parameters": PARAMETERS | {"c1_V": c1_V}, "fit": {}}))
            for _ in range(ROUNDS):
                both = at_once(rig, *(("upload", "--force", *(f"{name}{chamber}.json" for chamber in CHAMBERS)) for name in volts))
                done = [c1_V for (code, *_), c1_V in zip(both, volts.values()) if code == 0]
                self.assertTrue(done, both)
                for code, _, error in both:
                    self.assertIn((code, "another master is uploading models" in error), [(0, False), (1, True)], error)
                self.assertEqual(rig.plenum("download", "--bus", rig.bus, "-o", "back").returncode, 0)
                found = {json.loads(rig.path(f"back/model-{chamber}.json").read_text())["parameters"]["c1_V"] for chamber in CHAMBERS}
                self.assertEqual(len(found), 1, "all of one set")
                self.assertIn(*found, done)


if __name__ == "__main__":
    unittest.main(verbosity=2)
