"""Makes the pictures of the README from real runs.

    python -m pip install playwright pillow
    cargo build --release -p pneudrive-host-cli -p pneudrive-model-cli --bins
    python docs/pictures/make.py live                     # docs/pictures/live.webp: the live page of four virtual boards
    python docs/pictures/make.py report REPORT.html OUT   # a page as a picture

The programs are those of target/release, or of the folder that PNEUDRIVE_BIN names; the browser is the system's chromium.
"""

import argparse
import io
import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

HERE = Path(__file__).parent
BIN = Path(os.environ.get("PNEUDRIVE_BIN", HERE.parents[1] / "target" / "release"))
#: One picture takes this long to show, s, and there are so many.
FRAME_S, FRAMES = 0.5, 24
WIDTH = 900


def shown(browser, url, width, height):
    page = browser.new_page(viewport={"width": width, "height": height}, color_scheme="light")
    page.goto(url)
    return page


def live(browser):
    """Four virtual boards that follow a trajectory of steps, as a moving picture."""
    host = BIN / "pneudrive-host"
    with tempfile.TemporaryDirectory(prefix="pneudrive-") as folder:
        trajectory = Path(folder) / "steps.csv"
        plan = ["--low", 40, "--high", 250, "--seconds", 120, "--hold", 4]
        subprocess.run([host, "generate", "aprbs", trajectory, "--devices", "4", *map(str, plan)], check=True)
        # A browser that draws takes two cores for a while: at this rate nothing is lost meanwhile.
        run = [host.resolve(), "--port", "sim", "--devices", "4", "--rate", "250", "--allowance-us", "20000"]
        run += ["--plain", "--trajectory", trajectory, "--web", "127.0.0.1:0"]
        null = subprocess.DEVNULL
        polling = subprocess.Popen(run, cwd=folder, stdin=null, stdout=null, stderr=subprocess.PIPE, text=True)
        try:
            url = next(found.group(1) for line in polling.stderr if (found := re.search(r"live page: (http\S+)", line)))
            page = shown(browser, url, 1280, 800)
            page.wait_for_timeout(40_000)  # lines need some length
            frames = []
            due = time.monotonic()
            for _ in range(FRAMES):
                frames.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
                due += FRAME_S
                page.wait_for_timeout(max(0.0, 1e3 * (due - time.monotonic())))
        finally:
            polling.terminate()
            polling.stderr.close()
            polling.wait()
    frames = [frame.resize((WIDTH, WIDTH * 800 // 1280), Image.Resampling.LANCZOS) for frame in frames]
    out = HERE / "live.webp"
    frames[0].save(out, save_all=True, append_images=frames[1:], duration=int(1e3 * FRAME_S), loop=0, quality=60, method=6)
    print(f"{out}: {out.stat().st_size} bytes")


def report(browser, page, out):
    shown(browser, Path(page).resolve().as_uri(), 1100, 1230).screenshot(path=out)


def main():
    parser = argparse.ArgumentParser(description="Pictures of the README from real runs.")
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("live", help="the live page of four virtual boards, moving")
    picture = commands.add_parser("report", help="a page of a diagnosis")
    picture.add_argument("page", help="report.html")
    picture.add_argument("out", help="the picture, .png")
    chosen = parser.parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"))
        if chosen.command == "live":
            live(browser)
        else:
            report(browser, chosen.page, chosen.out)
        browser.close()


if __name__ == "__main__":
    main()
