"""Runs the registered benchmarks and writes and prints their summary (called by `toolchains/dev bench`).

usage: bench.py LIST SUMMARY [PREFIX...]

LIST is what tests/bench/CMakeLists.txt registers. With PREFIX only the benchmarks that can hold rows of that name run, and the
rows of the others stay as they are in SUMMARY. Exit code: 0 all ran (a missed target is reported, it is no failure),
1 a benchmark failed or broke the format (its earlier rows are then dropped), 2 bad usage.
"""

import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path

FIELDS = ("name", "value", "unit", "better", "target", "peer", "peer_value")


class BrokenRow(Exception):
    pass


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def starts(name, prefix):
    """Whether `name` is `prefix` or continues it at a dot or an underscore."""
    return name == prefix or name.startswith((prefix + ".", prefix + "_"))


def row_of(bench, line):
    """The row that a line of standard output holds. BrokenRow says which field is wrong and what was expected."""
    try:
        row = json.loads(line)
    except json.JSONDecodeError:
        raise BrokenRow(f"expected a JSON object, found: {line[:100]}")
    if not isinstance(row, dict):
        raise BrokenRow(f"expected a JSON object, found: {line[:100]}")
    unknown = set(row) - set(FIELDS)
    if unknown:
        raise BrokenRow(f"unknown field {sorted(unknown)[0]!r}, expected {', '.join(FIELDS)}")
    checks = [
        ("name", isinstance(row.get("name"), str) and starts(row["name"], bench), f"a name that starts with {bench!r}"),
        ("value", row.get("value", "") is None or is_number(row.get("value")), "a finite number, or null for no answer"),
        ("unit", isinstance(row.get("unit"), str), "text"),
        ("better", row.get("better") in ("lower", "higher"), "'lower' or 'higher'"),
        ("target", "target" in row and (row["target"] is None or is_number(row["target"])), "a number or null"),
        ("peer", row.get("peer") is None or isinstance(row["peer"], str), "text or nothing"),
        ("peer_value", row.get("peer_value") is None or is_number(row["peer_value"]), "a number or nothing"),
    ]
    for field, holds, expected in checks:
        if not holds:
            raise BrokenRow(f"{row.get('name', '?')}: {field} is {row.get(field)!r}, expected {expected}")
    return {field: row.get(field) for field in FIELDS}


def verdict(row):
    if row["target"] is None:
        return ""
    if row["value"] is None:
        return "MISSED"
    met = row["value"] <= row["target"] if row["better"] == "lower" else row["value"] >= row["target"]
    return "met" if met else "MISSED"


def text_of(value):
    if value is None:
        return "-"
    if isinstance(value, int) or (abs(value) >= 1000 and abs(value) < 1e7):
        return f"{value:,.0f}"
    return f"{value:.4g}"


def print_table(rows):
    signs = {"lower": "<=", "higher": ">="}
    lines = [("name", "value", "unit", "target", "", "peer")]
    for row in rows:
        target = "reported" if row["target"] is None else f"{signs[row['better']]} {text_of(row['target'])}"
        peer = "" if row["peer"] is None else f"{row['peer']}: {text_of(row['peer_value'])}"
        lines.append((row["name"], text_of(row["value"]), row["unit"], target, verdict(row), peer))
    widths = [max(len(line[column]) for line in lines) for column in range(6)]
    for number, line in enumerate(lines):
        cells = [cell.rjust(width) if column in (1, 3) else cell.ljust(width)
                 for column, (cell, width) in enumerate(zip(line, widths))]
        print("  ".join(cells).rstrip())
        if number == 0:
            print("  ".join("-" * width for width in widths))


def run(bench):
    """The rows of one benchmark; its standard error passes through."""
    print(f"-- {bench['name']}", flush=True)
    start = time.monotonic()
    process = subprocess.run(bench["command"], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True)
    rows = [row_of(bench["name"], line) for line in process.stdout.splitlines() if line.strip()]
    if process.returncode != 0:
        raise BrokenRow(f"ended with {process.returncode}, expected 0")
    if not rows:
        raise BrokenRow("printed no row")
    print(f"   {time.monotonic() - start:.0f} s", flush=True)
    return rows


def write_whole(path, text):
    partial = path.with_name(path.name + f".{os.getpid()}.partial")
    partial.write_text(text, encoding="utf-8")
    partial.replace(path)


def main(arguments):
    if len(arguments) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    summary = Path(arguments[1])
    prefixes = arguments[2:]
    benches = json.loads(Path(arguments[0]).read_text(encoding="utf-8"))
    chosen = [bench for bench in benches
              if not prefixes or any(bench["name"].startswith(p) or p.startswith(bench["name"]) for p in prefixes)]
    if not chosen:
        known = ", ".join(bench["name"] for bench in benches) or "none is registered"
        print(f"bench: no benchmark {' or '.join(prefixes) or 'at all'}, expected one of: {known}", file=sys.stderr)
        return 2

    def owner(name):
        """The registered benchmark that a row belongs to: the longest that its name starts with."""
        return max((bench["name"] for bench in benches if starts(name, bench["name"])), key=len, default=None)

    earlier = json.loads(summary.read_text(encoding="utf-8")) if summary.exists() else []
    rows_of = {}
    for row in earlier:
        rows_of.setdefault(owner(row["name"]), []).append(row)
    failed = []
    for bench in chosen:
        try:
            rows_of[bench["name"]] = run(bench)
        except (BrokenRow, OSError) as fault:
            rows_of.pop(bench["name"], None)
            failed.append(bench["name"])
            print(f"bench: {bench['name']}: {fault}", file=sys.stderr)
        rows = [row for one in benches for row in rows_of.get(one["name"], [])]
        write_whole(summary, json.dumps(rows, indent=1) + "\n")  # after each, so that an interrupted run keeps its rows
    print()
    print_table(rows)
    print(f"\nwritten: {summary}")
    if failed:
        print(f"bench: failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
