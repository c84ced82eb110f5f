"""The live page as its users meet it: real programs, real browser, virtual boards in a process of their own."""

import http.server
import os
import re
import signal
import threading
from pathlib import Path

import pytest
from conftest import PATIENCE_MS
from playwright.sync_api import expect

expect.set_options(timeout=PATIENCE_MS)

PHONE = {"viewport": {"width": 375, "height": 740}, "device_scale_factor": 2, "is_mobile": True, "has_touch": True}
SCREENSHOTS = os.environ.get("PNEUDRIVE_SCREENSHOTS")


def pressure(page, chamber):
    """Waits for nothing: the number shown, or NaN."""
    text = page.locator(f"[data-chamber='{chamber}'] .pressure").inner_text()
    try:
        return float(text.split()[0])
    except ValueError:
        return float("nan")


def until_pressure(page, chamber, condition):
    script = f"""() => {{
        const kpa = parseFloat(document.querySelector("[data-chamber='{chamber}'] .pressure")?.textContent);
        return {condition};
    }}"""
    page.wait_for_function(script)


def picture(page, name):
    if SCREENSHOTS:
        page.screenshot(path=Path(SCREENSHOTS) / f"{name}.png")


def test_numbers_move(start, visit):
    run = start(1, "--command", "100,50,100,150")
    page = visit(run.url)
    until_pressure(page, "0.0", "kpa > 90")
    until_pressure(page, "0.1", "kpa > 40 && kpa < 60")
    expect(page.locator("[data-chamber='0.3'] .set")).to_have_text("command 150.3")  # as sent: a whole count
    expect(page.locator("[data-board='0'] .pill")).to_have_text("present")
    expect(page.locator("#link")).to_have_text("live")
    page.wait_for_function("() => parseFloat(document.getElementById('hz').textContent) > 1")
    before = page.locator("#time").inner_text()
    expect(page.locator("#time")).not_to_have_text(before)
    # Both lines are drawn: the chart has pixels of their colours.
    colours = page.evaluate("""() => {
        const canvas = document.querySelector("[data-chamber='0.3'] canvas");
        const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        const wanted = colours(), found = { measured: 0, command: 0 };
        for (const name of Object.keys(found)) {
            const [r, g, b] = wanted[name].match(/[0-9a-f]{2}/gi).map((hex) => parseInt(hex, 16));
            for (let i = 0; i < data.length; i += 4) {
                const near = Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 60;
                if (near && data[i + 3] > 100) found[name]++;
            }
        }
        return found;
    }""")
    assert colours["measured"] > 20 and colours["command"] > 20, colours


WATCH = """#!/bin/sh
say() { echo '{"schema":"pneudrive-watch/1","text":"'"$1"'",'"$2"'}'; }
say "it begins" '"kind":"begin","channels":["b0c0","b0c1"]'
read -r first_row
while [ ! -e LEARNT ]; do sleep 0.1; done
say "learnt" '"kind":"learnt","channel":"b0c0"'
say "learnt" '"kind":"learnt","channel":"b0c1"'
while [ ! -e CHANGED ]; do sleep 0.1; done
say "channel b0c1 has changed" '"kind":"changed","channel":"b0c1","t_s":700,"since_s":641.2,"explanations":[{"effect":"exhaust_leak","probability":0.83}]'
cat > /dev/null
"""


@pytest.mark.parametrize("size", ["1280x800", "375x740"])
def test_sensors_and_the_watch_stand_in_the_head(start, visit, tmp_path, size):
    """What boards measure beside their chambers, and what a watch says: here a program that says what its real one would."""
    program, learnt, changed = tmp_path / "watch", tmp_path / "learnt", tmp_path / "changed"
    program.write_text(WATCH.replace("LEARNT", str(learnt)).replace("CHANGED", str(changed)))
    program.chmod(0o755)
    parameters = tmp_path / "rig.fit.toml"
    parameters.touch()
    watch = ["--watch", parameters, "--watch-program", program]
    run = start(1, "--command", "100", "--sensors", 0.5, *watch, sim_args=["--supply-sensor", "all"])
    width, height = map(int, size.split("x"))
    page = visit(run.url, viewport={"width": width, "height": height})
    sensors, watched = page.locator("[data-board='0'] .sensors"), page.locator("#watch")
    expect(sensors).to_have_text(re.compile(r"^supply 5\d\d\.\d kPa, chip \d\d \u00b0C$"))
    expect(watched).to_have_text("watch learns (0 of 2)")
    learnt.touch()
    expect(watched).to_have_text("watched")
    expect(watched).not_to_have_class("bad")
    changed.touch()
    expect(watched).to_have_text("b0c1 CHANGED since 641 s: exhaust_leak 83 %")
    expect(watched).to_have_class("bad")
    expect(page.locator("#log li", has_text="channel b0c1 has changed")).to_have_count(1)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    picture(page, f"watch-{size}")


def test_nothing_is_said_of_sensors_and_a_watch_that_are_not_there(start, visit):
    run = start(1, "--command", "100")
    page = visit(run.url)
    until_pressure(page, "0.0", "kpa > 90")
    expect(page.locator("#watch")).to_be_hidden()
    expect(page.locator("[data-board='0'] .sensors")).to_have_text("")


def test_who_comes_later_sees_the_last_minute(start, visit):
    run = start(1, "--command", "100")
    first = visit(run.url)
    first.wait_for_function("() => page.picture?.t > 4")
    second = visit(run.url)
    second.wait_for_function("() => page.picture !== null")
    oldest, newest = second.evaluate("() => [page.history.times[0], page.picture.t]")
    assert newest - oldest > 3, (oldest, newest)


def test_vent_vents_and_every_client_sees_it(start, visit):
    run = start(2, "--command", "100")
    one, two = visit(run.url), visit(run.url, **PHONE)
    for page in (one, two):
        until_pressure(page, "1.3", "kpa > 80")
    # No token was given to anybody.
    two.locator("#vent").tap()
    for page in (one, two):
        expect(page.locator("#banner")).to_contain_text(
            "VENTED: 0 kPa is commanded to all boards until they are released. This page cannot release them"
        )
        expect(page.locator("#vent")).to_have_text("VENTED")
        expect(page.locator("#link")).to_have_text("VENTED")
        expect(page).to_have_title("VENTED - PneuDrive " + run.port)
        for chamber in ("0.0", "1.3"):
            until_pressure(page, chamber, "kpa < 8")
            expect(page.locator(f"[data-chamber='{chamber}'] .set")).to_have_text("command 0.0")
        expect(page.locator("#release")).to_be_hidden()
    assert run.host.line("all boards vented from the web page")
    # It holds, also for a page that is loaded again.
    one.reload()
    expect(one.locator("#vent")).to_have_text("VENTED")


def test_vent_beats_a_trajectory(start, visit, tmp_path):
    steps = tmp_path / "steps.csv"
    steps.write_text("t_s,b0_cmd0_kpa\n" + "".join(f"{second},{100 + second % 2}\n" for second in range(600)))
    run = start(1, "--trajectory", steps, "--allow-control")
    page = visit(f"{run.url}#token={run.token}")
    until_pressure(page, "0.0", "kpa > 80")
    arm, number = page.locator("[data-board='0'] .arm"), page.locator("[data-chamber='0.0'] .number input")
    expect(page.locator("#commanding")).to_have_text("trajectory")
    expect(arm).to_be_disabled()
    expect(number).to_be_disabled()
    page.locator("#vent").click()
    until_pressure(page, "0.0", "kpa < 8")
    page.locator("#release").click()
    # What the trajectory would command now does not come back.
    expect(page.locator("#commanding")).to_have_text("by hand")
    arm.click()
    expect(number).to_be_enabled()
    expect(page.locator("[data-chamber='0.0'] .set")).to_have_text("command 0.0")


def test_set_points_with_the_token(start, visit):
    run = start(1, "--allow-control", "--control-limit", "120")
    page = visit(f"{run.url}#token={run.token}")
    arm, number = page.locator("[data-board='0'] .arm"), page.locator("[data-chamber='0.2'] .number input")
    expect(number).to_be_disabled()
    arm.click()
    expect(number).to_be_enabled()
    assert "token" not in page.url
    number.fill("120.1")
    number.press("Enter")
    expect(page.locator("#log")).to_contain_text("a set point is a number from 0 to 120 kPa")
    number.fill("90")
    number.press("Enter")
    until_pressure(page, "0.2", "kpa > 75")
    assert not pressure(page, "0.1") > 20, "the other chambers stay"
    page.locator("#vent").click()
    until_pressure(page, "0.2", "kpa < 8")
    expect(arm).to_be_disabled()
    expect(number).to_be_disabled()
    page.locator("#release").click()
    # Released boards are as unarmed as those of a new page.
    expect(arm).to_be_enabled()
    expect(number).to_be_disabled()
    arm.click()
    expect(number).to_be_enabled()
    expect(page.locator("[data-chamber='0.2'] .set")).to_have_text("command 0.0")
    picture(page, "control-desktop")


def test_a_slider_says_what_its_end_is_and_when_the_set_point_is_beyond(start, visit):
    run = start(1, "--allow-control", "--command", "290,100,100,100")
    for size in ({}, PHONE):
        page = visit(f"{run.url}#token={run.token}", **size)
        until_pressure(page, "0.0", "kpa > 280")
        beyond = page.locator("[data-chamber='0.0'] .reading")
        expect(beyond).to_have_text("290 of 200 kPa")
        expect(beyond).to_have_class("reading beyond")
        within = page.locator("[data-chamber='0.1'] .reading")
        expect(within).to_have_text("99.8 of 200 kPa")  # as sent: a whole count
        expect(within).to_have_class("reading")
        expect(page.locator("[data-chamber='0.1'] .off")).to_have_attribute("title", "measured minus commanded pressure")
        picture(page, f"slider-{page.viewport_size['width']}")


def test_losses_are_marked_from_a_share_on_that_the_title_says(start, visit):
    page = visit(start(1).url)
    page.wait_for_function("() => page.picture !== null")
    for lost, kind in ((59, "good"), (5000, "warn")):
        said = page.evaluate("""(lost) => {
            showFigures({ recording: null, statistics: { cycle_us: { p99: 1 }, loop_hz: { mean: 1 }, lost, exchanges: 17800, rejected: 0, cpu_share: 0, boards: [] } });
            return [at("lost").className, at("lost").title];
        }""", lost)
        assert said[0] == kind and "marked from 1 % on" in said[1], said


def test_a_wrong_token_is_refused(start, visit):
    run = start(1, "--allow-control")
    wrong = visit(f"{run.url}#token={'0' * 32}")
    expect(wrong.locator("#log")).to_contain_text("that is not the token")
    expect(wrong.locator("#token-form")).to_be_visible()
    expect(wrong.locator("[data-chamber='0.0'] .setter")).to_be_hidden()
    refused = wrong.evaluate("""async (token) => {
        const headers = { "Content-Type": "application/json", Authorization: "Bearer " + token };
        const body = JSON.stringify({ board: 0, channel: 0, kpa: 50 });
        return (await fetch("/api/set", { method: "POST", headers, body })).status;
    }""", run.token[:-1])
    assert refused == 403
    expect(wrong.locator("[data-chamber='0.0'] .set")).to_have_text("command 0.0")
    # The right one, typed in.
    wrong.locator("#token").fill(run.token)
    wrong.locator("#token-form button").click()
    expect(wrong.locator("[data-chamber='0.0'] .setter")).to_be_visible()


def test_a_foreign_page_can_do_nothing(start, visit, tmp_path):
    run = start(1, "--command", "100")
    (tmp_path / "index.html").write_text("<title>foreign</title>")
    handler = lambda *args: http.server.SimpleHTTPRequestHandler(*args, directory=tmp_path)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        foreign = visit(f"http://localhost:{server.server_port}/")
        reached = foreign.evaluate("""async (url) => {
            await fetch(url + "api/vent", { method: "POST", mode: "no-cors" });
            return fetch(url + "api/state").then(() => "read", () => "not readable");
        }""", run.url)
        server.shutdown()
    assert reached == "not readable"
    page = visit(run.url)
    expect(page.locator("#commanding")).to_have_text("by hand")
    until_pressure(page, "0.0", "kpa > 80")


def test_a_dead_bus_is_said(start, visit):
    run = start(2, "--command", "100")
    page = visit(run.url)
    until_pressure(page, "1.0", "kpa > 50")
    # Boards that say nothing: the port is still there.
    run.sim.process.send_signal(signal.SIGSTOP)
    expect(page.locator("#banner")).to_contain_text("The bus is dead: no board answers")
    expect(page.locator("#link")).to_have_text("bus dead")
    expect(page).to_have_title("BUS DEAD - PneuDrive " + run.port)
    expect(page.locator("[data-board='1'] .pill")).to_have_text("MISSING")
    expect(page.locator("[data-chamber='1.0'] .pressure")).to_have_text("---")
    picture(page, "dead-desktop")
    run.sim.process.send_signal(signal.SIGCONT)
    expect(page.locator("[data-board='1'] .pill")).to_have_text("present")
    expect(page.locator("#banner")).to_be_hidden()
    expect(page.locator("#log")).to_contain_text("board 1 answers again")
    # A port that is gone for good, as a pty is.
    run.sim.kill()
    expect(page.locator("#banner")).to_contain_text("The bus is dead: ")
    expect(page.locator("#banner")).to_contain_text("the port is gone")
    expect(page.locator("#link")).to_have_text("bus dead")


def test_a_dead_host_is_said(start, visit):
    run = start(1)
    page = visit(run.url)
    until_pressure(page, "0.0", "kpa < 20")
    run.host.kill()
    expect(page.locator("#banner")).to_contain_text("Nothing from the host for")
    expect(page.locator("#link")).to_have_text("no connection")
    page.locator("#vent").click()
    expect(page.locator("#banner")).to_contain_text("NOT VENTED, the host does not answer (try 7)")
    expect(page.locator("#link")).to_have_text("venting")


def record_by_button(page):
    """Records for some rows under the name take-1."""
    page.locator("#record-name").fill("take-1")
    page.locator("#record-button").click()
    expect(page.locator("#record-button")).to_have_text("Stop recording")
    page.wait_for_function("() => parseInt(document.getElementById('record-text').textContent.split(', ')[1]) > 2")
    page.locator("#record-button").click()
    expect(page.locator("#record-text")).to_contain_text("rows,")


def test_a_recording_by_button(start, visit, tmp_path):
    run = start(1, "--record-folder", tmp_path, "--record-format", "csv")
    page = visit(run.url)
    expect(page.locator("#record-text")).to_contain_text(str(tmp_path))
    record_by_button(page)
    [file] = tmp_path.glob("*-take-1.csv")
    rows = sum(not line.startswith("#") for line in file.read_text().splitlines()) - 1
    expect(page.locator("#record-text")).to_contain_text(f"{file.name}: {rows} rows")
    assert rows > 10


def test_a_bag_by_button(start, visit, tmp_path):
    run = start(1, "--record-folder", tmp_path, "--record-format", "mcap")
    page = visit(run.url)
    record_by_button(page)
    [bag] = tmp_path.iterdir()
    file = bag / f"{bag.name}.mcap"
    expect(page.locator("#record-text")).to_contain_text(f"{file.name}: ")
    assert bag.name.endswith("-take-1")
    assert file.read_bytes().startswith(b"\x89MCAP0\r\n") and file.read_bytes().endswith(b"\x89MCAP0\r\n")
    assert file.name in (bag / "metadata.yaml").read_text()


@pytest.mark.parametrize("size", ["desktop", "phone"])
@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_sixteen_chambers_fit(start, visit, size, scheme):
    """Nothing to scroll sideways, and the vent button always in reach of a thumb."""
    commands = [f"{board}:{40 + 20 * board},{60 + 20 * board},{80 + 20 * board},0" for board in range(4)]
    run = start(4, "--allow-control", *(part for command in commands for part in ("--command", command)))
    options = {**(PHONE if size == "phone" else {}), "color_scheme": scheme}
    foreign = []
    page = visit("about:blank", **options)
    page.on("request", lambda request: request.url.startswith(run.url) or foreign.append(request.url))
    page.goto(run.url)
    until_pressure(page, "3.2", "kpa > 120")
    page.wait_for_function("() => page.picture.t > 9")
    assert page.locator(".chamber canvas").count() == 16
    width, scrolled = page.evaluate("() => [document.documentElement.clientWidth, document.documentElement.scrollWidth]")
    assert scrolled <= width
    box, screen = page.locator("#vent").bounding_box(), page.viewport_size
    assert box["height"] >= 44 and box["y"] + box["height"] <= screen["height"] and box["x"] >= 0
    assert box["x"] + box["width"] <= screen["width"]
    assert foreign == []
    picture(page, f"sixteen-{size}-{scheme}")


RIG = """
[display]
unit = "psi"
[limits]
max_rate_kpa_s = 5
[boards.0]
name = "left shoulder"
[boards.0.channels.2]
name = "front left"
"""


@pytest.mark.parametrize("size", [(1280, 800), (844, 390)], ids=["desktop", "phone-held-sideways"])
def test_names_and_unit_of_the_rig_file_have_room(start, visit, tmp_path, size):
    """States, buttons and set points that are on their way are whole, and nothing covers anything else. A board's name gives way."""
    rig = tmp_path / "rig.toml"
    rig.write_text(RIG)
    # 100 kPa take 20 s: the command is on its way the whole time.
    run = start(4, "--allow-control", "--rig", rig, "--command", "100")
    page = visit(f"{run.url}#token={run.token}", viewport={"width": size[0], "height": size[1]})
    board = page.locator("[data-board='0']")
    expect(board.locator(".called")).to_have_text("left shoulder")
    expect(page.locator("[data-chamber='0.2'] .name")).to_have_text("front left")
    expect(page.locator("[data-chamber='0.2'] .pressure")).to_contain_text("psi")
    expect(page.locator("[data-chamber='0.2'] .set")).to_contain_text("\u2192 14.")
    board.locator(".arm").click()
    expect(board.locator(".arm")).to_contain_text("Disarm")
    cut = page.evaluate("""() => [...document.querySelectorAll("h2 .pill, .arm, .name, .set")]
        .filter((one) => one.offsetParent && one.scrollWidth > one.clientWidth + 1).map((one) => one.className + ": " + one.textContent)""")
    assert cut == []
    covered = page.evaluate("""() => [...document.querySelectorAll(".chamber")].filter((chamber) => {
        const right = Math.max(...[...chamber.querySelectorAll(".set, .set span")].map((one) => one.getBoundingClientRect().right));
        return right > chamber.querySelector("canvas").getBoundingClientRect().left + 1;
    }).map((chamber) => chamber.dataset.chamber)""")
    assert covered == []
    # The armed board's sliders and what the others read are on the screen together.
    fits = "() => document.documentElement.scrollHeight <= innerHeight"
    assert page.evaluate(fits)
    picture(page, f"names-{size[0]}")
    # And stay there beside what a banner says; it can come at any time.
    run.sim.process.send_signal(signal.SIGSTOP)
    expect(page.locator("#banner")).to_be_visible()
    assert page.evaluate(fits)
    picture(page, f"names-{size[0]}-banner")
    run.sim.process.send_signal(signal.SIGCONT)
