"""Headless Chromium by the DevTools protocol: what the test of reports and tools/bench drive it with."""
import base64
import fcntl
import json
import os
import select
import shutil
import signal
import subprocess
import time


SILENCE = 300  # seconds without an answer, on a machine that is busy, too


def chromium():
    """The program; None: it is not there."""
    return next((p for p in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if p), None)


class Browser:
    """Chromium at the other ends of two pipes: messages are JSON, each ended by a zero byte."""

    def __init__(self, program, profile, shots=None):
        self.shots = shots
        to_read, self.write = os.pipe()
        self.read, to_write = os.pipe()

        def take():  # its numbers for the pipes are 3 and 4, whatever numbers they and other files have here
            ends = [fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, 10) for fd in (to_read, to_write)]
            for end, place in zip(ends, (3, 4)):
                os.dup2(end, place)

        self.process = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--no-first-run", "--disable-dev-shm-usage", "--remote-debugging-pipe", "--use-gl=angle",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--hide-scrollbars", "--window-size=1200,900", f"--user-data-dir={profile}", "about:blank"],
            preexec_fn=take, close_fds=False, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read), os.close(to_write)
        self.number, self.kept, self.session, self.errors = 0, b"", None, []
        target = next(t for t in self("Target.getTargets")["targetInfos"] if t["type"] == "page")
        self.session = self("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self(f"{domain}.enable")
        self("Emulation.setDeviceMetricsOverride", width=1200, height=900, deviceScaleFactor=1, mobile=False)

    def __call__(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.message()
            if answer.get("id") == self.number:
                assert "error" not in answer, answer
                return answer["result"]
            self.note(answer)

    def message(self):
        while b"\0" not in self.kept:
            assert select.select([self.read], [], [], SILENCE)[0], f"the browser says nothing for {SILENCE} s"
            more = os.read(self.read, 1 << 20)
            assert more, "the browser ended"
            self.kept += more
        one, self.kept = self.kept.split(b"\0", 1)
        return json.loads(one)

    def note(self, event):
        if event.get("method") == "Runtime.exceptionThrown":
            self.errors.append(event["params"]["exceptionDetails"].get("exception", {}).get("description"))
        if event.get("method") == "Log.entryAdded" and event["params"]["entry"]["level"] == "error":
            self.errors.append(event["params"]["entry"]["text"])
        if event.get("method") == "Network.requestWillBeSent":
            address = event["params"]["request"]["url"]
            if not address.startswith(("file:", "data:", "blob:", "about:")):
                self.errors.append(f"asks the network for {address}")

    def run(self, code):
        answer = self("Runtime.evaluate", expression=code, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def wait(self, code, seconds=120):
        end = time.monotonic() + seconds
        while not self.run(code):
            assert time.monotonic() < end, f"waited for {code}"
            time.sleep(0.05)

    def key(self, key):
        text = {"text": "\r", "windowsVirtualKeyCode": 13} if key == "Enter" else {"text": key} if len(key) == 1 else {}
        self("Input.dispatchKeyEvent", type="keyDown", key=key, **text)
        self("Input.dispatchKeyEvent", type="keyUp", key=key)

    def mouse(self, kind, x, y, **more):
        self("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def set(self, name, value):
        """As a user would: a new value, and the events of it."""
        self.run(f"""(async () => {{ const e = document.getElementById({json.dumps(name)});
            if (e.type === "checkbox") e.checked = {json.dumps(value)}; else e.value = {json.dumps(str(value))};
            e.dispatchEvent(new Event("input", {{ bubbles: true }})); e.dispatchEvent(new Event("change", {{ bubbles: true }}));
            await document.body.viewer.update(); }})()""")

    def look(self):
        """The canvas in 48 x 32 pixels."""
        return self.run("""(() => { const small = document.createElement("canvas"); small.width = 48; small.height = 32;
            const c = small.getContext("2d"); c.imageSmoothingQuality = "high"; c.drawImage(document.body.viewer.canvas, 0, 0, 48, 32);
            return Array.from(c.getImageData(0, 0, 48, 32).data).filter((_, i) => i % 4 < 3); })()""")

    def shot(self, name, whole=False):
        if self.shots is None:
            return
        parts = {"captureBeyondViewport": True} if whole else {}
        if whole:
            size = self("Page.getLayoutMetrics")["cssContentSize"]
            parts["clip"] = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        self.shots.mkdir(parents=True, exist_ok=True)
        (self.shots / f"{name}.png").write_bytes(base64.b64decode(self("Page.captureScreenshot", **parts)["data"]))

    def close(self):
        """Its processes have ended then, and write no more into the profile."""
        try:
            self("Browser.close") if self.process.poll() is None else None
            self.process.wait(30)
        finally:
            end = time.monotonic() + 10
            while self.lives():
                self.lives(signal.SIGKILL if time.monotonic() > end else 0)
                time.sleep(0.02)
            os.close(self.read), os.close(self.write)

    def lives(self, send=0):
        self.process.poll()
        try:
            os.killpg(self.process.pid, send)
        except ProcessLookupError:
            return False
        return True
