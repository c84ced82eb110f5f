// Puts together what the host sends and what the page shows.

const at = (id) => document.getElementById(id);
// Exchanges lost from this share on are marked; fewer cost a reading now and then, and healthy
// boards lose some on a busy machine.
const LOST_SHARE = 0.01;
// Who gives the set points, as people call it.
const COMMANDING = { "set points": "by hand", recording: "recorded" };
const page = { hello: null, boards: [], history: null, picture: null, heard: -Infinity, ended: null, ahead: Infinity, venting: null, hovered: null, recordingFailed: null };

// `time` is that of the run.
function log(text, time = page.picture ? duration(page.picture.t) : "") {
  const line = element("li", {}, time + "  " + text);
  at("log").prepend(line);
  while (at("log").children.length > 50) at("log").lastChild.remove();
}

function refused(error) {
  log(error.message);
  if (error.status === 401 || error.status === 403) {
    token.use(null);
    showControl();
  }
}

function begin(hello) {
  page.hello = hello;
  Object.assign(unit, hello.labels.unit);
  page.ended = null;
  page.picture = null;
  page.ahead = Infinity;
  at("log").replaceChildren();
  page.history = new Minute(hello.boards.length * hello.channels, hello.pictures_hz);
  page.boards = hello.boards.map((number, n) =>
    new Board(number, hello.channels, hello.labels.boards[n], hello.control_limit_kpa));
  at("boards").dataset.count = hello.boards.length;
  at("boards").replaceChildren(...page.boards.map((board) => board.root));
  at("port").textContent = hello.port + (hello.whole_run ? ", whole run recorded to " + hello.whole_run : "");
  at("record").hidden = hello.record_folder === null;
  showControl();
  if (token.value && hello.control_limit_kpa !== null) act("/api/token").catch(refused);
}

function remember(past) {
  past.t.forEach((t, n) => page.history.add(t, past.c.map((line) => line[n]), past.p.map((line) => line[n])));
}

function take(picture) {
  page.heard = performance.now();
  // How much later than ever before this picture came: a slow connection shows the past.
  page.ahead = Math.min(page.ahead, page.heard / 1000 - picture.t);
  page.behind = page.heard / 1000 - picture.t - page.ahead;
  const before = page.picture;
  page.picture = picture;
  page.history.add(picture.t, picture.boards.flatMap((board) => board.c), picture.boards.flatMap((board) => board.p));
  if (before?.commanding === picture.commanding) return;
  showControl();
}

// Whether this page may command at all.
function mayControl() {
  return Boolean(page.hello && page.hello.control_limit_kpa !== null && token.value);
}

function showControl() {
  const allowed = page.hello && page.hello.control_limit_kpa !== null;
  const commanding = page.picture?.commanding;
  at("control").hidden = !allowed;
  at("token-form").hidden = Boolean(token.value);
  at("deadman-label").hidden = !mayControl();
  at("release").hidden = !(mayControl() && commanding === "vented");
  for (const board of page.boards) board.control(mayControl(), commanding === "set points");
}

function showDeadman() {
  const { deadman_s: limit, deadman_required: required } = page.hello;
  const other = page.picture.deadman && !deadman.armed;
  at("deadman").checked = required || (deadman.asked ?? deadman.armed);
  at("deadman").disabled = required;
  at("deadman-text").textContent = "Deadman: vent when this page is closed, hidden or out of reach for " + limit + " s"
    + (deadman.armed ? " (on)" : other ? " (another page is watched)" : required ? " (from the first set point on)" : "");
}

function showFigures(figures) {
  const run = figures.statistics;
  if (run) {
    const us = run.cycle_us.p99;
    at("p99").textContent = us < 9999.5 ? Math.round(us) + " us" : (us / 1000).toFixed(1) + " ms";
    // A recording does not know it.
    at("baud-figure").hidden = !run.baud;
    at("baud").textContent = run.baud ? run.baud / 1e6 + " Mbaud" : "-";
    at("lost").textContent = compact.format(run.lost) + " of " + compact.format(run.exchanges);
    const share = run.lost / Math.max(1, run.exchanges);
    at("lost").title = run.lost + " of " + run.exchanges + ", " + (100 * share).toFixed(2) + " %; marked from " + 100 * LOST_SHARE + " % on";
    at("lost").className = share < LOST_SHARE ? "good" : "warn";
    at("rejected").textContent = compact.format(run.rejected);
    at("cpu").textContent = (100 * run.cpu_share).toFixed(0) + " % CPU";
    page.boards.forEach((board, n) => board.figures(run.boards[n]));
  }
  at("watch-figure").hidden = !figures.watch;
  if (figures.watch) {
    at("watch").textContent = at("watch").title = figures.watch.words;
    at("watch").className = figures.watch.warning ? "bad" : "";
  }
  const recording = figures.recording;
  if (!recording) return;
  page.recordingFailed = recording.failed && !recording.running ? recording.last : null;
  if (page.shownRecording !== (recording.last ?? "")) showRecordings();
  page.shownRecording = recording.last ?? "";
  const button = at("record-button"), running = recording.running;
  button.textContent = running ? "Stop recording" : "Record";
  button.classList.toggle("running", Boolean(running));
  at("record-name").hidden = Boolean(running);
  at("record-text").classList.toggle("bad", recording.failed && !running);
  at("record-text").textContent = running ? running[0] + ", " + (running[1] / 1000).toFixed(0) + " kB"
    : recording.finishing ? "writing the last rows" : recording.last ?? "to " + page.hello.record_folder;
}

let drawn = 0;
function draw(now) {
  requestAnimationFrame(draw);
  if (now - drawn < 60) return;
  drawn = now;
  const now_is = condition(), picture = page.picture;
  at("banner").hidden = !now_is.text;
  if (now_is.text && at("banner").textContent !== now_is.text) at("banner").textContent = now_is.text;
  at("link").textContent = now_is.word;
  at("link").className = "pill " + now_is.kind;
  const live = picture && !["ended", "bus dead", "no connection"].includes(now_is.word);
  document.body.classList.toggle("old", Boolean(picture) && !live);
  if (!picture) return;
  at("hz").textContent = live && picture.hz !== null ? picture.hz.toFixed(picture.hz < 100 ? 1 : 0) + " Hz" : "-";
  at("commanding").textContent = COMMANDING[picture.commanding] ?? picture.commanding;
  at("commanding").className = picture.commanding === "vented" ? "bad" : "";
  at("time").textContent = duration(picture.t);
  at("vent").hidden = picture.commanding === "recording";
  at("vent").classList.toggle("vented", picture.commanding === "vented" && !page.venting);
  at("vent").textContent = page.venting ? "VENTING" : picture.commanding === "vented" ? "VENTED" : "VENT ALL";
  showDeadman();
  const colour = colours(), channels = page.hello.channels;
  page.boards.forEach((board, n) => {
    board.show(picture.boards[n]);
    const scale = board.scale ?? scaleAbove(page.history.highest(picture.t, n * channels, channels));
    board.chambers.forEach((chamber, channel) => drawChart(chamber.canvas, page.history, n * channels + channel, picture.t, scale,
      colour, { times: channel === channels - 1, hovered: page.hovered }));
  });
}

// The recordings that can be had, newest first.
async function showRecordings() {
  try {
    const answer = await fetch("/api/recordings", { credentials: "omit", cache: "no-store" });
    const { recordings } = await answer.json();
    at("downloads").replaceChildren(...recordings.filter((one) => one.whole).reverse().slice(0, 5).map((one) =>
      element("a", { href: "/api/recordings/" + encodeURIComponent(one.name), download: one.name, title: one.name },
        "\u2913 " + compact.format(one.bytes) + "B")));
  } catch {
    // The next recording asks again.
  }
}

function duration(seconds) {
  const whole = Math.floor(seconds), two = (n) => String(n).padStart(2, "0");
  return Math.floor(whole / 3600) + ":" + two(Math.floor(whole / 60) % 60) + ":" + two(whole % 60);
}

function ventNow() {
  venting.start((says) => {
    // One line for what changes, not for each try.
    const what = (text) => text?.replace(/ \(try \d+\)/, "");
    if (says && what(says) !== what(page.venting)) log(what(says));
    page.venting = says;
  });
}
// As soon as a finger or a button is down; a click is what keys make.
at("vent").addEventListener("pointerdown", (event) => event.button === 0 && ventNow());
at("vent").addEventListener("click", ventNow);
at("release").addEventListener("click", () => act("/api/release").catch(refused));
at("record-button").addEventListener("click", () => {
  const running = at("record-button").classList.contains("running");
  const done = running ? act("/api/record/stop") : act("/api/record/start", { name: at("record-name").value.trim() });
  done.then((said) => said.file && log("recording to " + said.file)).catch((error) => log(error.message));
});
at("token-form").addEventListener("submit", (event) => {
  event.preventDefault();
  token.use(at("token").value.trim());
  at("token").value = "";
  act("/api/token").then(showControl).catch(refused);
});

at("deadman").addEventListener("change", () => deadman.ask(at("deadman").checked).catch(refused));
(function beat() {
  deadman.beat();
  setTimeout(beat, page.hello ? Math.min(500, 100 * page.hello.deadman_s) : 500);
})();
document.addEventListener("visibilitychange", () => {
  if (document.hidden) page.boards.forEach((board) => board.arm(false));
});

// A zoomed page or a keyboard on the screen covers what is fixed to the page: the footer stays
// where it can be seen.
function keepFooterVisible() {
  const seen = window.visualViewport, footer = document.querySelector("footer"), whole = document.documentElement;
  const moved = whole.clientHeight - seen.offsetTop - seen.height;
  footer.style.transform = seen.scale > 1.01 || moved > 1
    ? "translate(" + seen.offsetLeft + "px, " + -moved + "px) scale(" + 1 / seen.scale + ")" : "";
}
for (const event of ["resize", "scroll"]) window.visualViewport?.addEventListener(event, keepFooterVisible);

stream.open();
// Titles change on pages that are not drawn, too.
setInterval(() => document.title = title(condition()), 500);
requestAnimationFrame(draw);
