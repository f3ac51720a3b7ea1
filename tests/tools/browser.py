"""Chromium without a display, driven by the Chrome DevTools Protocol over two pipes."""

import base64
import json
import os
import signal
import subprocess
import threading

DEADLINE_S = 300  # a lid on a browser that hangs


class Browser:
    """with Browser(folder) as browser: browser.open(address); browser.ask("document.title")"""

    def __init__(self, folder, width=800, height=1080):
        """`folder`: for its profile. width, height [pixels]: of the page."""
        to_it, ours = os.pipe()
        theirs, from_it = os.pipe()
        flags = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
                 "--disable-component-update", "--disable-sync", "--hide-scrollbars", f"--user-data-dir={folder / 'profile'}", "--remote-debugging-pipe", "about:blank"]
        self.process = subprocess.Popen(
            ["bash", "-c", 'exec 3<&"$1" 4>&"$2"; shift 2; exec chromium "$@"', "bash", str(to_it), str(from_it), *flags],
            pass_fds=(to_it, from_it), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(to_it)
        os.close(from_it)
        self.requests, self.answers = open(ours, "wb"), open(theirs, "rb")
        self.size = {"width": width, "height": height}
        self.number, self.rest, self.session = 0, b"", None
        self.problems = []  # what the page complained of
        self.lid = threading.Timer(DEADLINE_S, self.end)
        self.lid.start()

    def __enter__(self):
        page, = [one for one in self.call("Target.getTargets")["targetInfos"] if one["type"] == "page"]
        self.session = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        for domain in ["Page", "Runtime"]:
            self.call(f"{domain}.enable")
        self.call("Emulation.setDeviceMetricsOverride", **self.size, deviceScaleFactor=1, mobile=False)
        return self

    def __exit__(self, *_):
        self.lid.cancel()
        self.end()
        self.process.stdout.read()  # ends with the last of its processes: until then one may write to the profile
        self.process.stdout.close()
        self.process.wait()
        self.requests.close()
        self.answers.close()

    def end(self):
        os.killpg(self.process.pid, signal.SIGKILL)

    def take(self):
        """The next message, which ends in a zero byte."""
        while b"\0" not in self.rest:
            more = self.answers.read1(1 << 16)
            if not more:
                raise AssertionError("the browser has gone")
            self.rest += more
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **parameters):
        self.number += 1
        request = {"id": self.number, "method": method, "params": parameters} | ({"sessionId": self.session} if self.session else {})
        self.requests.write(json.dumps(request).encode() + b"\0")
        self.requests.flush()
        while True:
            message = self.take()
            if message.get("method") == "Runtime.exceptionThrown":
                self.problems.append(message["params"]["exceptionDetails"])
            if message.get("id") == self.number:
                if "error" in message:
                    raise AssertionError(f"{method}: {message['error']}")
                return message["result"]

    def open(self, address):
        self.call("Page.navigate", url=address)

    def ask(self, expression):
        """The value of a JavaScript expression; of a promise once it is kept."""
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            raise AssertionError(f"{expression}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def wait(self, condition):
        """Until a JavaScript expression is true of the page, which is asked at each frame that it paints, and painted then."""
        self.ask(f"""new Promise((done) => {{
            const look = () => requestAnimationFrame(() => {condition} ? requestAnimationFrame(done) : look());
            look();
        }})""")

    def picture(self):
        """What is painted, as the bytes of a PNG file."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
