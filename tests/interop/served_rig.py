"""A rig that `plenum sim` serves to the test over socketcand, on a free port of the loopback interface."""

import json
import pathlib
import re
import signal
import subprocess
import tempfile


class ServedRig:
    """with ServedRig(program, "--chambers", "2") as rig: rig.host, rig.port, rig.channel, rig.bus; afterwards rig.result."""

    def __init__(self, program, *arguments):
        self.program = program
        self.arguments = [str(one) for one in arguments]
        self.channel = "can0"
        self.result = None

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.json = pathlib.Path(self.folder.name) / "served.json"
        self.errors = open(pathlib.Path(self.folder.name) / "errors.txt", "w+", encoding="utf-8")
        # The time is a lid on a test that hangs; each one ends its rig by a signal.
        self.process = subprocess.Popen(
            [self.program, "sim", "--bus", f"socketcand:127.0.0.1:0/{self.channel}", "--seconds", "120", "--json", self.json, *self.arguments],
            stdout=subprocess.PIPE, stderr=self.errors, text=True)
        self.ready = self.process.stdout.readline()
        found = re.match(r"serving (socketcand:([^:]+):(\d+)/(\w+)):", self.ready)
        if not found:
            self.process.kill()
            raise AssertionError(f"no ready line but {self.ready!r}, {self.said()}")
        self.bus, self.host, self.port = found[1], found[2], int(found[3])
        return self

    def said(self):
        self.errors.seek(0)
        return self.errors.read()

    def plenum(self, *arguments, timeout=60):
        """Another plenum, in the rig's folder."""
        return subprocess.run([self.program, *map(str, arguments)], cwd=self.folder.name, capture_output=True, text=True, timeout=timeout)

    def path(self, name):
        return pathlib.Path(self.folder.name) / name

    def __exit__(self, kind, *_):
        self.process.send_signal(signal.SIGINT)
        self.process.communicate(timeout=30)
        if kind is None:
            assert self.process.returncode == 0, (self.process.returncode, self.said())
            self.result = json.loads(self.json.read_text(encoding="utf-8"))
        self.errors.close()
        self.folder.cleanup()
