"""What every command does with wrong usage and bad input."""

import json
import random
import re
import subprocess

from command import PROGRAM, SMALL, CommandTest, model, run

COMMANDS = ["demo", "sim", "capture", "identify", "diagnose", "effects", "upload", "download", "regulate", "reproduce",
            "scan", "info", "faults", "reset", "diff", "backup", "restore", "monitor", "acceptance", "calibrate", "orifice", "describe", "lss", "nmt",
            "regulator", "relief", "friction", "cylinder", "flow", "narx"]


class Usage(CommandTest):
    def test_version_is_printed(self):
        self.assertRegex(self.done("--version"), r"^\d+\.\d+\.\d+(\+git\d{14}\.[0-9a-f]{12}(\.changed)?)?(\+fixed)?\n$")

    def test_help_lists_every_command(self):
        text = self.done("--help")
        for command in COMMANDS:
            self.assertRegex(text, rf"\n  {command} ")

    def test_the_help_of_each_command_names_defaults_json_and_ends_in_an_example(self):
        for command in COMMANDS:
            text = self.done(command, "--help")
            self.assertIn("--json", text, command)
            self.assertRegex(text.split("Example:")[-1], rf"\A\n  plenum {command} [^\n]+", command)
            self.assertRegex(text, r"=\S+|\(default: ", command)

    def test_the_help_speaks_of_commands_and_ranges_and_of_simulated_boards_apart(self):
        self.assertRegex(self.done("--help"), r"plenum \[OPTIONS\] COMMAND\n(.|\n)*\nCommands:\n  demo ")
        options, simulated = self.done("regulate", "--help").split("\nSimulated board only:\n")
        for option in ["--store DIR", "--plant ", "--effect ID=VALUE", "--volume-swing FLOAT:0..0.9=0.2", "--spool,--no-spool "]:
            self.assertIn(f"\n  {option}", "\n" + simulated)
        for option in ["--node INT:1..127=1", "--chambers INT:1..8=8", "--amplitude FLOAT:>=0=100", "--seed INT:0..4294967295=1"]:
            self.assertIn(f"\n  {option} ", options)

    def test_an_option_that_takes_one_value_at_a_time_shows_one_and_that_it_may_be_repeated(self):
        text = self.done("diagnose", "--help")
        for option in ["--heldout HELD.csv", "--baseline OLD.csv", "--strike ID"]:
            self.assertRegex(text, rf"\n  {option} +[^\n.](.|\n +)*?repeatable")

    def test_defaults_are_those_of_the_contract(self):
        self.assertRegex(self.done("identify", "--help"), r"--c-gamma \S*=auto")
        self.assertRegex(self.done("identify", "--help"), r"--stretch \S*.*=0\.2")
        self.assertRegex(self.done("demo", "--help"), r"--report \S*=plenum-demo\.html")

    def test_wrong_usage_is_exit_2_and_one_line(self):
        self.refused(2, says=["no command, expected demo, sim, "])
        self.refused(2, "frobnicate", says=["'frobnicate'", "demo, sim"])
        self.refused(2, "sim", "--frobnicate", says=["--frobnicate", "plenum sim --help"])
        self.refused(2, "sim", "--seconds", "0", says=["--seconds", "0", "range"])
        self.refused(2, "sim", "--chambers", "9", says=["--chambers", "9", "8"])
        self.refused(2, "regulate", "--store", ".", "--reference", "square", says=["--reference", "square", "trapezoid"])
        self.refused(2, "upload", "m.json", says=["--store"])
        self.refused(2, "identify", says=["LOG"])
        self.refused(2, "identify", "a.csv", "--c-gamma", "wide", says=["--c-gamma wide", "auto"])
        self.refused(2, "identify", "a.csv", "--model", "grey", says=["--model", "grey", "tassa9", "greybox"])
        self.refused(2, "identify", "a.csv", "--model", "greybox", "--stretch", 1, says=["--stretch", "tassa9"])
        self.refused(2, "identify", "a.csv", "--model", "spline", says=["--model", "spline", "tassa9", "tassa9r"])

    def test_an_answer_that_cannot_be_printed_is_exit_2_and_one_line(self):
        lost = r"\Aplenum[^\n]*: standard output: [^\n]*\n\Z"
        for command in [["effects"], ["effects", "--json", "-"], ["sim", *SMALL, "--seconds", 1], ["--help"], ["sim", "--help"]]:
            with open("/dev/full", "w", encoding="utf-8") as full:
                ran = subprocess.run([PROGRAM, *map(str, command)], cwd=self.folder, stdout=full, stderr=subprocess.PIPE, text=True)
            self.assertEqual(ran.returncode, 2, command)
            self.assertRegex(ran.stderr, lost)
            ran = self.shut("1", *command)
            self.assertEqual(ran.returncode, 2, command)
            self.assertRegex(ran.stderr, lost)
        self.assertEqual(self.shut("1", "sim", *SMALL, "--seconds", 1, "--json", "sim.json").returncode, 2)
        json.loads((self.folder / "sim.json").read_text(encoding="utf-8"))
        self.assertEqual(self.shut("2", "sim", "--chambers", 9).returncode, 2)

    def shut(self, stream, *arguments):
        """Runs with this standard stream closed."""
        return subprocess.run(["sh", "-c", f'exec "$0" "$@" {stream}>&-', PROGRAM, *map(str, arguments)], cwd=self.folder,
                              capture_output=True, text=True, timeout=900)

    def test_a_number_that_is_none_is_refused_by_every_option_of_every_command(self):
        needed = {"identify": ["a.csv"], "diagnose": ["a.csv"], "orifice": ["a.csv"], "regulator": ["a.csv"], "relief": ["a.csv"],
                  "friction": ["a.csv"], "cylinder": ["a.csv", "--bore=32", "--stroke=200"], "flow": ["a.csv"], "narx": ["a.csv"],
                  "upload": ["m.json"], "diff": ["m.json"], "restore": ["b.json"], "decode": ["a.log"], "record": ["--bus", "can:x", "-o", "a.log"],
                  "blind generate": ["--out", "set"], "blind score": ["set", "--answers", "a"]}
        seen = set()
        for command in [*COMMANDS, "record", "decode", "blind generate", "blind score"]:
            for option in re.findall(r"^ +(?:-\w,)?(--[a-z-]+) FLOAT", self.done(*command.split(), "--help"), re.MULTILINE):
                seen.add(f"{command} {option}")
                for number in ["nan", "-nan"] + (["inf"] if option in ("--from", "--to", "--mean") else []):
                    others = [one for one in needed.get(command, []) if not one.startswith(f"{option}=")]
                    self.refused(2, *command.split(), *others, f"{option}={number}",
                                 says=[option, number, "expected a finite number"])
        self.assertLessEqual({"blind generate --seconds", "sim --seconds", "identify --stretch", "orifice --from",
                              "regulate --mean", "monitor --rate", "calibrate --offset", "info --patience"}, seen)
        self.assertGreater(len(seen), 25)

    def test_a_bus_that_is_none_is_refused_by_its_name(self):
        self.refused(2, "capture", "--bus", "canbus", says=["--bus canbus", "expected inproc, socketcand:HOST:PORT/CHANNEL, can:IFACE or slcan:TTY"])
        self.refused(2, "capture", "--bus", "socketcand:localhost", says=["no channel", "socketcand:127.0.0.1:29536/can0"])
        self.refused(2, "capture", "--node", "128", says=["--node", "128", "127"])

    def test_what_only_a_simulated_rig_has_is_refused_on_another_bus(self):
        bus = ["--bus", "socketcand:127.0.0.1:1/can0"]
        self.write("m.json", model(1))
        for option in [["--store", "board"], ["--effect", "spool_lag=10"], ["--plant", "mpye"], ["--no-spool"]]:
            self.refused(2, "upload", *bus, *option, "m.json", says=["only a simulated rig", "--bus inproc"])
        self.refused(2, "capture", "--patience", 2, says=["--patience with --bus inproc", "expected a board on a bus"])
        self.refused(2, "capture", "--last", says=["--last with --bus inproc", "forgets", "expected a board on a bus"])

    def test_a_rig_is_served_on_a_bus_that_others_reach_or_writes_logs(self):
        self.refused(2, "sim", "--bus", "inproc", says=["--bus inproc", "expected socketcand:HOST:PORT/CHANNEL"])
        self.refused(2, "sim", "--speed", 2, says=["--speed without --bus"])
        self.refused(2, "sim", "--store", "s", says=["--store without --bus"])
        self.refused(2, "sim", "--bus", "socketcand:127.0.0.1:0/can0", "--out", "logs", says=["--out with --bus"])
        self.refused(3, "sim", "--bus", "socketcand:192.0.2.1:0/can0", says=["192.0.2.1:0", "expected a free port"])
        said = self.done("sim", "--bus", "socketcand:127.0.0.1:0/can0", "--speed", 100, "--seconds", 2, "--boards", 2,
                         "--chambers", 1, "--json", "served.json")
        self.assertRegex(said, r"^serving socketcand:127\.0\.0\.1:\d+/can0: nodes 1, 2; 1 chamber each, 1000000 bit/s\n")
        served = json.loads((self.folder / "served.json").read_text(encoding="utf-8"))
        self.assertEqual((served["nodes"], served["seconds"], served["clients"]), ([1, 2], 2.0, 0))

    def test_a_log_of_frames_is_read_whole_or_not_at_all(self):
        self.refused(2, "decode", "missing.log", says=["missing.log", "candump"])
        self.refused(2, "decode", ".", says=[".: cannot be read", "candump"])
        self.write("bad.log", "(1.000000) can0 705#05\n(1.1) can0 705#05\n")
        self.refused(2, "decode", "bad.log", says=["bad.log: line 2", "(1.1) can0 705#05", "expected"])
        self.write("good.log", "(1.000000) can0 705#05\n\n(1.250000) can0 080#\n")
        self.assertEqual(self.done("decode", "good.log"),
                         "0.000000 705 heartbeat   5  operational\n0.250000 080      SYNC      \n")
        self.write("mixed.log", "(1.000000) can0 20000004#0000000000000000\n(1.000000) can0 705#05\n(1.250000) can0 181##10102\n")
        self.assertEqual(self.done("decode", "mixed.log"), "0.000000 705 heartbeat   5  operational\n"
                         "2 lines are passed over: CAN FD frames or errors of the bus, no CANopen\n")
        self.write("gap.log", "(1.000000) can0 705#05\n(1.250000) can0 20000004#0001000000000000\n(1.250000) can0 080#\n")
        self.assertEqual(self.done("decode", "gap.log"), "0.000000 705 heartbeat   5  operational\n"
                         "0.250000 frames are missing here: a receive buffer was full\n0.250000 080      SYNC      \n")
        self.assertEqual(json.loads(self.done("decode", "gap.log", "--json", "-"))["gaps"], 1)
        self.refused(2, "record", "--bus", "inproc", "-o", "a.log", says=["--bus inproc"])
        self.refused(2, "record", "--bus", "socketcand:127.0.0.1:1/can0", "-o", "nowhere/a.log", says=["nowhere"])
        self.refused(3, "record", "--bus", "socketcand:127.0.0.1:1/can0", "-o", "a.log", says=["127.0.0.1:1"])

    def test_a_bus_that_nobody_serves_is_exit_3(self):
        self.refused(3, "download", "--bus", "socketcand:127.0.0.1:1/can0", says=["127.0.0.1:1", "Connection refused", "expected a server"])


LOG = "time_s,command_V,pressure_Pa,volume_m3\n"


class BadInput(CommandTest):
    def test_a_log_that_cannot_be_read_is_named_with_row_and_column(self):
        self.refused(2, "identify", "missing.csv", says=["missing.csv", "No such file"])
        self.refused(2, "identify", ".", says=["directory"])
        self.write("word.csv", LOG + "0,5,1e5,1e-3\n0.01,five,1e5,1e-3\n")
        self.refused(2, "identify", "word.csv", says=["word.csv", "row 2", "command_V", "'five'", "number"])
        self.write("jump.csv", LOG + "0,5,1e5,1e-3\n0.01,5,1e5,1e-3\n0.05,5,1e5,1e-3\n")
        self.refused(2, "identify", "jump.csv", says=["jump.csv", "row 3", "time_s"])

    def test_a_log_that_tells_nothing_is_exit_3(self):
        self.write("still.csv", LOG + "".join(f"{k / 100},5,200000,0.001\n" for k in range(300)))
        self.refused(3, "identify", "still.csv", says=["no excitation", "command"])
        self.refused(3, "identify", "--model", "greybox", "still.csv", says=["no excitation", "command"])

    def test_a_log_that_is_too_short_is_exit_3(self):
        self.write("short.csv", LOG + "".join(f"{k / 100},{3 + k % 5},{200000 + k},0.001\n" for k in range(100)))
        for kind in ["tassa9", "greybox"]:
            self.refused(3, "identify", "--model", kind, "short.csv", says=["short.csv: too short: 100 rows, 1 s, expected 3 s"])

    def test_a_log_of_noise_is_exit_3_with_any_model(self):
        draw = random.Random(1)
        commands_V = [draw.uniform(3, 7) for _ in range(200)]
        self.write("noise.csv", LOG + "".join(f"{k / 100},{commands_V[k // 10]},{draw.gauss(300e3, 100)},1e-4\n" for k in range(2000)))
        for kind in ["tassa9", "tassa9r", "greybox"]:
            self.refused(3, "identify", "--model", kind, "noise.csv", "-o", "model.json", "--report", "page.html",
                         says=["no excitation", "pressure", "noise of 0."])

    def test_a_rig_is_named_with_line_and_key(self):
        self.write("text.toml", '[sampling]\nrate_Hz = "fast"\n')
        self.refused(2, "sim", "--rig", "text.toml", says=["text.toml", "line 2", "rate_Hz"])
        self.write("slow.toml", "[sampling]\nrate_Hz = 50\n")
        self.refused(2, "sim", "--rig", "slow.toml", says=["slow.toml", "rate_Hz = 50", "expected 100"])

    def test_output_that_cannot_be_written_is_told_before_any_work(self):
        self.write("file", "")
        self.refused(2, "sim", "--out", "file", says=["file", "expected a folder"])
        self.refused(2, "demo", "--report", "nowhere/page.html", says=["nowhere", "no such folder"])
        self.refused(2, "demo", "--report", ".", says=["is a folder"])

    def test_no_command_works_for_a_json_that_it_cannot_write(self):
        for command in [["demo"], ["sim"], ["capture"], ["effects"], ["reproduce"], ["identify", "a.csv"], ["orifice", "a.csv"], ["regulator", "a.csv"],
                        ["relief", "a.csv"], ["friction", "a.csv"], ["narx", "a.csv"],
                        ["blind", "generate", "--out", "set"], ["scan", "--bus", "socketcand:192.0.2.1:1/can0"]]:
            self.refused(2, *command, "--json", "nowhere/answer.json", says=["nowhere", "no such folder"])
        self.done("sim", *SMALL, "--seconds", 1, "--out", "logs", "--json", "logs/answer.json")

    def test_a_file_that_is_read_or_written_already_is_not_written_over(self):
        self.write("run.csv", LOG)
        (self.folder / "link.csv").symlink_to("run.csv")
        for log in ["run.csv", "./run.csv", self.folder / "run.csv", "link.csv"]:
            self.refused(2, "identify", "run.csv", "-o", log, says=["--out", str(log), "the same file as LOG"])
        self.refused(2, "identify", "a.csv", "--predict", "run.csv", "--report", "link.csv", says=["--report", "--predict"])
        self.refused(2, "identify", "run.csv", "-o", "m.json", "--report", "./m.json", says=["--report", "m.json", "--out"])
        self.refused(2, "identify", "run.csv", "--json", "model.json", says=["model.json", "the same file"])
        self.refused(2, "diagnose", "run.csv", "--rig", "run.csv", "--save-rig", "run.csv", says=["run.csv", "the same file"])
        self.refused(2, "identify", "run.csv", "-o", "/dev/null", "--json", "/dev/null", says=["run.csv", "no rows"])

    def test_what_is_held_out_is_no_file_that_a_fit_sees(self):
        self.write("run.csv", LOG)
        for command in [["diagnose", "--rig", "rig.toml"], ["narx"], ["regulator"]]:
            self.refused(2, *command, "run.csv", "--heldout", "./run.csv", says=["--heldout ./run.csv", "the same file as LOG"])

    def test_a_fit_that_cannot_write_its_page_or_fails_writes_nothing(self):
        self.write("still.csv", LOG + "".join(f"{k / 100},5,200000,0.001\n" for k in range(300)))
        self.refused(2, "identify", "still.csv", "--report", "nowhere/page.html", says=["nowhere", "no such folder"])
        self.refused(2, "identify", "still.csv", "--report", ".", says=["is a folder"])
        self.refused(3, "identify", "still.csv", "--report", "page.html", says=["no excitation"])

    def test_a_store_below_a_file_is_refused(self):
        self.write("file", "")
        self.write("model.json", model(1))
        self.refused(2, "upload", "--store", "file/store", *SMALL, "model.json", says=["file/store", "expected a folder"])
        self.refused(2, "regulate", "--store", "file/store", *SMALL, says=["file/store", "no such folder"])

    def test_a_board_without_models_does_not_regulate_and_has_none_to_read(self):
        self.refused(2, "regulate", "--store", "nowhere", says=["nowhere", "no such folder"])
        (self.folder / "empty").mkdir()
        self.refused(2, "capture", "--closed-loop", says=["--store is missing"])
        self.refused(3, "capture", "--closed-loop", "--store", "empty", says=["empty", "chamber 1", "plenum upload"])
        self.refused(3, "regulate", "--store", "empty", says=["empty", "chamber 1", "plenum upload"])
        self.refused(3, "download", "--store", "empty", says=["empty", "no model"])


if __name__ == "__main__":
    run()
