"""Measured runs with an error of the sensor or a delay put in exactly: is what was put in named, and nothing where nothing was?

usage: spiked.py PLENUM DATA [--answers]

DATA holds the ventilator's oxygen runs (ctl_OXY_N.csv). Each run is cut in half; the first half is the baseline, the second is changed.
The machine is far outside what the nominal model holds (README.md of host-sim/identify), so only the baseline can say
what is new. A spike counts as shown where its half errs by 12 % more, as configured, than the model errs on the baseline.

And runs of a new pinch valve (pinch_new_N.csv) as the baselines of the same tests with one that has worked 594 hours (pinch_594h_N.csv).
What has worn is not known: told is how many of the tests agree on what has changed. Of the new valve the second half against the first is
one more from which nothing may be named.

--answers tells each answer on standard error.
"""

import argparse
import csv
import json
import math
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SIDE_BY_SIDE = 2
SHOWN = 1.12
TICK_S = 0.01


def lagged(pressure, seconds):
    keep = math.exp(-TICK_S / seconds)
    late = pressure[:1]
    for reading in pressure[1:]:
        late.append(keep * late[-1] + (1.0 - keep) * reading)
    return late


def delayed(pressure, seconds):
    rows = round(seconds / TICK_S)
    return pressure[:1] * rows + pressure[:-rows]


# the effect put in, its size in words, and how; gauge pressures in kPa
SPIKES = [
    ("sensor_lag", "50 ms", lambda p: lagged(p, 0.05)),
    ("sensor_lag", "150 ms", lambda p: lagged(p, 0.15)),
    ("dead_time", "50 ms", lambda p: delayed(p, 0.05)),
    ("sensor_bias", "0.5 kPa", lambda p: [one + 0.5 for one in p]),
    ("sensor_bias", "gain 1.2", lambda p: [1.2 * one for one in p]),
    (None, "nothing", lambda p: p),
]
WORN = "worn"


def write(path, header, rows, pressure, span):
    at = header.index("pressure")
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for tick, row in enumerate(range(*span)):
            cells = list(rows[row])
            cells[0], cells[at] = f"{tick * TICK_S:.3f}", f"{pressure[row]:.6f}"
            writer.writerow(cells)


def halves(folder, run, spike):
    """The first half of a run as it was measured, the second with its spike."""
    with open(run, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    at = header.index("pressure")
    measured = [float(row[at]) for row in rows]
    middle = len(rows) // 2
    here = folder / f"{run.stem}-{SPIKES.index(spike)}"
    (here / "before").mkdir(parents=True)
    write(here / "before" / run.name, header, rows, measured, (0, middle))
    write(here / run.name, header, rows, spike[2](measured), (middle, len(rows)))
    return here / "before" / run.name, here / run.name


def answer(plenum, before, after):
    done = subprocess.run([plenum, "diagnose", "--format", "respiraworks", "--baseline", before, after, "--json", "-"],
                          capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"spiked: {after.name}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def named(said):
    """The effects named, and with them those that they are not told from."""
    ids = [effect["id"] for effect in said["effects"]]
    return ids, set(ids).union(*(effect["aliases"] for effect in said["effects"]))


def count(counts, said, truth):
    ids, alike = named(said)
    gap = said["gap_kPa"]
    if truth is None:
        counts["plain"] += 1
        counts["plain_blamed"] += bool(ids)
    elif gap["as_configured"] > SHOWN * gap["noise_floor"]:
        counts["shown"] += 1
        counts["within"] += truth in alike
        if len(alike) == 1:
            counts["alone"] += 1
            counts["alone_right"] += alike == {truth}
    else:
        counts["hidden_blamed"] += bool(ids)


def tell(said, run, what, size):
    gap = said["gap_kPa"]
    print(f"{run.stem} {what:<12} {size:<9} {said['verdict']:<17} {', '.join(named(said)[0]) or '-'}"
          f"   {gap['as_configured']:.3f} > {gap['noise_floor']:.3f} kPa", file=sys.stderr, flush=True)


def row(name, value, unit, better):
    print(json.dumps({"name": name, "value": round(value, 4), "unit": unit, "better": better, "target": None}), flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("plenum")
    parser.add_argument("data", type=Path)
    parser.add_argument("--answers", action="store_true")
    options = parser.parse_args()
    runs = sorted(options.data.glob("ctl_OXY_*.csv"))
    new = sorted(options.data.glob("pinch_new_*.csv"))
    worn = [run.with_name(run.name.replace("new", "594h")) for run in new]
    for found, expected in ((runs, "ctl_OXY_N.csv"), (new, "pinch_new_N.csv")):
        if not found:
            sys.exit(f"spiked: {options.data}: no {expected} there")
    counts = {"shown": 0, "within": 0, "alone": 0, "alone_right": 0, "hidden_blamed": 0, "plain": 0, "plain_blamed": 0}
    first_named = Counter()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        spiked = [(run, spike) for run in runs for spike in SPIKES] + [(run, SPIKES[-1]) for run in new]
        cases = [(run, *spike[:2], halves(Path(folder), run, spike)) for run, spike in spiked]
        cases += [(after, None, WORN, (before, after)) for before, after in zip(new, worn)]
        answers = pool.map(lambda case: answer(options.plenum, *case[-1]), cases)
        for (run, truth, size, _), said in zip(cases, answers):
            if size == WORN:
                first_named.update(named(said)[0][:1])
            else:
                count(counts, said, truth)
            if options.answers:
                tell(said, run, truth or "-", size)
    print(f"spiked: {counts}, of {len(worn)} worn: {dict(first_named)}", file=sys.stderr)
    row("spiked.named_percent", 100.0 * counts["within"] / max(counts["shown"], 1), "%", "higher")
    row("spiked.alone_right_percent", 100.0 * counts["alone_right"] / max(counts["alone"], 1), "%", "higher")
    row("spiked.false_alarm_percent", 100.0 * counts["plain_blamed"] / counts["plain"], "%", "lower")
    row("spiked.worn_agreement_percent", 100.0 * max(first_named.values(), default=0) / len(worn), "%", "higher")


main()
