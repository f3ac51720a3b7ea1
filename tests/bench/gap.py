"""The diagnosis of sealed cases, scored: rows of `plenum blind score` against the targets, and how long a diagnosis takes.

usage: gap.py PLENUM [--cases N] [--none N] [--struck N] [--seed N] [--keep DIR] [--picture FILE.svg]
       gap.py PLENUM --seconds

Three sets are made: N cases of every kind and tier; N without any effect, for the false alarms, which are counted over the
effectless cases of both; and N of one effect, which is struck from the catalogue: what is left must then not explain the gap, unless it
fits within the noise, and the equation should still be found. `plenum diagnose` gets log, held-out log and rig of each, and nothing
else of the set. The seed is one that nothing was tuned on. A case that is refused, or on which the program fails, is a case without an
answer: wrong in each share. The score, its confusion matrix and each wrong answer go to standard error; --keep leaves sets, answers and
scores in DIR, --picture draws the matrix.

With --seconds: the wall time of a whole diagnosis of a log of 100 s and its held-out log of 60 s, nothing else running, the median of
three cases of one effect each (tier 1).
"""

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

SEED = 20261230
SIDE_BY_SIDE = 2
AT_FLOOR = 1.12  # of the noise floor: within it an answer fits
CONFIDENT = 0.8  # of a name
TIMED_CASES, TIMED_SECONDS = 3, 100


def say(text):
    print(text, file=sys.stderr, flush=True)


def row(name, value, unit, better, target):
    value = None if value is None else round(value, 4)
    print(json.dumps({"name": name, "value": value, "unit": unit, "better": better, "target": target}), flush=True)


def generate(plenum, folder, cases, seed, *more):
    subprocess.run([plenum, "blind", "generate", "--out", folder, "--cases", str(cases), "--seed", str(seed), *more],
                   check=True, stdout=subprocess.DEVNULL)
    return sorted(folder.glob("case-*"))


def diagnose(plenum, case, answer, *more):
    """The program's exit code and its last word on standard error; its answer is at `answer`, if it has one."""
    done = subprocess.run([plenum, "diagnose", "--rig", case / "rig.toml", "--heldout", case / "heldout.csv",
                           "--json", answer, *more, case / "log.csv"],
                          stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    words = done.stderr.strip().splitlines()
    return done.returncode, words[-1] if words else "no word on standard error"


def score(plenum, name, folder, cases, seed, *more):
    say(f"gap: making {cases} cases, {name}")
    made = generate(plenum, folder / name, cases, seed, *more)
    answers = folder / f"{name}-answers"
    answers.mkdir()
    begin = time.monotonic()
    with ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        waiting = {pool.submit(diagnose, plenum, case, answers / f"{case.name}.json"): case.name for case in made}
        for number, one in enumerate(as_completed(waiting), start=1):
            code, word = one.result()
            if code != 0:
                (answers / f"{waiting[one]}.json").unlink(missing_ok=True)
                say(f"gap: {waiting[one]} of {name}: exit {code}: {word}")
            if number % 10 == 0 or number == len(made):
                say(f"gap: {number} of {len(made)} diagnosed, {time.monotonic() - begin:.0f} s")
    if not any(answers.iterdir()):
        sys.exit(f"gap: not one of {len(made)} cases has an answer")
    file = folder / f"{name}-score.json"
    text = subprocess.run([plenum, "blind", "score", folder / name, "--answers", answers, "--json", file],
                          check=True, stdout=subprocess.PIPE, text=True).stdout
    say(f"\n{name}, seed {seed}\n{text}")
    result = json.loads(file.read_text(encoding="utf-8"))
    for wrong in result["mistakes"]:
        truth = ", ".join(f"{one['id']} {one['alone_over_floor']:.1f}" for one in wrong["truth"]) or "none"
        said = ", ".join("~".join([f"{one['id']} {one['confidence']:.2f}", *one["aliases"]]) for one in wrong["effects"])
        say(f"{wrong['case']} tier {wrong['tier']}, {wrong['what']}: truth (over the floor) {truth}; "
            f"{wrong['verdict']}: {said or 'nothing named'}; equation {wrong['equation'] or 'none'}")
    return result


def picture(confusion, cases, seed):
    """The matrix as an SVG: a row a truth, a column a first answer, darker where more of the row; blue is right, red is not."""
    truths, counts = confusion["truth"], confusion["counts"]
    answers = [one for column, one in enumerate(confusion["answer"]) if any(row[column] for row in counts)]
    rows = [[count for one, count in zip(confusion["answer"], row) if one in answers] for row in counts]
    side, left, top = 30, 190, 170
    width, height = left + side * len(answers) + 110, top + side * len(truths) + 40
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
             f'<rect width="{width}" height="{height}" fill="#fff"/>',
             f'<text x="10" y="{height - 12}" fill="#444">{cases} sealed cases, seed {seed}; row: true cause, column: first answer; '
             'number of cases, shade: share of the row; blue: right</text>']
    for column, answer in enumerate(answers):
        x = left + side * column + side / 2 + 4
        parts.append(f'<text transform="translate({x},{top - 8}) rotate(-60)" fill="#222">{answer}</text>')
    for line, truth in enumerate(truths):
        y = top + side * line
        row = rows[line]
        parts.append(f'<text x="{left - 8}" y="{y + side / 2 + 4}" text-anchor="end" fill="#222">{truth}</text>')
        for column, answer in enumerate(answers):
            count = row[column]
            share = count / max(sum(row), 1)
            right = answer in (truth, "ambiguous, truth in it") or (answer == "unexplained" and truth not in confusion["answer"])
            hue = "31,119,180" if right else "200,80,40"
            parts.append(f'<rect x="{left + side * column}" y="{y}" width="{side - 1}" height="{side - 1}" '
                         f'fill="rgba({hue},{share:.2f})" stroke="#ddd"/>')
            if count:
                parts.append(f'<text x="{left + side * column + side / 2}" y="{y + side / 2 + 4}" text-anchor="middle" '
                             f'fill="{"#fff" if share > 0.5 else "#222"}">{count}</text>')
    return "\n".join([*parts, "</svg>", ""])


def percent(told):
    return 100 * sum(told) / len(told) if told else None


def struck(plenum, folder, cases, seed):
    """The answers where the true effect is no hypothesis: flagged, and another blamed with confidence, of those that nothing else
    fits; right equation of those that a recording can show."""
    made = generate(plenum, folder / "struck", cases, seed, "--kind", "one")
    answers = folder / "struck-answers"
    answers.mkdir()

    def one(case):
        label = json.loads((folder / "struck" / "labels" / f"{case.name}.json").read_text(encoding="utf-8"))
        effect, floor = label["effects"][0], label["noise_floor_Pa"]
        if label["recalibrated_gap_Pa"] < floor:
            return None
        answer = answers / f"{case.name}.json"
        code, word = diagnose(plenum, case, answer, "--strike", effect["id"])
        if code != 0:
            say(f"gap: {case.name} without {effect['id']}: exit {code}: {word}")
            return False, False, True, False
        gap = json.loads(answer.read_text(encoding="utf-8"))
        flagged = gap["verdict"] in ("unexplained", "partly_explained")
        right = gap["equation"] is not None and gap["equation"]["id"] == effect["equation"]
        fitted = not flagged and 1e3 * gap["gap_kPa"]["with_effects"] <= AT_FLOOR * floor
        if not flagged and not fitted:
            named = ", ".join(f"{other['id']} {other['confidence']:.2f}" for other in gap["effects"])
            say(f"gap: {case.name} tier {label['tier']} without {effect['id']}: {gap['verdict']}: {named or 'nothing named'}")
        return flagged, right, not fitted, any(other["confidence"] >= CONFIDENT for other in gap["effects"])

    with ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        told = [answer for answer in pool.map(one, made) if answer is not None]
    counted = [(flagged, blamed) for flagged, _, open_gap, blamed in told if open_gap]
    row("gap.struck_flagged_percent", percent([flagged for flagged, _ in counted]), "%", "higher", None)
    row("gap.struck_blamed_percent", percent([blamed for _, blamed in counted]), "%", "lower", None)
    row("gap.struck_equation_percent", percent([right for _, right, _, _ in told]), "%", "higher", None)


def shares(plenum, options, folder):
    all_kinds = score(plenum, "all", folder, options.cases, options.seed)
    if options.picture:
        options.picture.write_text(picture(all_kinds["confusion"], options.cases, options.seed), encoding="utf-8")
    none = score(plenum, "none", folder, options.none, options.seed + 1, "--kind", "none")
    top1 = all_kinds["top1_percent"]

    def of_tier(tier):
        return top1[tier]["percent"] if tier in top1 else None  # few cases: not every tier has one that counts

    alarms = [one["false_alarm_percent"] for one in (all_kinds, none)]
    quiet = sum(one["of"] for one in alarms)
    row("gap.top1_tier1_percent", of_tier("tier1"), "%", "higher", 97)
    row("gap.top1_tier2_percent", of_tier("tier2"), "%", "higher", 92)
    row("gap.top1_tier3_percent", of_tier("tier3"), "%", "higher", None)
    row("gap.top1_percent", top1["all"]["percent"], "%", "higher", None)
    row("gap.singleton_correct_percent", all_kinds["singleton_correct_percent"]["percent"], "%", "higher", 99)
    row("gap.coverage_percent", all_kinds["coverage_percent"]["percent"], "%", "higher", 98)
    row("gap.multi_f1", all_kinds["multi_f1"]["f1"], "", "higher", 0.90)
    row("gap.false_alarm_percent", 100 * sum(one["right"] for one in alarms) / quiet if quiet else None, "%", "lower", 1)
    row("gap.unknown_flagged_percent", all_kinds["unknown_flagged_percent"]["percent"], "%", "higher", 90)
    row("gap.closed_median_percent", all_kinds["closed_median_percent"], "%", "higher", 97)
    row("gap.equation_named_percent", all_kinds["equation_named_percent"]["percent"], "%", "higher", 95)
    row("gap.equation_before_names_percent", all_kinds["equation_before_names_percent"]["percent"], "%", "higher", 95)
    row("gap.calibration_error", all_kinds["calibration_error"], "", "lower", 0.05)
    struck(plenum, folder, options.struck, options.seed + 2)
    row("gap.without_answer", all_kinds["missing_answers"] + none["missing_answers"], "cases", "lower", 0)
    row("gap.cases", all_kinds["cases"] + none["cases"], "cases", "higher", None)


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def seconds(plenum, options, folder):
    took = []
    for case in generate(plenum, folder / "timed", TIMED_CASES, options.seed, "--kind", "one", "--tier", "1",
                         "--seconds", str(TIMED_SECONDS)):
        begin, used = time.monotonic(), processor_seconds()
        code, word = diagnose(plenum, case, folder / "timed.json")
        took.append(time.monotonic() - begin)
        say(f"gap: {case.name}: {took[-1]:.1f} s, {processor_seconds() - used:.1f} s of the processors")
        if code != 0:
            sys.exit(f"gap: {case.name}: exit {code}: {word}")
    row("gap.seconds", statistics.median(took), "s", "lower", 8)
    row("gap.seconds_worst", max(took), "s", "lower", None)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plenum")
    parser.add_argument("--cases", type=int, default=120)
    parser.add_argument("--none", type=int, default=300)
    parser.add_argument("--struck", type=int, default=42)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--seconds", action="store_true")
    options = parser.parse_args()
    measure = seconds if options.seconds else shares
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
        measure(options.plenum, options, options.keep)
    else:
        with tempfile.TemporaryDirectory() as folder:
            measure(options.plenum, options, Path(folder))


if __name__ == "__main__":
    main()
