"""python-can, which nobody here wrote, as a client of the simulated bus: it sees what our own client sees.

Usage: python_can_test.py PLENUM
"""

import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

try:
    import can
except ImportError:
    print("skipped: no python3-can here (toolchains/packages.txt)")
    sys.exit(77)

from served_rig import ServedRig

PROGRAM = sys.argv.pop()
DEADLINE_S = 20.0


def join(rig):
    return can.Bus(interface="socketcand", host=rig.host, port=rig.port, channel=rig.channel)


def send(bus, identifier, data=b""):
    bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))


def wait_for(bus, identifier):
    """The next frame with this identifier."""
    end = time.monotonic() + DEADLINE_S
    while time.monotonic() < end:
        frame = bus.recv(timeout=end - time.monotonic())
        if frame is not None and frame.arbitration_id == identifier:
            return frame
    raise AssertionError(f"no frame {identifier:03X} within {DEADLINE_S} s")


class Recorder(threading.Thread):
    """Takes all frames until it sees the one with identifier `last`."""

    def __init__(self, bus, last):
        super().__init__()
        self.bus, self.last, self.frames = bus, last, []

    def run(self):
        end = time.monotonic() + DEADLINE_S
        while time.monotonic() < end:
            frame = self.bus.recv(timeout=1.0)
            if frame is None:
                continue
            if frame.arbitration_id == self.last:
                return
            self.frames.append((round(frame.timestamp * 1e6), frame.arbitration_id, bytes(frame.data)))


class PythonCan(unittest.TestCase):
    def test_it_reads_the_device_type_by_sdo(self):
        with ServedRig(PROGRAM, "--chambers", 1) as rig, join(rig) as bus:
            send(bus, 0x601, bytes.fromhex("4000100000000000"))
            self.assertEqual(wait_for(bus, 0x581).data.hex(), "430010009801ffff")

    def test_each_board_answers_a_sync_of_it(self):
        with ServedRig(PROGRAM, "--chambers", 1, "--boards", 3) as rig, join(rig) as bus:
            send(bus, 0x000, b"\x01\x00")
            send(bus, 0x080)
            for node in (1, 2, 3):
                self.assertEqual(len(wait_for(bus, 0x180 + node).data), 8)

    def test_every_frame_of_one_client_reaches_the_others_in_order(self):
        sent = [k.to_bytes(2, "little") for k in range(2000)]
        with ServedRig(PROGRAM, "--chambers", 1) as rig, join(rig) as first, join(rig) as second, join(rig) as third:
            recorders = [Recorder(bus, last=0x7FF) for bus in (first, second)]
            recorders[0].start()
            for data in sent:
                send(third, 0x123, data)
            send(third, 0x7FF)
            recorders[0].join()
            recorders[1].start()  # finds all of them waiting, and takes them in pieces of 1024 bytes
            recorders[1].join()
            for recorder in recorders:
                self.assertEqual([data for _, identifier, data in recorder.frames if identifier == 0x123], sent)
            self.assertEqual(recorders[0].frames, recorders[1].frames)  # with the same time stamps
        self.assertEqual(rig.result["dropped"], 0)

    def test_it_sees_what_our_own_client_says_and_hears(self):
        with ServedRig(PROGRAM, "--chambers", 1) as rig, join(rig) as bus, join(rig) as last:
            ours = rig.plenum("download", "--bus", rig.bus, "--chambers", 2)
            send(last, 0x7FF)
            recorder = Recorder(bus, last=0x7FF)
            recorder.run()
        self.assertIn("no model", ours.stderr)
        # 2118h and 2119h asked for, and both answered in the end with abort 0800 0024h: there are no data.
        said = [(identifier, data.hex()) for _, identifier, data in recorder.frames if identifier in (0x581, 0x601)]
        self.assertEqual([identifier for identifier, _ in said], [0x601, 0x581] * (len(said) // 2))
        for answered in ("8018210024000008", "8019210024000008"):
            self.assertIn((0x581, answered), said)


class Logs(unittest.TestCase):
    """What `plenum record` writes, can-utils and python-can read; what python-can writes, `plenum decode` reads."""

    def record(self, rig):
        """The log of a conversation, whole up to its last frame, 7FFh."""
        log = rig.path("bus.log")
        recording = subprocess.Popen([PROGRAM, "record", "--bus", rig.bus, "-o", log], stdout=subprocess.PIPE, text=True)
        self.assertRegex(recording.stdout.readline(), "^recording ")
        rig.plenum("download", "--bus", rig.bus, "--chambers", 1)
        with join(rig) as bus:
            send(bus, 0x000, b"\x01\x00")
            send(bus, 0x080)
            self.heard = wait_for(bus, 0x181)
            send(bus, 0x7FF)
        end = time.monotonic() + DEADLINE_S
        while " 7FF#" not in log.read_text(encoding="ascii") and time.monotonic() < end:
            time.sleep(0.02)
        recording.send_signal(signal.SIGINT)
        self.assertIn(" frames in ", recording.communicate(timeout=DEADLINE_S)[0])
        self.assertEqual(recording.returncode, 0)
        return log

    def test_can_utils_and_python_can_read_what_was_recorded(self):
        with ServedRig(PROGRAM, "--chambers", 1) as rig:
            log = self.record(rig)
            ours = [(int(identifier, 16), data) for identifier, data in re.findall(r" can0 (\w+)#(\w*)", log.read_text(encoding="ascii"))]
            self.assertIn((0x080, ""), ours)
            read = [(frame.arbitration_id, frame.data.hex().upper()) for frame in can.CanutilsLogReader(str(log))]
            self.assertEqual(read, ours)
            stamps = [frame.timestamp for frame in can.CanutilsLogReader(str(log)) if frame.arbitration_id == 0x181]
            self.assertAlmostEqual(min(stamps, key=lambda stamp: abs(stamp - self.heard.timestamp)), self.heard.timestamp, delta=1e-6,
                                   msg="the time at which another client was told that it was on the bus")
            now = time.time()
            self.assertTrue(all(abs(frame.timestamp - now) < 120 for frame in can.CanutilsLogReader(str(log))))
            if shutil.which("log2asc") is None:
                self.skipTest("no can-utils here (toolchains/packages.txt)")
            ascii_log = subprocess.run(["log2asc", "-I", log, "can0"], capture_output=True, text=True, check=True).stdout
            lines = re.findall(r"^ *[\d.]+ +1 +(\w+) +[RT]x +d +\d((?: \w\w)*) *$", ascii_log, re.MULTILINE)
            self.assertEqual([(int(identifier, 16), data.replace(" ", "")) for identifier, data in lines], ours)

    def test_what_was_recorded_is_told_as_canopen(self):
        with ServedRig(PROGRAM, "--chambers", 1) as rig:
            self.record(rig)
            frames = json.loads(rig.plenum("decode", "bus.log", "--json", "-").stdout)["frames"]
            said = rig.plenum("decode", "bus.log").stdout
        told = [(frame["kind"], frame["node"], frame["text"]) for frame in frames]
        self.assertIn(("NMT", 0, "start all nodes"), told)
        self.assertTrue(any(kind == "SDO" and node == 1 and text.startswith("abort 2118h:0") for kind, node, text in told))
        pdo = next(frame for frame in frames if frame["kind"] == "TPDO1")
        self.assertEqual(pdo["values"][0]["unit"], "Pa")
        self.assertTrue(5e4 < pdo["values"][0]["value"] < 8e5)  # a chamber between ambient and supply
        self.assertEqual(len(said.splitlines()), len(frames))

    def test_a_log_of_python_can_is_decoded(self):
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder) / "theirs.log"
            writer = can.CanutilsLogWriter(str(log))
            writer.on_message_received(can.Message(timestamp=1.5, arbitration_id=0x705, data=b"\x05", is_extended_id=False))
            writer.on_message_received(can.Message(timestamp=2.0, arbitration_id=0x705, is_remote_frame=True, dlc=1, is_extended_id=False))
            writer.on_message_received(can.Message(timestamp=2.5, arbitration_id=0x12345, data=b"\x01", is_extended_id=True))
            writer.stop()
            ran = subprocess.run([PROGRAM, "decode", log, "--json", "-"], capture_output=True, text=True, timeout=60)
            self.assertEqual([(frame["time_s"], frame["kind"], frame["text"]) for frame in json.loads(ran.stdout)["frames"]],
                             [(1.5, "heartbeat", "operational"), (2.0, "other", "remote frame"), (2.5, "other", "01")])


if __name__ == "__main__":
    unittest.main(verbosity=2)
