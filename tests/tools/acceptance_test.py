"""`plenum acceptance` as its user runs it."""

import json
import re
import socket

from command import CommandTest, run

SMALL = ["--chambers", "2", "--seconds", "2"]
ITEMS = ["latency_p999_us", "latency_max_us", "jitter_us", "overruns", "tick_rate_error_percent", "rows_lost", "sdo_p99_ms",
         "can_load_percent", "stuck_channels", "noise_Pa", "volume_noise_mL", "supply_noise_Pa", "moving_latency_p999_us", "moving_jitter_us",
         "moving_overruns", "chambers_amiss"]
UNWATCHED = {"supply_noise_Pa": "not run"}  # the simulated boards have no supply that they watch
AT_REST = dict.fromkeys(ITEMS, "pass") | UNWATCHED | dict.fromkeys(ITEMS[-4:], "not run")


class AcceptanceCommand(CommandTest):
    def measured(self, *arguments, seconds=2, code=0):
        ran = self.plenum("acceptance", "--chambers", 2, "--seconds", seconds, *arguments, "--json", "-")
        self.assertEqual((ran.returncode, ran.stderr), (code, ""), ran.stdout)
        return json.loads(ran.stdout)

    def verdicts(self, result):
        return {item["id"]: item["verdict"] for item in result["items"]}


class Acceptance(AcceptanceCommand):
    """On a rig simulated inside the program: its time is virtual, so that every figure is the same each time."""

    def test_a_good_board_passes_and_what_was_not_run_says_so(self):
        result = self.measured()
        self.assertEqual(list(self.verdicts(result)), ITEMS)
        self.assertEqual(self.verdicts(result), AT_REST)
        self.assertTrue(result["accepted"])
        self.assertEqual((result["schema"], result["node"], len(result["chambers"])), ("plenum-acceptance/1", 1, 2))
        text = self.done("acceptance", *SMALL)
        self.assertRegex(text, r"\nNoise of a pressure at rest, worst chamber +[\d.]+ +<= 300 +Pa +pass ")
        self.assertRegex(text, r"\nChambers that do not answer their valve +- +<= 0 +not run  \(no valve was moved: --move\)\n")
        self.assertTrue(text.endswith("\nacceptance: passed\n"), text)

    def test_the_noise_found_is_the_rigs_and_the_load_is_that_of_its_frames(self):
        result = self.measured("--plant", "thin-plate", "--volume-swing", 0, seconds=30)
        for chamber in result["chambers"]:
            self.assertAlmostEqual(chamber["noise_Pa"], 100, delta=10)  # pressure_noise_Pa of the standard rig
        load, = [item["value"] for item in result["items"] if item["id"] == "can_load_percent"]
        # Two frames of eight bytes a tick at 1 Mbit/s: 111 bits each with the pause behind, and at most 24 stuff bits.
        self.assertTrue(100e-6 * 100 * 2 * 111 <= load <= 100e-6 * 100 * (2 * 135 + 5), load)

    def test_with_move_each_chamber_answers_its_own_valve(self):
        result = self.measured("--move")
        self.assertEqual(self.verdicts(result), dict.fromkeys(ITEMS, "pass") | UNWATCHED)
        for chamber in result["chambers"]:
            self.assertEqual(chamber["answer"]["follows_valve"], chamber["chamber"])
            self.assertGreater(chamber["answer"]["own_valve"], 0.25)

    def test_one_item_beyond_its_limit_fails_it_with_exit_1(self):
        result = self.measured("--limit", "noise_Pa=1", code=1)
        self.assertFalse(result["accepted"])
        self.assertEqual([name for name, verdict in self.verdicts(result).items() if verdict == "fail"], ["noise_Pa"])

    def test_the_page_is_whole_and_loads_nothing(self):
        self.done("acceptance", *SMALL, "--move", "--report", "page.html")
        page = (self.folder / "page.html").read_text(encoding="utf-8")
        for part in ["Acceptance: passed", "How late ticks began", "Pressures at rest", "Chamber 2, command", "not seen"]:
            self.assertIn(part, page)
        for loads in ["<script src", "<link rel=\"stylesheet\"", "@import"]:
            self.assertNotIn(loads, page)
        self.done("acceptance", *SMALL, "--report", "page.html")
        page = (self.folder / "page.html").read_text(encoding="utf-8")
        self.assertIn("Not run: no valve was moved", page)
        self.assertIn("as those of a simulated board do", page, "why pressures move at rest")

    def test_bad_usage_is_refused_before_anything_is_asked_of_the_board(self):
        nobody = ["acceptance", "--bus", "socketcand:127.0.0.1:1/can0"]
        self.refused(2, *nobody, "--limit", "noise=3", says=["'noise=3'", "noise_Pa"])
        self.refused(2, *nobody, "--limit", "noise_Pa=loud", says=["noise_Pa=loud", "number"])
        self.refused(2, *nobody, "--command-low", 6, "--command-high", 5, says=["--command-low 6", "--command-high 5"])
        self.refused(2, *nobody, "--pressure-low", 500, says=["--pressure-low 500", "--pressure-high 400"])
        self.refused(2, *nobody, "--report", "nowhere/page.html", says=["nowhere"])
        self.refused(2, *nobody, "--seconds", 0, says=["--seconds"])
        self.refused(3, *nobody, says=["127.0.0.1:1", "Connection refused"])


class AcceptanceBus(AcceptanceCommand):
    """On a rig that another program serves in real time: figures of time are this machine's, and nothing is said of them."""

    def setUp(self):
        super().setUp()
        self.serve("--chambers", 2)

    def backup(self, name):
        self.done("backup", *self.bus, "-o", name)
        return json.loads((self.folder / name).read_text(encoding="utf-8"))

    def test_it_measures_over_the_bus_and_gives_back_what_it_borrowed(self):
        before = self.backup("before.json")
        ran = self.plenum("acceptance", *SMALL, *self.bus, "--json", "result.json")
        result = json.loads((self.folder / "result.json").read_text(encoding="utf-8"))
        self.assertEqual(ran.returncode, 0 if result["accepted"] else 1, ran.stderr)
        verdicts = self.verdicts(result)
        self.assertEqual((verdicts["rows_lost"], verdicts["noise_Pa"], verdicts["can_load_percent"]), ("pass",) * 3)
        self.assertGreaterEqual(sum(one["ticks"] for one in result["latency"]), 150)
        self.assertEqual(self.backup("after.json"), before)

    def test_a_node_that_is_not_there_is_exit_3(self):
        self.refused(3, "acceptance", *self.bus, "--node", 9, says=["node 9"])

    def test_a_board_that_regulates_is_left_alone(self):
        with socket.create_connection(("127.0.0.1", int(re.search(r":(\d+)/", self.bus[1])[1])), timeout=30) as client:
            answers = client.makefile("rb")

            def say(words, answer):
                client.sendall(f"< {words} >".encode())
                heard = b""
                while answer not in heard:
                    heard += answers.read(1)

            say("open can0", b"< ok >")
            say("rawmode", b"< ok >")
            client.sendall(b"< send 000 2 1 1 >")
            say("send 601 8 2f 43 60 0 ff 0 0 0", b"frame 581 ")  # control mode: excitation
            for state in [1, 3]:  # DISABLED, HOLD
                say(f"send 601 8 2b 40 60 0 {state} 0 0 0", b"frame 581 ")
                shown = f"4B416000{state | 8:02X}".encode()
                while shown not in self.status(say, client, answers):
                    pass
            self.refused(1, "acceptance", *self.bus, says=["node 1", "HOLD", "at rest"])

    def status(self, say, client, answers):
        """The answer to a read of 6041h, in hex."""
        say("send 601 8 40 41 60 0 0 0 0 0", b"frame 581 ")
        heard = b""
        while b">" not in heard:
            heard += answers.read(1)
        return heard


if __name__ == "__main__":
    run()
