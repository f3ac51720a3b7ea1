"""Instructions of the dearest tick that plenum_tick_bench finds, counted by callgrind.

usage: tick.py PROGRAM [FILE]    FILE takes the callgrind profile of the dearest step, for callgrind_annotate
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path


def main():
    if shutil.which("valgrind") is None:
        sys.exit("tick: valgrind not found, expected on the PATH (apt install valgrind)")
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["valgrind", "--tool=callgrind", "--collect-atstart=no", "--dump-instr=no",
                               f"--callgrind-out-file={folder}/out", sys.argv[1]],
                              capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"tick: {done.stderr.strip()}")
        counts = {"receive": [], "step": [], "send": []}
        for dump in sorted(Path(folder).glob("out.*"), key=lambda path: int(path.suffix[1:])):
            lines = dump.read_text().splitlines()
            part = next((part for line in lines if line.startswith("desc: Trigger:") for part in counts
                         if line.endswith(f" {part}")), None)
            if part is None:
                continue
            total = next(int(line.split()[1]) for line in lines if line.startswith("totals:"))
            counts[part].append((total, dump))
        dearest, profile = max(counts["step"])
        whole = max(sum(total for total, _ in parts) for parts in zip(*counts.values()))
        mean = sum(total for total, _ in counts["step"]) / len(counts["step"])
        if len(sys.argv) > 2:
            shutil.copy(profile, sys.argv[2])
    for name, value, target in [("tick.instructions_8_chambers", dearest, 20000),
                                ("tick.instructions_8_chambers_mean", round(mean), None),
                                ("tick.instructions_8_chambers_with_frames", whole, None)]:
        print(json.dumps({"name": name, "value": value, "unit": "instructions", "better": "lower", "target": target}))


if __name__ == "__main__":
    main()
