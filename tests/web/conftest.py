"""Programs and browser for the tests of the live page.

Runs the real programs, built before (`cargo build -p pneudrive-host-cli -p pneudrive-sim`) into `target/debug` or the
folder that PNEUDRIVE_BIN names, and a headless Chromium: the one that CHROMIUM names, the system's, or Playwright's own.
"""

import os
import re
import shutil
import signal
import subprocess
import threading
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ.get("PNEUDRIVE_BIN", ROOT / "target" / "debug"))
# A shared machine can be slow: nothing here fails for being late by seconds.
PATIENCE_MS = 60_000


class Program:
    """A running program whose lines of one stream are kept."""

    def __init__(self, args, stream):
        other = "stdout" if stream == "stderr" else "stderr"
        pipes = {stream: subprocess.PIPE, other: subprocess.DEVNULL}
        self.process = subprocess.Popen([str(arg) for arg in args], stdin=subprocess.DEVNULL, text=True, **pipes)
        self.lines = []
        self._more = threading.Condition()
        self._reader = threading.Thread(target=self._read, args=(getattr(self.process, stream),), daemon=True)
        self._reader.start()

    def _read(self, stream):
        for line in stream:
            with self._more:
                self.lines.append(line.rstrip("\n"))
                self._more.notify_all()

    def line(self, pattern):
        """The first line that matches, as a match."""
        find = lambda: next((m for line in self.lines if (m := re.search(pattern, line))), None)
        with self._more:
            assert self._more.wait_for(find, PATIENCE_MS / 1000), f"no line {pattern!r} in {self.lines}"
            return find()

    def kill(self):
        self.process.kill()
        self.process.wait()

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
            try:
                self.process.wait(30)
            except subprocess.TimeoutExpired:
                self.kill()
        self._reader.join(10)


class Run:
    """Virtual boards, a host that polls them, and the address of its page."""

    def __init__(self, devices, args, sim_args=()):
        self.sim = Program([BIN / "pneudrive-sim", "--devices", devices, *sim_args], "stdout")
        self.port = self.sim.line(r"^(/\S+)$").group(1)
        # Answers may take long on a busy machine; that is no loss here.
        host = [BIN / "pneudrive-host", "--port", self.port, "--devices", devices, "--allowance-us", 300_000, "--plain"]
        self.host = Program([*host, "--wait", 60, "--web", "127.0.0.1:0", *args], "stderr")
        found = self.host.line(r"live page: (http://127\.0\.0\.1:\d+/)(?:#token=(\w+))?")
        self.url, self.token = found.groups()

    def stop(self):
        self.host.stop()
        self.sim.stop()


@pytest.fixture
def start():
    """Starts a run: `start(devices, *host_arguments, sim_args=())`."""
    runs = []

    def begin(devices, *args, sim_args=()):
        runs.append(Run(devices, args, sim_args))
        return runs[-1]

    yield begin
    for run in runs:
        run.stop()
        # Shown beside a test that fails: what the host has said tells a pause of the machine from a
        # defect.
        print(*run.host.lines, sep="\n")


@pytest.fixture(scope="session")
def browser():
    found = (shutil.which(name) for name in ("chromium", "chromium-browser", "google-chrome"))
    path = os.environ.get("CHROMIUM") or next(filter(None, found), None)
    with sync_playwright() as playwright:
        # Containers have neither a sandbox for the browser nor room in /dev/shm.
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-dev-shm-usage"])
        yield browser
        browser.close()


@pytest.fixture
def visit(browser):
    """Opens a page in a browser of its own (no shared storage). Errors in the page's script fail the test."""
    contexts, errors = [], []

    def open_page(url, **options):
        context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **options})
        context.set_default_timeout(PATIENCE_MS)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(url)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert errors == []
