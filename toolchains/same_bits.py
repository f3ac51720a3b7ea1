"""Compiles the core with every compiler at every level of optimisation and has each give the same commands, bit for bit
(called by `toolchains/dev same-bits`).

usage: same_bits.py BUILD...

BUILD is a configured build folder of this machine, one a scalar type: the sources of plenum_same_bits and their options are
those of its compile_commands.json, but for compiler, level and warnings. Sources of the same options are compiled as one: all
of it takes two fifths of the processor time so, and the compiler has more to move about. The programs of other architectures
run under qemu-user. All goes to build/same-bits. Each program is shown tests/data/bits/recording.txt, and its digest is the one
in expected.txt.

Exit code: 0 all digests are the expected one, 1 one is not, 2 bad usage, a compiler that is missing or refuses.
"""

import json
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent
LEVELS = ("-O0", "-O2", "-O3")
DATA = TOP / "tests" / "data" / "bits"


class Impossible(Exception):
    pass


def targets():
    """Name, compiler and emulator: this machine's two, and those of the toolchain files of the boards."""
    machine = platform.machine()
    found = [(f"{machine} g++", "g++", []), (f"{machine} clang++", "clang++", [])]
    for preset in ("aarch64", "armhf", "armel"):
        text = (TOP / "toolchains" / "cmake" / f"{preset}.cmake").read_text(encoding="utf-8")
        triplet, qemu = (re.search(rf"set\(plenum_{what} ([^)]+)\)", text)[1] for what in ("triplet", "qemu"))
        found.append((f"{preset} g++", f"{triplet}-g++", qemu.split()))
    return found


def units(build):
    """What plenum_same_bits is made of: its sources by their words of command, without compiler, output and what this varies."""
    chosen = {}
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        words = shlex.split(entry["command"])
        # other targets may compile a source of the core once more, for ends of their own
        if not re.search(r"/plenum_(firmware|same_bits)\.dir/", words[words.index("-o") + 1]):
            continue
        launcher = words[:1] if Path(words[0]).name == "ccache" else []
        kept = []
        rest = iter(words[len(launcher) + 1:])
        for word in rest:
            if word in ("-o", "-MT", "-MF", "-c"):
                next(rest)
            elif not re.fullmatch(r"-O.|-g.?|-W.*|-MD", word):
                kept.append(word)
        chosen.setdefault((*launcher, "COMPILER", *kept), []).append(Path(entry["directory"], entry["file"]).resolve())
    if sum(map(len, chosen.values())) < 2:
        raise Impossible(f"{build}/compile_commands.json names no source of the core")
    return chosen


def run(command):
    done = subprocess.run(command, cwd=TOP, capture_output=True, text=True)
    if done.returncode != 0:
        raise Impossible(f"{shlex.join(map(str, command))}\n{done.stderr}")


def made_by(core, target, level, folder):
    """The program of one row."""
    _, compiler, emulator = target
    folder.mkdir(parents=True, exist_ok=True)
    objects = []
    for number, (words, sources) in enumerate(core.items()):
        unit = folder / f"unit-{number}.cpp"
        unit.write_text("".join(f'#include "{source.relative_to(TOP)}"\n' for source in sources), encoding="utf-8")
        objects.append(unit.with_suffix(".o"))
        run([*(compiler if word == "COMPILER" else word for word in words), "-w", level, "-c", unit, "-o", objects[-1]])
    program = folder / "plenum_same_bits"
    run([compiler, *objects, *(["-static"] if emulator else []), "-o", program])
    return program


def shown_the_recording(build, core, target, level):
    """What a row prints, and what its program says against the digest expected; nothing if that is met."""
    name, compiler, emulator = target
    program = made_by(core, target, level, TOP / "build" / "same-bits" / build.name / f"{compiler}{level}")
    done = subprocess.run([*emulator, program, DATA / "recording.txt", DATA / "expected.txt"], capture_output=True, text=True)
    differs = done.returncode != 0
    return f"{build.name:<8} {name:<16} {level}  {'DIFFERS' if differs else 'same'}", f"{done.stderr}\n" if differs else ""


def main(arguments):
    if not arguments:
        print(__doc__, file=sys.stderr)
        return 2
    for name, compiler, emulator in targets():
        for program in (compiler, *emulator[:1]):
            if shutil.which(program) is None:
                raise Impossible(f"{name} asks for {program}: see toolchains/packages.txt and packages-cross.txt")
    differing = 0
    with ThreadPoolExecutor(int(os.environ.get("JOBS", os.cpu_count()))) as pool:
        rows = [pool.submit(shown_the_recording, build, core, target, level)
                for build, core in ((build, units(build)) for build in map(Path, arguments))
                for target in targets() for level in LEVELS]
        try:
            for row in rows:
                line, fault = row.result()
                print(line, flush=True)
                if fault:
                    differing += 1
                    print(fault, file=sys.stderr, flush=True)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return 1 if differing else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except (Impossible, OSError) as fault:
        print(f"same-bits: {fault}", file=sys.stderr)
        sys.exit(2)
