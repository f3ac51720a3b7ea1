"""plenumd as a process: its answers to mistakes, and its life on a machine that has none of its devices."""

import os
import signal
import socket
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

PROGRAM = sys.argv.pop(1)
FIXED = sys.argv.pop(1) == "fixed"  # what its core computes in; else float
LIMIT_S = 60  # no wait is without end
BY_HAND = {name: value for name, value in os.environ.items() if name not in ("STATE_DIRECTORY", "RUNTIME_DIRECTORY", "WATCHDOG_PID")}

# The devices of no machine.
BOARD = """
[can]
interface = "{interface}"
node_id = 5
[analog_input]
rate_Hz = 1000
[[chamber]]
pressure = {{ device = "plenum-none", channel = "voltage0" }}
position = {{ device = "plenum-none", channel = "voltage1" }}
command = {{ device = "plenum-none", channel = "voltage0" }}
[gpio]
valve_power = {{ chip = "plenum-none", line = "0" }}
[store]
folder = "{folder}"
[real_time]
priority = 0
guard_ticks = 1000 # a busy machine is no failure here
"""


def run(*arguments, **environment):
    return subprocess.run([PROGRAM, *arguments], env=dict(BY_HAND, **environment), capture_output=True, text=True, timeout=LIMIT_S)


class Mistakes(unittest.TestCase):
    def test_a_pipe_is_no_file(self):
        with tempfile.TemporaryDirectory() as folder:
            pipe = Path(folder) / "board.toml"
            os.mkfifo(pipe)
            for path in str(pipe), "/dev/full":
                done = run("--config", path, "--check")
                self.assertEqual(done.stderr, f"plenumd: {path}: is a pipe or a device, expected a board.toml\n")
                self.assertEqual(done.returncode, 2)

    def test_a_file_that_is_not_there_is_named_and_ends_with_2(self):
        done = run("--config", "/nowhere/board.toml")
        self.assertEqual(done.stderr, "plenumd: /nowhere/board.toml: No such file or directory, expected a board.toml\n")
        self.assertEqual(done.returncode, 2)

    def test_every_mistake_of_a_file_has_a_line_of_its_own(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("[can]\ninterface = 0\n[analog_input]\nrate_Hz = 1\n[store]\nfolder = 2\n[[chamber]]\nin_use = false\n")
            file.flush()
            done = run("--config", file.name, "--check")
        self.assertEqual([line.split(" is ")[0].split(" = ")[0] for line in done.stderr.splitlines()],
                         [f"plenumd: {file.name}: line {line}: {key}"
                          for line, key in ((2, "can.interface"), (4, "analog_input.rate_Hz"), (6, "store.folder"))])
        self.assertEqual(done.returncode, 2)

    def test_of_three_orders_only_one_is_taken(self):
        for order in "--check", "--safe":
            done = run("--set-bit-rate", order)
            self.assertIn("excludes", done.stderr)
            self.assertEqual(done.returncode, 2)

    def test_an_option_that_is_none_ends_with_2(self):
        self.assertEqual(run("--chekc").returncode, 2)

    def test_help_tells_that_a_check_changes_no_output(self):
        self.assertIn("no output changes, valve power and vent included", " ".join(run("--help").stdout.split()))

    def test_version_is_printed_with_what_the_core_computes_in(self):
        done = run("--version")
        # of a commit, for which dpkg knows the later one; of sources without a repository the project's alone
        version = r"^\d+\.\d+\.\d+(\+git\d{14}\.[0-9a-f]{12}(\.changed)?)?"
        self.assertRegex(done.stdout, version + (r"\+fixed, computing in fixed point\n$" if FIXED else r", computing in float\n$"))
        self.assertEqual(done.returncode, 0)


class NoDevices(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.board = self.folder / "board.toml"
        self.interface = f"none{os.getpid()}"  # a second run of this test is no second plenumd
        self.describe()

    def describe(self, folder=None, more=""):
        """Writes board.toml, with this store and `more` of [real_time]."""
        self.board.write_text(BOARD.format(folder=folder or self.folder, interface=self.interface) + more, encoding="utf-8")

    def test_an_interface_without_a_bit_rate_is_left_alone_and_one_that_is_not_there_is_named(self):
        done = run("--config", str(self.board), "--set-bit-rate")
        self.assertTrue(done.stderr.endswith(f"plenumd: can:{self.interface}: is not there yet: nothing is set\n"), done.stderr)
        self.assertEqual(done.returncode, 0)
        self.interface = "lo"
        self.describe()
        done = run("--config", str(self.board), "--set-bit-rate")
        self.assertEqual((done.stderr, done.returncode), ("", 0))
        self.assertEqual(list(self.folder.glob("slot-*")), [], "it has made a store")

    def last_checked(self, **environment):
        """The last line of --check."""
        return run("--config", str(self.board), "--check", **environment).stdout.splitlines()[-1]

    def start(self, **more):
        """The program, and the socket of its service manager."""
        manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(manager.close)
        manager.bind(str(self.folder / "notify"))
        manager.settimeout(LIMIT_S)
        environment = dict(BY_HAND, NOTIFY_SOCKET=str(self.folder / "notify"), WATCHDOG_USEC="300000", **more)
        return subprocess.Popen([PROGRAM, "--config", str(self.board)], env=environment, stderr=subprocess.PIPE, text=True), manager

    def live(self, **more):
        """All that one says that makes ticks and is asked to stop."""
        board, manager = self.start(**more)
        try:
            self.assertEqual(manager.recv(64), b"READY=1")
            board.send_signal(signal.SIGTERM)
            said = board.communicate(timeout=LIMIT_S)[1]
        finally:
            board.kill()
            board.communicate()
        manager.close()
        (self.folder / "notify").unlink()
        self.assertEqual(board.returncode, 0, said)
        return said


class WithoutDevices(NoDevices):
    def test_check_names_each_thing_on_a_line_of_its_own_and_ends_with_1(self):
        done = run("--config", str(self.board), "--check")
        self.assertEqual([[line[:4].strip(), line[6:19].strip()] for line in done.stdout.splitlines()],
                         [["ok", "configuration"], ["FAIL", "bus"], ["FAIL", "digital lines"], ["FAIL", "analog input"],
                          ["FAIL", "analog output"], ["ok", "store"]])
        self.assertEqual(done.returncode, 1)

    def test_check_refuses_a_store_that_could_not_be_opened(self):
        (self.folder / "slot-a.bin").mkdir()
        for folder in self.folder, self.board, Path("/dev/null"):
            self.describe(folder)
            self.assertRegex(self.last_checked(), rf"^FAIL  store +store:{folder}\S*: .*, expected a folder")

    def test_check_says_what_the_service_needs_for_a_store_outside_of_its_own_folder(self):
        needs = f"the service needs a line ReadWritePaths={self.folder} (systemctl edit plenumd)"
        self.assertEqual(self.last_checked(), f"ok    store          {self.folder}, outside of /var/lib/plenum: {needs}")
        self.assertEqual(self.last_checked(STATE_DIRECTORY=f"{self.folder}-"), f"ok    store          {self.folder}, outside of {self.folder}-: {needs}")
        for own in self.folder, self.folder.parent:
            self.assertEqual(self.last_checked(STATE_DIRECTORY=str(own)), f"ok    store          {self.folder}")

    def test_check_tells_a_watchdog_from_another_device_and_a_processor_from_none(self):
        for path, found in (("/nowhere/watchdog0", "No such file or directory"), ("/dev/null", "is one of its mem devices"),
                            (self.board, "is no device that the kernel lists")):
            self.describe(more=f'watchdog = "{path}"\n')
            self.assertEqual(self.last_checked(), f"FAIL  watchdog       {path}: {found}, expected a watchdog that can be written")
        here = min(os.sched_getaffinity(0))
        for cpu, says in (here, f"ok    processor      {here}"), (1023, "FAIL  processor      real_time.cpu = 1023: Invalid argument, "
                                                                        "expected a processor of this machine"):
            self.describe(more=f"cpu = {cpu}\n")
            self.assertEqual(self.last_checked(), says)

    def test_check_makes_nothing(self):
        run("--config", str(self.board), "--check")
        self.assertEqual(list(self.folder.iterdir()), [self.board])

    def test_safe_tries_everything_and_ends_with_1(self):
        done = run("--config", str(self.board), "--safe")
        self.assertEqual(len(done.stderr.splitlines()), 2)
        self.assertEqual(done.returncode, 1)

    def test_it_runs_on_says_what_is_missing_feeds_the_watchdog_and_stops_when_asked(self):
        board, manager = self.start()
        try:
            self.assertEqual([manager.recv(64) for _ in range(4)], [b"READY=1"] + 3 * [b"WATCHDOG=1"])
            board.send_signal(signal.SIGTERM)
            said = board.communicate(timeout=LIMIT_S)[1].splitlines()
        finally:
            board.kill()
        self.assertEqual(board.returncode, 0)
        missing = [line for line in said if "expected" in line and "real_time" not in line and "memory" not in line]
        self.assertEqual(len(missing), 4, said)
        manager.settimeout(0)
        told = []
        try:
            while True:
                told.append(manager.recv(64))
        except BlockingIOError:
            pass
        self.assertEqual(told[-1], b"STOPPING=1")

    def test_safe_does_its_work_though_nobody_can_read_what_it_says(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run([PROGRAM, "--config", str(self.board), "--safe"], stderr=full, timeout=LIMIT_S)
        self.assertEqual(done.returncode, 1)
        reader, writer = os.pipe()
        os.close(reader)
        with os.fdopen(writer, "w") as nobody:
            done = subprocess.run([PROGRAM, "--config", str(self.board), "--safe"], stderr=nobody, timeout=LIMIT_S)
        self.assertEqual(done.returncode, 1)

    def test_a_second_one_on_the_interface_is_refused_and_leaves_the_first_alone(self):
        board, manager = self.start()
        try:
            self.assertEqual(manager.recv(64), b"READY=1")
            second = run("--config", str(self.board))
            self.assertEqual(second.stderr, f"plenumd: {self.interface}: another plenumd runs on it, expected to be the only one\n")
            self.assertEqual(second.returncode, 1)
            self.assertIsNone(board.poll())
        finally:
            board.kill()
            board.communicate()

    def test_it_runs_without_a_watchdog_that_is_missing_and_says_so(self):
        with self.board.open("a", encoding="utf-8") as file:
            file.write('watchdog = "/nowhere/watchdog0"\n')
        said = self.live()
        self.assertIn("plenumd: /nowhere/watchdog0: No such file or directory, expected a watchdog that takes 5 s\n", said)

    def test_it_runs_under_a_guard_and_ends_with_1_when_it_has_lost_it(self):
        board, manager = self.start()
        try:
            self.assertEqual(manager.recv(64), b"READY=1")
            guard = Path(f"/proc/{board.pid}/task/{board.pid}/children").read_text(encoding="utf-8").split()
            self.assertEqual(len(guard), 1)
            os.kill(int(guard[0]), signal.SIGKILL)
            said = board.communicate(timeout=LIMIT_S)[1].splitlines()
        finally:
            board.kill()
        self.assertIn("guard of the outputs", said[-1])
        self.assertEqual(board.returncode, 1)


class WhileTheFileIsRefused(NoDevices):
    """What was accepted last stands in for it."""

    SAID = r"plenumd: {board}: line 4: can.speed is no key of this file, .*\nplenumd: {accepted}: was accepted last, and stands in for it: .*"

    def setUp(self):
        super().setUp()
        self.state = self.folder / "state"
        self.state.mkdir()
        self.accepted = self.state / "board.toml.accepted"
        self.said = self.SAID.format(board=self.board, accepted=self.accepted)

    def live(self):
        return super().live(STATE_DIRECTORY=str(self.state))

    def keep_and_spoil(self):
        text = self.board.read_text(encoding="utf-8")
        self.accepted.write_text(f"{text}\n# CRC-32 of the lines above: {zlib.crc32(text.encode()):08X}\n", encoding="utf-8")
        self.board.write_text(text.replace("node_id", "speed = 1\nnode_id"), encoding="utf-8")

    def once(self, *arguments):
        return run("--config", str(self.board), *arguments, STATE_DIRECTORY=str(self.state))

    def test_the_file_that_was_run_by_last_is_kept_and_written_only_when_it_is_another(self):
        self.live()
        text = self.board.read_text(encoding="utf-8")
        seal = f"\n# CRC-32 of the lines above: {zlib.crc32(text.encode()):08X}\n"
        self.assertEqual(self.accepted.read_text(encoding="utf-8"), text + seal)
        first = self.accepted.stat()
        self.live()
        self.assertEqual((self.accepted.stat().st_ino, self.accepted.stat().st_mtime_ns), (first.st_ino, first.st_mtime_ns))
        self.board.write_text(text + "# another\n", encoding="utf-8")
        self.live()
        self.assertTrue(self.accepted.read_text(encoding="utf-8").startswith(text + "# another\n"))

    def test_it_runs_by_that_one_says_why_and_keeps_it(self):
        self.keep_and_spoil()
        kept = self.accepted.read_bytes()
        self.assertRegex(self.live(), self.said)
        self.assertEqual(self.accepted.read_bytes(), kept)
        self.board.unlink()
        self.assertIn(f"plenumd: {self.board}: No such file or directory", self.live())

    def test_without_one_it_ends_with_2(self):
        self.keep_and_spoil()
        self.accepted.unlink()
        for arguments in (), ("--safe",):
            done = self.once(*arguments)
            self.assertEqual((len(done.stderr.splitlines()), done.returncode), (1, 2), done.stderr)
        self.assertEqual(list(self.state.iterdir()), [])

    def test_one_that_is_damaged_is_told_of_beside_the_refusal_and_ends_it_with_2(self):
        self.keep_and_spoil()
        kept = self.accepted.read_text(encoding="utf-8")
        self.accepted.write_text(kept.replace("node_id = 5", "node_id = 7"), encoding="utf-8")
        for arguments in (), ("--safe",):
            done = self.once(*arguments)
            self.assertRegex(done.stderr, rf"^plenumd: {self.board}: line 4: .*\nplenumd: {self.accepted}: is damaged, expected .*\n$")
            self.assertEqual(done.returncode, 2)

    def test_safe_tries_the_outputs_of_that_one_and_ends_as_with_a_file_that_is_right(self):
        self.keep_and_spoil()
        done = self.once("--safe")
        self.assertRegex(done.stderr, r"(?s)^plenumd --safe: .*\nplenumd --safe: .*\n" + self.said)
        self.assertEqual(done.returncode, 1)

    def test_safe_tries_the_outputs_of_the_file_that_ran_though_another_is_installed_by_now(self):
        with tempfile.TemporaryDirectory() as runtime:
            super().live(RUNTIME_DIRECTORY=runtime)
            text = self.board.read_text(encoding="utf-8")
            self.board.write_text(text.replace('"plenum-none"', '"another"'), encoding="utf-8")
            done = run("--config", str(self.board), "--safe", RUNTIME_DIRECTORY=runtime)
            self.assertIn("gpio:plenum-none 0:", done.stderr)
            self.assertNotIn("another", done.stderr)
            self.assertEqual(done.returncode, 1)

    def test_check_asks_for_the_file_itself(self):
        self.keep_and_spoil()
        done = self.once("--check")
        self.assertRegex(done.stderr, rf"^plenumd: {self.board}: line 4: .*\n$")
        self.assertEqual((done.stdout, done.returncode), ("", 2))

    def test_a_folder_that_takes_no_copy_is_told_of_and_stops_nothing(self):
        self.state.rmdir()
        self.assertIn(f"plenumd: {self.accepted}: No such file or directory, expected a folder", self.live())

    def test_started_by_hand_it_keeps_nothing_and_takes_nothing(self):
        self.keep_and_spoil()
        self.assertEqual(run("--config", str(self.board)).returncode, 2)


unittest.main()
