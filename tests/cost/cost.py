"""What the core costs, measured, and compared with the table that stands in the tree (called by `toolchains/dev cost`).

usage: cost.py [--write] [--table FILE] BUILD_JSON...

BUILD_JSON is build/PRESET/cost/build.json. Of each build are measured: the stack that the core's entries may need at most, by the
call graph (call_graph.py); the stack that they really used (stack.cpp), which must lie under that bound and over half of it; and,
where the build is for this machine, the instructions of the dearest calls that a search finds, under callgrind (instructions.cpp).

A row that grew by more than 10 % fails. One that shrank by more asks to be written anew, so that it cannot grow back unseen. Figures
of another compiler are not compared. --write searches several times as long, takes over what is measured, and keeps the dearest cases
in FILE's cases.json: there each search begins, so that what a change costs is seen on the very same cases. Exit code: 0 nothing grew,
1 something did or could not be measured, 2 bad usage.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from itertools import repeat
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from call_graph import CallGraph, RefusedGraph  # noqa: E402

TABLE = Path(__file__).with_name("cost.json")
CASES = "cases.json"
LIMIT = 0.10
SEED, ROUNDS_OF_WRITE = 2024, 4
STACK, USED, INSTRUCTIONS = "stack at most [bytes]", "stack used [bytes]", "instructions of the dearest call found"

# The functions that the owner of a board calls, as gcc prints them. The drivers that a Board calls are not counted.
ENTRIES = {
    "Controller::step": r"plenum::Outputs plenum::Controller::step\(.*\)",
    "Controller::receive": r"void plenum::canopen::Node::receive\(.*\)",
    "Controller::next_frame": r"bool plenum::canopen::Node::next_frame\(.*\)",
    "Controller::prepare": r"uint32_t plenum::canopen::DataSheet::size\(\)",
    "Controller::restore": r"plenum::config::ImageVerdict plenum::Controller::restore\(.*\)",
    "Controller::Controller": r"plenum::Controller::Controller\(.*\)",
    "Board::start": r"void plenum::Board::start\(\)",
    "Board::handle_frames": r"void plenum::Board::handle_frames\(\)",
    "Board::tick": r"void plenum::Board::tick\(.*\)",
    "Board::store_changed": r"void plenum::Board::store_changed\(\)",
}


class NotMeasured(Exception):
    pass


def lines_of(command, told=""):
    """What a program that is told this prints, a JSON object a line."""
    done = subprocess.run(command, input=told, capture_output=True, text=True)
    if done.returncode != 0:
        raise NotMeasured(f"{' '.join(map(str, command))} ended with {done.returncode}: {done.stderr.strip()}")
    return [json.loads(line) for line in done.stdout.splitlines()]


def stack_needs(build):
    graph = CallGraph([Path(name).with_suffix(".ci") for name in build["objects"]], build["root"])
    return {entry: graph.need(pattern) for entry, pattern in ENTRIES.items()}


def stack_used(build):
    emulator = [word for word in build["emulator"] if word]
    return {one["row"]: one["bytes"] for one in lines_of(emulator + [build["stack"]])}


def count_rows(program, seed, known, rows):
    """What a search finds in each of `rows`, from the cases `known` on: {row, instructions, kept, case}."""
    cases = "".join(f"{row}\t{case}\n" for row in rows for case in sorted(known.get(row, ())))
    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/out"
        return lines_of(["valgrind", "--tool=callgrind", "--collect-atstart=no", "--dump-line=no", f"--callgrind-out-file={out}",
                         program, out, str(seed), *rows], cases)


def instructions(program, known, rounds):
    """By row: instructions of the dearest case found, its case, and what the dearest of the cases known before took."""
    rows = subprocess.run([program, "--list"], capture_output=True, text=True, check=True).stdout.splitlines()
    dear = [row for row in rows if row.startswith("Controller::")]
    jobs = [[row] for row in dear] + [[row for row in rows if row not in dear]]
    found = {}
    for turn in range(rounds):
        begin = {row: known.get(row, set()) | ({found[row]["case"]} if row in found else set()) for row in rows}
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for counts in pool.map(count_rows, repeat(program), repeat(SEED + turn), repeat(begin), jobs):
                for one in counts:
                    found[one["row"]] = one | {"kept": found.get(one["row"], one)["kept"]}
    return {row: found[row] for row in rows}


def measure(build, cases, rounds, say):
    """A section of the table, its dearest cases by row, and what is wrong with the measurement itself."""
    needs, used = stack_needs(build), stack_used(build)
    faults = []
    for entry, bytes_used in used.items():
        need = needs[entry]
        if not need.bytes / 2 <= bytes_used <= need.bytes:
            faults.append(f"{entry} used {bytes_used} bytes of stack; between the half and the whole of {need.bytes} are expected, "
                          f"the bound by its call graph: {path_of(need)}")
    for entry, need in needs.items():
        say(f"   {entry}: at most {need.bytes} bytes of stack: {path_of(need)}")
    section = {"compiler": build["compiler"], STACK: {entry: need.bytes for entry, need in needs.items()}, USED: used}
    dearest = {}
    if build["instructions"]:
        known = {}
        for of_section in cases.values():
            for row, case in of_section.items():
                known.setdefault(row, set()).add(case)
        found = instructions(build["instructions"], known, rounds)
        section[INSTRUCTIONS] = {row: one["instructions"] for row, one in found.items()}
        dearest = {row: one["case"] for row, one in found.items()}
        for row, one in found.items():
            if one["instructions"] > one["kept"] * (1 + LIMIT):
                say(f"   {row}: {one['instructions']} instructions in a case newly found, {one['kept']} in the cases kept")
    return section, dearest, faults


def path_of(need):
    """The frames of the deepest path: name without scope and parameters, bytes."""
    names = (frame.function.split("(")[0].split(" ")[-1].split("::")[-1] or frame.function for frame in need.path)
    return ", ".join(f"{name} {frame.bytes}" for name, frame in zip(names, need.path))


def differences(name, was, now):
    """What changed from one state of a section to the next: those that fail, and those that only ask to be written."""
    grown, notes = [], []
    if was is None:
        return [f"{name}: no such section in the table"], []
    for group in sorted((set(was) | set(now)) - {"compiler"}):
        before, after = was.get(group, {}), now.get(group, {})
        for row in before | after:
            place = f"{name}: {group}: {row}"
            if row not in after:
                grown.append(f"{place}: {before[row]} in the table, but not measured any more")
            elif row not in before:
                grown.append(f"{place}: {after[row]}, not in the table yet")
            elif after[row] > before[row] * (1 + LIMIT):
                grown.append(f"{place}: from {before[row]} to {after[row]}, {change(before[row], after[row])}")
            elif after[row] < before[row] * (1 - LIMIT):
                notes.append(f"{place}: from {before[row]} to {after[row]}, {change(before[row], after[row])}")
    return grown, notes


def change(before, after):
    return f"{100 * (after / before - 1):+.1f} %" if before else "from nothing"


def read_table(path):
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def compare(table, measured):
    """Prints what changed. Returns whether something grew."""
    failed = False
    for name, section in measured.items():
        was = table.get(name)
        if was is not None and was["compiler"] != section["compiler"]:
            print(f"cost: {name}: the table is of {was['compiler']}, this is {section['compiler']}: nothing compared")
            continue
        grown, notes = differences(name, was, section)
        for line in grown:
            print(f"cost: {line}", file=sys.stderr)
        for line in notes:
            print(f"cost: {line}: keep the gain by toolchains/dev cost --write")
        if grown:
            failed = True
        else:
            rows = sum(len(group) for group in section.values() if isinstance(group, dict))
            print(f"cost: {name}: {rows} rows, none above the table by more than {100 * LIMIT:.0f} %")
    if failed:
        print("cost: the above is over the limit; where it is worth its cost take it over by toolchains/dev cost --write with the "
              "presets measured, and say why in the commit", file=sys.stderr)
    return failed


def main(words):
    parser = argparse.ArgumentParser(description="What the core costs, against the table that is kept.")
    parser.add_argument("--write", action="store_true", help="take over what is measured")
    parser.add_argument("--table", type=Path, default=TABLE)
    parser.add_argument("builds", nargs="+", type=Path, metavar="BUILD_JSON")
    arguments = parser.parse_args(words)
    cases_path = arguments.table.with_name(CASES)
    measured, cases, faults = {}, read_table(cases_path), []
    for path in arguments.builds:
        build = json.loads(path.read_text(encoding="utf-8"))
        name = build["section"]
        try:
            print(f"-- {name}", flush=True)
            # --write tries the other sections' cases, too; a comparison begins where the table's figures come from
            known, rounds = (cases, ROUNDS_OF_WRITE) if arguments.write else ({name: cases.get(name, {})}, 1)
            measured[name], dearest, wrong = measure(build, known, rounds, print)
            if dearest and arguments.write:
                cases[name] = dearest
            faults += [f"{name}: {fault}" for fault in wrong]
        except (RefusedGraph, NotMeasured, OSError) as refusal:
            faults.append(f"{name}: {refusal}")
    for fault in faults:
        print(f"cost: {fault}", file=sys.stderr)
    table = read_table(arguments.table)
    if arguments.write and not faults:
        for file, what in ((arguments.table, table | measured), (cases_path, cases)):
            file.write_text(json.dumps(dict(sorted(what.items())), indent=1) + "\n", encoding="utf-8")
        print(f"cost: written: {arguments.table.name}, {', '.join(measured)}")
        return 0
    return 1 if faults or compare(table, measured) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
