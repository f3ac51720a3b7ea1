"""`plenum monitor` as its user runs it: lines, datagrams, the page in a browser. Called with: the program, the top of the tree, a test case.

The board is a simulated one, which lives in real time here; nothing leaves the loopback interface."""

import fcntl
import http.client
import http.server
import json
import os
import pty
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import termios
import threading
import unittest

import plenum_test
from plenum_test import Plenum

SMALL = ["--chambers", "2"]


class MonitorCommand(Plenum):
    def start(self, *arguments, **options):
        running = subprocess.Popen([plenum_test.PROGRAM, "monitor", *SMALL, *map(str, arguments)], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)
        self.addCleanup(running.stdout.close)
        self.addCleanup(running.stderr.close)
        self.addCleanup(running.wait)
        self.addCleanup(running.kill)
        return running

    def start_page(self, *arguments):
        """The monitor, and the address of its page, which it says on standard error."""
        running = self.start("--web", 0, *arguments)
        found = re.search(r"http://127\.0\.0\.1:(\d+)/", running.stderr.readline())
        self.assertIsNotNone(found)
        return running, int(found[1])

    def ask(self, port, path, host=None):
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
        self.addCleanup(connection.close)
        connection.request("GET", path, headers={"Host": host} if host else {})
        return connection.getresponse()


class Monitor(MonitorCommand):
    def test_it_prints_a_line_a_time_where_there_is_no_terminal(self):
        lines = self.done("monitor", *SMALL, "--seconds", 1.6, "--rate", 5).splitlines()
        self.assertEqual(len(lines), 8)
        self.assertRegex(lines[-1], r"^ +1\.4\d s  node 1  operational  ACTIVE  no fault  \| 1: \d+\.\d of - kPa - V - mL  \| 2: ")

    def test_with_the_stream_it_shows_command_and_volume(self):
        last = self.done("monitor", *SMALL, "--seconds", 0.5, "--stream").splitlines()[-1]
        self.assertRegex(last, r"\| 1: \d+\.\d of - kPa \d+\.\d\d V \d+ mL")

    def drawn(self, columns):
        """What it writes to a terminal of so many columns; 0: one that does not know."""
        leader, follower = pty.openpty()
        fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        ran = subprocess.run([plenum_test.PROGRAM, "monitor", *SMALL, "--seconds", "0.3"], stdout=follower, timeout=60)
        os.close(follower)
        drawn = os.read(leader, 65536).decode()
        os.close(leader)
        self.assertEqual(ran.returncode, 0)
        return drawn

    def test_it_draws_over_itself_on_a_terminal(self):
        drawn = self.drawn(80)
        self.assertIn("\x1b[5F", drawn)
        self.assertIn("set point [kPa]", drawn)

    def test_a_line_is_no_longer_than_the_terminal_is_wide(self):
        for columns, widest in [(40, 40), (20, 20), (0, 64)]:
            lines = re.sub(r"\x1b\[\d*[FK]", "", self.drawn(columns)).split("\r\n")
            self.assertEqual(max(map(len, lines)), widest, lines)

    def test_ctrl_c_ends_it_with_its_result(self):
        running = self.start("--stream", "--json", "result.json")
        running.stdout.readline()
        running.send_signal(signal.SIGINT)
        running.communicate(timeout=30)
        self.assertEqual(running.returncode, 0)
        result = json.loads((self.folder / "result.json").read_text())
        self.assertGreater(result["frames"], 0)
        self.assertEqual(result["last"]["node1"]["state"], "ACTIVE")

    def test_datagrams_are_json_with_a_timestamp_and_nested_names(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taker:
            taker.bind(("127.0.0.1", 0))
            taker.settimeout(30)
            self.done("monitor", *SMALL, "--seconds", 0.5, "--rate", 20, "--stream", "--udp", f"127.0.0.1:{taker.getsockname()[1]}")
            views = [json.loads(taker.recv(65536)) for _ in range(10)]
        times = [view["timestamp"] for view in views]
        self.assertEqual(times, sorted(times))
        self.assertEqual(set(views[-1]["node1"]["chamber2"]), {"setpoint_kPa", "actual_kPa", "command_V", "volume_mL"})
        self.assertGreater(views[-1]["node1"]["chamber2"]["actual_kPa"], 50)

    def test_bad_usage_is_refused(self):
        self.refused(2, "monitor", "--udp", "9870", says=["--udp 9870", "HOST:PORT"])
        for port in ["0", "65536", "99999", "-1", "98x", "http"]:
            self.refused(2, "monitor", "--seconds", 0.1, "--udp", f"127.0.0.1:{port}", says=[f"'{port}'", "1 to 65535"])
        self.refused(2, "monitor", "--rate", "1000", says=["--rate", "1000"])
        self.refused(2, "monitor", "--web", "0", "--web-address", "localhost", says=["--web-address localhost", "IPv4"])
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            self.refused(3, "monitor", "--web", port, says=[str(port), "free port"])

    def test_the_page_is_one_file_and_only_for_this_machine(self):
        _, port = self.start_page()
        answer = self.ask(port, "/")
        page = answer.read().decode()
        self.assertEqual(answer.status, 200)
        for loads in ["<script src", "<link rel=\"stylesheet\"", "@import"]:
            self.assertNotIn(loads, page)
        self.assertEqual(self.ask(port, "/other").status, 404)
        for host in ["evil.example", f"evil.example:{port}", "127.0.0.1.evil.example", "localhost.evil.example"]:
            self.assertEqual(self.ask(port, "/", host=host).status, 403, host)
        self.assertEqual(self.ask(port, "/", host=f"localhost:{port}").status, 200)

    def test_events_are_views(self):
        _, port = self.start_page("--rate", 20)
        events = self.ask(port, "/events")
        self.assertEqual(events.getheader("Content-Type").split(";")[0], "text/event-stream")
        for _ in range(3):
            line = events.readline()
            self.assertTrue(line.startswith(b"data: "), line)
            self.assertIn("chamber1", json.loads(line[6:])["node1"])
            self.assertEqual(events.readline(), b"\n")


@unittest.skipUnless(shutil.which("chromium"), "no chromium on the PATH, so no page was drawn; to enable: apt-get install chromium")
class MonitorPage(MonitorCommand):
    def dump(self, port):
        """The page as a browser has it in the end, once no more events may come."""
        ran = subprocess.run(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
             "--disable-component-update", "--disable-sync", "--enable-logging=stderr", "--virtual-time-budget=3000", "--dump-dom",
             "--window-size=1200,1100", f"--user-data-dir={self.folder / 'profile'}", f"http://127.0.0.1:{port}/"],
            capture_output=True, text=True, timeout=90, stdin=subprocess.DEVNULL)
        self.assertNotIn("Uncaught", ran.stderr)
        return ran.stdout

    def test_a_page_that_stays_open_shows_what_a_new_monitor_watches(self):
        silent = {"nmt": None, "state": None, "fault": None, "silent_s": None, "frames": 0}
        values = {"setpoint_kPa": None, "actual_kPa": 200, "command_V": None, "volume_mL": None}
        views = [{"timestamp": 90, "node1": silent | {"chamber1": values, "chamber2": values}},
                 {"timestamp": 91, "node1": silent | {"chamber1": values, "chamber2": values}},
                 {"timestamp": 1, "node5": silent | {"chamber1": values}}]
        events = [f"data: {json.dumps(view)}\n\n".encode() for view in views]
        streams = [events[:2], events[2:]]
        _, port = self.start_page()
        page = self.ask(port, "/").read()

        class Monitors(http.server.BaseHTTPRequestHandler):
            """Each stream ends as if its monitor had; then there is none."""
            def do_GET(self):
                status, kind, body = 200, "text/html", page
                if self.path == "/events":
                    status, kind = 200 if streams else 204, "text/event-stream"
                    body = b"".join([b"retry: 10\n", *streams.pop(0)]) if streams else b""
                self.send_response(status)
                self.send_header("Content-Type", kind)
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_):
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Monitors) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            self.addCleanup(server.shutdown)
            shown = self.dump(server.server_port)
        self.assertEqual(streams, [])
        self.assertIn("<title>Plenum node 5</title>", shown)
        self.assertRegex(shown, r'data-events="1"')

    def test_a_browser_draws_the_live_charts(self):
        # The browser's virtual time stands still while events may come: it prints the page once the monitor has ended.
        _, port = self.start_page("--stream", "--rate", 20, "--seconds", 5)
        shown = self.dump(port)
        counted = re.search(r'<html[^>]* data-events="(\d+)"', shown)
        self.assertIsNotNone(counted, "no event reached the page")
        self.assertGreater(int(counted[1]), 10)
        self.assertRegex(shown, r'id="state">ACTIVE · operational<')
        self.assertRegex(shown, r'id="fault"[^>]*>no fault<')
        self.assertRegex(shown, r'id="link" class="lost">the monitor does not answer<')
        self.assertEqual(shown.count("<canvas"), 3)


if __name__ == "__main__":
    plenum_test.PROGRAM, plenum_test.TOP, case = sys.argv[1], sys.argv[2], sys.argv[3]
    unittest.main(argv=[sys.argv[0], case], verbosity=2)
