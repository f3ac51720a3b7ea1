"""The commands that identify a component, as their user runs them."""

import csv
import html
import json
import math
import re
import subprocess
import sys
from pathlib import Path
from random import Random

from command import CommandTest, run

BENCH_LOGS = sys.argv[4]


class Component(CommandTest):
    def bench(self, component, name, seed, *how):
        subprocess.run([BENCH_LOGS, component, self.folder / name, str(seed), *map(str, how)], check=True, timeout=300)
        return name

    def answer(self, *arguments):
        return json.loads(self.done(*arguments, "--json", "-"))

    def table(self, name, header, rows):
        return self.write(name, header + "\n" + "".join(",".join(f"{cell:.9g}" for cell in row) + "\n" for row in rows))


class Regulator(Component):
    """The bench valve of host-sim/plant, 1 kPa of noise. It has k_me/A_d = 156 kPa/mm and a dead band of 0.9 mm; while it fills,
    m s^3 + B s^2 + k s + k/(0.15 s) = 0 of (28), with the masses, dampings and springs of the paper's Table 2 and 3."""

    GAIN, DEAD_BAND_M = 1.56e8, 0.9e-3

    @staticmethod
    def slowest_time_constant_s():
        mass, damping, spring, pole = (17.30 + 16.77) * 1e-3, 24.0, 2607.63 + 2705.23, -1 / 0.15
        for _ in range(20):  # Newton's method
            pole -= (((mass * pole + damping) * pole + spring) * pole + spring / 0.15) / ((3 * mass * pole + 2 * damping) * pole + spring)
        return -1 / pole

    def test_a_noisy_staircase_gives_back_gain_time_constant_and_dead_band(self):
        answer = self.answer("regulator", "--supply", 800, "--ambient", 100, self.bench("regulator", "stairs.csv", 1, 5))
        swarm = answer["rising"]["pso"]["parameters"]
        self.assertAlmostEqual(swarm["static_gain_Pa_m"]["value"] / self.GAIN, 1, delta=0.005)
        self.assertAlmostEqual(swarm["time_constant_s"]["value"] / self.slowest_time_constant_s(), 1, delta=0.02)
        self.assertAlmostEqual(answer["falling"]["pso"]["parameters"]["static_gain_Pa_m"]["value"] / self.GAIN, 1, delta=0.02)
        self.assertAlmostEqual(answer["three_conditions"]["dead_band_m"], self.DEAD_BAND_M, delta=0.01e-3)
        self.assertAlmostEqual(answer["three_conditions"]["idle_m"], self.DEAD_BAND_M, delta=0.02e-3)
        for name in ("static_gain_Pa_m", "time_constant_s"):
            self.assertTrue(swarm[name]["identified"], name)
            self.assertLess(swarm[name]["standard_error"], 0.02 * swarm[name]["value"])

    def test_another_staircase_is_predicted_above_90_percent_and_by_the_swarm_no_worse(self):
        fitted, other = self.bench("regulator", "stairs.csv", 1, 5), self.bench("regulator", "other.csv", 2, 5)
        answer = self.answer("regulator", "--ambient", 100, fitted, "--heldout", other)
        self.assertEqual((answer["file"], answer["held_out_file"]), (fitted, other))
        for side in ("rising", "falling"):
            least_squares, swarm = (answer[side][method]["held_out_fit_percent"] for method in ("ls", "pso"))
            self.assertGreater(least_squares, 90)
            self.assertGreaterEqual(swarm, least_squares)
        self.assertGreater(answer["three_conditions"]["fit_percent"], 90)

    def test_fast_poles_that_noise_hides_are_said_to_be_unknown(self):
        answer = self.answer("regulator", "--ambient", 100, "--internal", self.bench("regulator", "stairs.csv", 1, 5))
        for name in ("plunger_mass_kg", "spool_mass_kg", "plunger_spring_N_m", "diaphragm_area_m2"):
            self.assertFalse(answer["internal"][name]["identified"], name)
            self.assertRegex(answer["internal"][name]["why_not"], "sample time is too long|no such valve")

    def test_a_direction_that_was_not_recorded_is_told(self):
        up = self.bench("regulator", "up.csv", 1, 2, "up")
        self.assertIn("no falling branch: 0 plateaus", self.done("regulator", "--ambient", 100, "--method", "ls", up))
        answer = self.answer("regulator", "--ambient", 100, "--method", "ls", up)
        self.assertNotIn("falling", answer)
        self.assertNotIn("three_conditions", answer)
        self.refused(3, "regulator", "--ambient", 100, "--method", "ls", "--internal", up, says=["up.csv", "falling", "--internal"])

    def test_the_page_and_the_text_say_the_same(self):
        text = self.done("regulator", "--ambient", 100, self.bench("regulator", "stairs.csv", 3, 2), "--report", "valve.html")
        page = html.unescape((self.folder / "valve.html").read_text(encoding="utf-8"))
        fits = re.findall(r"fit (\S+) % of \S+ s, held out (\S+) %", text)
        self.assertEqual(len(fits), 4)
        for fit, held_out in fits:
            self.assertIn(f"fit {fit} %, held out {held_out} %", page)
        self.assertEqual(len(re.findall(r"held out", text)), 4)

    def staircase(self, name, screw_m, pressure_Pa, header="time_s,screw_m,pressure_Pa"):
        return self.table(name, header, [(k / 100, screw_m(k), pressure_Pa(k)) for k in range(1000)])

    def test_what_tells_nothing_is_exit_3_and_says_why(self):
        self.refused(3, "regulator", self.staircase("still.csv", lambda k: 2e-3, lambda k: 3e5),
                     says=["still.csv", "rising branch: 0 plateaus", "at least 2"])
        self.refused(3, "regulator", self.staircase("swept.csv", lambda k: 1e-6 * k, lambda k: 2e5 + 100 * k),
                     says=["swept.csv", "screw_m is held for 1 rows at most", "staircase"])
        steps = self.staircase("stuck.csv", lambda k: 1e-3 * (k // 200), lambda k: 3e5)
        self.refused(3, "regulator", steps, says=["stuck.csv", "rising branch", "pressure never changes"])

    def test_bad_input_is_one_line_of_what_where_and_what_was_expected(self):
        self.refused(2, "regulator", "missing.csv", says=["missing.csv", "No such file"])
        step = lambda k: 1e-3 * (k // 200)
        self.refused(2, "regulator", self.staircase("knob.csv", step, lambda k: 3e5, "time_s,knob_m,pressure_Pa"),
                     says=["knob.csv", "column 'screw_m' is missing"])
        self.refused(2, "regulator", self.staircase("mm.csv", lambda k: 1e3 * step(k), lambda k: 3e5),
                     says=["mm.csv", "row 201", "column screw_m: 1", "expected m"])
        for name, scale in {"bar": 1e-5, "kPa": 1e-3}.items():
            self.refused(2, "regulator", self.staircase(f"{name}.csv", step, lambda k, scale=scale: 3e5 * scale),
                         says=[f"{name}.csv", "row 1", "column pressure_Pa", "absolute pressure in Pa"])
        self.refused(2, "regulator", self.staircase("a.csv", step, lambda k: 3e5), "--supply", "200",
                     says=["--pressure-low below --pressure-high", "supply above"])


class Relief(Component):
    """A grey-box valve by its equations: opening a = k1 P + k2 Q sqrt(P) + k3 at rest, a first-order lag behind it in motion.
    Then a classical two-stage valve of host-sim/plant, which is no grey box, under noise."""

    DENSITY, K1, K2, K3, LAG_S = 865.0, 1.2e-12, 2e-6, -2.3e-6, 0.015
    CRACKING_PA, MAXIMUM_PA = 2.3e-6 / 1.2e-12, math.sqrt(865.0 / 2) / 2e-6

    def flow(self, pressure_Pa, k2):
        return (self.K1 * pressure_Pa + self.K3) / (math.sqrt(self.DENSITY / (2 * pressure_Pa)) - k2 * math.sqrt(pressure_Pa))

    def curve(self, name, k2=K2, header="pressure_drop_Pa,flow_m3_s", scale=1.0, pressures=None):
        pressures = pressures or [self.CRACKING_PA * (1.05 + 0.1 * i) for i in range(12)]
        return self.table(name, header, [(P * scale, self.flow(P, k2)) for P in pressures])

    def step(self, name, before_Pa, after_Pa, seconds=0.2):
        """The pressure steps at 20 ms; the opening, and with it the flow, follows by e^(-t/lag)."""
        opening = lambda P: self.K1 * P + self.K3
        rows = []
        for k in range(round(seconds / 1e-4)):
            t = 1e-4 * k
            P = before_Pa if t < 0.02 else after_Pa
            a = opening(P) + (opening(before_Pa) - opening(P)) * math.exp(-max(t - 0.02, 0) / self.LAG_S)
            rows.append((t, P, a * math.sqrt(2 * P / self.DENSITY)))
        return self.table(name, "time_s,pressure_drop_Pa,flow_m3_s", rows)

    def test_a_curve_gives_back_its_constants_cracking_and_maximum_pressure(self):
        found = self.answer("relief", self.curve("curve.csv"))["static"]
        self.assertTrue(found["flow_force"])
        for name, truth in {"k1_m2_Pa": self.K1, "k2_s_m_sqrtPa": self.K2, "k3_m2": self.K3,
                            "cracking_pressure_Pa": self.CRACKING_PA, "maximum_pressure_Pa": self.MAXIMUM_PA}.items():
            self.assertAlmostEqual(found["parameters"][name]["value"] / truth, 1, delta=1e-5, msg=name)
            self.assertTrue(found["parameters"][name]["identified"], name)
        self.assertLess(found["held_out_worst_error"], 1e-5)

    def test_points_of_a_valve_that_is_shut_do_not_pull_the_curve(self):
        shut = self.curve("shut.csv")
        text = (self.folder / shut).read_text(encoding="utf-8") + "1e6,0\n1.5e6,0\n"
        found = self.answer("relief", self.write("shut.csv", text))["static"]
        self.assertEqual((found["points"], found["shut"]), (12, 2))
        self.assertAlmostEqual(found["parameters"]["cracking_pressure_Pa"]["value"] / self.CRACKING_PA, 1, delta=1e-5)

    def test_a_curve_without_flow_force_shows_no_maximum_pressure(self):
        pulled = self.curve("pulled.csv", k2=-0.2 * self.K2)
        self.assertNotIn("maximum_pressure_Pa", self.answer("relief", pulled)["static"]["parameters"])
        self.assertIn("no flow force", self.done("relief", pulled))

    def test_the_lag_comes_from_the_transient_with_the_curve_held(self):
        curve, step = self.curve("curve.csv", k2=0), self.step("step.csv", 1.2 * self.CRACKING_PA, 1.6 * self.CRACKING_PA)
        found = self.answer("relief", curve, "--transient", step)["dynamic"]
        self.assertAlmostEqual(found["parameters"]["lag_s"]["value"] / self.LAG_S, 1, delta=0.02)
        self.assertAlmostEqual(found["runs"][0]["held_out_from_s"], 0.12, delta=1e-3)
        other = self.step("other.csv", 1.7 * self.CRACKING_PA, 1.3 * self.CRACKING_PA)
        run = self.answer("relief", curve, "--transient", step, "--heldout", other)["dynamic"]["runs"][0]
        self.assertEqual((run["file"], run["held_out_from_s"]), (other, 0))
        self.assertLess(run["worst_error"], 0.02)
        self.assertGreater(run["worst_error_without_lag"], 0.1)

    def test_a_classical_two_stage_valve_is_predicted_within_15_percent_and_5_at_the_end(self):
        curve, ramp, sudden = (self.bench(f"relief-{kind}", f"{name}.csv", seed, how)
                               for kind, name, seed, how in (("curve", "curve", 1, 41), ("step", "ramp", 2, 568), ("step", "sudden", 3, 79.7e3)))
        answer = self.answer("relief", curve, "--transient", ramp, "--heldout", sudden)
        self.assertLess(answer["static"]["held_out_worst_error"], 0.03)
        run = answer["dynamic"]["runs"][0]
        self.assertLess(run["worst_error"], 0.15)
        self.assertLess(abs(run["final_error"]), 0.05)
        self.assertGreater(run["worst_error_without_lag"], 0.15)

    def test_the_page_and_the_text_say_the_same(self):
        curve, step = self.curve("curve.csv", k2=0), self.step("step.csv", 1.2 * self.CRACKING_PA, 1.6 * self.CRACKING_PA)
        text = self.done("relief", curve, "--transient", step, "--report", "relief.html")
        page = html.unescape((self.folder / "relief.html").read_text(encoding="utf-8"))
        lag_ms = re.search(r"k2, lag +(\S+)", text)[1]
        self.assertIn(f">{float(lag_ms):.5g}<", page)
        self.assertIn(re.search(r"errs by (\S+) % at most \(", text)[1] + " % at most", page)

    def test_what_tells_nothing_is_exit_3_and_says_why(self):
        self.refused(3, "relief", self.curve("few.csv", pressures=[2.5e6, 3e6, 3.5e6]), says=["few.csv", "3 points for 3 parameters"])
        self.refused(3, "relief", self.table("falls.csv", "pressure_drop_Pa,flow_m3_s", [(4e6 - 1e5 * i, 1e-3 + 1e-4 * i) for i in range(9)]),
                     says=["falls.csv", "expected a relief valve, which opens"])
        self.refused(3, "relief", self.table("shut.csv", "pressure_drop_Pa,flow_m3_s", [(1e5 * i, 0) for i in range(1, 9)]),
                     says=["shut.csv", "never opens"])
        still = self.step("still.csv", 1.2 * self.CRACKING_PA, 1.2 * self.CRACKING_PA)
        self.refused(3, "relief", self.curve("curve.csv", k2=0), "--transient", still, says=["still.csv", "the lag is", "do not show it"])

    def test_bad_input_is_one_line_of_what_where_and_what_was_expected(self):
        self.refused(2, "relief", "missing.csv", says=["missing.csv", "No such file"])
        self.refused(2, "relief", self.curve("names.csv", header="pressure_Pa,flow_m3_s"), says=["names.csv", "column 'pressure_drop_Pa' is missing"])
        self.refused(2, "relief", self.curve("bar.csv", scale=1e-5), says=["bar.csv", "row 1, column pressure_drop_Pa", "in Pa"])
        shut = self.table("closed.csv", "time_s,pressure_drop_Pa,flow_m3_s", [(0.1 * k, 2e6, 1e-4 * k) for k in range(9)])
        self.refused(2, "relief", self.curve("curve.csv"), "--transient", shut, says=["closed.csv", "row 1, column flow_m3_s: 0", "stays open"])
        self.refused(2, "relief", "curve.csv", "--heldout", shut, says=["--heldout without --transient"])


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

    R, T, KAPPA, SUPPLY_PA, AMBIENT_PA, STEP_S, ROWS_A_SECOND = 287.05, 293.15, 1.4, 7e5, 101325.0, 5e-5, 100
    A1_M2, A2_M2, STROKE_M, DEAD_M3 = math.pi / 4 * 0.032 ** 2, math.pi / 4 * (0.032 ** 2 - 0.012 ** 2), 0.2, 20e-6
    LEAK_M2, TRANSITION_M2, DISCHARGE, HALF_BAND_V, STRIBECK_M_S = 3e-8, 5e-8, 0.72, 0.08, 0.02
    TRUTH = {"inlet_area_m2_V": 1.2e-6, "exhaust_area_m2_V": 1.9e-6, "null_V": 5.03, "coulomb_N": 35.0, "stribeck_N": 12.0,
             "viscous_N_s_m": 60.0, "moving_mass_kg": 6.5}
    SHEET = ("--bore", 32, "--rod", 12, "--stroke", 200)

    def flux(self, upstream, downstream):
        if downstream >= upstream:
            return 0.0
        k, ratio = self.KAPPA, max(downstream / upstream, (2 / 2.4) ** 3.5)
        return self.DISCHARGE * upstream * math.sqrt(2 * k / (k - 1) / (self.R * self.T) * (ratio ** (2 / k) - ratio ** ((k + 1) / k)))

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
        mass = [p[0] * (self.DEAD_M3 + self.A1_M2 * x) / self.R / self.T, p[1] * (self.DEAD_M3 + self.A2_M2 * x) / self.R / self.T]
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
                    flow, gas_K = self.filling(command, p[side]), p[side] * volumes[side] / mass[side] / self.R
                    flow *= math.sqrt(self.T / gas_K) if flow < 0 else 1.0
                    p[side] += dt * k * (self.R * gas_K * flow - p[side] * grows) / volumes[side]
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
    def nozzle(upstream, downstream):
        ratio = max(downstream / upstream, (2 / 2.4) ** 3.5)
        return upstream * math.sqrt(7 / (287.05 * 293.15) * (ratio ** (2 / 1.4) - ratio ** (2.4 / 1.4)))

    @staticmethod
    def area_m2(u):
        return 1e-6 * (0.5 - 0.4 * u + 0.1 * u * u)

    def port(self, name, flow, commands=range(5, 11), header="command_V,pressure_Pa,flow_kg_s", unit=1.0):
        return self.table(name, header, [(u, (self.AMBIENT_PA + share * (self.SUPPLY_PA - self.AMBIENT_PA)) * unit,
                                          flow(u, self.AMBIENT_PA + share * (self.SUPPLY_PA - self.AMBIENT_PA)))
                                         for u in commands for share in (i / 12 for i in range(13))])

    def test_an_orifice_is_told_from_a_polynomial_on_either_side_of_the_chamber(self):
        for side, flow in {"inlet": lambda u, P: self.area_m2(u) * self.nozzle(self.SUPPLY_PA, P),
                           "exhaust": lambda u, P: self.area_m2(u) * self.nozzle(P, self.AMBIENT_PA)}.items():
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
        sharp = lambda u, P: 1e-6 * max(u - 7, 0) * self.nozzle(self.SUPPLY_PA, P)
        orifice = self.answer("flow", self.port("sharp.csv", sharp))["laws"]["orifice"]
        self.assertGreater(orifice["between_rms_kg_s"], 1.2 * orifice["rms_kg_s"])
        few = self.answer("flow", self.port("few.csv", sharp, commands=range(7, 11)))
        self.assertEqual((few["commands"], few["laws"]["orifice"]["between_rms_kg_s"]), (4, None))

    def test_the_page_and_the_text_say_the_same(self):
        text = self.done("flow", self.port("inlet.csv", lambda u, P: self.area_m2(u) * self.nozzle(self.SUPPLY_PA, P)), "--report", "flow.html")
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


class Narx(Component):
    """A third-order ARX model in closed form, without noise; a filter behind a valve with a dead band; and chambers of host-sim/plant."""

    PERIOD_S, TIME_CONSTANT_S, PAIR, GAIN = 0.01, 0.2, 0.6 + 0.3j, 3.0

    def arx(self):
        """a_1 .. a_3 from the poles, b_1 .. b_3 from the gain, c."""
        slow, pair = math.exp(-self.PERIOD_S / self.TIME_CONSTANT_S), self.PAIR
        total, product = 2 * pair.real, abs(pair) ** 2
        a = (slow + total, -(product + slow * total), slow * product)
        return a, [share * self.GAIN * (1 - sum(a)) for share in (0.2, 0.5, 0.3)], 1.5 * (1 - sum(a))

    @staticmethod
    def levels(random, rows, low=0.0, high=10.0, shortest=3, longest=40):
        u = []
        while len(u) < rows:
            u += [random.uniform(low, high)] * random.randint(shortest, longest)
        return u[:rows]

    def log(self, name, u, y, header="time_s,command_V,pressure_Pa", period_s=PERIOD_S):
        return self.table(name, header, [(period_s * k, *row) for k, row in enumerate(zip(u, y))])

    def third_order(self, name, seed, rows=800, start=0.0, noise=0.0, still=False, **how):
        random = Random(seed)
        (a, b, c), u, y = self.arx(), [5] * rows if still else self.levels(random, rows), [start] * 3
        for k in range(3, rows):
            y.append(c + sum(a[i] * y[k - 1 - i] + b[i] * u[k - 1 - i] for i in range(3)) + random.gauss(0, noise))
        return self.log(name, u, y, **how)

    def behind_a_dead_band(self, name, seed, rows=2000):
        """y' = (q(u) - y)/0.1 s; q is 0 within 1 V of 5 V, and turns three times as steep below as above."""
        random = Random(seed)
        u, y = self.levels(random, rows), [0.0]
        flow = lambda u: max(u - 6, 0) + 3 * min(u - 4, 0)
        for k in range(1, rows):
            y.append(flow(u[k - 1]) + (y[-1] - flow(u[k - 1])) * math.exp(-0.1))
        return self.log(name, u, [v + random.gauss(0, 0.02) for v in y])

    def test_the_poles_and_the_gain_that_made_the_data_come_back(self):
        arx = self.answer("narx", self.third_order("third.csv", 1))["arx"]
        poles = sorted((complex(*z) for z in arx["poles"]), key=lambda z: (z.imag, abs(z)))
        slow = math.exp(-self.PERIOD_S / self.TIME_CONSTANT_S)
        for pole, truth in zip(poles, (self.PAIR.conjugate(), slow, self.PAIR)):
            self.assertAlmostEqual(abs(pole - truth), 0, delta=1e-5)
        a, b, c = self.arx()
        truths = {"static_gain": self.GAIN, "time_constant_s": self.TIME_CONSTANT_S, "c": c,
                  **{f"a{i + 1}": a[i] for i in range(3)}, **{f"b{i + 1}": b[i] for i in range(3)}}
        self.assertEqual(set(arx["parameters"]), set(truths))
        for name, truth in truths.items():
            self.assertAlmostEqual(arx["parameters"][name]["value"] / truth, 1, delta=1e-4, msg=name)
            self.assertTrue(arx["parameters"][name]["identified"], name)
        self.assertGreater(arx["held_out_fit_percent"], 99.99)
        self.assertLess(arx["linear_network_difference"], 1e-2)

    def test_under_noise_of_the_equation_the_figures_lie_within_their_errors(self):
        parameters = self.answer("narx", self.third_order("noisy.csv", 2, rows=4000, noise=0.05))["arx"]["parameters"]
        for name, truth in {"static_gain": self.GAIN, "time_constant_s": self.TIME_CONSTANT_S, "a1": self.arx()[0][0]}.items():
            error = parameters[name]["standard_error"]
            self.assertLess(abs(parameters[name]["value"] - truth), 4 * error, name)
            self.assertLess(error, 0.1 * truth, name)

    def test_rows_of_several_recordings_count_and_do_not_meet(self):
        high, low = self.third_order("high.csv", 3, start=200.0, still=True), self.third_order("low.csv", 4)
        self.refused(3, "narx", high, says=["high.csv", "does not move"])
        answer = self.answer("narx", high, low)
        self.assertEqual([(one["file"], one["from_row"], one["rows"]) for one in answer["held_out"]],
                         [("high.csv", 481, 320), ("low.csv", 481, 320)])
        self.assertAlmostEqual(answer["arx"]["parameters"]["time_constant_s"]["value"] / self.TIME_CONSTANT_S, 1, delta=1e-4)

    def test_sigmoids_learn_the_dead_band_that_a_linear_model_cannot_have(self):
        fitted, other = self.behind_a_dead_band("fitted.csv", 5), self.behind_a_dead_band("other.csv", 6)
        answer = self.answer("narx", fitted, "--heldout", other)
        self.assertEqual(answer["held_out"], [{"file": other, "from_row": 1, "rows": 2000}])
        self.assertGreater(answer["narx"]["held_out_fit_percent"], 95)
        self.assertLess(answer["arx"]["held_out_fit_percent"], 85)

    def free_run(self, name, narx, order, from_row):
        """By hand, from the JSON: weights are rows (bias, past outputs, past inputs) of the hidden layer, then bias and
        weights of the output."""
        rows = self.rows(name)[from_row - 1:]
        u, y = ([(float(row[column]) - narx[scaling]["mean"]) / narx[scaling]["deviation"] for row in rows]
                for column, scaling in (("command_V", "input_scaling"), ("pressure_Pa", "output_scaling")))
        width, weights, run = 2 * order + 1, narx["weights"], y[:order]
        layer = [weights[j * width:(j + 1) * width] for j in range(narx["hidden"])]
        out = weights[narx["hidden"] * width:]
        for k in range(order, len(y)):
            phi = [1] + [run[k - 1 - i] for i in range(order)] + [u[k - 1 - i] for i in range(order)]
            run.append(out[0] + sum(W * math.tanh(sum(map(float.__mul__, w, map(float, phi)))) for W, w in zip(out[1:], layer)))
        mean = sum(y) / len(y)
        return 100 * (1 - math.sqrt(sum((p - q) ** 2 for p, q in zip(run, y)) / sum((q - mean) ** 2 for q in y)))

    def test_the_weights_in_the_json_are_the_network_that_was_scored(self):
        log = self.behind_a_dead_band("log.csv", 7, rows=1200)
        answer = self.answer("narx", log, "--order", 2, "--hidden", 5, "--seeds", 1)
        self.assertEqual(answer["held_out"], [{"file": log, "from_row": 721, "rows": 480}])
        self.assertAlmostEqual(answer["narx"]["held_out_fit_percent"], self.free_run(log, answer["narx"], 2, 721), delta=1e-6)

    def test_the_best_seed_is_chosen_and_seeds_repeat(self):
        log = self.behind_a_dead_band("log.csv", 8, rows=1200)
        how = "narx", log, "--hidden", 4, "--iterations", 40
        several, again = (self.done(*how, "--json", "-", "--seed", 5) for _ in range(2))
        self.assertEqual(several, again)
        narx = json.loads(several)["narx"]
        fits = {one["seed"]: one["choosing_fit_percent"] for one in narx["seeds"]}
        self.assertEqual((list(fits), fits[narx["chosen_seed"]]), ([5, 6, 7], max(fits.values())))
        self.assertEqual(len(set(fits.values())), 3)
        alone = self.answer(*how, "--seed", narx["chosen_seed"], "--seeds", 1)["narx"]
        self.assertEqual(alone["weights"], narx["weights"])

    def test_chambers_of_thin_plates_are_predicted_by_sigmoids_and_not_by_a_linear_model(self):
        self.done("sim", "--plant", "thin-plate", "--chambers", 1, "--seconds", 60, "--volume-swing", 0, "--out", "logs")
        rows = [[float(row[name]) for name in ("command_V", "pressure_Pa")] for row in self.rows("logs/chamber-1.csv")]
        answer = self.answer("narx", self.log("chamber.csv", *zip(*rows)))
        first_order, arx, narx = (answer[model]["held_out_fit_percent"] for model in ("first_order", "arx", "narx"))
        self.assertGreater(narx, 95)
        self.assertLess(max(arx, first_order), 75)

    def test_the_page_and_the_text_say_the_same(self):
        log = self.behind_a_dead_band("log.csv", 9, rows=1200)
        text = self.done("narx", log, "--report", "narx.html")
        page = html.unescape((self.folder / "narx.html").read_text(encoding="utf-8"))
        scores = re.findall(r"^  (first-order lag|ARX, order 3|NARX, order 3, 10 sigmoids) +(\S+ %) \((\S+ %)\)$", text, re.MULTILINE)
        self.assertEqual(len(scores), 3)
        for cells in scores:
            self.assertIn("".join(f"<td>{cell}</td>" for cell in cells), page)
        seeds = re.findall(r"seed (\d+): fit (\S+ %)", text)
        self.assertEqual(len(seeds), 3)
        for seed, fit in seeds:
            self.assertIn(f"<td>{seed}</td><td>{fit}</td>", page)
        self.assertIn("<td>static gain [kPa/V]</td>", page)
        self.assertIn('"unit":"kPa"', page)

    def test_what_tells_nothing_is_exit_3_and_says_why(self):
        random = Random(10)
        u, noise = self.levels(random, 800), [random.gauss(2e5, 1e3) for _ in range(800)]
        self.refused(3, "narx", self.log("still.csv", [5] * 800, noise), says=["still.csv", "input", "does not move"])
        self.refused(3, "narx", self.log("stuck.csv", u, [2e5] * 800), says=["stuck.csv", "pressure_Pa does not move"])
        self.refused(3, "narx", self.log("unplugged.csv", u, noise), says=["unplugged.csv", "command_V does not tell pressure_Pa", "F of"])
        self.refused(3, "narx", self.log("ramp.csv", [0.01 * k for k in range(800)], noise), says=["ramp.csv", "determine", "does not excite"])
        self.refused(3, "narx", self.third_order("few.csv", 11, rows=20), says=["few.csv: 3 rows that choose among the seeds", "more than the order of 3"])
        self.refused(3, "narx", self.third_order("short.csv", 12, rows=150), says=["short.csv", "training", "cases for 81 weights"])
        self.refused(3, "narx", self.third_order("short.csv", 12), "--heldout", self.log("end.csv", u[:3], noise[:3]),
                     says=["end.csv", "3 rows held out", "more than the order of 3"])

    def test_bad_input_is_one_line_of_what_where_and_what_was_expected(self):
        self.refused(2, "narx", "missing.csv", says=["missing.csv", "No such file"])
        good = self.third_order("good.csv", 13)
        self.refused(2, "narx", good, "--input", "screw_m", says=["good.csv", "column 'screw_m' is missing"])
        self.refused(2, "narx", good, "--output", "command_V", says=["--input command_V", "two different columns"])
        self.refused(2, "narx", good, self.third_order("slow.csv", 14, period_s=0.02), says=["slow.csv", "0.02 s", "expected 0.01 s as in good.csv"])
        self.refused(2, "narx", good, "--order", 0, says=["--order", "0"])
        text = (self.folder / good).read_text(encoding="utf-8").split("\n")
        self.refused(2, "narx", self.write("gap.csv", "\n".join(text[:50] + text[60:])), says=["gap.csv", "time_s"])
        self.refused(2, "narx", self.write("word.csv", "\n".join(text[:5] + ["0.04,open,1"] + text[6:])), says=["word.csv", "command_V", "open"])


if __name__ == "__main__":
    run()
