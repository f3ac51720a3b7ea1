"""The candidate fits of a diagnosis against scipy.optimize.least_squares over a NumPy simulator, one thread each.

usage: gap_speed.py PLENUM GAP_SPEED [SECONDS]

Both fit the first SECONDS (default: all 40) of one blind case of tier 1, a supply that droops: recalibration alone, then each of four
effects together with it. Same model, step, variables, scales, bounds, start and residuals (free run, every row). scipy's method is trf with
the solver's own tolerance in the cost; its Jacobian is by the same forward differences.

The simulator is the one a good Python engineer would write: what does not depend on the pressure (spool, openings, volume) is calculated
for the whole log at once, the sensor's lag afterwards, both by scipy.signal; in the loop over steps a variable of the Jacobian is a lane
of each array, both ports are one array, and the unchanged chamber is one lane more, so that an accepted step's Jacobian is there already.
Before anything is timed it must give the cost that the other one gives with the other one's answer. Each time is the
processor's, of one solve.

A wrong hypothesis has several minima, and the solvers need not end in the same one. The ratio is over the candidates on which their
costs agree within 1 %; how many those are is a row of its own.
"""

import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import json
import subprocess
import sys
import tempfile
import time

import numpy as np
import scipy
from scipy.linalg import expm
from scipy.optimize import least_squares
from scipy.signal import lfilter

SEED = 20261121
DIFFERENCE = 1e-4  # of a scaled variable
SAME_COST = 0.01
START_SCALE_PA, START_ROOM_PA, LEAST_START_PA = 10000.0, 250000.0, 5000.0
TOLERANCE = 1e-5  # of the cost: that of the fit which is timed beside
SPOOL_PARTS = 3
OPEN_ABOVE, EXHAUST_BELOW, INLET_GAIN, EXHAUST_GAIN, INLET_LEAK, EXHAUST_LEAK, TRANSITION = range(7)


class Chamber:
    """Free runs of the chamber, as many side by side as there are lanes."""

    def __init__(self, case):
        ticks = case["rows"] - 1
        self.steps, self.h = case["steps"], case["tick_s"] / case["steps"]
        self.command = np.array(case["command_V"][:ticks])
        volume = np.array(case["volume_m3"][:ticks * self.steps + 1])
        self.volume, self.rate = 0.5 * (volume[:-1] + volume[1:]), np.diff(volume) / self.h
        self.measured = np.array(case["measured_Pa"][1:case["rows"]])
        self.supply, self.ambient = case["supply_Pa"], case["ambient_Pa"]
        self.energy = case["kappa"] * case["gas_J_kg"]
        self.kappa, self.alpha, self.critical = case["kappa"], case["alpha_s_m"], 1 / case["theta"]
        self.counted = min(max(round(case["average_s"] / self.h), 1), self.steps)
        self.at = case["first_figures"]

    def spool(self, period, damping):
        """The command that the spool makes of the one asked: its mean over each third of a step, one lane."""
        asked = np.repeat(self.command, self.steps * SPOOL_PARTS)
        step = self.h / SPOOL_PARTS
        tau = period / (2 * np.pi)
        if step > 700 * tau:
            return asked
        move = expm(step / tau * np.array([[0, 1], [-1, -2 * damping]]))
        drive = np.array([1, 0]) - move[:, 0]
        trace, determinant = np.trace(move), np.linalg.det(move)
        late = move @ drive - trace * drive
        u = np.append(asked, asked[-1]) - asked[0]
        place, speed = (lfilter([0, drive[i], late[i]], [1, -trace, determinant], u) for i in range(2))
        return asked - tau / step * (np.diff(speed) + 2 * damping * np.diff(place))

    def openings(self, x, effect):
        """Of both ports [m2], (steps, 2, lanes)."""
        if effect == "spool_lag":
            at = self.at[effect]
            u = np.stack([self.spool(period, damping) for period, damping in x[:, at:at + 2]], axis=1)
        else:
            u = self.command[:, None]
        def smooth(towards, leak):
            towards = towards - leak
            return leak + 0.5 * (np.sqrt(towards * towards + x[:, TRANSITION] ** 2) + towards)
        ports = np.stack([smooth(x[:, INLET_GAIN] * (u - x[:, OPEN_ABOVE]), x[:, INLET_LEAK]),
                          smooth(x[:, EXHAUST_GAIN] * (x[:, EXHAUST_BELOW] - u), x[:, EXHAUST_LEAK])], axis=1)
        if effect == "spool_lag":
            return ports.reshape(-1, SPOOL_PARTS, 2, len(x)).mean(axis=1)
        return np.repeat(ports, self.steps, axis=0)

    def plate(self, first, second):
        """Flow through a square metre [kg/s], its slopes in the pressures before and behind."""
        backwards = first < second
        up = np.maximum(first, second)
        ratio = np.minimum(first, second) / up
        r = np.maximum(ratio, self.critical)
        q = r ** (1 / 7)
        q2 = q * q
        w2 = 1 - q2
        per_w = 1 / np.sqrt(np.maximum(w2, 3e-5))
        g = q2 * q2 * q * w2 * per_w
        slope = np.where(w2 < 3e-5, -0.2857, (5 * w2 - q2) / (7 * q2)) * per_w * (ratio > self.critical)
        flow, by_down, by_up = self.alpha * up * g, self.alpha * slope, self.alpha * (g - ratio * slope)
        return (np.where(backwards, -flow, flow), np.where(backwards, -by_down, by_up), np.where(backwards, -by_up, by_down))

    def readings(self, x, start, effect):
        """Of all rows but the first [Pa], (rows - 1, lanes), for figures x (lanes, figures) and pressures at the first row."""
        lanes, h = len(x), self.h
        open_m2 = self.openings(x, effect)
        volume = self.volume[:, None]
        if effect == "volume_error":
            volume = np.maximum(volume + 1e-6 * x[:, self.at[effect]], 0.1 * volume)
        per_mass = np.broadcast_to(self.energy / volume, (len(open_m2), lanes))
        squeeze = np.broadcast_to(self.kappa * self.rate[:, None] / volume, (len(open_m2), lanes))
        means, ends = np.empty((len(open_m2), lanes)), np.empty((len(open_m2) + 1, lanes))
        before, behind = np.empty((2, lanes)), np.empty((2, lanes))
        before[0], behind[1] = self.supply, self.ambient
        p = ends[0] = start
        droops = effect == "supply_droop"
        if droops:
            at = self.at[effect]
            resistance, inertia = 1e6 * x[:, at], x[:, at + 1] / h
            linear, orifice = 1 - x[:, at + 2], 20 * x[:, at + 2]
            supply = np.full(lanes, self.supply)

        def after(pressure, d, drawn):
            a = d * pressure - resistance * drawn
            square = (self.supply * d - a) * (self.supply * d + a)
            b, c, e = self.supply * linear * d**2 + a, (orifice - linear**2) * d**2 + 1, 1 + linear * d
            into = square / (b + np.sqrt(np.maximum(b**2 + c * square, 0)))
            forwards = np.sqrt(np.maximum((self.supply - linear * into)**2 - orifice * into**2, 0.04 * self.supply**2))
            if (square >= 0).all():
                return forwards
            back = -square / (a * e + np.sqrt(np.maximum((a * e)**2 + (e**2 - orifice * d**2) * square, 0)))
            return np.where(square < 0, (a - back) / d, forwards)

        def balance(pressure, opening):
            before[1] = behind[0] = pressure
            flow, by_before, by_behind = self.plate(before, behind)
            flow *= opening
            return flow[0] - flow[1], opening[0] * by_behind[0] - opening[1] * by_before[1], flow[0]

        for n, opening in enumerate(open_m2):
            if droops:
                flow, by_supply, _ = self.plate(supply, p)
                before[0] = after(supply, 2 * inertia + resistance * opening[0] * by_supply, opening[0] * flow)
            net, slope, inlet = balance(p, opening)
            f = per_mass[n] * net - squeeze[n] * p
            z = h * (per_mass[n] * slope - squeeze[n])
            z = np.where(np.abs(z) < 1e-7, 1e-7, z)
            trial = np.maximum(p + h * np.expm1(z) / z * f, 1e3)
            net, _, inlet_trial = balance(trial, opening)
            way = trial - p
            moved = np.abs(way) >= 0.1
            z = np.where(moved, h * (per_mass[n] * net - squeeze[n] * trial - f) / np.where(moved, way, 1), z)
            z = np.minimum(z, 1)
            z = np.where(np.abs(z) < 1e-7, 1e-7, z)
            phi_1 = np.expm1(z) / z
            means[n] = p + h * f * (phi_1 - 1) / z
            p = ends[n + 1] = np.maximum(p + h * f * phi_1, 1e3)
            if droops:
                drawn = 0.5 * (inlet + inlet_trial)
                halves = after(after(supply, 2 * inertia, drawn), 2 * inertia, drawn)
                supply = np.maximum(2 * halves - after(supply, inertia, drawn), 0.2 * self.supply)
        if effect == "sensor_lag":
            means = self.lagged(x[:, self.at[effect]], ends, means)
        return means.reshape(-1, self.steps, lanes)[:, self.steps - self.counted:].mean(axis=1)

    def lagged(self, taus, ends, means):
        out = np.empty_like(means)
        for i, tau in enumerate(taus):
            keep = np.exp(-self.h / tau) if tau > 0 else 0.0
            lag = tau / self.h * np.diff(ends[:, i])
            forcing = ends[1:, i] - lag + keep * (lag - ends[:-1, i])
            reading, _ = lfilter([1], [1, -keep], forcing, zi=[keep * ends[0, i]])
            out[:, i] = means[:, i] - tau / self.h * np.diff(reading, prepend=ends[0, i])
        return out


class Problem:
    """One candidate, by the scaled variables: figures, then the start pressure."""

    def __init__(self, chamber, fit, begin_Pa):
        self.chamber, self.effect, self.begin = chamber, fit["effect"], begin_Pa
        self.figures = [v["figure"] for v in fit["variables"]]
        self.scale = np.array([v["scale"] for v in fit["variables"]])
        base = np.array(fit["start"])
        bound = {side: np.array([v[side] for v in fit["variables"]]) for side in ("low", "high")}
        base[self.figures] = np.clip(base[self.figures], bound["low"], bound["high"])
        self.base = base
        room = START_ROOM_PA / START_SCALE_PA
        least = max(-room, min(LEAST_START_PA - begin_Pa, 0) / START_SCALE_PA)
        self.low = np.append((bound["low"] - base[self.figures]) / self.scale, least)
        self.high = np.append((bound["high"] - base[self.figures]) / self.scale, room)
        self.last = None

    def errors_of(self, lanes):
        x = np.tile(self.base, (len(lanes), 1))
        x[:, self.figures] += self.scale * lanes[:, :-1]
        start = self.begin + START_SCALE_PA * lanes[:, -1]
        return self.chamber.readings(x, start, self.effect) - self.chamber.measured[:, None]

    def errors(self, z):
        steps = np.where(z + DIFFERENCE > self.high, -DIFFERENCE, DIFFERENCE)
        table = self.errors_of(np.vstack([z, z + np.diag(steps)]))
        self.last = z.copy(), (table[:, 1:] - table[:, :1]) / steps
        return table[:, 0]

    def jacobian(self, z):
        if not np.array_equal(self.last[0], z):
            self.errors(z)
        return self.last[1]

    def squares_with(self, figures, start_Pa):
        x = np.array(figures)[None, :]
        errors = self.chamber.readings(x, np.array([start_Pa]), self.effect)[:, 0] - self.chamber.measured
        return errors @ errors

    def solve(self):
        begin = time.process_time()
        result = least_squares(self.errors, np.zeros(len(self.low)), jac=self.jacobian, bounds=(self.low, self.high),
                               method="trf", x_scale="jac", ftol=TOLERANCE)
        return time.process_time() - begin, result


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit("usage: gap_speed.py PLENUM GAP_SPEED [SECONDS]")
    plenum, program = sys.argv[1:3]
    seconds = sys.argv[3] if len(sys.argv) == 4 else "40"
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([plenum, "blind", "generate", "--out", f"{folder}/set", "--cases", "1", "--seed", str(SEED), "--kind",
                        "one", "--tier", "1", "--effect", "supply_droop"], check=True, stdout=subprocess.DEVNULL)
        done = subprocess.run([program, f"{folder}/set/case-0001", seconds], check=True, stdout=subprocess.PIPE, text=True)
    case = json.loads(done.stdout)
    chamber = Chamber(case)
    ours, peers, same = 0.0, 0.0, 0
    for fit in case["fits"]:
        name = fit["effect"] or "recalibration"
        problem = Problem(chamber, fit, case["recalibrated_start_Pa"] if fit["effect"] else case["begin_Pa"])
        again = problem.squares_with(fit["figures"], fit["start_Pa"])
        if abs(again / fit["squares_Pa2"] - 1) > 1e-3:
            sys.exit(f"gap_speed: {name}: the NumPy simulator has {again:.8g} Pa2 with the figures found, "
                     f"expected {fit['squares_Pa2']:.8g}")
        peer_seconds, result = problem.solve()
        cost = fit["squares_Pa2"] / (2 * result.cost)
        if abs(cost - 1) <= SAME_COST:
            ours += fit["seconds"]
            peers += peer_seconds
            same += 1
        rows = case["rows"] - 1
        print(f"{name}: ours {1e3 * fit['seconds']:.1f} ms, {(fit['squares_Pa2'] / rows) ** 0.5:.2f} Pa RMS "
              f"({fit['iterations']} iterations); scipy {peer_seconds:.1f} s, {(2 * result.cost / rows) ** 0.5:.2f} Pa RMS "
              f"({result.nfev} evaluations, status {result.status})"
              f"{'' if abs(cost - 1) <= SAME_COST else '; not the same minimum, not counted'}", file=sys.stderr, flush=True)
    if same == 0:
        sys.exit("gap_speed: no candidate on which both reach the same cost")
    print(f"{same} candidates: ours {1e3 * ours:.1f} ms, scipy {peers:.1f} s", file=sys.stderr)
    peer = f"scipy {scipy.__version__} least_squares trf over NumPy {np.__version__} in lanes, {seconds} s of log"
    for name, value, unit, better, target, peer_value in (
            ("gap.speed_vs_scipy", peers / ours, "x", "higher", 50, 1),
            ("gap.speed_vs_scipy_ms", 1e3 * ours, "ms", "lower", None, 1e3 * peers),
            ("gap.speed_vs_scipy_same_minimum", same, "candidates", "higher", None, len(case["fits"]))):
        print(json.dumps({"name": name, "value": round(value, 3), "unit": unit, "better": better, "target": target,
                          "peer": peer, "peer_value": round(peer_value, 3)}))


if __name__ == "__main__":
    main()
