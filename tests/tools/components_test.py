"""The commands that identify a component, as their user runs them."""

import html
import json
import math
import re
from random import Random

from command import run
from component import Component


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

    def test_a_held_out_part_that_never_changes_is_exit_3_and_named(self):
        screw_m = lambda k: 2e-4 * (k // 100)
        moving = lambda k: 2e5 + 1e4 * (k // 100) + 3e3 * math.sin(k * k)
        late = self.staircase("late.csv", screw_m, lambda k: moving(k) if k < 500 else 2.6e5)
        self.refused(3, "regulator", "--method", "ls", late, says=["late.csv: rising branch, held out", "never changes"])
        self.refused(3, "regulator", "--method", "ls", self.staircase("moving.csv", screw_m, moving),
                     "--heldout", self.staircase("stuck.csv", screw_m, lambda k: 2.6e5),
                     says=["stuck.csv: rising branch, held out", "never changes"])

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
