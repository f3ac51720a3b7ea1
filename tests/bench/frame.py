"""Instructions of the dearest frame that plenum_frame_bench shows a node, counted by callgrind.

usage: frame.py PROGRAM

The row is the dearest frame of all; beside it, without a target, the dearest tick that works off what a frame has left to it. Standard
error has the dearest of each type.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

TRIGGER = "desc: Trigger: Client Request: "


def main():
    if shutil.which("valgrind") is None:
        sys.exit("frame: valgrind not found, expected on the PATH (apt install valgrind)")
    worst = {}  # of each type: instructions, and which frame it was
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["valgrind", "--tool=callgrind", "--collect-atstart=no", "--dump-instr=no",
                               f"--callgrind-out-file={folder}/out", sys.argv[1]],
                              capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"frame: {done.stderr.strip()}")
        for line in done.stderr.splitlines():
            if not line.startswith("=="):  # valgrind's own
                print(line, file=sys.stderr)
        for dump in Path(folder).glob("out.*"):
            lines = dump.read_text().splitlines()
            label = next((line.removeprefix(TRIGGER) for line in lines if line.startswith(TRIGGER)), None)
            if label is None:
                continue
            total = next(int(line.split()[1]) for line in lines if line.startswith("totals:"))
            kind, _, which = label.partition(": ")
            worst[kind] = max(worst.get(kind, (0, "")), (total, which))
    for kind, (total, which) in sorted(worst.items(), key=lambda item: -item[1][0]):
        print(f"{total:8d}  {kind}{f', {which}' if which else ''}", file=sys.stderr)
    for name, in_tick, target in [("", False, 3000), ("_in_its_tick", True, None)]:
        value = max(total for kind, (total, _) in worst.items() if kind.startswith("tick") == in_tick)
        print(json.dumps({"name": f"node.instructions_per_frame{name}", "value": value, "unit": "instructions",
                          "better": "lower", "target": target}))


if __name__ == "__main__":
    main()
