"""The commands that speak to a board, as their user runs them."""

import configparser
import json
import os
import pty
import re
import resource
import signal
import socket
import subprocess
import tempfile
import threading

from command import PROGRAM, CommandTest, model, run

MODEL = {
    "schema": "plenum-model/1", "kind": "tassa9", "chamber": 2,
    "parameters": {"c1_V": 5.02, "c2_per_V": 2.5, "c3_per_V3": 4.0, "c4_kPa_s_per_mL": -0.05, "c5_per_mL": 0.003,
                   "c6_per_mL": 0.02, "c7_per_V_s": 40, "c8": 0.1, "c9_V": 0.08, "c_gamma_V": 0.1,
                   "supply_kPa": 620, "ambient_kPa": 101.325},
    "fit": {"date_s": 1700000000, "rms_one_step_kPa": 1.25, "valve_serial": 4711, "sensor_serial": 815},
}
HEARTBEAT = ("1017h", 0)


class BoardCommands(CommandTest):
    def json_of(self, *arguments, code=0):
        ran = self.plenum(*arguments, "--json", "-")
        self.assertEqual((ran.returncode, ran.stderr), (code, ""), arguments)
        return json.loads(ran.stdout)

    def upload(self):
        self.write("model-2.json", json.dumps(MODEL))
        self.done("upload", "--store", "board", "model-2.json")

    def changed(self, backup, setting, value):
        """A copy of a backup file in which one setting is another."""
        content = json.loads((self.folder / backup).read_text())
        row, = [one for one in content["settings"] if (one["index"], one["sub"]) == setting]
        row["value"] = value
        return self.write("changed.json", json.dumps(content))


class Looking(BoardCommands):
    def test_scan_finds_the_node_and_says_how_it_is(self):
        text = self.done("scan", "--node", 9)
        self.assertRegex(text, r"\n +9 +pre-operational +Plenum valve board .* INIT +0/8 +-\n")
        node, = self.json_of("scan", "--node", 9)["nodes"]
        self.assertEqual((node["node"], node["device_type"], node["board"]["models"]), (9, "FFFF0198h", 0))
        self.assertTrue(node["board"]["compatible"])

    def test_info_shows_models_with_crc_date_error_and_serials(self):
        self.upload()
        text = self.done("info", "--store", "board")
        self.assertRegex(text, r"\n +2 +active +[0-9A-F]{8}h +\d+ +2023-11-14 +1\.25 +0 +[0-9.e-]+ +4711 +815\n")
        self.assertRegex(text, r"\n +1 +empty\n")
        self.assertIn("Producer heartbeat time [ms]", text)
        info = self.json_of("info", "--store", "board")
        self.assertEqual(info["models"][1]["valve_serial"], 4711)
        self.assertLess(0, info["models"][1]["fixed_error_kPa"])
        self.assertLess(info["models"][1]["fixed_error_kPa"], 1e-3)
        self.assertIsNone(info["models"][0]["crc"])
        self.assertEqual(info["health"]["overruns"], 0)
        self.assertIn({"index": "1017h", "sub": 0, "name": "Producer heartbeat time [ms]", "value": 1000}, info["settings"])

    def test_upload_tells_whether_the_board_compared_a_model_with_the_one_before(self):
        self.write("model-2.json", json.dumps(MODEL))
        first, = self.json_of("upload", "--store", "board", "model-2.json")["uploaded"]
        self.assertEqual(first["comparison"], {"compared": False, "outcome": "no model before", "rms_Pa": None, "before_rms_Pa": None, "doubt": None})
        self.assertNotIn("not compared", self.done("upload", "--store", "board", "model-2.json"), "the same again")
        self.write("other.json", json.dumps(MODEL | {"parameters": MODEL["parameters"] | {"c7_per_V_s": 41}}))
        self.assertRegex(self.done("upload", "--store", "board", "other.json"),
                         r"\Achamber 2: .*; not compared with the model before: the board has no log [^\n]*\n\Z")
        self.done("backup", "--store", "board", "-o", "b.json")
        self.upload()
        self.assertIn("  chamber 2: not compared with the model before", self.done("restore", "--store", "board", "b.json"))
        self.upload()
        compared, = self.json_of("restore", "--store", "board", "b.json")["comparisons"]
        self.assertEqual((compared["chamber"], compared["comparison"]["outcome"]), (2, "no log with movement"))

    def ini(self, file):
        """A file of CiA 306, read by what shares no line with its writer."""
        read = configparser.ConfigParser(strict=True, interpolation=None, delimiters=("=",))
        read.optionxform = str
        read.read_string((self.folder / file).read_text())
        return read

    def test_describe_writes_the_sheet_of_the_board_and_the_same_for_its_node(self):
        files = self.json_of("describe", "--node", 9, "-o", "sheets", "--bit-rate", 500000)["files"]
        self.assertEqual(files, {kind: f"sheets/node-9.{kind}" for kind in ["eds", "dcf", "dbc"]})
        eds, dcf = self.ini(files["eds"]), self.ini(files["dcf"])
        self.assertEqual(eds["1800sub1"]["DefaultValue"], "$NODEID+0x40000180")
        self.assertEqual(int(dcf["1800sub1"]["DefaultValue"], 0), 0x40000189)
        self.assertEqual(dcf["DeviceComissioning"]["NodeID"], "9")
        self.assertEqual(dcf["DeviceComissioning"]["Baudrate"], "500")
        self.assertEqual(dcf["DeviceComissioning"]["NodeName"], "Plenum valve board")
        self.assertEqual(dcf["FileInfo"]["LastEDS"], "node-9.eds")
        self.assertIn("BO_ 393 Board9_TPDO1: 8 Board9\n", (self.folder / files["dbc"]).read_text())

    def test_describe_tells_what_the_board_is_set_to(self):
        self.done("backup", "--store", "board", "-o", "b.json")
        content = json.loads((self.folder / "b.json").read_text())
        changed = {HEARTBEAT: 500, ("1804h", 1): 0x681, ("2228h", 2): 2e-8}
        for row in content["settings"]:
            row["value"] = changed.get((row["index"], row["sub"]), row["value"])
        self.write("changed.json", json.dumps(content))
        self.done("restore", "--store", "board", "changed.json")
        self.done("describe", "--store", "board")
        dcf = self.ini("description/node-1.dcf")
        for section, default, value in [("1017", 1000, 500), ("1804sub1", 0xC0000000, 0x681), ("1014", 0x81, 0x81)]:
            self.assertEqual(int(dcf[section]["DefaultValue"], 0), default, section)
            self.assertEqual(int(dcf[section]["ParameterValue"], 0), value, section)
        self.assertEqual(float(dcf["2228sub2"]["ParameterValue"]), 2e-8)
        self.assertNotIn("ParameterValue", dcf["1018sub4"], "no setting")
        dbc = (self.folder / "description/node-1.dbc").read_text()
        message = dbc[dbc.index("BO_ 1665 Board1_TPDO5: 8 Board1\n"):].split("\n\n")[0]
        self.assertIn(' SG_ Actual_pressure_chamber_1 : 0|32@1- (1,0) [0|0] "Pa" Master', message)
        command, volume = message.split("\n")[2:4]
        factor = re.fullmatch(r' SG_ Command_code_chamber_1 : 32\|16@1\+ \((\S+),0\) \[0\|(\S+)\] "V" Master', command)
        self.assertAlmostEqual(float(factor[1]), 10 / 65535, places=11)
        self.assertAlmostEqual(float(factor[2]), 10, places=6)
        self.assertEqual(volume, ' SG_ Volume_code_chamber_1 : 48|16@1+ (0.00000002,0) [0|0.0013107] "m3" Master')
        self.assertIn("SIG_VALTYPE_ 1665 Actual_pressure_chamber_1 : 1;\n", dbc)

    def test_a_backup_of_a_board_that_streams_is_refused_unless_forced(self):
        self.done("backup", "--store", "board", "-o", "b.json")
        streaming = self.changed("b.json", ("1804h", 1), 0x681)
        self.done("restore", "--store", "board", streaming)
        self.refused(1, "backup", "--store", "board", "-o", "again.json", says=["TPDO 5 streams on 681h already"])
        self.assertFalse((self.folder / "again.json").exists())
        self.done("backup", "--store", "board", "-o", "again.json", "--force")

    def test_describe_names_each_identifier_and_each_signal_of_a_message_once(self):
        self.done("backup", "--store", "board", "-o", "b.json")
        content = json.loads((self.folder / "b.json").read_text())
        status = 0x60410010
        changed = {("1402h", 1): 0x401, ("1403h", 1): 0x401, ("1A02h", 0): 2, ("1A02h", 1): status, ("1A02h", 2): status}
        for row in content["settings"]:
            row["value"] = changed.get((row["index"], row["sub"]), row["value"])
        self.write("changed.json", json.dumps(content))
        self.done("restore", "--store", "board", "changed.json")
        self.done("describe", "--store", "board")
        dbc = (self.folder / "description/node-1.dbc").read_text()
        messages = re.findall(r"^BO_ (\d+) .*\n((?: SG_ .*\n)*)", dbc, re.M)
        identifiers = [identifier for identifier, _ in messages]
        self.assertEqual(len(identifiers), len(set(identifiers)), identifiers)
        self.assertIn('CM_ BO_ 1025 "Board1_RPDO4 has this identifier, too";\n', dbc)
        for _, signals in messages:
            names = re.findall(r"^ SG_ (\w+) ", signals, re.M)
            self.assertEqual(len(names), len(set(names)), names)

    def test_describe_refuses_what_cannot_be(self):
        self.refused(2, "describe", "--bit-rate", 123456, says=["bit rate 123456", "1000000"])
        self.write("file", "")
        self.refused(2, "describe", "-o", "file", says=["file"])
        self.refused(2, "describe", "-o", "file/below", says=["file/below"])
        self.refused(3, "describe", "--bus", "socketcand:127.0.0.1:1/can0", says=["127.0.0.1"])

    def test_faults_of_a_board_without_one(self):
        self.assertIn("no fault stands", self.done("faults"))
        self.assertEqual(self.json_of("faults"), {"fault": None, "standing": [], "history": [], "history_cleared": False})

    def test_reset_wants_to_know_what(self):
        self.refused(2, "reset", says=["nothing", "--fault", "--restart", "--communication", "--log"])
        self.refused(2, "reset", "--fault", "--restart", says=["several things", "one of"])
        for kind in ["--restart", "--communication"]:
            self.assertIn("has started anew", self.done("reset", kind))
        self.assertEqual(self.json_of("reset", "--fault")["fault_before"], None)


class ServedBoard(BoardCommands):
    """A rig of one chamber that another program serves."""

    def serve(self, *arguments):
        return super().serve("--chambers", 1, *arguments)

    def say(self, *frames):
        """Frames to the rig, as another program's; when it has taken them it answers an echo."""
        host, port = re.fullmatch(r"socketcand:([^:]+):(\d+)/can0", self.bus[1]).groups()
        with socket.create_connection((host, int(port))) as other:
            other.sendall("".join(["< open can0 >", *(f"< send {frame} >" for frame in frames), "< echo >"]).encode())
            heard = b""
            while b"< echo >" not in heard:
                heard += other.recv(4096)


class InUse(ServedBoard):
    """What a board is left as by one command is what the next one meets."""

    def state(self):
        return self.json_of("scan", *self.bus)["nodes"][0]["board"]["state"]

    def test_who_was_recorded_before_takes_settings_a_calibration_and_a_bit_rate(self):
        self.serve()
        capture = ["capture", *self.bus, "--seconds", 1, "--chambers", 1]
        self.done(*capture, "-o", "first")
        self.assertEqual(self.state(), "DISABLED")
        self.done("backup", *self.bus, "-o", "b.json")
        self.assertEqual(self.json_of("restore", *self.bus, self.changed("b.json", ("2400h", 2), 1.0))["not_written"], [])
        found = self.json_of("diff", *self.bus, "b.json", code=1)
        self.assertEqual([one["what"] for one in found["differences"]], ["2400h:2 pressure_offset_kPa"])
        self.done(*capture, "-o", "second")
        self.done("calibrate", *self.bus, "--chamber", 1, "--offset", 0)
        self.done(*capture, "-o", "third")
        self.done("lss", *self.bus, "--node", 1, "--set-bit-rate", 1000000)

    def test_a_warning_is_left_to_go_by_itself_and_the_state_to_its_master(self):
        self.serve()
        self.done("nmt", *self.bus, "--start")
        self.say("601 8 2b 40 60 0 1 0 0 0", "401 1 1")  # DISABLED; and an RPDO that is too short
        found = self.json_of("faults", *self.bus, code=1)
        self.assertEqual([one["code"] for one in found["standing"]], ["8210h"])
        self.say("601 8 2b 40 60 0 0 0 0 0")
        said = self.json_of("reset", *self.bus, "--fault")
        self.assertEqual((said["fault_before"]["code"], said["fault_left"]["code"]), ("8210h", "8210h"))
        self.assertEqual(self.state(), "INIT", "as its master has it")
        self.assertIn("nothing to reset: 8210h", self.done("reset", *self.bus, "--fault"))

    def test_a_fault_whose_cause_has_gone_is_cleared_and_its_history_too(self):
        self.serve()
        self.done("nmt", *self.bus, "--start")
        self.say("601 8 23 16 10 1 64 0 32 0", "732 1 5")  # 1016h:1: node 50 beats within 100 ms, as it does once
        while self.plenum("faults", *self.bus).returncode == 0:
            pass
        self.refused(1, "reset", *self.bus, "--fault", says=["8130h", "still stands", "expected its cause to be gone"])
        self.assertEqual([one["code"] for one in self.json_of("faults", *self.bus, code=1)["standing"]], ["8130h"])
        self.say("601 8 23 16 10 1 0 0 0 0")
        self.assertIn("8130h heartbeat lost is cleared; the board is DISABLED\n", self.done("reset", *self.bus, "--fault"))
        found = self.json_of("faults", *self.bus)
        self.assertEqual((found["standing"], [one["code"] for one in found["history"]]), ([], ["8130h"]))
        self.assertEqual(self.json_of("faults", *self.bus, "--clear-history")["history_cleared"], True)
        self.assertEqual(self.json_of("faults", *self.bus)["history"], [])

    def test_a_master_who_takes_the_board_away_ends_a_recording_and_is_told_of(self):
        self.serve()
        running = subprocess.Popen([PROGRAM, "capture", *self.bus, "--seconds", "60", "--chambers", "1", "-o", "cut"], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while self.state() != "ACTIVE":
            pass
        self.say("601 8 2b 40 60 0 1 0 0 0")
        _, told = running.communicate()
        self.assertEqual(running.returncode, 1, told)
        self.assertRegex(told, r"\Aplenum capture: node 1: has left ACTIVE by row \d+ and is DISABLED, and no fault says why[^\n]*\n\Z")
        self.assertLess(len(self.rows("cut/chamber-1.csv")), 6000)


    def test_a_log_that_finds_no_room_ends_while_the_bus_is_busy(self):
        def in_little_room():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))

        self.serve()
        capturing = subprocess.Popen([PROGRAM, "capture", *self.bus, "--seconds", "300", "--chambers", "1", "-o", "busy"], cwd=self.folder,
                                     stdout=subprocess.DEVNULL)
        recording = subprocess.run([PROGRAM, "record", *self.bus, "-o", "bus.log"], cwd=self.folder, preexec_fn=in_little_room,
                                   capture_output=True, text=True, timeout=200)
        self.assertIsNone(capturing.poll())
        capturing.terminate()
        capturing.wait()
        self.assertEqual((recording.returncode, recording.stderr),
                         (2, "plenum record: bus.log: cannot be written, expected room for a log\n"))


class Naming(ServedBoard):
    """Node ids by LSS."""

    def nodes(self, code=0):
        return [node["node"] for node in self.json_of("scan", *self.bus, code=code)["nodes"]]

    def test_a_board_gets_another_node_id_and_keeps_it(self):
        serving = self.serve("--store", "board")
        self.assertEqual(self.json_of("lss", *self.bus, "--node", 1, "--set-node", 9)["node"], 9)
        self.assertEqual(self.nodes(), [9])
        serving.terminate()
        serving.wait()
        self.serve("--store", "board")
        self.assertEqual(self.nodes(), [9])

    def test_a_board_that_was_operational_is_so_again_unless_it_has_another_node_id(self):
        self.serve()
        bit_rate = ["lss", *self.bus, "--node", 1, "--set-bit-rate", 1000000]
        self.assertIn("it is pre-operational: its PDOs wait for NMT start\n", self.done(*bit_rate))
        self.say("0 2 1 1")
        self.assertIn("it is operational again\n", self.done(*bit_rate))
        self.assertEqual(self.json_of("scan", *self.bus)["nodes"][0]["nmt"], "operational")
        self.assertEqual(self.json_of(*bit_rate)["nmt"], "operational")
        self.refused(1, "lss", *self.bus, "--node", 1, "--set-bit-rate", 500000, says=["bit rate", "error 1"])
        self.assertEqual(self.json_of("scan", *self.bus)["nodes"][0]["nmt"], "operational", "also after a refusal")
        self.assertEqual(self.json_of("lss", *self.bus, "--node", 1, "--set-node", 9)["nmt"], "pre-operational")
        self.assertEqual(self.json_of("scan", *self.bus)["nodes"][0]["nmt"], "pre-operational")

    def test_process_data_is_started_and_stopped(self):
        self.serve()
        self.refused(2, "nmt", *self.bus, says=["nothing", "--start"])
        self.refused(2, "nmt", *self.bus, "--start", "--stop", says=["several", "one of"])
        for order, state in [("--start", "operational"), ("--stop", "stopped"), ("--pre-operational", "pre-operational")]:
            self.assertEqual(self.json_of("nmt", *self.bus, order), {"node": 1, "nmt": state})
            if state == "stopped":
                self.refused(3, "info", *self.bus, says=["had no answer", "is stopped", "plenum nmt --pre-operational"])
        self.assertIn("no pressures: they wait for `plenum nmt --start`", self.done("monitor", *self.bus, "--seconds", 1.5))

    def test_a_log_that_somebody_left_frozen_is_told_and_let_go_on(self):
        self.serve()
        self.assertIn("not frozen", self.done("reset", *self.bus, "--log"))
        self.say("601 8 2f 0 23 1 1 0 0 0")  # 2300h:1 = freeze
        self.assertTrue(self.json_of("info", *self.bus)["log_frozen"])
        self.assertIn("its log is frozen", self.done("info", *self.bus))
        self.assertIn("the log goes on", self.done("reset", *self.bus, "--log"))
        self.assertFalse(self.json_of("info", *self.bus)["log_frozen"])

    def test_a_board_without_a_node_id_is_found_and_named(self):
        self.serve()
        self.refused(3, "lss", *self.bus, says=["without a node id", "--node"])
        identity = self.json_of("info", *self.bus)["identity"]
        self.done("lss", *self.bus, "--node", 1, "--set-node", 255)
        self.assertEqual(self.nodes(code=1), [])
        self.assertEqual(self.json_of("lss", *self.bus), {"identity": identity, "node": None, "nmt": None, "bit_rate": None})
        self.refused(1, "lss", *self.bus, "--set-node", 7, "--set-bit-rate", 500000, says=["bit rate", "error 1"])  # the rig's bus has one
        self.assertIn("is node 7 now", self.done("lss", *self.bus, "--set-node", 7, "--set-bit-rate", 1000000))
        self.assertEqual(self.nodes(), [7])

    def test_what_cannot_be_is_refused_and_no_node_changes(self):
        self.serve("--boards", "2")
        self.refused(1, "lss", *self.bus, "--node", 1, "--set-node", 2, says=["node 2", "no other has"])
        self.refused(2, "lss", *self.bus, "--node", 1, says=["--set-node", "--set-bit-rate"])
        self.refused(2, "lss", *self.bus, "--node", 1, "--set-node", 200, says=["--set-node 200", "127"])
        self.refused(2, "lss", *self.bus, "--node", 1, "--set-node", 1, says=["--set-node 1"])
        self.refused(2, "lss", *self.bus, "--node", 1, "--set-bit-rate", 123, says=["bit rate 123", "1000000"])
        self.refused(3, "lss", *self.bus, "--node", 9, "--set-node", 10, says=["node 9"])
        self.assertEqual(self.nodes(), [1, 2])


class Progress(BoardCommands):
    """What commands say of a transfer to who waits at a terminal, and to nobody else."""

    def drawn(self, *arguments):
        """Standard output, and what went to standard error, a terminal."""
        leader, follower = pty.openpty()
        self.addCleanup(os.close, leader)
        self.addCleanup(os.close, follower)
        end = b"\0"  # a terminal whose last writer goes away can lose what it wrote last, so it stays open and this ends it

        def finish(ran):
            ran.wait()
            os.write(follower, end)

        with tempfile.TemporaryFile() as out:
            with subprocess.Popen([PROGRAM, *map(str, arguments)], cwd=self.folder, stdout=out, stderr=follower) as ran:
                finishing = threading.Thread(target=finish, args=[ran])
                finishing.start()
                said = b""
                while not said.endswith(end):
                    said += os.read(leader, 65536)
                finishing.join()
            self.assertEqual(ran.returncode, 0, said)
            out.seek(0)
            return out.read().decode(), said.removesuffix(end).decode()

    def test_a_terminal_sees_chamber_and_bytes(self):
        self.write("model-2.json", json.dumps(MODEL))
        # the header, twelve parameters and a CRC: 32 + 12 x 4 + 4
        said = {
            "upload": ["uploading: ", "chamber 2: Active model image, 84 of 84 bytes", "Mask and model images, 85 of 85 bytes"],
            "download": ["downloading: chamber 2: Active model image, 84 of 84 bytes"],
            "diff": ["comparing: chamber 2: Active model image, 84 of 84 bytes"],
            "info": ["reading: chamber 2: Active model image, 84 of 84 bytes", "chamber 8: residual_ticks"],
            "backup": ["reading: chamber 2: Active model image, 84 of 84 bytes"],
            "restore": ["restoring: ", "chamber 2: Active model image, 84 of 84 bytes"],
            "scan": ["scanning: listening", "scanning: node 1"],
        }
        given = {"upload": ["model-2.json"], "diff": ["model-2.json"], "backup": ["-o", "b.json"], "restore": ["b.json"]}
        for command, parts in said.items():
            with self.subTest(command):
                out, drawn = self.drawn(command, "--store", "board", *given.get(command, []), "--json", "-")
                json.loads(out)
                for part in parts:
                    self.assertIn(part, drawn)
                self.assertTrue(drawn.endswith("\r\x1b[K"), "the line is taken away")
                for line in drawn.replace("\x1b[K", "").split("\r"):
                    self.assertLess(len(line), 80)

    def test_what_is_printed_takes_the_place_of_the_line(self):
        self.upload()
        _, drawn = self.drawn("info", "--store", "board")
        self.assertIn("\r\x1b[K\r\x1b[K", drawn)


class Keeping(BoardCommands):
    def test_a_backup_is_alike_the_board_it_came_from_and_restores_to_it(self):
        self.upload()
        said = self.json_of("backup", "--store", "board", "-o", "b.json")
        self.assertEqual((said["models"], said["settings"] > 100), (1, True))
        self.assertEqual(self.json_of("diff", "--store", "board", "b.json")["alike"], True)
        restored = self.json_of("restore", "--store", "board", "b.json")
        self.assertEqual((restored["models"], restored["not_written"]), (1, []))
        self.done("backup", "--store", "board", "-o", "again.json")
        self.assertEqual((self.folder / "b.json").read_text(), (self.folder / "again.json").read_text())

    def test_a_board_that_lost_its_models_gets_them_back(self):
        self.upload()
        self.done("backup", "--store", "board", "-o", "b.json")
        self.done("restore", "--store", "other", "b.json")
        self.assertEqual(self.json_of("diff", "--store", "other", "model-2.json")["alike"], True)

    def test_another_boards_backup_is_taken_over_when_asked_for(self):
        self.done("backup", "--store", "board", "-o", "b.json")
        self.refused(2, "restore", "--store", "board", "--node", 5, "b.json", says=["is of node 1", "node 5", "--move"])
        self.done("restore", "--store", "other", "--node", 5, "--move", "b.json")
        self.done("backup", "--store", "other", "--node", 5, "-o", "moved.json")
        values = [{(row["index"], row["sub"]): row["value"] for row in json.loads((self.folder / file).read_text())["settings"]}
                  for file in ["b.json", "moved.json"]]
        moved = {key: both for key, *both in ((key, value, values[1][key]) for key, value in values[0].items()) if both[0] != both[1]}
        self.assertEqual(moved[("1800h", 1)], [0x40000181, 0x40000185])
        for key, (before, after) in moved.items():
            self.assertEqual((before & 0x7F, after), (1, before + 4), key)

    def test_a_simulated_board_that_keeps_nothing_is_neither_saved_nor_restored(self):
        self.refused(2, "backup", says=["--store is missing"])
        self.done("backup", "--store", "board", "-o", "b.json")
        self.refused(2, "restore", "b.json", says=["--store is missing"])

    def test_diff_names_what_differs(self):
        self.upload()
        MODEL2 = json.loads(json.dumps(MODEL))
        MODEL2["parameters"]["c7_per_V_s"] = 41
        self.write("other.json", json.dumps(MODEL2))
        found = self.json_of("diff", "--store", "board", "other.json", code=1)
        self.assertEqual(found["differences"], [{"what": "chamber 2 c7_per_V_s", "file": "41", "board": "40"}])
        self.done("diff", "--store", "board", "model-2.json")
        found = self.json_of("diff", "--store", "board", "model-2.json", "--chamber", "3", code=1)
        self.assertEqual(found["differences"], [{"what": "chamber 3 model", "file": "there", "board": None}])
        self.done("backup", "--store", "board", "-o", "b.json")
        found = self.json_of("diff", "--store", "board", self.changed("b.json", HEARTBEAT, 500), code=1)
        self.assertEqual([(one["file"], one["board"]) for one in found["differences"]], [("500", "1000")])

    def test_what_a_board_refuses_is_named_and_exit_1(self):
        self.done("backup", "--store", "board", "-o", "b.json")
        ran = self.plenum("restore", "--store", "board", self.changed("b.json", ("1005h", 0), 0x40000080))
        self.assertEqual((ran.returncode, ran.stderr), (1, ""))
        self.assertRegex(ran.stdout, r"not written: 1005h:0 COB-ID SYNC: .*06090030h")

    def test_a_value_beyond_its_range_is_told_with_the_range_and_the_rest_is_written(self):
        self.done("backup", "--store", "board", "-o", "b.json")
        said = self.json_of("restore", "--store", "board", self.changed("b.json", ("2401h", 9), 5000), code=1)
        refused, = said["not_written"]
        self.assertEqual((refused["index"], refused["sub"], refused["name"]), ("2401h", 9, "pressure_low_kPa"))
        self.assertRegex(refused["reason"], r": is 5000, expected 0 to 2000$")

    def test_a_reference_beyond_the_limits_of_a_chamber_is_refused_before_anything_moves(self):
        self.upload()
        self.refused(2, "regulate", "--store", "board", "--mean", 650, "--amplitude", 100,
                     says=["chamber 1", "reference from 550 to 750 kPa", "63A0h"])
        self.refused(2, "regulate", "--store", "board", "--amplitude", 400,
                     says=["chamber 1", "reference from -50 to 750 kPa", "within 100 to 700 kPa", "63A1h"])
        self.assertFalse((self.folder / "regulate").exists())

    def test_a_model_that_the_backup_lacks_is_told_and_exit_1(self):
        self.done("backup", "--store", "board", "-o", "b.json")
        self.upload()
        ran = self.plenum("restore", "--store", "board", "b.json")
        self.assertEqual((ran.returncode, ran.stderr), (1, ""))
        self.assertRegex(ran.stdout, r"no model of chamber 2, and the board keeps the one it has")
        self.assertIn("has stored its settings", ran.stdout)
        self.assertEqual(self.json_of("restore", "--store", "board", "b.json", code=1)["models_beside"], [2])
        self.done("restore", "--store", "board", "--settings-only", "b.json")

    def test_a_backup_that_was_cut_is_refused_before_anything_is_written(self):
        self.done("backup", "--store", "board", "-o", "b.json")
        content = json.loads((self.folder / "b.json").read_text())
        for setting in content["settings"]:
            if (setting["index"], setting["sub"]) == HEARTBEAT:
                setting["value"] = 500
        lost = content["settings"].pop()
        self.write("cut.json", json.dumps(content))
        self.refused(2, "restore", "--store", "board", "cut.json",
                     says=["cut.json", "lacks 1 setting that", f"{lost['index']}:{lost['sub']} {lost['name']}", "--partial"])
        self.assertEqual(self.json_of("diff", "--store", "board", "b.json")["alike"], True)
        self.assertEqual(self.json_of("restore", "--store", "board", "--partial", "cut.json")["not_written"], [])
        self.assertEqual(len(self.json_of("diff", "--store", "board", "b.json", code=1)["differences"]), 1)

    def test_a_backup_that_cannot_be_meant_is_refused(self):
        self.refused(2, "restore", "missing.json", says=["missing.json", "No such file"])
        self.write("text.json", "PLM1")
        self.refused(2, "restore", "text.json", says=["text.json", "JSON"])
        self.done("backup", "--store", "board", "-o", "b.json")
        self.refused(2, "restore", "--store", "board", "--node", 2, "b.json", says=["node 1", "node 2"])
        content = json.loads((self.folder / "b.json").read_text())
        for change, says in [({"schema": "plenum-model/1"}, ["schema", "plenum-backup/1"]),
                             ({"node": "one"}, ["node", "\"one\""]),
                             ({"settings": [{"index": "10", "sub": 0}]}, ["settings[0]", "index", "\"10\""]),
                             ({"settings": 2 * [content["settings"][0]]}, ["1005h:0", "twice"]),
                             ({"settings": [content["settings"][0] | {"value": -1}]}, ["settings[0]", "-1", "UNSIGNED32"]),
                             ({"models": [{"chamber": 9, "image": "00"}]}, ["models[0]", "chamber", "9", "1..8"]),
                             ({"models": [{"chamber": 1, "image": "0x"}]}, ["models[0]", "image"])]:
            self.write("bad.json", json.dumps(content | change))
            self.refused(2, "restore", "bad.json", says=["bad.json", *says])

    def test_what_a_sensor_is_off_goes_into_the_calibration_and_stays_there_when_kept(self):
        options = ["--chamber", 2, "--offset", 2, "--gain-error", 0.05, "--ambient", 100]
        self.assertIn("gone with this command", self.done("calibrate", "--store", "board", *options))
        found = self.json_of("calibrate", "--store", "board", *options)
        # z = p + 2 + 0.05 (p - 100) = 1.05 p - 3
        self.assertEqual(found["before"], {"pressure_gain_kPa_per_V": 100.0, "pressure_offset_kPa": 0.0})
        self.assertAlmostEqual(found["after"]["pressure_gain_kPa_per_V"], 100 / 1.05, places=4)
        self.assertAlmostEqual(found["after"]["pressure_offset_kPa"], 3 / 1.05, places=4)
        again = self.json_of("calibrate", "--store", "board", *options, "--keep")
        self.assertEqual(again["before"], found["before"], "not kept the first time")
        kept = self.json_of("calibrate", "--store", "board", "--chamber", 2, "--offset", 0)
        self.assertEqual(kept["before"], found["after"])
        self.assertIn("the board has stored its settings (1010h)", self.done("calibrate", "--store", "board", "--offset", 0, "--keep"))
        ran = self.plenum("calibrate", "--store", "board", "--gain-error", 0.3)
        self.assertEqual((ran.returncode, ran.stdout), (1, ""))
        self.assertRegex(ran.stderr, "chamber 1: over_pressure_kPa = 910, expected 700 to 7[0-9.]+ with the other settings")
        self.refused(2, "calibrate", "--store", "board", "--offset", 101, says=["--offset", "100"])
        self.done("calibrate", "--store", "order", "--chamber", 1, "--offset", -20, "--gain-error", 0.1)  # each alone is refused, or not
        self.refused(2, "calibrate", "--offset", 1, says=["--store"])
        self.refused(2, "calibrate", "--store", "board", "--keep", says=["nothing to correct", "--offset", "--gain-error"])

    def test_a_simulated_board_stays_of_the_rig_that_its_store_keeps(self):
        self.write("m.json", model(1))
        self.done("upload", "--store", "board", "--plant", "thin-plate", "--chambers", 1, "--effect", "spool_lag=10", "m.json")
        self.write("soft.toml", "[sampling]\nrate_Hz = 100\n[supply]\npressure_Pa = 500000\n")
        for option, of_store in [("--plant mpye", "thin-plate"), ("--chambers 8", "1"), ("--volume-swing 0.5", "0.2"), ("--no-spool", "--spool"),
                                 ("--effect spool_lag=9", '["spool_lag=10"]'), ("--rig soft.toml", "other figures")]:
            self.refused(2, "calibrate", "--store", "board", "--offset", 1, "--keep", *option.split(),
                         says=[option.split()[0], option.split()[-1], f"board in board has {of_store} (rig.json)", "another --store"])
        self.done("calibrate", "--store", "board", "--offset", 1, "--keep")
        self.assertEqual(len(self.json_of("regulate", "--store", "board", "--seed", 2, "--seconds", 1)["chambers"]), 1)
        self.assertEqual(self.json_of("faults", "--store", "board", "--plant", "thin-plate", "--chambers", 1)["fault"], None)
        self.write("board/rig.json", "{}")
        self.refused(2, "faults", "--store", "board", says=["board/rig.json", "expected"])

    def test_models_of_another_schema_are_left_alone_only_when_asked(self):
        self.done("backup", "--store", "board", "-o", "b.json")
        content = json.loads((self.folder / "b.json").read_text())
        content["versions"]["schema_hash"] = "12345678h"
        self.write("old.json", json.dumps(content))
        self.refused(2, "restore", "--store", "board", "old.json", says=["old.json", "12345678h", "--settings-only"])
        self.done("restore", "--store", "board", "--settings-only", "old.json")


if __name__ == "__main__":
    run()
