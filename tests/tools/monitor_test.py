"""`plenum monitor` as its user runs it: lines, datagrams, the page in a browser.

The board is a simulated one, which lives in real time here; nothing leaves the loopback interface."""

import contextlib
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
import termios
import threading
import unittest

from browser import Browser
from command import PROGRAM, SMALL, CommandTest, run
from screenshot import Screenshot


class MonitorCommand(CommandTest):
    def start(self, *arguments, **options):
        running = subprocess.Popen([PROGRAM, "monitor", *SMALL, *map(str, arguments)], cwd=self.folder,
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

    def test_where_no_pressure_comes_it_says_what_lets_them_come(self):
        self.serve("--chambers", 1)
        remedy = "; no pressures: they come with SYNC, or by --stream"
        self.assertIn(remedy, self.plenum("monitor", *self.bus, "--seconds", 0.1).stdout)
        self.assertNotIn(remedy, self.plenum("monitor", *self.bus, "--seconds", 0.1, "--chambers", 1, "--stream").stdout)

    def drawn(self, columns):
        """What it writes to a terminal of so many columns; 0: one that does not know."""
        leader, follower = pty.openpty()
        fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        ran = subprocess.run([PROGRAM, "monitor", *SMALL, "--seconds", "0.3"], stdout=follower, timeout=60)
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


def address(port):
    return f"http://127.0.0.1:{port}/"


@unittest.skipUnless(shutil.which("chromium"), "no chromium on the PATH, so no page was drawn; to enable: apt-get install chromium")
class MonitorPage(MonitorCommand):
    GRID = (64, 44, 20, 36)  # of a chart, which its curves are drawn within: left, top, right, bottom [px]
    CHART_px = 300

    def browse(self, port):
        browser = self.enterContext(Browser(self.folder))
        browser.open(address(port))
        return browser

    def plots(self, painted, page):
        """Where the curves of each chart may be, as (left, top, right, bottom): the charts are found by their borders."""
        border = tuple(bytes.fromhex(self.colour(page, "line").removeprefix("#")))
        middle = painted.width // 2
        lines = [row for row in range(painted.height) if all(painted.pixel(middle + x, row) == border for x in (-200, -99, 0, 101, 200))]
        ends = [(row, row + self.CHART_px - 1) for row in lines if row + self.CHART_px - 1 in lines]
        if not ends:
            return []
        left, top, right, bottom = self.GRID
        side = next(column for column in range(middle) if painted.pixel(column, ends[0][0] + self.CHART_px // 2) == border)
        width = 2  # of a curve, half of which is beyond the grid where its value is at an end of the axis
        return [(side + 1 + left, first + 1 + top - width, painted.width - side - 1 - right, last - bottom + width) for first, last in ends]

    def colour(self, page, name):
        """A colour of the page's light theme."""
        return re.search(rf"--{name}: (#[0-9a-f]{{6}})", page)[1]

    def serve_views(self, page, streams):
        """A server of the page in which each stream of views ends as if its monitor had; then there is none. Returns its port."""
        class Monitors(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                status, kind, body = 200, "text/html", page.encode()
                if self.path == "/events":
                    status, kind = 200 if streams else 204, "text/event-stream"
                    events = [f"data: {json.dumps(view)}\n\n" for view in streams.pop(0)] if streams else []
                    body = "".join(["retry: 10\n", *events]).encode() if events else b""
                self.send_response(status)
                self.send_header("Content-Type", kind)
                self.end_headers()
                with contextlib.suppress(ConnectionError):  # the browser went on to another page
                    self.wfile.write(body)

            def log_message(self, *_):
                pass

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Monitors)
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        return server.server_port

    def view(self, time_s, node, *chambers):
        silent = {"nmt": None, "state": None, "fault": None, "silent_s": None, "frames": 0}
        nothing = {"setpoint_kPa": None, "actual_kPa": None, "command_V": None, "volume_mL": None}
        return {"timestamp": time_s, f"node{node}": silent | {f"chamber{c + 1}": nothing | one for c, one in enumerate(chambers)}}

    def page(self):
        _, port = self.start_page()
        return self.ask(port, "/").read().decode()

    def test_a_page_that_stays_open_shows_what_a_new_monitor_watches(self):
        full = {"actual_kPa": 200}
        streams = [[self.view(90, 1, full, full), self.view(91, 1, full, full)], [self.view(1, 5, full)]]
        browser = self.browse(self.serve_views(self.page(), streams))
        browser.wait("document.title === 'Plenum node 5'")
        self.assertEqual(streams, [])
        self.assertEqual(browser.ask("document.documentElement.dataset.events"), "1")
        self.assertEqual(browser.problems, [])

    def test_curves_are_painted_where_their_values_belong_and_move_as_time_goes_on(self):
        # Chamber 2 steps up after 10 s: its edge is at half the width after 20 s, and at a quarter after 40 s.
        page, browser = self.page(), self.enterContext(Browser(self.folder))
        for seconds in [20, 40]:
            views = [self.view(0.1 * k, 1, {"actual_kPa": 150, "command_V": 4}, {"actual_kPa": 200 if k < 100 else 300}, {"setpoint_kPa": 250})
                     for k in range(10 * seconds + 1)]
            browser.open(address(self.serve_views(page, [views])))
            browser.wait(f"document.documentElement.dataset.events === '{len(views)}'")
            picture = Screenshot(browser.picture())
            pressure, command, volume = self.plots(picture, page)
            left, _, right, _ = pressure
            flat, step, dashed = (picture.curve(self.colour(page, name), pressure) for name in ["c0", "c1", "c2"])
            for whole in [flat, step, picture.curve(self.colour(page, "c0"), command)]:
                self.assertGreater(len(whole), 0.98 * (right - left), "from the first second to the last")
            self.assertTrue(0.3 * (right - left) < len(dashed) < 0.9 * (right - left), len(dashed))
            for level in [flat, dashed]:
                self.assertLess(max(level.values()) - min(level.values()), 1)
            low, high, line, constant = step[left + 5], step[right - 5], next(iter(dashed.values())), flat[left + 5]  # rows count down
            self.assertAlmostEqual((constant - low) / (low - high), (200 - 150) / (300 - 200), delta=0.02)
            self.assertAlmostEqual((low - line) / (low - high), (250 - 200) / (300 - 200), delta=0.02)
            edge = min(column for column, row in step.items() if row < (low + high) / 2)
            self.assertAlmostEqual((edge - left) / (right - left), 9.95 / seconds, delta=3 / (right - left))
            for name in ["c0", "c1", "c2"]:
                self.assertEqual(picture.painted(self.colour(page, name), volume), {}, "nobody told a volume")

    def test_a_browser_draws_the_live_charts(self):
        running, port = self.start_page("--stream", "--rate", 20)
        page = self.ask(port, "/").read().decode()
        browser = self.browse(port)
        browser.wait("document.documentElement.dataset.events >= 60")
        said = browser.ask("Object.fromEntries(['state', 'fault', 'link'].map((id) => [id, document.getElementById(id).textContent]))")
        self.assertEqual(said, {"state": "ACTIVE · operational", "fault": "no fault", "link": "live"})
        picture = Screenshot(browser.picture())
        plots = self.plots(picture, page)
        self.assertEqual(len(plots), 3)
        for plot in plots:
            for name in ["c0", "c1"]:
                drawn = picture.painted(self.colour(page, name), plot)
                self.assertGreater(len(drawn), 0.9 * (plot[2] - plot[0]), f"the curve of {name} in {plot}")
        running.send_signal(signal.SIGINT)
        browser.wait("document.getElementById('link').textContent === 'the monitor does not answer'")
        self.assertEqual(browser.problems, [])


if __name__ == "__main__":
    run()
