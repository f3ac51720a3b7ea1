"""The program as its user runs it. Called with: the program, the top of the tree, the name of a test case."""

import csv
import html
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

PROGRAM = TOP = None
COMMANDS = ["demo", "sim", "capture", "identify", "diagnose", "effects", "upload", "download", "regulate", "reproduce",
            "scan", "info", "faults", "reset", "diff", "backup", "restore", "monitor", "acceptance", "calibrate", "orifice", "describe", "lss",
            "regulator", "relief", "friction", "narx"]
SMALL = ["--chambers", "2"]


class Plenum(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def serve(self, *arguments):
        """A rig that another program serves in real time: its process; self.bus says where it is."""
        serving = subprocess.Popen([PROGRAM, "sim", "--bus", "socketcand:127.0.0.1:0/can0", *map(str, arguments)], cwd=self.folder,
                                   stdout=subprocess.PIPE, text=True)
        self.addCleanup(serving.stdout.close)
        self.addCleanup(serving.wait)
        self.addCleanup(serving.terminate)
        self.bus = ["--bus", re.search(r"socketcand:127\.0\.0\.1:\d+/can0", serving.stdout.readline())[0]]
        return serving

    def plenum(self, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=900)

    def done(self, *arguments):
        """Runs to exit code 0, silent on standard error, which is no terminal here."""
        ran = self.plenum(*arguments)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""), arguments)
        return ran.stdout

    def refused(self, code, *arguments, says):
        """One line on standard error, nothing on standard output, nothing left behind."""
        before = self.listing()
        ran = self.plenum(*arguments)
        self.assertEqual(ran.returncode, code, ran.stderr)
        self.assertEqual(ran.stdout, "")
        self.assertRegex(ran.stderr, r"\Aplenum[^\n]*\n\Z", "one line")
        for part in says:
            self.assertIn(part, ran.stderr)
        self.assertEqual(self.listing(), before, "a refused command changed files")

    def listing(self):
        return {path.relative_to(self.folder): path.is_file() and path.read_bytes() for path in self.folder.rglob("*")}

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")
        return name

    def rows(self, name):
        with open(self.folder / name, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))


class Usage(Plenum):
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

    def test_defaults_are_those_of_the_contract(self):
        self.assertRegex(self.done("identify", "--help"), r"--c-gamma \S*=auto")
        self.assertRegex(self.done("identify", "--help"), r"--stretch \S*.*=0\.2")
        self.assertRegex(self.done("demo", "--help"), r"--report \S*=plenum-demo\.html")

    def test_wrong_usage_is_exit_2_and_one_line(self):
        self.refused(2, says=["--help"])
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
                  "friction": ["a.csv"], "narx": ["a.csv"], "upload": ["m.json"], "diff": ["m.json"],
                  "restore": ["b.json"], "decode": ["a.log"], "record": ["--bus", "can:x", "-o", "a.log"],
                  "blind generate": ["--out", "set"], "blind score": ["set", "--answers", "a"]}
        seen = set()
        for command in [*COMMANDS, "record", "decode", "blind generate", "blind score"]:
            for option in re.findall(r"^ +(?:-\w,)?(--[a-z-]+) FLOAT", self.done(*command.split(), "--help"), re.MULTILINE):
                seen.add(f"{command} {option}")
                for number in ["nan", "-nan"] + (["inf"] if option in ("--from", "--to", "--mean") else []):
                    self.refused(2, *command.split(), *needed.get(command, []), f"{option}={number}",
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

    def test_a_rig_is_served_on_a_bus_that_others_reach_or_writes_logs(self):
        self.refused(2, "sim", "--bus", "inproc", says=["--bus inproc", "expected socketcand:HOST:PORT/CHANNEL"])
        self.refused(2, "sim", "--speed", 2, says=["--speed without --bus"])
        self.refused(2, "sim", "--store", "s", says=["--store without --bus"])
        self.refused(2, "sim", "--bus", "socketcand:127.0.0.1:0/can0", "--out", "logs", says=["--out with --bus"])
        self.refused(3, "sim", "--bus", "socketcand:192.0.2.1:0/can0", says=["192.0.2.1:0", "expected a free port"])
        said = self.done("sim", "--bus", "socketcand:127.0.0.1:0/can0", "--speed", 100, "--seconds", 2, "--boards", 2,
                         "--chambers", 1, "--json", "served.json")
        self.assertRegex(said, r"^serving socketcand:127\.0\.0\.1:\d+/can0: nodes 1, 2; 1 chambers each, 1000000 bit/s\n")
        served = json.loads((self.folder / "served.json").read_text(encoding="utf-8"))
        self.assertEqual((served["nodes"], served["seconds"], served["clients"]), ([1, 2], 2.0, 0))

    def test_a_log_of_frames_is_read_whole_or_not_at_all(self):
        self.refused(2, "decode", "missing.log", says=["missing.log", "candump"])
        self.write("bad.log", "(1.000000) can0 705#05\n(1.1) can0 705#05\n")
        self.refused(2, "decode", "bad.log", says=["bad.log: line 2", "(1.1) can0 705#05", "expected"])
        self.write("good.log", "(1.000000) can0 705#05\n\n(1.250000) can0 080#\n")
        self.assertEqual(self.done("decode", "good.log"),
                         "0.000000 705 heartbeat   5  operational\n0.250000 080      SYNC      \n")
        self.write("mixed.log", "(1.000000) can0 20000004#0000000000000000\n(1.000000) can0 705#05\n(1.250000) can0 181##10102\n")
        self.assertEqual(self.done("decode", "mixed.log"), "0.000000 705 heartbeat   5  operational\n"
                         "2 lines are passed over: CAN FD frames or errors of the bus, no CANopen\n")
        self.refused(2, "record", "--bus", "inproc", "-o", "a.log", says=["--bus inproc"])
        self.refused(2, "record", "--bus", "socketcand:127.0.0.1:1/can0", "-o", "nowhere/a.log", says=["nowhere"])
        self.refused(3, "record", "--bus", "socketcand:127.0.0.1:1/can0", "-o", "a.log", says=["127.0.0.1:1"])

    def test_a_bus_that_nobody_serves_is_exit_3(self):
        self.refused(3, "download", "--bus", "socketcand:127.0.0.1:1/can0", says=["127.0.0.1:1", "Connection refused", "expected a server"])


LOG = "time_s,command_V,pressure_Pa,volume_m3\n"


class BadInput(Plenum):
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


def model(chamber=1, **changed):
    """An admissible model; the joint conditions hold by hand: c9 > 0.1 (1 - sqrt(1 - 0.1^2)), c3 > 0."""
    parameters = {"c1_V": 5.02, "c2_per_V": 0.7, "c3_per_V3": 1.3, "c4_kPa_s_per_mL": -0.05, "c5_per_mL": 0.3, "c6_per_mL": 0.2,
                  "c7_per_V_s": 90, "c8": 0.1, "c9_V": 0.3, "c_gamma_V": 0.1, "supply_kPa": 700, "ambient_kPa": 101.325}
    parameters.update(changed)
    return json.dumps({"schema": "plenum-model/1", "kind": "tassa9", "chamber": chamber, "parameters": parameters, "fit": {}})


def greybox(chamber=1, **changed):
    """An admissible grey-box model of a valve of 60 mL/s a volt."""
    parameters = {"open_above_V": 5.08, "exhaust_below_V": 4.92, "inlet_conductance_mL_per_s_V": 60, "exhaust_conductance_mL_per_s_V": 64,
                  "inlet_leak_mL_per_s": 0.1, "exhaust_leak_mL_per_s": 0.1, "transition_mL_per_s": 1, "inlet_slope": 0, "inlet_curve": 0,
                  "inlet_bend": 0, "exhaust_slope": 0, "exhaust_curve": 0, "exhaust_bend": 0, "critical_ratio": 0.53,
                  "subsonic_index": 0.5, "cracking_ratio": 1, "discharge_slope": 0, "dead_volume_mL": 0, "volume_exponent": 1.4,
                  "chamber_leak_mL_per_s": 0, "dead_time_s": 0, "spool_period_s": 0, "spool_damping": 0.8, "hysteresis_V": 0,
                  "sensor_lag_s": 0, "supply_kPa": 700, "ambient_kPa": 101.325}
    parameters.update(changed)
    return json.dumps({"schema": "plenum-model/1", "kind": "greybox", "chamber": chamber, "parameters": parameters, "fit": {}})


class SimEffects(Plenum):
    THIN = ["sim", "--plant", "thin-plate", "--chambers", "1", "--seconds", "6"]

    def pressures(self, *arguments, out):
        self.done(*self.THIN, *arguments, "--out", out)
        return [float(row["pressure_Pa"]) for row in self.rows(f"{out}/chamber-1.csv")]

    def test_what_is_no_effect_is_refused_with_what_there_is(self):
        self.refused(2, *self.THIN, "--effect", "spool=10", says=["'spool'", "spool_lag, dead_time", "sensor_bias"])
        self.refused(2, *self.THIN, "--effect", "spool_lag", says=["--effect spool_lag", "ID=VALUE", "ID=PARAMETER:VALUE"])
        self.refused(2, *self.THIN, "--effect", "spool_lag=slow", says=["--effect spool_lag=slow", "'slow'", "number"])
        self.refused(2, *self.THIN, "--effect", "spool_lag=10,0.5", says=["'0.5'", "PARAMETER:VALUE"])
        self.refused(2, *self.THIN, "--effect", "spool_lag=zeta:1", says=["'zeta'", "natural_frequency_Hz, damping"])
        self.refused(2, *self.THIN, "--effect", "dead_time=1", says=["delay_s = 1", "0.08"])
        self.refused(2, "sim", "--effect", "dead_time=0.01", says=["dead_time", "--plant thin-plate"])

    def test_a_rig_without_noise_writes_the_volumes_that_it_has(self):
        self.write("quiet.toml", "[sampling]\nrate_Hz = 100\n[sensor]\npressure_noise_Pa = 0\n")
        self.done("sim", "--plant", "thin-plate", "--rig", "quiet.toml", "--chambers", 1, "--seconds", 10, "--out", "quiet")
        volumes_mL = [1e6 * float(row["volume_m3"]) for row in self.rows("quiet/chamber-1.csv")]
        self.assertGreater(min(volumes_mL), 119.5)
        self.assertLess(max(volumes_mL), 180.5)

    def test_an_effect_changes_the_log_and_not_what_its_user_knows(self):
        plain = self.pressures(out="plain")
        off = self.pressures("--effect", "dead_time=0", out="off")
        late = self.pressures("--effect", "dead_time=0.03", out="late")
        rms = lambda a, b: math.sqrt(sum((x - y) ** 2 for x, y in zip(a, b)) / len(a))
        self.assertGreater(rms(late, off), 5e3, "Pa: three ticks of steps")
        self.assertEqual((self.folder / "late/rig.toml").read_bytes(), (self.folder / "plain/rig.toml").read_bytes())
        self.assertEqual(len(plain), len(late))

    def test_an_effect_of_the_rig_file_is_that_of_the_command_line(self):
        self.write("rig.toml", "[sampling]\nrate_Hz = 100\n[effects.supply_droop]\nresistance_kPa_s_per_g = 20\nrecovery_s = 0.1\n")
        of_file = self.pressures("--rig", "rig.toml", out="a")
        of_line = self.pressures("--effect", "supply_droop=20,recovery_s:0.1", out="b")
        named = self.pressures("--effect", "supply_droop=resistance_kPa_s_per_g:20,recovery_s:0.1", out="c")
        self.assertEqual(of_file, of_line)
        self.assertEqual(of_file, named)
        self.assertIn("[effects.supply_droop]", (self.folder / "a/rig.toml").read_text(), "what its user knows")
        self.assertNotIn("effects", (self.folder / "b/rig.toml").read_text())


class Line(Plenum):
    def test_models_go_to_the_board_and_come_back_byte_for_byte(self):
        self.write("a.json", model(1))
        self.write("b.json", model(2, c1_V=4.9, c8=-0.2))
        self.done("upload", "--store", "board", *SMALL, "a.json", "b.json")
        self.done("download", "--store", "board", *SMALL, "-o", "models")
        back = json.loads((self.folder / "models/model-2.json").read_text())
        self.assertEqual((back["chamber"], back["parameters"]["c1_V"], back["parameters"]["c8"]), (2, 4.9, -0.2))
        self.done("upload", "--store", "again", *SMALL, "models/model-1.json", "models/model-2.json")
        boards = [{path.name: path.read_bytes() for path in (self.folder / of).iterdir()} for of in ("board", "again")]
        self.assertEqual(*boards)
        self.assertIn("slot-a.bin", boards[0])
        self.done("download", "--store", "again", *SMALL, "-o", "models again")
        self.assertEqual((self.folder / "models/model-1.json").read_bytes(), (self.folder / "models again/model-1.json").read_bytes())

    def test_models_go_all_or_none(self):
        self.write("good.json", model(1))
        self.done("upload", "--store", "board", *SMALL, "good.json")
        self.write("other.json", model(1, c1_V=5.5))
        self.write("bad.json", model(2, c9_V=1e-4))
        self.refused(1, "upload", "--store", "board", *SMALL, "other.json", "bad.json", says=["chamber 2", "refused"])
        self.write("wide.json", model(2, c1_V=9))
        self.refused(2, "upload", "--store", "board", *SMALL, "other.json", "wide.json", says=["wide.json", "c1_V", "9"])
        self.refused(2, "upload", "--store", "board", *SMALL, "good.json", "other.json", says=["chamber 1", "good.json"])
        self.write("far.json", model(3))
        self.refused(2, "upload", "--store", "board", *SMALL, "far.json", says=["far.json", "chamber 3", "1 to 2"])

    def test_a_capture_stays_within_the_limits_it_was_given(self):
        self.done("capture", *SMALL, "--seconds", 20, "--pressure-low", 180, "--pressure-high", 320, "--command-low", 3.5,
                  "--command-high", 6.1, "-o", "soft")
        for chamber in (1, 2):
            rows = self.rows(f"soft/chamber-{chamber}.csv")
            commands_V = [float(row["command_V"]) for row in rows]
            self.assertGreaterEqual(min(commands_V), 3.5 - 1e-3)
            self.assertLessEqual(max(commands_V), 6.1 + 1e-3)
            pressures_kPa = [float(row["pressure_Pa"]) / 1e3 for row in rows[300:]]  # once it has come there from the ambient's
            self.assertGreater(min(pressures_kPa), 180 - 10, "what moves on in a tick")
            self.assertLess(max(pressures_kPa), 320 + 10)
        self.refused(2, "capture", *SMALL, "--pressure-low", 400, "--pressure-high", 300, says=["--pressure-low 400", "low below high"])
        self.refused(2, "capture", *SMALL, "--command-low", 7, "--command-high", 3, says=["--command-low 7", "low below high"])

    def test_a_model_that_does_not_suit_its_chamber_is_refused_with_what_is_wrong_and_where(self):
        unfit = {
            "inlet_slope is -2, expected -1.85106..20": {"inlet_slope": -2},
            "its valve does not act: at ": {"open_above_V": 15, "exhaust_below_V": -5},
            "lowers the pressure by ": {"inlet_leak_mL_per_s": 1e5},
            "raises the pressure by ": {"inlet_conductance_mL_per_s_V": 1e-3},
            "dead_volume_mL is -5000, expected ": {"dead_volume_mL": -5000},
        }
        self.write("fit.json", greybox(1))
        self.done("upload", "--store", "board", *SMALL, "fit.json")
        for says, edits in unfit.items():
            with self.subTest(says):
                self.write("unfit.json", greybox(1, **edits))
                self.refused(1, "upload", "--store", "board", *SMALL, "unfit.json", says=["chamber 1: model refused: ", says])

    def test_from_capture_to_regulation(self):
        self.done("capture", *SMALL, "--seconds", 20, "-o", "first")
        self.assertEqual(len(self.rows("first/chamber-2.csv")), 2000)
        for chamber in (1, 2):
            result = json.loads(self.done("identify", f"first/chamber-{chamber}.csv", "--rig", "first/rig.toml", "-o",
                                          f"{chamber}.json", "--json", "-"))
            self.assertEqual(result["chamber"], chamber, "the number in the log's name")
            self.assertNotIn("valve_serial", result["fit"], "a simulated board states none")
            self.assertLess(result["fit"]["rms_one_step_kPa"], 10.0)
        self.done("upload", "--store", "board", *SMALL, "1.json", "2.json")
        self.done("capture", "--closed-loop", "--store", "board", *SMALL, "--seed", 2, "--seconds", 5, "-o", "second")
        result = json.loads(self.done("regulate", "--store", "board", *SMALL, "--reference", "sine", "--frequency", 1, "--seconds", 3,
                                      "-o", "tracked", "--json", "-"))
        for chamber in result["chambers"]:
            rows = self.rows(f"tracked/chamber-{chamber['chamber']}.csv")
            reference = [float(row["reference_Pa"]) for row in rows]
            errors = [float(row["pressure_Pa"]) - (now + before) / 2 for row, now, before in zip(rows[1:], reference[1:], reference)][49:]
            rmse_kPa = math.sqrt(sum(e * e for e in errors) / len(errors)) / 1e3
            self.assertAlmostEqual(chamber["rmse_kPa"], rmse_kPa, places=6)
            self.assertLess(rmse_kPa, 10.0, "a tenth of the amplitude [kPa]")
            self.assertIsNone(chamber["overshoot_percent_of_span"])

    def test_a_model_tells_when_and_on_what_it_was_fitted(self):
        self.done("capture", *SMALL, "--seconds", 5, "-o", "log")
        rig = self.folder / "log" / "rig.toml"
        rig.write_text(rig.read_text() + "\n[chamber.2]\nvalve_serial = 4711\nsensor_serial = 815\n")
        def fit(*arguments, **environment):
            ran = subprocess.run([PROGRAM, "identify", "--rig", "log/rig.toml", "-o", "m.json", "--no-free-run", *arguments],
                                 cwd=self.folder, capture_output=True, text=True, timeout=900, env={**os.environ, **environment})
            self.assertEqual((ran.returncode, ran.stderr), (0, ""))
            return json.loads((self.folder / "m.json").read_text())["fit"], (self.folder / "m.json").read_bytes()
        day = 20781 * 86400  # 2026-11-24
        told, _ = fit("log/chamber-2.csv", "--date", "2026-11-24")
        self.assertEqual((told["date_s"], told["valve_serial"], told["sensor_serial"]), (day, 4711, 815))
        of_chamber_1, _ = fit("log/chamber-1.csv", "--date", str(day + 5))
        self.assertEqual(of_chamber_1["date_s"], day + 5)
        self.assertNotIn("valve_serial", of_chamber_1)
        first, second = (fit("log/chamber-2.csv", SOURCE_DATE_EPOCH="1700000000") for _ in range(2))
        self.assertEqual(first[0]["date_s"], 1700000000)
        self.assertEqual(first[1], second[1], "the same input gives the same file")
        before = int(time.time())
        date_s = fit("log/chamber-2.csv", SOURCE_DATE_EPOCH="")[0]["date_s"]
        self.assertGreaterEqual(date_s, before, "else it is now")
        self.assertLessEqual(date_s, time.time())
        for date in ["2026-13-01", "2026-02-30", "yesterday", "-1", "4294967296"]:
            self.refused(2, "identify", "log/chamber-2.csv", "-o", "n.json", f"--date={date}", says=["--date", date, "2026-11-24"])
        self.done("upload", "--store", "board", *SMALL, "m.json")
        info = json.loads(self.done("info", "--store", "board", "--json", "-"))["models"][1]
        self.assertEqual((info["valve_serial"], info["sensor_serial"]), (4711, 815))

    def test_the_grey_box_model_goes_from_capture_to_regulation(self):
        rig = ["--plant", "thin-plate", "--chambers", 1, "--effect", "spool_lag=12"]
        self.done("capture", *rig, "--seconds", 10, "-o", "first")
        # nothing of the valve is given but the rig's pressures
        result = json.loads(self.done("identify", "--model", "greybox", "first/chamber-1.csv", "--rig", "first/rig.toml", "-o", "1.json",
                                      "--predict", "first/chamber-1.csv", "--report", "page.html", "--json", "-"))
        self.assertEqual((result["kind"], result["chamber"]), ("greybox", 1))
        self.assertIn("date_s", result["fit"])
        self.assertEqual(result["fit"]["effects"], ["spool_lag"])
        self.assertAlmostEqual(result["fit"]["parameters"]["spool_lag.natural_frequency_Hz"]["value"], 12, delta=0.5)
        self.assertLess(result["predicted"][0]["rms_free_run_kPa"], 1.0)
        for text in ["held-out", "spool_lag", "<figure><h3>Error, chamber-1.csv"]:
            self.assertIn(text.lower(), (self.folder / "page.html").read_text(encoding="utf-8").lower())
        self.done("upload", "--store", "board", *rig, "1.json")
        result = json.loads(self.done("regulate", "--store", "board", *rig, "--seconds", 2, "-o", "tracked", "--json", "-"))
        self.assertLess(result["chambers"][0]["rmse_kPa"], 10.0, "a tenth of the amplitude [kPa]")

    def test_the_same_seed_gives_the_same_bytes_and_another_does_not(self):
        for name, seed in [("a", 7), ("b", 7), ("c", 8)]:
            self.done("sim", *SMALL, "--plant", "thin-plate", "--seconds", 3, "--seed", seed, "--out", name)
        a, b, c = ((self.folder / name / "chamber-1.csv").read_bytes() for name in "abc")
        self.assertEqual(a, b)
        self.assertNotEqual(a, c)


class Demo(Plenum):
    def test_a_short_demo_writes_its_page_and_its_figures(self):
        text = self.done("demo", "--no-gaps", "--seconds", 10, *SMALL, "--report", "page.html", "--json", "demo.json")
        self.assertIn("report: page.html", text)
        self.assertLess(len(text.splitlines()), 25)
        result = json.loads((self.folder / "demo.json").read_text())
        self.assertEqual([one["chamber"] for one in result["chambers"]], [1, 2])
        self.assertEqual(set(result["chambers"][0]["tracking_rmse_kPa"]),
                         {"sine 0.5 Hz", "sine 1 Hz", "sine 2 Hz", "sine 4 Hz", "trapezoid", "random", "steps"})
        self.assertLess(result["tracking_rmse_kPa"], 30.0, "5 % of span [kPa]")
        page = (self.folder / "page.html").read_text(encoding="utf-8")
        for figure in ["Free runs, ch. ", "Drift of free runs", "Pressure change in one tick", "s(u)", "r(u)", "Command, random",
                       "Tracking error by chamber"]:
            self.assertRegex(page, "<figure><h3>[^<]*" + re.escape(figure))
        self.assertNotRegex(page, r"<(script|link|img)[^>]+(src|href)=.?https?:", "the page needs no network")

    def test_every_rig_that_the_readme_tells_of_is_shown(self):
        for plant in ("thin-plate", "mpye"):
            for swing in (0, 0.2):
                self.assertIn("report: page.html", self.done("demo", "--no-gaps", "--plant", plant, "--volume-swing", swing,
                                                             "--report", "page.html"))

    def test_effects_withheld_from_the_diagnosis_are_named_and_their_models_regulate_better(self):
        self.done("demo", "--seconds", 4, *SMALL, "--report", "page.html", "--json", "demo.json")
        gaps = json.loads((self.folder / "demo.json").read_text())["gaps"]
        self.assertEqual(len(gaps), 9)
        for gap in gaps:
            self.assertEqual(gap["named"], gap["effect"])
            self.assertTrue(gap["uploaded"])
            self.assertLess(gap["tracking_rmse_after_kPa"], gap["tracking_rmse_before_kPa"], gap["effect"])
        after = {gap["effect"]: gap["tracking_rmse_after_kPa"] / gap["tracking_rmse_before_kPa"] for gap in gaps}
        # what comes late no estimate makes up for, nor, in time, for what the play of a valve swallows; a sensor that errs none sees
        for hidden in ("spool_lag", "dead_time", "sensor_lag", "valve_hysteresis", "sensor_bias"):
            self.assertLess(after[hidden], 0.5, hidden)
        self.assertIn("What the data sheet does not tell", (self.folder / "page.html").read_text(encoding="utf-8"))


class Measured(Plenum):
    def test_ventilator_runs_are_fitted_and_predict_others(self):
        data = Path(TOP) / "tests/data/respiraworks"
        result = json.loads(self.done("identify", "--format", "respiraworks", "--stretch", 2, *(data / f"ctl_OXY_{i}.csv" for i in (1, 3, 5)),
                                      "--predict", *(data / f"ctl_OXY_{i}.csv" for i in (2, 4, 6)), "--report", "page.html",
                                      "--json", "-"))
        errors = [one["rms_free_run_2_s_kPa"] for one in result["predicted"]]
        self.assertEqual(len(errors), 3)
        # holding the start pressure errs by 0.78, 1.58 and 1.16 kPa there (README.md of host-sim/identify)
        for error, held in zip(errors, (0.78, 1.58, 1.16)):
            self.assertLess(error, 0.6 * held)
        self.assertEqual([round(one["rms_start_held_2_s_kPa"], 2) for one in result["predicted"]], [0.78, 1.58, 1.16])
        page = (self.folder / "page.html").read_text(encoding="utf-8")
        for i in range(1, 7):
            self.assertIn(f"<figure><h3>ctl_OXY_{i}.csv", page)
            self.assertIn(f"<figure><h3>Error, ctl_OXY_{i}.csv", page)
        for text in ["s(u)", "r(u)", "Standard error", "at its lower bound", "What these data can and cannot identify"]:
            self.assertIn(text, page)
        self.assertNotIn(str(data), page, "a page holds no path")


class Reproduce(Plenum):
    def test_a_paper_that_is_none_is_refused_with_those_there_are(self):
        self.refused(2, "reproduce", "--paper", "6", says=["6 is none", "1 (Modeling and Identification of Pneumatic Actuators)"])
        self.refused(2, "reproduce", "--paper", "0", says=["0 is none"])
        self.refused(2, "reproduce", "--report", "nowhere/page.html", says=["nowhere", "no such folder"])

    def test_text_json_and_page_say_the_same_of_a_paper(self):
        text = self.done("reproduce", "--paper", "4", "--json", "papers.json", "--report", "papers.html")
        said = json.loads((self.folder / "papers.json").read_text())
        self.assertEqual((said["schema"], len(said["papers"])), ("plenum-reproduce/1", 1))
        paper = said["papers"][0]
        findings = [one for part in paper["parts"] for one in part["findings"]]
        self.assertGreater(len(findings), 10)
        page = html.unescape((self.folder / "papers.html").read_text())
        said_in_words = " ".join(text.split())
        for part in paper["parts"]:
            self.assertIn(" ".join(part["text"].split()), said_in_words)
        self.assertLessEqual(max(len(line) for line in text.split("\n") if line.startswith("  ") and line[2:3].strip()), 100)
        for one in findings:
            self.assertIn(one["quantity"], text)
            self.assertIn(f"difference {one['difference']:.5g}: {one['verdict']}", text)
            self.assertIn(one["quantity"], page)
            self.assertEqual(one["verdict"] == "reproduced", agrees(one), one)
            self.assertTrue(one["verdict"] == "reproduced" or one["why"], one)
        counts = {verdict: sum(one["verdict"] == verdict for one in findings) for verdict in paper["verdicts"]}
        self.assertEqual(counts, paper["verdicts"])
        self.assertIn(f"paper 4: {counts['reproduced']} reproduced, {counts['differs']} differ, ", text)


def agrees(finding):
    """The verdict by a second route, from the numbers in the file."""
    if finding["ours"] is None or finding["paper"] is None:
        return False
    room = finding["tolerance"] + 1e-15 * max(abs(finding["ours"]), abs(finding["paper"]))
    above = finding["ours"] > finding["paper"] + room
    below = finding["ours"] < finding["paper"] - room
    return {"near": not above and not below, "at most": not above, "at least": not below}[finding["expect"]]


class Orifice(Plenum):
    """Choked flow has a closed form: p falls as e^(-k t), and rises at k P_s. A row is the mean over the 10 ms before it."""

    RATE_1_S, VOLUME_M3, SUPPLY_PA = 0.05, 0.2e-3, 700e3

    def log(self, name, pressure_Pa, seconds=6.0, command_V=lambda t: 5.0, volume=lambda t: 1.0):
        rows = [f"{t:.2f},{command_V(t)},{pressure_Pa(t - 0.005):.6f},{self.VOLUME_M3 * volume(t):.9f}"
                for t in (0.01 * k for k in range(round(100 * seconds)))]
        return self.write(name, "time_s,command_V,pressure_Pa,volume_m3\n" + "\n".join(rows) + "\n")

    def emptying(self, name, **how):
        return self.log(name, lambda t: self.SUPPLY_PA * math.exp(-self.RATE_1_S * t), **how)

    def test_a_choked_vessel_shows_the_rate_the_area_and_the_sonic_conductance(self):
        filling = self.log("filling.csv", lambda t: 101325 + self.RATE_1_S * self.SUPPLY_PA * t, command_V=lambda t: 6.0)
        answer = json.loads(self.done("orifice", "--thin-plate", "--exponent", "1", "--json", "-", self.emptying("emptying.csv"), filling))
        # mass per second per pascal at 293.15 K, and ISO 6358's 1.185 kg/m3; of a thin plate 0.0404 A p/sqrt(T) with C_d 1
        mass_kg_s_Pa = self.RATE_1_S * self.VOLUME_M3 / (287.87 * 293.15)
        for of, flow, command_V in zip(answer["orifices"], ("discharge", "charge"), (5, 6)):
            self.assertEqual((of["flow"], of["command_V"]), (flow, command_V))
            self.assertAlmostEqual(of["parameters"]["choked_rate_1_s"]["value"], self.RATE_1_S, delta=1e-6)
            self.assertAlmostEqual(of["sonic_conductance_dm3_s_bar"], 1e8 * mass_kg_s_Pa / 1.185, delta=1e-6)
            self.assertAlmostEqual(of["parameters"]["area_m2"]["value"] / (mass_kg_s_Pa * math.sqrt(293.15) / 0.040418), 1.0, delta=0.01)
            self.assertTrue(of["parameters"]["critical_ratio"]["held"])
            self.assertLess(of["mean_absolute_error_kPa"], 1e-3)

    def opened(self, name, seconds):
        """A valve that is opened at 1 s and shut at 3 s."""
        return self.log(name, lambda t: self.SUPPLY_PA * math.exp(-0.5 * min(max(t - 1, 0), 2)), seconds,
                        command_V=lambda t: 6.0 if 0.995 < t < 2.995 else 5.0)

    def test_a_log_from_the_step_of_its_command_on_has_no_part_in_what_was_before(self):
        valve = self.opened("valve.csv", 4.0)
        answer = json.loads(self.done("orifice", "--thin-plate", "--from", "1", "--to", "3", "--json", "-", valve))
        self.assertAlmostEqual(answer["orifices"][0]["parameters"]["choked_rate_1_s"]["value"], 0.5, delta=1e-6)

    def test_conductance_and_area_are_of_gas_at_the_temperature_of_the_rig(self):
        leak = self.emptying("leak.csv")
        at = {}
        for temperature_K in (293.15, 320):
            rig = self.write("rig.toml", f"[sampling]\nrate_Hz = 100\n[gas]\ntemperature_K = {temperature_K}\n")
            at[temperature_K] = json.loads(self.done("orifice", "--thin-plate", "--rig", rig, "--json", "-", leak))["orifices"][0]
        warm, cool = at[320], at[293.15]
        self.assertEqual(warm["parameters"]["choked_rate_1_s"], cool["parameters"]["choked_rate_1_s"])
        ratio = math.sqrt(293.15 / 320)
        self.assertAlmostEqual(warm["sonic_conductance_dm3_s_bar"] / cool["sonic_conductance_dm3_s_bar"], ratio, delta=1e-9)
        self.assertAlmostEqual(warm["parameters"]["area_m2"]["value"] / cool["parameters"]["area_m2"]["value"], ratio, delta=1e-9)

    def test_columns_in_another_unit_are_refused(self):
        for name, scale, says in (("mL", 1e6, "expected m3"), ("litres", 1e3, "expected m3"), ("none", 0.0, "expected above 0")):
            self.refused(2, "orifice", self.emptying(f"{name}.csv", volume=lambda t, scale=scale: scale),
                         says=[f"{name}.csv", "column volume_m3", says])
        for name, scale in {"kPa": 1e-3, "bar": 1e-5}.items():
            self.refused(2, "orifice", self.log(f"{name}.csv", lambda t, scale=scale: scale * (700e3 - 50e3 * t)),
                         says=[f"{name}.csv", "column pressure_Pa", "expected absolute pressure in Pa"])
        self.refused(2, "orifice", self.log("gauge.csv", lambda t: 600e3 - 99e3 * t),
                     says=["gauge.csv", "column pressure_Pa", "gauge pressure in Pa", "expected absolute pressure"])

    def test_the_page_and_the_text_say_the_same(self):
        self.assertIn("effective_area", self.done("orifice", "--thin-plate", self.emptying("vent.csv")))
        text = self.done("orifice", "--thin-plate", self.emptying("leak.csv"), "--report", "leak.html")
        rate = re.search(r"choked_rate +(\S+)", text)[1]
        self.assertIn(rate[:6], html.unescape((self.folder / "leak.html").read_text(encoding="utf-8")))

    def test_what_is_no_single_orifice_is_refused_with_the_part_that_is_one(self):
        steps = self.emptying("steps.csv", command_V=lambda t: 5.0 if t < 1.995 else 4.8)
        self.refused(3, "orifice", steps, says=["steps.csv", "the command changes", "longest part at one is --from 2\n"])
        self.done("orifice", "--thin-plate", steps, "--from", "2")
        valve = self.opened("valve.csv", 4.0)
        self.refused(3, "orifice", valve, says=["longest part at one is --from 1 --to 3\n"])
        self.assertIn(", 1.98 s,", self.done("orifice", "--thin-plate", valve, "--from", "1", "--to", "3"))
        moving = self.emptying("moving.csv", volume=lambda t: 1.0 + 0.02 * t)
        self.refused(3, "orifice", moving, says=["moving.csv", "the volume moves from 200 to"])
        tight = self.log("tight.csv", lambda t: self.SUPPLY_PA * math.exp(-1e-3 * t))
        self.refused(3, "orifice", tight, says=["tight.csv", "pressure ratios from", "--thin-plate"])
        self.refused(2, "orifice", tight, "--from", "7", says=["tight.csv", "--from 7", "3 or more"])


class Blind(Plenum):
    """A small set, answered by a diagnosis that reads the labels: it must score full marks."""

    def perfect(self, label):
        floor, gap = label["noise_floor_Pa"], label["recalibrated_gap_Pa"]
        left = (floor ** 2 + gap ** 2) ** 0.5
        effects = [{"id": e["id"], "confidence": 1.0, "aliases": []} for e in label["effects"]
                   if e["catalogued"] and e["alone_recalibrated_gap_Pa"] >= floor]
        verdict = "calibration" if gap < floor else "explained" if effects else "unexplained"
        if verdict == "calibration":
            effects = []
        closed = left if verdict == "unexplained" else floor
        return {"schema": "plenum-gap/1", "verdict": verdict, "effects": effects, "candidates": effects,
                "gap_kPa": {"recalibrated": left / 1e3, "with_effects": closed / 1e3},
                "equation": {"id": label["effects"][0]["equation"], "confidence": 1.0} if effects else None}

    def make(self, *options):
        self.done("blind", "generate", "--out", "set", "--cases", 10, "--seconds", 10, *options)
        (self.folder / "answers").mkdir()
        for path in sorted((self.folder / "set" / "labels").iterdir()):
            label = json.loads(path.read_text(encoding="utf-8"))
            self.write(f"answers/{path.name}", json.dumps(self.perfect(label)))

    def test_a_diagnosis_that_knows_the_labels_scores_full_marks(self):
        self.make()
        score = json.loads(self.done("blind", "score", "set", "--answers", "answers", "--json", "-"))
        self.assertEqual((score["cases"], score["missing_answers"], score["mistakes"]), (10, 0, []))
        self.assertEqual(score["top1_percent"]["all"]["percent"], 100)
        self.assertEqual(score["false_alarm_percent"]["percent"], 0)
        self.assertIn("truth \\ first answer", self.done("blind", "score", "set", "--answers", "answers"))

    def test_what_was_sealed_cannot_be_changed(self):
        self.make("--effect", "dead_time")
        label = self.folder / "set" / "labels" / "case-0003.json"
        label.write_text(label.read_text(encoding="utf-8").replace("dead_time", "spool_lag"), encoding="utf-8")
        self.refused(2, "blind", "score", "set", "--answers", "answers", says=["case-0003.json", "SHA-256", "changed"])

    def test_wrong_requests_and_answers_are_one_line(self):
        self.refused(2, "blind", says=["subcommand"])
        self.refused(2, "blind", "generate", "--out", "q", "--effect", "gremlin", says=["gremlin", "spool_lag"])
        self.refused(2, "blind", "generate", "--out", "q", "--effect", "dead_time", "--kind", "none", says=["dead_time"])
        self.refused(2, "blind", "generate", "--out", "q", "--tier", "4", says=["--tier", "4"])
        self.refused(2, "blind", "score", "set", "--answers", "answers", says=["answers", "no such folder"])
        self.done("blind", "generate", "--out", "set", "--cases", 1, "--seconds", 10)
        self.refused(2, "blind", "generate", "--out", "set", says=["set", "new folder"])
        (self.folder / "answers").mkdir()
        self.refused(2, "blind", "score", "set", "--answers", "answers", says=["case-0001.json"])
        self.write("answers/case-0001.json", "{}")
        self.refused(2, "blind", "score", "set", "--answers", "answers", says=["answers/case-0001.json", "schema"])


if __name__ == "__main__":
    PROGRAM, TOP, CASE = sys.argv[1:4]
    unittest.main(argv=[sys.argv[0], CASE], verbosity=2)
