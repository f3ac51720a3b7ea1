"""`plenum orifice` on flows that have a closed form."""

import html
import json
import math
import re
from pathlib import Path

from command import TOP, CommandTest, run


class Orifice(CommandTest):
    """Choked flow has a closed form: p falls as e^(-k t), and rises at k P_s. A row is the mean over the 10 ms before it."""

    RATE_1_S, VOLUME_M3, SUPPLY_PA = 0.05, 0.2e-3, 700e3

    def log(self, name, pressure_Pa, seconds=6.0, command_V=lambda t: 5.0, volume=lambda t: 1.0):
        rows = [f"{t:.2f},{command_V(t)},{pressure_Pa(t - 0.005):.6f},{self.VOLUME_M3 * volume(t):.9f}"
                for t in (0.01 * k for k in range(round(100 * seconds)))]
        return self.write(name, "time_s,command_V,pressure_Pa,volume_m3\n" + "\n".join(rows) + "\n")

    def emptying(self, name, **how):
        return self.log(name, lambda t: self.SUPPLY_PA * math.exp(-self.RATE_1_S * t), **how)

    def test_a_choked_vessel_shows_the_rate_the_area_and_the_sonic_conductance(self):
        filling = self.log("filling.csv", lambda t: 101325 + self.RATE_1_S * self.SUPPLY_PA * t, command_V=lambda t: 6.0)
        answer = json.loads(self.done("orifice", "--thin-plate", "--exponent", "1", "--json", "-", self.emptying("emptying.csv"), filling))
        # mass per second per pascal at 293.15 K, and ISO 6358's 1.185 kg/m3; of a thin plate 0.0404 A p/sqrt(T) with C_d 1
        mass_kg_s_Pa = self.RATE_1_S * self.VOLUME_M3 / (287.87 * 293.15)
        for of, flow, command_V in zip(answer["orifices"], ("discharge", "charge"), (5, 6)):
            self.assertEqual((of["flow"], of["command_V"]), (flow, command_V))
            self.assertAlmostEqual(of["parameters"]["choked_rate_1_s"]["value"], self.RATE_1_S, delta=1e-6)
            self.assertAlmostEqual(of["sonic_conductance_dm3_s_bar"], 1e8 * mass_kg_s_Pa / 1.185, delta=1e-6)
            self.assertAlmostEqual(of["parameters"]["area_m2"]["value"] / (mass_kg_s_Pa * math.sqrt(293.15) / 0.040418), 1.0, delta=0.01)
            self.assertTrue(of["parameters"]["critical_ratio"]["held"])
            self.assertLess(of["mean_absolute_error_kPa"], 1e-3)

    def opened(self, name, seconds):
        """A valve that is opened at 1 s and shut at 3 s."""
        return self.log(name, lambda t: self.SUPPLY_PA * math.exp(-0.5 * min(max(t - 1, 0), 2)), seconds,
                        command_V=lambda t: 6.0 if 0.995 < t < 2.995 else 5.0)

    def test_a_log_from_the_step_of_its_command_on_has_no_part_in_what_was_before(self):
        valve = self.opened("valve.csv", 4.0)
        answer = json.loads(self.done("orifice", "--thin-plate", "--from", "1", "--to", "3", "--json", "-", valve))
        self.assertAlmostEqual(answer["orifices"][0]["parameters"]["choked_rate_1_s"]["value"], 0.5, delta=1e-6)

    def test_conductance_and_area_are_of_gas_at_the_temperature_of_the_rig(self):
        leak = self.emptying("leak.csv")
        at = {}
        for temperature_K in (293.15, 320):
            rig = self.write("rig.toml", f"[sampling]\nrate_Hz = 100\n[gas]\ntemperature_K = {temperature_K}\n")
            at[temperature_K] = json.loads(self.done("orifice", "--thin-plate", "--rig", rig, "--json", "-", leak))["orifices"][0]
        told = self.done("orifice", "--thin-plate", "--rig", rig, leak)
        self.assertIn("rig.toml: not stated and taken as: sampling.pressure_average_s = 0.01, supply.pressure_Pa = 700000, ", told)
        warm, cool = at[320], at[293.15]
        self.assertEqual(warm["parameters"]["choked_rate_1_s"], cool["parameters"]["choked_rate_1_s"])
        ratio = math.sqrt(293.15 / 320)
        self.assertAlmostEqual(warm["sonic_conductance_dm3_s_bar"] / cool["sonic_conductance_dm3_s_bar"], ratio, delta=1e-9)
        self.assertAlmostEqual(warm["parameters"]["area_m2"]["value"] / cool["parameters"]["area_m2"]["value"], ratio, delta=1e-9)

    def test_columns_in_another_unit_are_refused(self):
        for name, scale, says in (("mL", 1e6, "expected m3"), ("litres", 1e3, "expected m3"), ("none", 0.0, "expected above 0")):
            self.refused(2, "orifice", self.emptying(f"{name}.csv", volume=lambda t, scale=scale: scale),
                         says=[f"{name}.csv", "column volume_m3", says])
        for name, scale in {"kPa": 1e-3, "bar": 1e-5}.items():
            self.refused(2, "orifice", self.log(f"{name}.csv", lambda t, scale=scale: scale * (700e3 - 50e3 * t)),
                         says=[f"{name}.csv", "column pressure_Pa", "expected absolute pressure in Pa"])
        self.refused(2, "orifice", self.log("gauge.csv", lambda t: 600e3 - 99e3 * t),
                     says=["gauge.csv", "column pressure_Pa", "gauge pressure in Pa", "expected absolute pressure"])

    def test_the_page_and_the_text_say_the_same(self):
        self.assertIn("effective_area", self.done("orifice", "--thin-plate", self.emptying("vent.csv")))
        text = self.done("orifice", "--thin-plate", self.emptying("leak.csv"), "--report", "leak.html")
        self.assertRegex(text, r"sonic_conductance +\S+ dm3/\(s bar\) \+- \S+: the choked rate, times")
        rate = re.search(r"choked_rate +(\S+)", text)[1]
        self.assertIn(rate[:6], html.unescape((self.folder / "leak.html").read_text(encoding="utf-8")))

    def test_what_is_no_single_orifice_is_refused_with_the_part_that_is_one(self):
        steps = self.emptying("steps.csv", command_V=lambda t: 5.0 if t < 1.995 else 4.8)
        self.refused(3, "orifice", steps, says=["steps.csv", "the command changes", "longest part at one is --from 2\n"])
        self.done("orifice", "--thin-plate", steps, "--from", "2")
        valve = self.opened("valve.csv", 4.0)
        self.refused(3, "orifice", valve, says=["longest part at one is --from 1 --to 3\n"])
        self.assertIn(", 1.98 s,", self.done("orifice", "--thin-plate", valve, "--from", "1", "--to", "3"))
        moving = self.emptying("moving.csv", volume=lambda t: 1.0 + 0.02 * t)
        self.refused(3, "orifice", moving, says=["moving.csv", "the volume moves from 200 to"])
        tight = self.log("tight.csv", lambda t: self.SUPPLY_PA * math.exp(-1e-3 * t))
        self.refused(3, "orifice", tight, says=["tight.csv", "pressure ratios from", "--thin-plate"])
        self.refused(2, "orifice", tight, "--from", "7", says=["tight.csv", "--from 7", "3 or more"])

    LEAKS = Path(TOP).resolve() / "tests" / "data" / "leak_zillen"

    def sealed(self, name, header="t_s,p_bar", time=lambda t: t, scale=1e-5):
        """Its stamps are uneven, as of a recorder that is late at times."""
        rows = [f"{time(t)},{scale * (self.SUPPLY_PA * math.exp(-self.RATE_1_S * t) - 101325):.9g}"
                for t in (0.1 * k + (0.04 if k % 7 == 3 else 0) for k in range(60))]
        return self.write(name, header + "\n" + "\n".join(rows) + "\n")

    def test_a_sealed_vessel_is_known_by_its_columns_and_shows_what_needs_no_volume(self):
        leak = self.sealed("sealed.csv")
        text = self.done("orifice", "--thin-plate", leak)
        self.assertIn("sealed.csv: discharge, 5.94 s, ", text)
        self.assertRegex(text, r"sonic_conductance +- not told: the file holds no volume; --volume gives it\n")
        answer = json.loads(self.done("orifice", "--thin-plate", "--report", "sealed.html", "--json", "-", leak))["orifices"][0]
        self.assertEqual([answer[name] for name in ("command_V", "volume_m3", "sonic_conductance_dm3_s_bar")], [None] * 3)
        self.assertAlmostEqual(answer["parameters"]["choked_rate_1_s"]["value"], self.RATE_1_S, delta=1e-6)
        self.assertNotIn("area_m2", answer["parameters"])
        page = html.unescape((self.folder / "sealed.html").read_text(encoding="utf-8"))
        self.assertIn("Sonic conductance not told: the file holds no volume", page)

    def test_a_sealed_vessel_of_known_volume_shows_what_a_chamber_of_that_volume_does(self):
        answers = [json.loads(self.done("orifice", "--thin-plate", "--json", "-", *how))["orifices"][0]
                   for how in ([self.emptying("chamber.csv")], [self.sealed("sealed.csv"), "--volume", 1e6 * self.VOLUME_M3])]
        chamber, sealed = [[of["volume_m3"], of["sonic_conductance_dm3_s_bar"], of["parameters"]["area_m2"]["value"]] for of in answers]
        for of_chamber, of_sealed in zip(chamber, sealed):
            self.assertAlmostEqual(of_sealed / of_chamber, 1.0, delta=1e-5)
        together = json.loads(self.done("orifice", "--thin-plate", "--json", "-", "sealed.csv", "chamber.csv"))["orifices"]
        self.assertEqual([of["file"] for of in together], ["chamber.csv", "sealed.csv"])

    def bar(self, name, rows, at):
        """A sealed vessel at 10 Hz, gauge pressure in bar."""
        return self.write(name, "t_s,p_bar\n" + "".join(f"{0.1 * k:.1f},{at(k):.5f}\n" for k in range(rows)))

    def test_too_few_rows_are_refused_in_one_line_that_names_the_file(self):
        # it also seems to be held at first, which is no second line
        short = self.bar("short.csv", 8, lambda k: 5 * math.exp(-0.1 * k))
        self.refused(2, "orifice", short, says=["short.csv: vessel record: 8 rows, expected 21 or more\n"])

    def test_the_shape_is_held_only_where_that_helps(self):
        helps = "; --thin-plate holds the flow's shape"
        tight = self.bar("tight.csv", 200, lambda k: 5 * math.exp(-0.0003 * k))
        self.refused(3, "orifice", tight, says=["tight.csv", "pressure ratios from", helps])
        rising = self.bar("rising.csv", 100, lambda k: 1 + 0.04 * k)
        at_rest = self.bar("at-rest.csv", 100, lambda k: 5 + 0.002 * (-1) ** k - 1e-5 * k)
        self.refused(3, "orifice", rising, says=["rising.csv", "the vessel's pressure rises by 360 kPa\n"])
        self.refused(3, "orifice", at_rest, says=["at-rest.csv", "no excitation", "less than 10 times\n"])

    def test_measured_leaks_are_taken_as_they_were_recorded(self):
        porous = json.loads(self.done("orifice", "--from", "5.204", "--exponent", 1, "--most-subsonic-index", 10, "--json", "-",
                                      self.LEAKS / "Ultimaker_020.csv"))["orifices"][0]
        self.assertLess(porous["mean_absolute_error_kPa"], 2.5)
        held = self.plenum("orifice", self.LEAKS / "Ultimaker_020.csv")
        self.assertEqual((held.returncode, held.stderr), (0, "plenum orifice: Ultimaker_020.csv: hardly falls at first; "
                                                            "--from 5.204 leaves out what is before its leak\n"))
        tight = [self.LEAKS / f"{name}.csv" for name in ("Aluminium", "Formlabs", "Prusa", "Ultimaker_006", "Ultimaker_010")]
        self.refused(3, "orifice", *tight, says=["Aluminium.csv", "pressure ratios from", "--thin-plate"])
        found = json.loads(self.done("orifice", "--thin-plate", "--exponent", 1, "--json", "-", *tight))["orifices"]
        for name, of in zip(tight, found):
            self.assertEqual(of["file"], name.name)
            self.assertTrue(of["parameters"]["choked_rate_1_s"]["identified"], name)

    def test_a_sealed_vessel_that_is_none_is_refused_in_one_line(self):
        self.refused(2, "orifice", self.sealed("back.csv", time=lambda t: min(t, 3)), says=["back.csv", "row 32, column t_s", "expected time to rise"])
        self.refused(2, "orifice", self.sealed("kPa.csv", scale=1e-3), says=["kPa.csv", "row 1, column p_bar", "expected bar above ambient"])
        self.refused(2, "orifice", self.sealed("below.csv", scale=-1e-5), says=["below.csv", "row 1, column p_bar", "expected bar above ambient"])
        self.refused(2, "orifice", self.sealed("header.csv", header="t_s,pressure_bar"), says=["header.csv", "time_s"])
        self.refused(2, "orifice", self.emptying("chamber.csv"), "--volume", 200, says=["--volume", "chamber.csv has its own", "volume_m3"])


if __name__ == "__main__":
    run()
