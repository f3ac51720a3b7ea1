"""Instructions of the dearest tick that plenum_tick_bench finds, counted by callgrind.

usage: tick.py PROGRAM [FILE]     FILE takes the callgrind profile of the dearest step, for callgrind_annotate
       tick.py PROGRAM --greybox  what models of the grey-box kind cost over those of the 9-parameter kind
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path


def counts_of(program, kind, profile=None):
    """Of each tick the instructions of its parts: {"receive": [...], "step": [...], "send": [...]}."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["valgrind", "--tool=callgrind", "--collect-atstart=no", "--dump-instr=no",
                               f"--callgrind-out-file={folder}/out", program, kind],
                              capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"tick: {done.stderr.strip()}")
        counts = {"receive": [], "step": [], "send": []}
        dumps = []
        for dump in sorted(Path(folder).glob("out.*"), key=lambda path: int(path.suffix[1:])):
            lines = dump.read_text().splitlines()
            part = next((part for line in lines if line.startswith("desc: Trigger:") for part in counts
                         if line.endswith(f" {part}")), None)
            if part is None:
                continue
            counts[part].append(next(int(line.split()[1]) for line in lines if line.startswith("totals:")))
            if part == "step":
                dumps.append(dump)
        if profile is not None:
            shutil.copy(max(zip(counts["step"], dumps))[1], profile)
    return counts


def dearest_and_mean(counts):
    steps = counts["step"]
    return max(steps), sum(steps) / len(steps)


def print_row(name, value, unit, target=None):
    print(json.dumps({"name": name, "value": value, "unit": unit, "better": "lower", "target": target}), flush=True)


def print_greybox(program):
    (tassa9, tassa9_mean), (greybox, greybox_mean) = (dearest_and_mean(counts_of(program, kind))
                                                      for kind in ("tassa9", "greybox"))
    print_row("model.greybox_tick_cost_vs_tassa9", round(greybox / tassa9, 3), "x", 1.5)
    print_row("model.greybox_tick_cost_mean_vs_tassa9", round(greybox_mean / tassa9_mean, 3), "x")
    print_row("model.greybox_tick_cost_instructions", greybox, "instructions")
    print_row("model.greybox_tick_cost_instructions_mean", round(greybox_mean), "instructions")


def print_tick(program, profile):
    counts = counts_of(program, "tassa9", profile)
    dearest, mean = dearest_and_mean(counts)
    print_row("tick.instructions_8_chambers", dearest, "instructions", 20000)
    print_row("tick.instructions_8_chambers_mean", round(mean), "instructions")
    print_row("tick.instructions_8_chambers_with_frames", max(sum(parts) for parts in zip(*counts.values())), "instructions")
    dearest, mean = dearest_and_mean(counts_of(program, "tassa9r"))
    print_row("tick.instructions_8_chambers_tassa9r", dearest, "instructions")
    print_row("tick.instructions_8_chambers_tassa9r_mean", round(mean), "instructions")


def main():
    if shutil.which("valgrind") is None:
        sys.exit("tick: valgrind not found, expected on the PATH (apt install valgrind)")
    if sys.argv[2:] == ["--greybox"]:
        print_greybox(sys.argv[1])
    else:
        print_tick(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None)


if __name__ == "__main__":
    main()
