"""The operations of the core's fixed-point number beside libfixmath's: their errors, and by callgrind the instructions of a call.

usage: fixmath.py PROGRAM
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

OPERATIONS = ("product", "quotient", "root", "exponential")
CALLS = 100000  # of the program


def instructions(program, operation, who):
    """Of a call, its wrapper's few included."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        done = subprocess.run(["valgrind", "--tool=callgrind", f"--toggle-collect=counted_{who}", f"--callgrind-out-file={out}",
                               program, operation, who], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"fixmath: {done.stderr.strip()}")
        return next(int(line.split()[1]) for line in out.read_text().splitlines() if line.startswith("totals:")) / CALLS


def main():
    program = sys.argv[1]
    subprocess.run([program], check=True)
    if shutil.which("valgrind") is None:
        print("fixmath: valgrind not found; toolchains/dev setup installs it", file=sys.stderr)
        return
    for operation in OPERATIONS:
        print(json.dumps({"name": f"fixed.operation_{operation}_instructions", "value": round(instructions(program, operation, "ours")),
                          "unit": "instructions", "better": "lower", "target": None, "peer": "libfixmath",
                          "peer_value": round(instructions(program, operation, "theirs"))}), flush=True)


if __name__ == "__main__":
    main()
