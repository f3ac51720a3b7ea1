"""python-can, which nobody here wrote, as a client of the simulated bus: it sees what our own client sees.

Usage: python_can_test.py PLENUM
"""

import sys
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
    """The next frame with this identifier, as bytes."""
    end = time.monotonic() + DEADLINE_S
    while time.monotonic() < end:
        frame = bus.recv(timeout=end - time.monotonic())
        if frame is not None and frame.arbitration_id == identifier:
            return bytes(frame.data)
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
            self.assertEqual(wait_for(bus, 0x581).hex(), "430010009801ffff")

    def test_each_board_answers_a_sync_of_it(self):
        with ServedRig(PROGRAM, "--chambers", 1, "--boards", 3) as rig, join(rig) as bus:
            send(bus, 0x000, b"\x01\x00")
            send(bus, 0x080)
            for node in (1, 2, 3):
                self.assertEqual(len(wait_for(bus, 0x180 + node)), 8)

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
        for asked, answered in (("4018210000000000", "8018210024000008"), ("4019210000000000", "8019210024000008")):
            self.assertEqual(said[said.index((0x601, asked)) + 1], (0x581, answered))


if __name__ == "__main__":
    unittest.main(verbosity=2)
