"""The fit against scipy.optimize.least_squares: same ticks, same errors, same start, same feasible set, one thread each.

usage: identify_speed.py IDENTIFY_SPEED

scipy's method is trf, with x_scale="jac" and its default tolerances, its residuals one vectorised expression. It solves for c1..c9
with c3 and c9 shifted so that the joint conditions of fit.hpp are a box. Timed twice: with its default Jacobian, by differences,
and with the analytic one. Each time is the least of several runs of the same solve.
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
from scipy.optimize import least_squares

SEEDS = (1, 2, 3, 4)
H = 0.01
SUPPLY_KPA, AMBIENT_KPA, C_GAMMA_V = 620.0, 101.325, 0.1
C_B, C_S = (SUPPLY_KPA + AMBIENT_KPA) / 2, (SUPPLY_KPA - AMBIENT_KPA) / 2
MONOTONE = 1 / (3 * 8.0**2)


class Problem:
    def __init__(self, folder):
        self.u, self.v, self.w, self.y = np.loadtxt(os.path.join(folder, "ticks.csv"), delimiter=",", unpack=True)
        c = np.loadtxt(os.path.join(folder, "start.csv"))
        volume = self.v.mean()
        rate = np.sqrt(np.mean(self.w**2))
        self.low = np.array([2, 1e-3, 0, -2 * C_S / rate, -np.inf, 0, 1e-3, -0.99, 1e-4])
        self.high = np.array([8, 50, 500, 2 * C_S / rate, np.inf, 1000 / volume, 200 * 1001, 0.99, 5])
        self.start = np.clip(self.shifted(c), self.low, self.high)
        self.u, self.v, self.w = self.u[:-1], self.v[:-1], self.w[:-1]

    @staticmethod
    def shifted(c):
        z = c.copy()
        z[2] += MONOTONE * c[1]
        z[8] -= C_GAMMA_V * (1 - np.sqrt(1 - c[7] ** 2))
        return z

    def terms(self, z):
        c1, c2, d3, c4, c5, c6, c7, c8, d9 = z
        c3 = d3 - MONOTONE * c2
        x = self.u - c1
        argument = (c2 + c3 * x * x) * x
        inverse_root = 1 / np.sqrt(argument * argument + 1)
        s = C_B + C_S * argument * inverse_root + c4 * self.w
        root = np.sqrt(x * x + C_GAMMA_V**2)
        k = root - C_GAMMA_V * np.sqrt(1 - c8 * c8) + d9 + c8 * x
        inverse = 1 / (1 + c6 * self.v)
        r = (c7 * k + c5 * self.w) * inverse
        a = np.clip(r * H, -4, 40)
        decay = np.exp(-a)
        safe = np.where(np.abs(a) < 1e-8, 1e-8, a)
        return x, c3, inverse_root, s, root, k, inverse, r, a, decay, np.expm1(safe) / safe

    def errors(self, z):
        _, _, _, s, _, _, _, _, _, decay, mean = self.terms(z)
        start = s[:-1] + (self.y[1:-1] - s[:-1]) / mean[:-1]
        return s[1:] + (start - s[1:]) * decay[1:] * mean[1:] - self.y[2:]

    def jacobian(self, z):
        c8, c7, c2 = z[7], z[6], z[1]
        x, c3, inverse_root, s, root, k, inverse, r, a, decay, mean = self.terms(z)
        g = C_S * inverse_root**3
        n = len(x)
        ds = np.zeros((n, 9))
        dr = np.zeros((n, 9))
        ds[:, 0] = -g * (c2 + 3 * c3 * x * x)
        ds[:, 1] = g * (x - MONOTONE * x**3)
        ds[:, 2] = g * x**3
        ds[:, 3] = self.w
        dr[:, 0] = -c7 * inverse * (x / root + c8)
        dr[:, 4] = self.w * inverse
        dr[:, 5] = -r * self.v * inverse
        dr[:, 6] = k * inverse
        dr[:, 7] = c7 * inverse * (x + C_GAMMA_V * c8 / np.sqrt(1 - c8 * c8))
        dr[:, 8] = c7 * inverse
        growth = 1 / decay
        slope = np.where(np.abs(a) < 1e-6, 0.5 + a / 3, (growth - mean) / np.where(a == 0, 1, a)) * H
        seen, before = decay * mean, 1 / mean
        seen_by_r = decay * slope - H * seen
        before_by_r = -slope * before * before
        y = self.y[1:-1]
        start = s[:-1] + (y - s[:-1]) * before[:-1]
        return ((1 - seen[1:])[:, None] * ds[1:] + ((start - s[1:]) * seen_by_r[1:])[:, None] * dr[1:]
                + (seen[1:] * (1 - before[:-1]))[:, None] * ds[:-1]
                + (seen[1:] * (y - s[:-1]) * before_by_r[:-1])[:, None] * dr[:-1])

    def solve(self, jacobian):
        begin = time.perf_counter()
        result = least_squares(self.errors, self.start, jac=jacobian, bounds=(self.low, self.high), method="trf",
                               x_scale="jac")
        return time.perf_counter() - begin, result


def check_jacobian(problem):
    """A wrong Jacobian would make the peer look slow: hold it against differences before timing anything."""
    z = problem.start + 1e-3
    exact = problem.jacobian(z)
    for i in range(9):
        step = 1e-6 * max(0.1, abs(z[i]))
        up, down = z.copy(), z.copy()
        up[i] += step
        down[i] -= step
        difference = (problem.errors(up) - problem.errors(down)) / (2 * step)
        assert np.abs(difference - exact[:, i]).max() <= 1e-4 * np.abs(exact[:, i]).max() + 1e-9, i


def main():
    ours, by_differences, analytic, worse = 0.0, 0.0, 0.0, []
    for seed in SEEDS:
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.argv[1], str(seed), folder], check=True, capture_output=True, text=True)
            mine = json.loads(done.stdout)
            problem = Problem(folder)
        check_jacobian(problem)
        seconds_2, result_2 = min((problem.solve("2-point") for _ in range(2)), key=lambda one: one[0])
        seconds_a, result_a = min((problem.solve(problem.jacobian) for _ in range(2)), key=lambda one: one[0])
        best = min(result_2.cost, result_a.cost)
        ours += mine["seconds"]
        by_differences += seconds_2
        analytic += seconds_a
        worse.append(mine["cost_kPa2"] / best)
        print(f"chamber {seed}: ours {1e3 * mine['seconds']:.1f} ms, cost {mine['cost_kPa2']:.6f}; scipy 2-point "
              f"{1e3 * seconds_2:.0f} ms ({result_2.nfev} evaluations, status {result_2.status}), cost {result_2.cost:.6f}; "
              f"analytic {1e3 * seconds_a:.0f} ms ({result_a.nfev}, status {result_a.status}), cost {result_a.cost:.6f}",
              file=sys.stderr)
    peer = f"scipy {scipy.__version__} least_squares trf"
    for name, value, unit, better, target, peer_name, peer_value in (
            ("identify.speed_vs_scipy", by_differences / ours, "x", "higher", 50, peer, 1),
            ("identify.speed_vs_scipy_analytic_jacobian", analytic / ours, "x", "higher", None, peer + ", analytic Jacobian", 1),
            ("identify.speed_vs_scipy_worst_cost_ratio", max(worse), "", "lower", 1.000001, peer, 1)):
        print(json.dumps({"name": name, "value": round(value, 7), "unit": unit, "better": better, "target": target,
                          "peer": peer_name, "peer_value": peer_value}))


main()
