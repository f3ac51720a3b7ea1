"""Runs the fuzzers of build/fuzz (called by `toolchains/dev fuzz` and the benchmark sdo.fuzz_execs).

usage: fuzz.py BUILD SEEDS SECONDS [--row]

Runs each of the fuzzers BUILD/bin/fuzz_* for SECONDS, beginning with the inputs in SEEDS/NAME and with what earlier runs
found (BUILD/corpus/NAME). A crash, a leak, a claim that does not hold or an input that takes 10 s ends that fuzzer; the input is
kept as BUILD/found/NAME-*. --row prints the benchmark's row. Exit code: 0 nothing found, 1 something found, 2 bad usage.
"""

import json
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path


def run(program, seeds, build, seconds):
    name = program.name.removeprefix("fuzz_")
    corpus, found = build / "corpus" / name, build / "found"
    corpus.mkdir(parents=True, exist_ok=True)
    found.mkdir(exist_ok=True)
    command = [program, f"-max_total_time={seconds}", "-print_final_stats=1", "-timeout=10", "-rss_limit_mb=2048",
               f"-artifact_prefix={found}/{name}-", corpus, seeds / name]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace")
    count = re.search(r"stat::number_of_executed_units:\s*(\d+)", done.stderr)
    return name, int(count[1]) if count else 0, done.returncode == 0, done.stderr


def main(arguments):
    row = "--row" in arguments
    arguments = [a for a in arguments if a != "--row"]
    if len(arguments) != 3 or not arguments[2].isdigit():
        print(__doc__, file=sys.stderr)
        return 2
    build, seeds, seconds = Path(arguments[0]), Path(arguments[1]), int(arguments[2])
    programs = sorted(p for p in (build / "bin").glob("fuzz_*") if os.access(p, os.X_OK))
    if not programs:
        print(f"fuzz: no fuzz_* in {build / 'bin'}, expected a build of the preset fuzz", file=sys.stderr)
        return 2
    total, clean = 0, True
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, count, ok, log in pool.map(lambda p: run(p, seeds, build, seconds), programs):
            total += count
            clean = clean and ok
            print(f"fuzz_{name}: {count} executions, {'nothing found' if ok else 'FOUND SOMETHING:'}", file=sys.stderr)
            if not ok:
                print(log[-4000:], file=sys.stderr)
    if row:
        print(json.dumps({"name": "sdo.fuzz_execs", "value": total if clean else None, "unit": "executions", "better": "higher",
                          "target": 20_000_000}))
    return 0 if clean else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
