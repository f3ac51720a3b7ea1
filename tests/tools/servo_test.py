"""The commands that identify a servo and its parts, as their user runs them."""

import csv
import html
import math
import re
from pathlib import Path
from random import Random

from command import run
from component import Component

R, T = 287.05, 293.15  # of air [J/(kg K)], of the supply [K]


def nozzle(upstream, downstream):
    """Isentropic flow of air through 1 m2 [kg/s]; choked below a ratio of (2/2.4)^3.5."""
    ratio = max(downstream / upstream, (2 / 2.4) ** 3.5)
    return upstream * math.sqrt(7 / (R * T) * (ratio ** (2 / 1.4) - ratio ** (2.4 / 1.4)))


class Friction(Component):
    """A bench that pulls a piston to and fro at speeds that differ from stroke to stroke, force by (23); and the measured O-ring
    piston of tests/data/friction_zillen, whose friction is half of what the two directions differ by."""

    AREA_M2, ZERO_N, VISCOUS_N_S_M, STROKE_M = 4.9e-4, 0.7, 60.0, 0.04
    MEASURED = Path(__file__).resolve().parent.parent / "data" / "friction_zillen"

    def pulled(self, name, gauge_Pa, coulomb_N, ways=(1, -1), header="time_s,position_m,pressure_Pa,force_N", unit=1.0):
        rows, t = [], 0.0
        for speed in (0.01, 0.04, 0.02, 0.03) * 2:
            for way in ways:
                for k in range(round(self.STROKE_M / speed * 100)):
                    x = speed * 0.01 * k if way > 0 else self.STROKE_M - speed * 0.01 * k
                    rows.append((t, x * unit, gauge_Pa + 101325,
                                 self.AREA_M2 * gauge_Pa + self.ZERO_N + way * (coulomb_N + self.VISCOUS_N_S_M * speed)))
                    t += 0.01
        return self.table(name, header, rows)

    def test_the_figures_that_made_the_forces_come_back(self):
        answer = self.answer("friction", "--viscous", self.pulled("low.csv", 1e5, 4), self.pulled("high.csv", 5e5, 8))
        for name, truth in {"area_m2": self.AREA_M2, "zero_N": self.ZERO_N, "viscous_N_s_m": self.VISCOUS_N_S_M}.items():
            self.assertAlmostEqual(answer["parameters"][name]["value"] / truth, 1, delta=1e-4, msg=name)
            self.assertTrue(answer["parameters"][name]["identified"], name)
        for record, name, coulomb_N in zip(answer["records"], ("low.csv", "high.csv"), (4, 8)):
            self.assertEqual(record["file"], name)
            self.assertAlmostEqual(record["coulomb_N"]["value"], coulomb_N, delta=1e-3)
            self.assertLess(record["held_out_rms_N"], 1e-3)
            self.assertGreater(record["held_out_rms_without_friction_N"], coulomb_N)

    def test_one_pressure_will_do_where_the_bore_is_known(self):
        log, bore_mm = self.pulled("one.csv", 3e5, 5), 2e3 * math.sqrt(self.AREA_M2 / math.pi)
        self.refused(3, "friction", log, says=["one record", "two or more pressures", "known area"])
        answer = self.answer("friction", "--viscous", "--bore", bore_mm, log)
        self.assertAlmostEqual(answer["records"][0]["coulomb_N"]["value"], 5, delta=1e-3)
        self.assertAlmostEqual(answer["parameters"]["zero_N"]["value"], self.ZERO_N, delta=1e-3)

    def half_gap_N(self, bar, area_m2):
        """By hand: rows that move 0.2 mm or more in 50 ms, within the middle of the stroke."""
        with open(self.MEASURED / f"O-ring_{bar}bar.csv", newline="", encoding="utf-8") as file:
            rows = [[float(row[name]) for name in ("t_ms", "x_mm", "p_bar", "F_N")] for row in csv.DictReader(file)]
        sums = {1: [0, 0], -1: [0, 0]}
        for before, row, after in zip(rows, rows[5:], rows[10:]):
            moved, took = after[1] - before[1], after[0] - before[0]
            if took < 150 and abs(moved) > 0.3 and 5 < row[1] < 30:
                total = sums[1 if moved > 0 else -1]
                total[0] += row[3] - area_m2 * 1e5 * row[2]
                total[1] += 1
        return 0.5 * (sums[1][0] / sums[1][1] - sums[-1][0] / sums[-1][1])

    def test_a_measured_piston_has_half_the_gap_between_its_directions_as_friction(self):
        bars = (1, 3, 5, 7)
        answer = self.answer("friction", "--format", "zillen", *(self.MEASURED / f"O-ring_{bar}bar.csv" for bar in bars))
        area_m2 = answer["parameters"]["area_m2"]["value"]
        self.assertAlmostEqual(area_m2 / (math.pi / 4 * 25e-3 ** 2), 1, delta=0.02)  # a 25 mm bore
        self.assertLess(answer["rms_N"], 0.7)
        for bar, record in zip(bars, answer["records"]):
            self.assertAlmostEqual(record["gauge_Pa"], bar * 1e5, delta=0.1e5)
            self.assertTrue(record["coulomb_N"]["identified"])
            self.assertAlmostEqual(record["coulomb_N"]["value"], self.half_gap_N(bar, area_m2), delta=0.25)
            self.assertLess(record["held_out_rms_N"], 0.3 * record["held_out_rms_without_friction_N"])

    def test_friction_that_the_measured_speeds_cannot_tell_is_not_called_found(self):
        logs = [self.MEASURED / f"O-ring_{bar}bar.csv" for bar in (1, 3, 5, 7)]
        answer = self.answer("friction", "--format", "zillen", "--stribeck-velocity", 2, *logs)
        self.assertFalse(answer["parameters"]["stribeck_N"]["identified"])
        self.assertIn("below 0", answer["parameters"]["stribeck_N"]["why_not"])

    def test_the_page_and_the_text_say_the_same(self):
        text = self.done("friction", self.pulled("low.csv", 1e5, 4), self.pulled("high.csv", 5e5, 8), "--report", "friction.html")
        page = html.unescape((self.folder / "friction.html").read_text(encoding="utf-8"))
        errors = re.findall(r"rows: (\S+) N RMS, without friction (\S+) N", text)
        self.assertEqual(len(errors), 2)
        for rms, without in errors:
            self.assertIn(f"Held out: {rms} N RMS, without friction {without} N", page)
        self.assertEqual(len(re.findall(r"F_c at", text)), 2)

    def test_what_tells_nothing_is_exit_3_and_says_why(self):
        self.refused(3, "friction", self.pulled("out.csv", 1e5, 4, (1,)), self.pulled("back.csv", 5e5, 4, (1,)), says=["out.csv", "one direction only"])
        still = self.table("still.csv", "time_s,position_m,pressure_Pa,force_N", [(k / 100, 0.01, 2e5, 50) for k in range(200)])
        self.refused(3, "friction", still, still, says=["still.csv", "slides nowhere at 2 mm/s"])

    def test_bad_input_is_one_line_of_what_where_and_what_was_expected(self):
        self.refused(2, "friction", "missing.csv", says=["missing.csv", "No such file"])
        self.refused(2, "friction", self.pulled("x.csv", 1e5, 4, header="time_s,x_m,pressure_Pa,force_N"), says=["x.csv", "column 'position_m' is missing"])
        self.refused(2, "friction", self.pulled("mm.csv", 1e5, 4, unit=1e3), says=["mm.csv", "column position_m", "expected m"])
        back = self.table("back.csv", "time_s,position_m,pressure_Pa,force_N", [(t, 0.01, 2e5, 50) for t in (0, 0.01, 0.005)])
        self.refused(2, "friction", back, says=["back.csv", "row 3, column time_s", "expected time to rise"])


class Cylinder(Component):
    """A servo written down here once more, from (2), (11), (20), (22), (23) of the servo paper: a 32 mm cylinder on a 5/3 valve, its
    chambers adiabatic, in Euler's steps of 50 us. Positions with 20 um of noise, pressures with 300 Pa."""

    KAPPA, SUPPLY_PA, AMBIENT_PA, STEP_S, ROWS_A_SECOND = 1.4, 7e5, 101325.0, 5e-5, 100
    A1_M2, A2_M2, STROKE_M, DEAD_M3 = math.pi / 4 * 0.032 ** 2, math.pi / 4 * (0.032 ** 2 - 0.012 ** 2), 0.2, 20e-6
    LEAK_M2, TRANSITION_M2, DISCHARGE, HALF_BAND_V, STRIBECK_M_S = 3e-8, 5e-8, 0.72, 0.08, 0.02
    TRUTH = {"inlet_area_m2_V": 1.2e-6, "exhaust_area_m2_V": 1.9e-6, "null_V": 5.03, "coulomb_N": 35.0, "stribeck_N": 12.0,
             "viscous_N_s_m": 60.0, "moving_mass_kg": 6.5}
    SHEET = ("--bore", 32, "--rod", 12, "--stroke", 200)

    def flux(self, upstream, downstream):
        return self.DISCHARGE * nozzle(upstream, downstream) if downstream < upstream else 0.0

    def filling(self, u, pressure):
        def area(wanted):
            over = wanted - self.LEAK_M2
            return self.LEAK_M2 + 0.5 * (over + math.sqrt(over * over + self.TRANSITION_M2 ** 2))
        null = self.TRUTH["null_V"]
        return (area(self.TRUTH["inlet_area_m2_V"] * (u - null - self.HALF_BAND_V)) * self.flux(self.SUPPLY_PA, pressure)
                - area(self.TRUTH["exhaust_area_m2_V"] * (null - self.HALF_BAND_V - u)) * self.flux(pressure, self.AMBIENT_PA))

    def moves(self, name, seed, seconds=8, still=False, pressures=True, unit=1.0, gauge_Pa=0.0, header="time_s,command_V,position_m"):
        """A recording of a proportional position controller whose targets change, with steps of up to 0.4 V added."""
        random, dt, k, truth = Random(seed), self.STEP_S, self.KAPPA, self.TRUTH
        x, v, p = 0.1, 0.0, [3.4e5, 3.8e5]
        mass = [p[0] * (self.DEAD_M3 + self.A1_M2 * x) / R / T, p[1] * (self.DEAD_M3 + self.A2_M2 * x) / R / T]
        target, added, rows = 0.1, 0.0, []
        for row in range(round(seconds * self.ROWS_A_SECOND)):
            if row % 60 == 0:
                target = random.uniform(0.04, 0.16)
            if row % 15 == 0:
                added = random.uniform(-0.4, 0.4)
            u = 5.0 if still else min(max(truth["null_V"] + 8 * (target - x) + added, 3.5), 6.5)
            rows.append([row / self.ROWS_A_SECOND, u, (x + random.gauss(0, 2e-5)) * unit]
                        + [one + random.gauss(0, 300) - gauge_Pa for one in p if pressures])
            for _ in range(round(1 / self.ROWS_A_SECOND / dt)):
                volumes = self.DEAD_M3 + self.A1_M2 * x, self.DEAD_M3 + self.A2_M2 * (self.STROKE_M - x)
                push = p[0] * self.A1_M2 - p[1] * self.A2_M2 - self.AMBIENT_PA * (self.A1_M2 - self.A2_M2)
                dry = truth["coulomb_N"] + truth["stribeck_N"] * math.exp(-abs(v) / self.STRIBECK_M_S)
                if v == 0.0:
                    force = math.copysign(max(abs(push) - dry, 0.0), push)
                else:
                    force = push - math.copysign(dry, v) - truth["viscous_N_s_m"] * v
                for side, (command, grows) in enumerate(((u, self.A1_M2 * v), (10 - u, -self.A2_M2 * v))):
                    flow, gas_K = self.filling(command, p[side]), p[side] * volumes[side] / mass[side] / R
                    flow *= math.sqrt(T / gas_K) if flow < 0 else 1.0
                    p[side] += dt * k * (R * gas_K * flow - p[side] * grows) / volumes[side]
                    mass[side] += dt * flow
                before, v = v, v + dt * force / truth["moving_mass_kg"]
                if before * v < 0:
                    v = 0.0
                x += 0.5 * dt * (before + v)
                if not 0 < x < self.STROKE_M:
                    x, v = min(max(x, 0.0), self.STROKE_M), 0.0
        return self.table(name, header + (",pressure_1_Pa,pressure_2_Pa" if pressures else ""), rows)

    def test_the_figures_that_made_the_moves_come_back_and_others_are_predicted(self):
        answer = self.answer("cylinder", *self.SHEET, self.moves("moves.csv", 1), "--heldout", self.moves("others.csv", 2, seconds=5))
        for name, truth in self.TRUTH.items():
            found = answer["parameters"][name]
            # the gas constant is known to 0.3 %, Euler's steps err by as much
            self.assertAlmostEqual(found["value"] / truth, 1, delta=0.002 if name == "null_V" else 0.015, msg=name)
            self.assertTrue(found["identified"], name)
        self.assertLess(answer["rms_m"], 6e-5)
        run, = answer["runs"]
        self.assertEqual((run["file"], run["held_out_from_s"]), ("others.csv", 0))
        self.assertLess(run["rms_m"], 2e-4)
        self.assertGreater(run["fit_percent"], 99)
        self.assertLess(max(run["pressure_1_rms_Pa"], run["pressure_2_rms_Pa"]), 1500)

    def test_without_pressures_their_start_is_asked_for_and_a_figure_held_stays(self):
        log = self.moves("bare.csv", 3, pressures=False)
        self.refused(2, "cylinder", *self.SHEET, log, says=["bare.csv", "pressure_1_Pa", "--start-pressure-1"])
        answer = self.answer("cylinder", *self.SHEET, log, "--start-pressure-1", 340, "--start-pressure-2", 380, "--hold", "mass", "--mass", 6.5)
        mass = answer["parameters"]["moving_mass_kg"]
        self.assertEqual((mass["value"], mass["identified"], mass["why_not"]), (6.5, False, "held"))
        self.assertAlmostEqual(answer["parameters"]["coulomb_N"]["value"] / 35, 1, delta=0.015)
        self.assertIsNone(answer["runs"][0]["pressure_1_rms_Pa"])
        self.assertAlmostEqual(answer["runs"][0]["held_out_from_s"], 4.8)

    def test_a_figure_at_its_bound_is_not_called_found(self):
        answer = self.answer("cylinder", *self.SHEET, self.moves("moves.csv", 1, seconds=4), "--viscous", 10)
        self.assertFalse(answer["parameters"]["viscous_N_s_m"]["identified"])
        self.assertIn("at its bound: 4 times or a 4th of where --viscous starts it", answer["parameters"]["viscous_N_s_m"]["why_not"])

    def test_the_page_and_the_text_say_the_same(self):
        text = self.done("cylinder", *self.SHEET, self.moves("moves.csv", 1, seconds=4), "--report", "servo.html")
        page = html.unescape((self.folder / "servo.html").read_text(encoding="utf-8"))
        self.assertIn("Held out: {} mm RMS, fit {} %".format(*re.search(r"errs by (\S+) mm RMS \(fit (\S+) %", text).groups()), page)
        self.assertIn(f">{float(re.search(r'moving mass +([0-9.]+)', text)[1]):.5g}<", page)

    def test_what_tells_nothing_is_exit_3_and_says_why(self):
        self.refused(3, "cylinder", *self.SHEET, self.moves("still.csv", 1, seconds=1, still=True), says=["still.csv", "moves less than 1 mm"])
        log = self.moves("moves.csv", 1, seconds=2)
        self.refused(3, "cylinder", *self.SHEET, log, "--coulomb", 900, says=["moves.csv", "of the guess does not move"])

    def test_bad_input_is_one_line_of_what_where_and_what_was_expected(self):
        self.refused(2, "cylinder", "missing.csv", says=["--bore"])
        self.refused(2, "cylinder", *self.SHEET, "missing.csv", says=["missing.csv", "No such file"])
        one = dict(seed=1, seconds=0.2)
        self.refused(2, "cylinder", *self.SHEET, self.moves("x.csv", **one, header="time_s,command_V,x_m"), says=["x.csv", "column 'position_m' is missing"])
        self.refused(2, "cylinder", *self.SHEET, self.moves("mm.csv", **one, unit=1e3), says=["mm.csv", "row 1, column position_m", "0 to the stroke of 0.2"])
        self.refused(2, "cylinder", *self.SHEET, self.moves("gauge.csv", **one, gauge_Pa=335e3), says=["gauge.csv", "column pressure_1_Pa", "absolute"])
        self.refused(2, "cylinder", "--bore", 32, "--rod", 32, "--stroke", 200, "x.csv", says=["--rod 32", "less than --bore 32"])
        self.refused(2, "cylinder", *self.SHEET, "x.csv", "--hold", "friction", says=["--hold", "friction", "coulomb"])


class Flow(Component):
    """A nozzle by the isentropic relation, its area a parabola in the command; and a polynomial of the form of (5)."""

    SUPPLY_PA, AMBIENT_PA = 7e5, 101325.0

    @staticmethod
    def area_m2(u):
        return 1e-6 * (0.5 - 0.4 * u + 0.1 * u * u)

    def port(self, name, flow, commands=range(5, 11), header="command_V,pressure_Pa,flow_kg_s", unit=1.0):
        return self.table(name, header, [(u, (self.AMBIENT_PA + share * (self.SUPPLY_PA - self.AMBIENT_PA)) * unit,
                                          flow(u, self.AMBIENT_PA + share * (self.SUPPLY_PA - self.AMBIENT_PA)))
                                         for u in commands for share in (i / 12 for i in range(13))])

    def test_an_orifice_is_told_from_a_polynomial_on_either_side_of_the_chamber(self):
        for side, flow in {"inlet": lambda u, P: self.area_m2(u) * nozzle(self.SUPPLY_PA, P),
                           "exhaust": lambda u, P: self.area_m2(u) * nozzle(P, self.AMBIENT_PA)}.items():
            answer = self.answer("flow", self.port(f"{side}.csv", flow), "--port", side)
            laws, full_kg_s = answer["laws"], answer["full_scale_kg_s"]
            self.assertAlmostEqual(full_kg_s, flow(10, self.AMBIENT_PA if side == "inlet" else self.SUPPLY_PA), places=8)
            for power, truth in enumerate((0.5e-6, -0.4e-6, 0.1e-6)):
                self.assertAlmostEqual(laws["orifice"]["m2_by_V"][power] / truth, 1, delta=1e-3)  # (3) has five digits
            self.assertLess(laws["orifice"]["between_rms_kg_s"], 1e-3 * full_kg_s)
            self.assertGreater(laws["bipolynomial"]["rms_kg_s"], 1e-2 * full_kg_s)
            self.assertLess(laws["bipolynomial"]["rms_kg_s"], laws["bipolynomial_as_printed"]["rms_kg_s"])

    def test_the_coefficients_that_made_a_polynomial_come_back(self):
        c = [[1e-3, -2e-9, 1e-15], [3e-4, 5e-10, -1e-15], [-1e-5, 2e-11, 3e-17]]
        table = self.port("polynomial.csv", lambda u, P: sum(c[m][n] * u ** m * P ** n for m in range(3) for n in range(3)))
        laws = self.answer("flow", table)["laws"]
        for m in range(3):
            for n in range(3):
                self.assertAlmostEqual(laws["bipolynomial"]["kg_s_by_V_Pa"][m][n] / c[m][n], 1, delta=1e-3, msg=(m, n))
        self.assertEqual(laws["bipolynomial_as_printed"]["kg_s_by_V_Pa"][1][0], 0)

    def test_a_command_left_out_shows_what_lies_between_the_commands(self):
        sharp = lambda u, P: 1e-6 * max(u - 7, 0) * nozzle(self.SUPPLY_PA, P)
        orifice = self.answer("flow", self.port("sharp.csv", sharp))["laws"]["orifice"]
        self.assertGreater(orifice["between_rms_kg_s"], 1.2 * orifice["rms_kg_s"])
        few = self.answer("flow", self.port("few.csv", sharp, commands=range(7, 11)))
        self.assertEqual((few["commands"], few["laws"]["orifice"]["between_rms_kg_s"]), (4, None))

    def test_the_page_and_the_text_say_the_same(self):
        text = self.done("flow", self.port("inlet.csv", lambda u, P: self.area_m2(u) * nozzle(self.SUPPLY_PA, P)), "--report", "flow.html")
        page = html.unescape((self.folder / "flow.html").read_text(encoding="utf-8"))
        lines = re.findall(r"\n  \S.*? {2,}([0-9.e-]+) +([0-9.e-]+) +\S+ +\d+(?=\n)", text)
        self.assertEqual(len(lines), 3)
        for rms, largest in lines:
            self.assertIn(f"{rms} % of full scale RMS, {largest} % at most", page)
        self.assertEqual(len(re.findall("% of full scale RMS", page)), 3)

    def test_what_tells_nothing_is_exit_3_and_says_why(self):
        still = lambda u, P: 0.0
        self.refused(3, "flow", self.port("still.csv", still), says=["still.csv", "nothing flows"])
        self.refused(3, "flow", self.port("two.csv", lambda u, P: u, commands=(5, 6)), says=["two.csv", "6 of 9", "three commands"])

    def test_bad_input_is_one_line_of_what_where_and_what_was_expected(self):
        self.refused(2, "flow", "missing.csv", says=["missing.csv", "No such file"])
        line = lambda u, P: 1e-3 * u
        self.refused(2, "flow", self.port("names.csv", line, header="u_V,pressure_Pa,flow_kg_s"), says=["names.csv", "column 'command_V' is missing"])
        self.refused(2, "flow", self.port("bar.csv", line, unit=1e-5), says=["bar.csv", "row 1, column pressure_Pa", "absolute pressure in Pa"])
        self.refused(2, "flow", self.port("litres.csv", lambda u, P: 300 * u), says=["litres.csv", "row 1, column flow_kg_s: 1500", "kg/s"])
        self.refused(2, "flow", "x.csv", "--supply", 90, says=["--ambient", "--supply"])


if __name__ == "__main__":
    run()
