// Puts together what the host sends and what the page shows.

const at = (id) => document.getElementById(id);
const page = { hello: null, boards: [], history: null, picture: null, heard: -Infinity, ended: null, ahead: Infinity, ventError: null };

// `time` is that of the run.
function log(text, time = page.picture ? duration(page.picture.t) : "") {
  const line = element("li", {}, time + "  " + text);
  at("log").prepend(line);
  while (at("log").children.length > 8) at("log").lastChild.remove();
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
  page.ended = null;
  page.picture = null;
  page.ahead = Infinity;
  at("log").replaceChildren();
  page.history = new Minute(hello.boards.length * hello.channels, hello.pictures_hz);
  page.boards = hello.boards.map((number) => new Board(number, hello.channels, hello.control_limit_kpa, refused));
  at("boards").replaceChildren(...page.boards.map((board) => board.root));
  at("port").textContent = hello.port + (hello.whole_run ? ", whole run recorded to " + hello.whole_run : "");
  at("record").hidden = hello.record_folder === null;
  document.title = "PneuDrive " + hello.port;
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
  if (before) log(picture.commanding === "vented" ? "all boards vented" : "released: set points are 0 kPa");
  showControl();
}

function showControl() {
  const allowed = page.hello && page.hello.control_limit_kpa !== null;
  const commanding = page.picture?.commanding;
  at("control").hidden = !allowed;
  at("token-form").hidden = Boolean(token.value);
  at("release").hidden = !(allowed && token.value && commanding === "vented");
  for (const board of page.boards) {
    for (const chamber of board.chambers) chamber.control(Boolean(allowed && token.value), commanding === "set points");
  }
}

function showFigures(figures) {
  const run = figures.statistics;
  if (run) {
    const us = run.cycle_us.p99;
    at("p99").textContent = us < 9999.5 ? Math.round(us) + " us" : (us / 1000).toFixed(1) + " ms";
    at("lost").textContent = run.lost + " of " + compact.format(run.exchanges);
    at("lost").className = run.lost === 0 ? "good" : "warn";
    at("rejected").textContent = run.rejected;
    at("cpu").textContent = (100 * run.cpu_share).toFixed(0) + " % CPU";
    page.boards.forEach((board, n) => board.figures(run.boards[n]));
  }
  const recording = figures.recording;
  if (!recording) return;
  const button = at("record-button"), running = recording.running;
  button.textContent = running ? "Stop recording" : "Record";
  button.classList.toggle("running", Boolean(running));
  at("record-name").hidden = Boolean(running);
  at("record-text").classList.toggle("bad", recording.failed && !running);
  at("record-text").textContent = running ? running[0] + ", " + (running[1] / 1000).toFixed(0) + " kB"
    : recording.finishing ? "writing the last rows" : recording.last ?? "to " + page.hello.record_folder;
}

// What is wrong, the worst first.
function trouble() {
  const silent = (performance.now() - page.heard) / 1000, picture = page.picture;
  if (page.ventError) return page.ventError;
  if (page.ended) {
    return page.ended.reason
      ? "The bus is dead: " + page.ended.reason + ". The pressures below are the last ones known. Boards without a host hold, then vent."
      : "The run has ended; 0 kPa was commanded to all boards.";
  }
  if (!picture) return null;
  if (silent > 1.5) return "Nothing from the host for " + silent.toFixed(0) + " s. The pressures below are old.";
  if (picture.late > Math.max(1, 3 / (picture.hz || 1))) {
    return "The bus stands still: the last cycle was " + picture.late.toFixed(1) + " s ago.";
  }
  if (picture.boards.every((board) => board.state === "missing" || board.state === "unseen")) {
    return "The bus is dead: no board answers. Boards without a host hold, then vent.";
  }
  if (page.behind > 1) return "Slow connection: this picture is " + page.behind.toFixed(1) + " s old.";
  if (picture.commanding === "vented") {
    return "VENTED: 0 kPa is commanded to all chambers until " + (page.hello.control_limit_kpa === null
      ? "the run ends (this page cannot release them)." : "they are released with the token.");
  }
  return null;
}

let drawn = 0;
function draw(now) {
  requestAnimationFrame(draw);
  if (now - drawn < 60) return;
  drawn = now;
  const problem = trouble(), picture = page.picture;
  at("banner").hidden = !problem;
  if (problem && at("banner").textContent !== problem) at("banner").textContent = problem;
  const live = picture && !page.ended && performance.now() - page.heard < 1500;
  at("link").textContent = live ? "live" : page.ended ? "ended" : "no connection";
  at("link").className = "pill " + (live ? "good" : "bad");
  document.body.classList.toggle("old", Boolean(picture) && !live);
  if (!picture) return;
  at("hz").textContent = live && picture.hz !== null ? picture.hz.toFixed(picture.hz < 100 ? 1 : 0) + " Hz" : "-";
  at("commanding").textContent = picture.commanding;
  at("commanding").className = picture.commanding === "vented" ? "bad" : "";
  at("time").textContent = duration(picture.t);
  at("vent").classList.toggle("vented", picture.commanding === "vented");
  at("vent").textContent = picture.commanding === "vented" ? "VENTED" : "VENT ALL";
  const scale = scaleAbove(page.history.highest(picture.t)), colour = colours();
  page.boards.forEach((board, n) => {
    board.show(picture.boards[n]);
    board.chambers.forEach((chamber, channel) =>
      drawChart(chamber.canvas, page.history, n * page.hello.channels + channel, picture.t, scale, colour));
  });
}

function duration(seconds) {
  const whole = Math.floor(seconds), two = (n) => String(n).padStart(2, "0");
  return Math.floor(whole / 3600) + ":" + two(Math.floor(whole / 60) % 60) + ":" + two(whole % 60);
}

at("vent").addEventListener("click", () => vent((problem) => {
  if (problem && problem !== page.ventError) log(problem);
  page.ventError = problem;
}));
at("release").addEventListener("click", () => act("/api/release", {}).catch(refused));
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

const events = new EventSource("/events");
const on = (name, what) => events.addEventListener(name, (event) => what(JSON.parse(event.data)));
on("hello", begin);
on("past", remember);
on("picture", take);
on("figures", showFigures);
on("line", (line) => log(line.text, duration(line.t)));
on("end", (end) => {
  page.ended = end;
  log(end.reason ?? "the run has ended");
});
requestAnimationFrame(draw);
