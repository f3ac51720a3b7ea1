"""Ctrl-C and SIGTERM while a board is driven, as a user sees it."""

import json
import re
import signal
import subprocess
import time

from command import PROGRAM, CommandTest, model, run

ONE = ["--chambers", "1"]


class Stopped(CommandTest):
    """On a rig that another program serves in real time."""

    def setUp(self):
        super().setUp()
        self.serving = self.serve(*ONE)
        self.addCleanup(self.serving.send_signal, signal.SIGCONT)

    def started(self, *arguments):
        """A command that drives; runs until it has made its folder, from which on it answers to a signal."""
        running = subprocess.Popen([PROGRAM, *map(str, arguments), *ONE, *self.bus, "-o", "out"], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(running.kill)
        until_s = time.monotonic() + 30
        while not (self.folder / "out").exists():
            self.assertLess(time.monotonic(), until_s)
            time.sleep(0.005)
        return running

    def stopped(self, running, by=signal.SIGINT):
        running.send_signal(by)
        said, troubles = running.communicate(timeout=30)
        return running.returncode, said, troubles

    def backup(self, name):
        self.done("backup", *self.bus, "-o", name)
        return json.loads((self.folder / name).read_text(encoding="utf-8"))["settings"]

    def expect_at_rest(self):
        self.assertRegex(self.done("scan", *self.bus, "--node", 1), r" operational .* DISABLED ")
        self.done("record", *self.bus, "--seconds", 0.5, "-o", "bus.log")
        streamed = [line for line in (self.folder / "bus.log").read_text().splitlines() if re.search(r" 6[89A-D]\w#", line)]
        self.assertEqual(streamed, [])

    def test_a_capture_keeps_its_rows_and_leaves_the_board_as_it_was(self):
        before = self.backup("before.json")
        running = self.started("capture", "--seconds", 60, "--json", "result.json")
        time.sleep(2)
        code, said, troubles = self.stopped(running)
        self.assertEqual((code, troubles), (0, ""))
        self.assertRegex(said, r"\A1 chamber, \d+ rows each, excited, stopped by hand: out\n\Z")
        rows = len(self.rows("out/chamber-1.csv"))
        self.assertTrue(20 < rows < 6000, rows)
        result = json.loads((self.folder / "result.json").read_text())
        self.assertEqual((result["rows"], result["stopped"]), (rows, True))
        self.expect_at_rest()
        self.assertEqual(self.backup("after.json"), before)

    def test_before_there_is_a_log_nothing_is_written(self):
        code, said, troubles = self.stopped(self.started("capture"))
        self.assertEqual((code, said), (3, ""))
        self.assertRegex(troubles, r"\Aplenum capture: stopped by hand after [01] rows, expected at least 2[^\n]*\n\Z")
        self.assertFalse((self.folder / "out").exists())
        self.expect_at_rest()

    def test_a_regulation_ends_by_sigterm_too(self):
        self.write("model.json", model(1))
        self.done("upload", *self.bus, *ONE, "model.json")
        before = self.backup("before.json")
        running = self.started("regulate", "--seconds", 60)
        time.sleep(4)
        code, said, troubles = self.stopped(running, signal.SIGTERM)
        self.assertEqual((code, troubles), (0, ""))
        self.assertRegex(said, r"stopped by hand after \d+ rows, recorded in out\n\Z")
        self.expect_at_rest()
        self.assertEqual(self.backup("after.json"), before)

    def test_an_acceptance_judges_nothing(self):
        before = self.backup("before.json")
        running = subprocess.Popen([PROGRAM, "acceptance", *ONE, *self.bus], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(running.kill)
        time.sleep(2)
        code, said, troubles = self.stopped(running)
        self.assertEqual((code, said), (3, ""))
        self.assertRegex(troubles, r"\Aplenum acceptance: stopped by hand[^\n]*nothing is judged[^\n]*\n\Z")
        self.assertEqual(self.backup("after.json"), before)

    def test_a_second_signal_ends_it_at_once(self):
        running = self.started("capture", "--patience", 20)  # that waits long for a board that has gone
        self.serving.send_signal(signal.SIGSTOP)
        time.sleep(0.5)
        running.send_signal(signal.SIGINT)
        time.sleep(0.5)
        self.assertIsNone(running.poll(), "the first one waits for the board")
        code, _, _ = self.stopped(running, signal.SIGTERM)
        self.assertEqual(code, -signal.SIGTERM)


if __name__ == "__main__":
    run()
