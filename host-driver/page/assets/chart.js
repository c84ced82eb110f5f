// One chamber's last minute: the command as steps, the measured pressure as a line with gaps where
// there was none.

// Not finer than this, kPa: noise must not look like motion.
const SMALLEST_SCALE = 50;

// A round number not below `top`, kPa.
function scaleAbove(top) {
  const steps = [50, 100, 150, 200, 300, 400, 500, 600, 700, 800];
  return steps.find((step) => step >= Math.max(top, SMALLEST_SCALE)) ?? Math.ceil(top / 100) * 100;
}

function colours() {
  const style = getComputedStyle(document.documentElement);
  const names = ["measured", "command", "line", "dim"];
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue("--" + name).trim()]));
}

function drawChart(canvas, history, chamber, now, scale, colour) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const margin = 3;
  const x = (t) => width * (1 - (now - t) / Minute.SECONDS);
  const y = (kpa) => height - margin - (height - 2 * margin) * Math.max(0, kpa) / scale;

  pen.strokeStyle = colour.line;
  pen.lineWidth = 1;
  for (const part of [0, 0.5, 1]) {
    pen.beginPath();
    pen.moveTo(0, y(part * scale));
    pen.lineTo(width, y(part * scale));
    pen.stroke();
  }
  pen.fillStyle = colour.dim;
  pen.font = "10px system-ui, sans-serif";
  pen.textBaseline = "top";
  pen.fillText(scale + " kPa", 2, y(scale) + 2);

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
}
