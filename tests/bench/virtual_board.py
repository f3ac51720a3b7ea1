"""What plenumd of the image is like on the virtual board, which `toolchains/dev guest` has made (tests/virtual-board/README.md). Usage:

    virtual_board.py boot       seconds from the kernel's start to the first heartbeat on the bus, by the guest's clock: an
                                instruction takes 4 ns there
    virtual_board.py memory     what is resident of plenumd while eight chambers regulate: of the loop's process, and of its guard's
                                what is not the loop's, too
"""

import json
import re
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "virtual-board"))
from board import Board  # noqa: E402

HEARD = "/run/virtual-board/heartbeat"  # written by guest/units/virtual-board-heartbeat.service


def row(name, value, unit, target):
    print(json.dumps({"name": name, "value": round(value, 2), "unit": unit, "better": "lower", "target": target}))


def memory_KiB(board, process, *kinds):
    told = board.run(f"cat /proc/{process}/smaps_rollup")
    return sum(int(re.search(rf"^{kind}: +([0-9]+) kB$", told, re.MULTILINE)[1]) for kind in kinds)


def boot():
    with Board() as board:
        row("board.boot_to_heartbeat_s", float(board.run(f"until [ -s {HEARD} ]; do sleep 0.1; done; cat {HEARD}")), "s", None)


def memory():
    with Board() as board, tempfile.TemporaryDirectory() as folder:
        board.upload_models()
        board.plenum("regulate", "--seconds", "5", "-o", str(Path(folder) / "followed"))
        loop, guard = board.processes()
        resident_KiB = memory_KiB(board, loop, "Rss")
        own_KiB = memory_KiB(board, guard, "Private_Clean", "Private_Dirty")
        print(f"the loop {resident_KiB / 1024:.2f} MiB, its guard by itself {own_KiB / 1024:.2f} MiB", file=sys.stderr)
        row("board.rss_mib", (resident_KiB + own_KiB) / 1024, "MiB", 16)


if __name__ == "__main__":
    what = {"boot": boot, "memory": memory}
    if len(sys.argv) != 2 or sys.argv[1] not in what:
        sys.exit(__doc__)
    what[sys.argv[1]]()
