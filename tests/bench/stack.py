"""Bytes of stack that a call of the controller needs at most, by the call graph, and that such calls have used (tests/cost): of the
core of BUILD, and of the preset `fixed` beside it.

usage: stack.py BUILD     BUILD is build/PRESET
"""

import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "cost"))
from cost import stack_needs, stack_used  # noqa: E402

TARGET = {"Controller::step": 4096}  # eight chambers
NAMES = {"Controller::step": "tick", "Controller::receive": "receive", "Controller::next_frame": "next_frame"}


def print_row(name, value, target):
    print(json.dumps({"name": f"stack.bytes_{name}", "value": value, "unit": "bytes", "better": "lower", "target": target}))


def measure(folder, suffix):
    subprocess.run(["cmake", "--build", folder, "--target", "plenum_cost"], check=True, stdout=sys.stderr)
    build = json.loads(Path(folder, "cost", "build.json").read_text(encoding="utf-8"))
    needs, used = stack_needs(build), stack_used(build)
    for entry, name in NAMES.items():
        print_row(name + suffix, needs[entry].bytes, TARGET.get(entry))
        print_row(f"{name}_used{suffix}", used[entry], None)


def main():
    folder = Path(sys.argv[1]).resolve()
    measure(folder, "")
    fixed = folder.with_name("fixed")
    if not (fixed / "build.ninja").exists():
        subprocess.run(["cmake", "--preset", "fixed"], cwd=Path(__file__).parents[2], check=True, stdout=sys.stderr)
    measure(fixed, "_fixed")


if __name__ == "__main__":
    main()
