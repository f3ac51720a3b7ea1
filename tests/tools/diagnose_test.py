"""`plenum effects` as its user runs it. Called with: the program, the top of the tree, the name of a test case."""

import json
import sys
import unittest

import plenum_test

# The closed list of the contract, with the equation that each effect belongs to.
EQUATION = {"spool_lag": "command", "dead_time": "command", "valve_hysteresis": "command", "null_drift": "command",
            "area_shape": "valve_area", "flow_function": "mass_flow", "exhaust_backpressure": "mass_flow",
            "chamber_leak": "mass_flow", "tube_dynamics": "mass_flow", "supply_droop": "supply", "heat_transfer": "energy",
            "volume_error": "energy", "sensor_lag": "sensor", "sensor_bias": "sensor"}


class Effects(plenum_test.Plenum):
    def test_the_catalogue_has_the_effects_of_the_contract_each_in_its_equation(self):
        listed = json.loads(self.done("effects", "--json", "-"))["effects"]
        equation = {one["id"]: one["equation"] for one in listed}
        self.assertEqual({id: equation.get(id) for id in EQUATION}, EQUATION)
        for one in listed:
            self.assertEqual(list(one), ["id", "equation", "summary", "formula", "parameters", "source"])
            for parameter in one["parameters"]:
                self.assertLess(float(parameter["low"]), float(parameter["high"]), (one["id"], parameter["name"]))
                float(parameter["vanishes_at"])

    def test_the_text_says_formula_bounds_and_source_of_what_was_asked_for(self):
        text = self.done("effects", "spool_lag")
        for part in ["spool_lag: ", "equation   command", "formula ", "natural_frequency_Hz", "vanishes at infinity", "source "]:
            self.assertIn(part, text)
        self.assertNotIn("dead_time", text)

    def test_an_unknown_effect_is_refused_with_those_there_are(self):
        self.refused(2, "effects", "spool", says=["'spool'", "spool_lag, dead_time"])

    def test_a_rig_file_may_hold_only_effects_of_the_catalogue(self):
        self.write("rig.toml", "[sampling]\nrate_Hz = 100\n[effects.spool]\nnatural_frequency_Hz = 9\n")
        self.refused(2, "identify", "--rig", "rig.toml", "a.csv", says=["rig.toml", "'spool'", "spool_lag, dead_time"])
        self.write("rig.toml", "[sampling]\nrate_Hz = 100\n[effects.dead_time]\ndelay_s = 1\n")
        self.refused(2, "identify", "--rig", "rig.toml", "a.csv", says=["rig.toml", "delay_s = 1", "0.08"])


if __name__ == "__main__":
    plenum_test.PROGRAM, plenum_test.TOP, CASE = sys.argv[1:4]
    unittest.main(argv=[sys.argv[0], CASE], verbosity=2)
