"""Instructions of a tick on a board without floating point: the core in fixed point against the core in float.

usage: soft_tick.py FOLDER     FOLDER takes what is compiled

Both cores are compiled for armel with soft_tick.cpp and run under qemu-user, whose log of the blocks that it executes, each with its
length, gives the count. A tick's part is the difference to a run that draws the same scenes and leaves the controller alone.
"""

import json
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent.parent
COMPILER = "arm-linux-gnueabi-g++"
EMULATOR = ["qemu-arm-static", "-cpu", "arm926"]
# as the preset armel compiles firmware/
FLAGS = ["-std=c++20", "-O2", "-DNDEBUG", "-fno-exceptions", "-fno-rtti", "-fno-threadsafe-statics", "-ffp-contract=off",
         "-fno-math-errno", "-fno-trapping-math", "-DEIGEN_NO_MALLOC", "-DEIGEN_NO_DEBUG", "-DEIGEN_DONT_VECTORIZE", "-Wno-psabi",
         f"-I{TOP}", "-isystem", "/usr/include/eigen3"]
SCALARS = {"float": [], "fixed": ["-DPLENUM_SCALAR_FIXED"]}

# of the log: a block's instructions after its "IN:", and a "Trace" line with its address each time that it is executed
COUNT = r"""
/^IN:/    { first = 1; next }
/^0x/     { if (first) { at = substr($1, 3, 8); length_of[at] = 0; first = 0 }; ++length_of[at]; next }
/^Trace/  { split($0, part, "/"); ++times[part[2]] }
END       { for (at in times) sum += times[at] * length_of[at]; printf "%d\n", sum }
"""


def program_of(scalar, folder):
    target = folder / scalar
    target.mkdir(parents=True, exist_ok=True)
    sources = sorted((TOP / "firmware").rglob("*.cpp")) + [TOP / "tests/bench/soft_tick.cpp"]
    objects = [target / ("_".join(source.relative_to(TOP).parts) + ".o") for source in sources]

    def compile_one(source, made):
        subprocess.run([COMPILER, *FLAGS, *SCALARS[scalar], "-c", str(source), "-o", str(made)], check=True)

    with ThreadPoolExecutor() as workers:
        list(workers.map(compile_one, sources, objects))
    program = target / "soft_tick"
    subprocess.run([COMPILER, "-static", *map(str, objects), "-o", str(program)], check=True)
    return program


def instructions(program, kind, part):
    run = [*EMULATOR, "-d", "in_asm,exec,nochain", str(program), kind, part]
    with subprocess.Popen(run, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        counted = subprocess.run(["awk", COUNT], stdin=running.stderr, capture_output=True, text=True, check=True)
        ticks = int(running.stdout.read())
    if running.returncode != 0:
        sys.exit(f"soft_tick: {program} {kind} {part}: not every tick regulated; the count is void")
    return int(counted.stdout), ticks


def tick_of(program, kind):
    (whole, ticks), (idle, _) = instructions(program, kind, "run"), instructions(program, kind, "idle")
    return (whole - idle) / ticks


def main():
    missing = [tool for tool in (COMPILER, EMULATOR[0], "awk") if shutil.which(tool) is None]
    if missing:
        print(f"soft_tick: {', '.join(missing)} not found; toolchains/dev build armel installs them", file=sys.stderr)
        return
    programs = {scalar: program_of(scalar, Path(sys.argv[1])) for scalar in SCALARS}
    for kind, name in (("tassa9", ""), ("greybox", "_greybox")):
        ticks = {scalar: tick_of(program, kind) for scalar, program in programs.items()}
        rows = [(f"fixed.tick_cost_vs_softfloat{name}", round(ticks["fixed"] / ticks["float"], 3), "x", None if name else 0.2)]
        rows += [(f"fixed.tick_instructions_armel_{scalar}{name}", round(ticks[scalar]), "instructions", None) for scalar in SCALARS]
        for row, value, unit, target in rows:
            print(json.dumps({"name": row, "value": value, "unit": unit, "better": "lower", "target": target}), flush=True)


if __name__ == "__main__":
    main()
