"""Nanoseconds of one chamber over one tick, as rows: what plenum_plant_bench (Google Benchmark) measures.

usage: plant.py PROGRAM
"""

import json
import subprocess
import sys


def main():
    done = subprocess.run([sys.argv[1], "--benchmark_format=json", "--benchmark_min_time=0.1"],
                          capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"plant: {done.stderr.strip()}")
    for one in json.loads(done.stdout)["benchmarks"]:
        name = one["name"].replace("/", ".")
        print(json.dumps({"name": f"plant.{name}_ns", "value": round(one["cpu_time"], 1), "unit": one["time_unit"],
                          "better": "lower", "target": None}))


if __name__ == "__main__":
    main()
