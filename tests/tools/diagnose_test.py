"""`plenum effects` and `plenum diagnose` as their user runs them."""

import csv
import json
import math

from command import CommandTest, run

# The closed list of the contract, with the equation that each effect belongs to.
EQUATION = {"spool_lag": "command", "dead_time": "command", "valve_hysteresis": "command", "null_drift": "command",
            "area_shape": "valve_area", "flow_function": "mass_flow", "exhaust_backpressure": "mass_flow",
            "chamber_leak": "mass_flow", "tube_dynamics": "mass_flow", "supply_droop": "supply", "heat_transfer": "energy",
            "volume_error": "energy", "sensor_lag": "sensor", "sensor_bias": "sensor"}


class Effects(CommandTest):
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


RIG = "[sampling]\nrate_Hz = 100\n"


class Diagnose(CommandTest):
    def simulated(self, *options, seconds=20):
        """A log of a thin-plate chamber whose volume moves, and its rig."""
        self.done("sim", "--plant", "thin-plate", "--chambers", 1, "--seconds", seconds, *options, "--out", "logs")
        return ["--rig", "logs/rig.toml", "logs/chamber-1.csv"]

    def changed(self, name, **columns):
        """The simulated log with columns put through functions of a number."""
        rows = self.rows("logs/chamber-1.csv")
        with open(self.folder / name, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            for row in rows:
                writer.writerow(row | {column: repr(change(float(row[column]))) for column, change in columns.items()})
        return name

    def refused_log(self, code, name, *says):
        self.refused(code, "diagnose", "--rig", "logs/rig.toml", name, "--json", "gap.json", "--report", "gap.html", says=[name, *says])

    def test_a_log_in_a_wrong_unit_is_bad_input(self):
        self.simulated()
        self.refused_log(2, self.changed("kPa.csv", pressure_Pa=lambda p: p / 1e3), "pressure_Pa", "kPa")
        self.refused_log(2, self.changed("bar.csv", pressure_Pa=lambda p: p / 1e5), "pressure_Pa", "bar")
        self.refused_log(2, self.changed("gauge.csv", pressure_Pa=lambda p: p - 101325), "pressure_Pa", "gauge", "absolute")
        self.refused_log(2, self.changed("litres.csv", volume_m3=lambda v: 1e3 * v), "volume_m3", "litres")
        self.refused_log(2, self.changed("millilitres.csv", volume_m3=lambda v: 1e6 * v), "volume_m3", "millilitres")
        self.refused_log(2, self.changed("percent.csv", command_V=lambda u: 10 * u), "command_V", "per cent")
        self.refused_log(2, self.changed("unit.csv", command_V=lambda u: u / 10), "command_V", "normalised")

    def test_a_log_of_another_rate_or_with_a_gap_is_bad_input(self):
        self.simulated()
        self.refused_log(2, self.changed("slow.csv", time_s=lambda t: 2 * t), "50 Hz", "rate_Hz = 100")
        self.refused_log(2, self.changed("gap.csv", time_s=lambda t: t + (t > 5)), "row", "time_s")
        self.refused_log(2, self.changed("nan.csv", pressure_Pa=lambda p: math.nan), "row 1", "pressure_Pa", "finite")

    def test_a_log_that_tells_too_little_cannot_be_diagnosed(self):
        self.simulated()
        self.refused_log(3, self.changed("rest.csv", command_V=lambda u: 5.0), "no excitation", "command_V")
        self.refused_log(3, self.changed("still.csv", pressure_Pa=lambda p: 3e5), "no excitation", "pressure_Pa")
        self.refused_log(3, self.changed("full.csv", pressure_Pa=lambda p: 7e5 + p / 1e4), "pressure_Pa")
        self.refused_log(3, self.changed("clipped.csv", pressure_Pa=lambda p: min(p, 3e5)), "saturated", "300000")
        lines = (self.folder / "logs/chamber-1.csv").read_text().splitlines(keepends=True)
        self.refused_log(3, self.write("short.csv", "".join(lines[:250])), "too short")

    def test_wrong_usage_is_told_before_any_work(self):
        self.refused(2, "diagnose", "a.csv", says=["--rig"])
        self.refused(2, "diagnose", "--rig", "rig.toml", says=["LOG"])
        self.write("rig.toml", RIG)
        self.refused(2, "diagnose", "--rig", "rig.toml", "a.csv", says=["a.csv"])
        self.refused(2, "diagnose", "--rig", "rig.toml", "a.csv", "--strike", "spool", says=["--strike", "'spool'", "spool_lag"])
        self.refused(2, "diagnose", "--rig", "rig.toml", "a.csv", "--report", "nowhere/gap.html", says=["nowhere"])
        self.refused(2, "diagnose", "--rig", "rig.toml", "a.csv", "--save-rig", ".", says=["is a folder"])

    def check(self, gap):
        """The contract: keys in their order, types, ranges."""
        self.assertEqual(list(gap)[:9], ["schema", "gap_kPa", "closed_fraction", "verdict", "effects", "candidates", "equation",
                                         "where", "next_experiment"])
        self.assertEqual(gap["schema"], "plenum-gap/1")
        self.assertEqual(list(gap["gap_kPa"]), ["as_configured", "recalibrated", "with_effects", "noise_floor"])
        for value in gap["gap_kPa"].values():
            self.assertGreaterEqual(value, 0.0)
        self.assertTrue(0.0 <= gap["closed_fraction"] <= 1.001, gap["closed_fraction"])
        self.assertIn(gap["verdict"], ["none", "calibration", "explained", "partly_explained", "ambiguous", "unexplained"])
        for effect in gap["effects"]:
            self.assertEqual(list(effect)[:6], ["id", "confidence", "gap_without_kPa", "gap_with_kPa", "parameters", "aliases"])
            self.assertIn(effect["id"], EQUATION)
            self.assertTrue(0.0 <= effect["confidence"] <= 1.0)
            for name, of in effect["parameters"].items():
                self.assertEqual(list(of)[:2], ["value", "ci95"], name)
                self.assertEqual(len(of["ci95"]), 2)
        for candidate in gap["candidates"]:
            self.assertEqual(list(candidate)[:3], ["id", "heldout_kPa", "confidence"])
        if gap["equation"] is not None:
            self.assertIn(gap["equation"]["id"], EQUATION.values())
        self.assertLessEqual(sum(one["share"] for one in gap["where"]), 1.001)
        if gap["next_experiment"] is not None:
            self.assertEqual(list(gap["next_experiment"]), ["excitation", "why", "separates", "power", "instruction"])

    def test_an_effect_of_the_catalogue_is_named_and_its_rig_simulates_again(self):
        of_log = self.simulated("--effect", "dead_time=0.03")
        text = self.done("diagnose", *of_log, "--json", "gap.json", "--report", "gap.html", "--save-rig", "found.toml")
        self.assertLess(len(text.splitlines()), 20)
        gap = json.loads((self.folder / "gap.json").read_text())
        self.check(gap)
        named = gap["effects"][0]
        self.assertEqual(named["id"], "dead_time", gap["verdict"])
        self.assertAlmostEqual(named["parameters"]["delay_s"]["value"], 0.03, delta=0.003)
        self.assertEqual(gap["equation"]["id"], "command")
        self.assertIn(f"verdict   {gap['verdict']}: ", text)
        page = (self.folder / "gap.html").read_text(encoding="utf-8")
        for figure in ["Error left, from configured to floor", "Probability, if there is one cause", "Where the recalibrated model errs",
                       "Pressure, chamber-1.csv", "Command, chamber-1.csv"]:
            self.assertIn(f"<figure><h3>{figure}", page)
        self.assertNotRegex(page, r"<(script|link|img)[^>]+(src|href)=.?https?:", "the page needs no network")
        self.assertIn("[effects.dead_time]", (self.folder / "found.toml").read_text())
        self.done("sim", "--rig", "found.toml", "--chambers", 1, "--seconds", 5, "--out", "again")
        self.done("identify", "--rig", "found.toml", "logs/chamber-1.csv")
        again = json.loads(self.done("diagnose", "--rig", "found.toml", of_log[-1], "--json", "-"))
        self.assertEqual(again["effects"], [], "the rig that was found holds the effect")
        self.assertLess(again["gap_kPa"]["as_configured"], 1.2 * gap["gap_kPa"]["with_effects"])

    def test_what_is_found_goes_to_the_board_and_the_loop_is_the_better_for_it(self):
        effects = ["--effect", "dead_time=0.03", "--effect", "valve_hysteresis=0.2"]
        of_log = self.simulated(*effects)
        self.done("diagnose", *of_log, "--save-model", "found.json", "--date", "2026-11-24")
        self.assertEqual(json.loads((self.folder / "found.json").read_text())["fit"]["date_s"], 20781 * 86400)
        self.done("identify", *of_log, "-o", "nine.json")
        rmse_kPa = {}
        for model in ["found", "nine"]:
            rig = ["--store", model, "--plant", "thin-plate", "--chambers", 1, *effects]
            self.done("upload", *rig, f"{model}.json")
            regulated = self.done("regulate", *rig, "--preview", 6, "--amplitude", 80, "--json", "-", "--out", "tracked")
            rmse_kPa[model] = json.loads(regulated)["chambers"][0]["rmse_kPa"]
        self.assertLess(rmse_kPa["found"], 0.2 * rmse_kPa["nine"], rmse_kPa)

    def test_a_long_hose_goes_to_the_board_as_its_air_and_its_delay(self):
        hose = ["--effect", "tube_dynamics=4"]
        of_log = self.simulated(*hose)
        self.done("diagnose", *of_log, "--save-model", "found.json")
        self.done("identify", "--model", "greybox", *of_log, "-o", "identified.json")
        self.done("identify", *of_log, "-o", "nine.json")
        rmse_kPa = {}
        for model in ["found", "identified", "nine"]:
            rig = ["--store", model, "--plant", "thin-plate", "--chambers", 1, *hose]
            self.done("upload", *rig, f"{model}.json")
            regulated = self.done("regulate", *rig, "--preview", 4, "--amplitude", 60, "--json", "-", "--out", "tracked")
            rmse_kPa[model] = json.loads(regulated)["chambers"][0]["rmse_kPa"]
        self.assertLess(max(rmse_kPa["found"], rmse_kPa["identified"]), 0.25 * rmse_kPa["nine"], rmse_kPa)

    def test_a_wandering_null_is_drawn_and_rivals_beside_it_are_told_from_it(self):
        wander = ",".join(f"wander_{k}_V:{0.06 * math.sin(0.9 * k):.4f}" for k in range(1, 21))
        # at rest a delay and a lag of the sensor are one thing
        effects = ["--effect", f"null_drift=0,{wander}", "--effect", "dead_time=0.001", "--volume-swing", 0]
        self.done("sim", "--plant", "thin-plate", "--chambers", 1, "--seconds", 25, *effects, "--seed", 2, "--out", "heldout")
        of_log = self.simulated(*effects, seconds=25)
        text = self.done("diagnose", *of_log, "--heldout", "heldout/chamber-1.csv", "--json", "gap.json", "--report", "gap.html")
        gap = json.loads((self.folder / "gap.json").read_text())
        self.check(gap)
        self.assertEqual(gap["verdict"], "ambiguous", text)
        self.assertEqual(gap["effects"][0]["id"], "null_drift")
        self.assertEqual(gap["effects"][0]["aliases"], [])
        self.assertIn("wander_20_V", gap["effects"][0]["parameters"])
        delays = {one["id"] for one in gap["effects"][1:]}
        self.assertLessEqual({"dead_time", "sensor_lag"}, delays)
        self.assertLessEqual(set(gap["next_experiment"]["separates"]), delays, "not the null, which is sure")
        self.assertRegex(text, r"verdict   ambiguous: null_drift, and \w+(, \w+)? or \w+: these logs")
        self.assertIn("and 20 that refine it", text)
        self.assertIn("<figure><h3>How far the valve&#39;s null has moved", (self.folder / "gap.html").read_text(encoding="utf-8"))

    def test_a_chamber_without_an_effect_has_none_named_and_json_alone_goes_to_standard_output(self):
        of_log = self.simulated()
        gap = json.loads(self.done("diagnose", *of_log, "--json", "-"))
        self.check(gap)
        self.assertEqual(gap["effects"], [])

    def test_an_effect_that_is_struck_is_not_named(self):
        of_log = self.simulated("--effect", "dead_time=0.03")
        gap = json.loads(self.done("diagnose", *of_log, "--strike", "dead_time", "--json", "-"))
        self.check(gap)
        self.assertNotIn("dead_time", [one["id"] for one in gap["effects"] + gap["candidates"]])

    def test_errors_are_told_on_the_logs_held_out(self):
        of_log = self.simulated("--effect", "dead_time=0.03")
        self.done("sim", "--plant", "thin-plate", "--chambers", 1, "--seconds", 10, "--seed", 2, "--effect", "dead_time=0.03", "--out", "held")
        whole = json.loads(self.done("diagnose", *of_log, "--heldout", "held/chamber-1.csv", "--json", "-"))
        self.check(whole)
        self.assertEqual(whole["effects"][0]["id"], "dead_time")
        self.refused(2, "diagnose", *of_log, "--heldout", self.changed("kPa.csv", pressure_Pa=lambda p: p / 1e3), says=["kPa.csv", "kPa"])
        lines = (self.folder / "held/chamber-1.csv").read_text().splitlines(keepends=True)
        self.write("held/chamber-1.csv", "".join(lines[:4]))
        self.refused(3, "diagnose", *of_log, "--heldout", "held/chamber-1.csv", says=["held/chamber-1.csv", "too short", "3 rows"])
        self.refused(3, "diagnose", *of_log, "--heldout", self.changed("clipped.csv", pressure_Pa=lambda p: min(p, 3e5)),
                     says=["clipped.csv", "saturated"])
        self.refused(2, "diagnose", *of_log, "--heldout", self.changed("turned.csv", command_V=lambda u: 10 - u),
                     says=["turned.csv", "command_V", "other sign"])

    def test_only_what_has_changed_since_the_baseline_is_named(self):
        of_log = self.simulated("--effect", "dead_time=0.03")
        self.done("sim", "--plant", "thin-plate", "--chambers", 1, "--seconds", 20, "--effect", "dead_time=0.03",
                  "--effect", "sensor_bias=4", "--out", "later")
        gap = json.loads(self.done("diagnose", of_log[0], of_log[1], "--baseline", of_log[2], "later/chamber-1.csv", "--json", "-",
                                   "--save-rig", "now.toml", "--save-model", "now.json"))
        self.check(gap)
        self.assertEqual(gap["baseline"]["effects"], ["dead_time"])
        self.assertAlmostEqual(gap["baseline"]["parameters"]["dead_time"]["delay_s"]["value"], 0.03, delta=2e-3)
        self.assertEqual([effect["id"] for effect in gap["effects"]], ["sensor_bias"])
        self.assertAlmostEqual(gap["effects"][0]["parameters"]["offset_kPa"]["value"], 4.0, delta=0.4)
        with open(self.folder / "now.json", encoding="utf-8") as model:  # the machine as it is now, not what has changed
            self.assertAlmostEqual(json.load(model)["parameters"]["dead_time_s"], 0.03, delta=2e-3)
        whole = json.loads(self.done("diagnose", "--rig", "now.toml", "later/chamber-1.csv", "--json", "-"))
        self.assertEqual(whole["verdict"], "none")
        text = self.done("diagnose", of_log[0], of_log[1], "--baseline", of_log[2], of_log[2])
        self.assertIn("No gap: as it was", text)
        self.assertIn("before    the baseline", text)
        self.refused(2, "diagnose", *of_log, "--baseline", self.changed("kPa.csv", pressure_Pa=lambda p: p / 1e3), says=["kPa.csv", "kPa"])


if __name__ == "__main__":
    run()
