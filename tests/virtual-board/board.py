"""The board whole: plenumd of the image's package, started at boot with guest/board.toml, and the PC's tools at its bus."""

import json
import subprocess
import tempfile
import tomllib
from pathlib import Path

from machine import IMAGE, TOP, Machine

PLENUM = TOP / "build/host/bin/plenum"
CONFIGURATION = tomllib.loads((Path(__file__).parent / "guest/board.toml").read_text(encoding="utf-8"))
NODE = CONFIGURATION["can"]["node_id"]
CHAMBERS = range(len(CONFIGURATION["chamber"]))


def make_models(folder):
    """Of each chamber a model in `folder`, identified from a recording of the same chambers and valves, as host-sim simulates them."""
    logs = folder / "logs"
    subprocess.run([PLENUM, "sim", "--plant", "thin-plate", "--seconds", "40", "--out", logs], check=True, stdout=subprocess.PIPE)
    models = [folder / f"model-{c + 1}.json" for c in CHAMBERS]
    for c, model in zip(CHAMBERS, models):
        subprocess.run([PLENUM, "identify", "--rig", logs / "rig.toml", logs / f"chamber-{c + 1}.csv", "-o", model], check=True, stdout=subprocess.PIPE)
    return models


class Board(Machine):
    """It has booted, runs plenumd, and has no models yet."""

    def __init__(self):
        super().__init__(disk=IMAGE / "plenum-arm64.img", plenumd=True)
        try:
            self.run("systemctl is-system-running --wait", self.BOOT_s)
        except BaseException:
            self.close()
            raise

    def command(self, name, *words):
        """A command of the PC's tool, which is patient: the busier this PC, the longer the guest's second."""
        return [PLENUM, name, "--bus", f"socketcand:127.0.0.1:{self.door_port()}/can1", "--node", str(NODE), "--patience", "20", *words]

    def plenum(self, name, *words):
        """What the PC's tool answers, as JSON."""
        done = subprocess.run([*self.command(name, *words), "--json", "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False, timeout=5 * self.COMMAND_s)
        if done.returncode:
            raise AssertionError(f"plenum {name} ended with {done.returncode}: {done.stderr.decode()}")
        return json.loads(done.stdout)

    def upload_models(self):
        with tempfile.TemporaryDirectory() as folder:
            self.plenum("upload", *make_models(Path(folder)))

    def processes(self):
        """Of plenumd: the loop's, and its guard's."""
        loop = int(self.run("systemctl show -P MainPID plenumd"))
        return loop, int(self.run(f"cat /proc/{loop}/task/{loop}/children"))
