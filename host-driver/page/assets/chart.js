// One chamber's last minute: the command as steps, the measured pressure as a line with gaps where
// there was none, on the board's scale. Below the last chamber of a board stands the time.

// Not finer than this, kPa: noise must not look like motion.
const SMALLEST_SCALE = 20;
// Seconds between the lines of time.
const TICK_S = 15;

// A round number not below `top`, kPa.
function scaleAbove(top) {
  const steps = [20, 50, 100, 150, 200, 300, 400, 500, 600, 700, 800];
  return steps.find((step) => step >= Math.max(top, SMALLEST_SCALE)) ?? Math.ceil(top / 100) * 100;
}

function colours() {
  const style = getComputedStyle(document.documentElement);
  const names = ["measured", "command", "line", "dim", "text", "card"];
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue("--" + name).trim()]));
}

// `chamber` counts over all boards; `hovered` is how long ago what is pointed at was, s, or null.
function drawChart(canvas, history, chamber, now, scale, colour, { times: showTimes, hovered }) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const top = 3, bottom = height - (showTimes ? 14 : 3);
  const x = (t) => width * (1 - (now - t) / Minute.SECONDS);
  const y = (kpa) => bottom - (bottom - top) * Math.max(0, kpa) / scale;
  const line = (x1, y1, x2, y2) => {
    pen.beginPath();
    pen.moveTo(x1, y1);
    pen.lineTo(x2, y2);
    pen.stroke();
  };

  pen.strokeStyle = colour.line;
  pen.lineWidth = 1;
  for (const part of [0, 0.5, 1]) line(0, y(part * scale), width, y(part * scale));
  pen.fillStyle = colour.dim;
  pen.font = "10px system-ui, sans-serif";
  pen.textBaseline = "top";
  pen.textAlign = "left";
  for (let ago = TICK_S; ago < Minute.SECONDS; ago += TICK_S) {
    line(x(now - ago), y(scale), x(now - ago), bottom);
    // Labels that would touch are left out: then the middle one stands alone.
    if (!showTimes || (width < 170 && ago !== 30)) continue;
    pen.textAlign = "center";
    pen.fillText("\u2212" + ago + " s", x(now - ago), bottom + 3);
  }
  pen.textAlign = "left";
  // Where there is room, the scale stands at every chart.
  if (bottom - top > 22) pen.fillText(unit.short(scale) + " " + unit.name, 2, y(scale) + 2);
  if (bottom - top > 34) pen.fillText("0", 2, bottom - 11);

  const times = history.times, command = history.command[chamber], measured = history.measured[chamber];
  pen.strokeStyle = colour.command;
  pen.lineWidth = 1.5;
  pen.setLineDash([5, 3]);
  pen.beginPath();
  let before = NaN;
  history.each(now, Minute.SECONDS, (at) => {
    if (Number.isNaN(before)) pen.moveTo(x(times[at]), y(command[at]));
    else if (command[at] !== before) {
      pen.lineTo(x(times[at]), y(before));
      pen.lineTo(x(times[at]), y(command[at]));
    }
    before = command[at];
  });
  if (!Number.isNaN(before)) pen.lineTo(width, y(before));
  pen.stroke();

  pen.strokeStyle = colour.measured;
  pen.lineWidth = 2;
  pen.setLineDash([]);
  pen.beginPath();
  let drawing = false;
  history.each(now, Minute.SECONDS, (at) => {
    const there = !Number.isNaN(measured[at]);
    if (there && drawing) pen.lineTo(x(times[at]), y(measured[at]));
    else if (there) pen.moveTo(x(times[at]), y(measured[at]));
    drawing = there;
  });
  pen.stroke();
  if (hovered !== null) drawHovered(pen, history.near(now - hovered), { x, bottom, top, width, colour, chamber, history, now });
}

// What was at the moment that is pointed at.
function drawHovered(pen, at, { x, bottom, top, width, colour, chamber, history, now }) {
  if (at === null) return;
  const t = history.times[at], place = x(t), pressure = history.measured[chamber][at];
  pen.strokeStyle = colour.text;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(place, top);
  pen.lineTo(place, bottom);
  pen.stroke();
  const said = (Number.isNaN(pressure) ? "---" : unit.number(pressure)) + " / " + unit.number(history.command[chamber][at])
    + "  \u2212" + (now - t).toFixed(1) + " s";
  pen.font = "11px system-ui, sans-serif";
  const wide = pen.measureText(said).width + 8;
  const left = place + 4 + wide > width ? Math.max(0, place - 4 - wide) : place + 4;
  pen.fillStyle = colour.card;
  pen.fillRect(left, top, wide, 15);
  pen.fillStyle = colour.text;
  pen.textBaseline = "top";
  pen.fillText(said, left + 4, top + 2);
}
