// A board's card: its state, and four chambers with number, chart and slider.

function element(name, attributes, ...children) {
  const made = document.createElement(name);
  Object.assign(made, attributes);
  made.append(...children);
  return made;
}

// 12345678 as 12.3M.
const compact = new Intl.NumberFormat("en", { notation: "compact", maximumFractionDigits: 1 });

const STATES = {
  present: ["present", "good"],
  doubtful: ["did not answer", "warn"],
  missing: ["MISSING", "bad"],
  unseen: ["never answered", "bad"],
};

class Chamber {
  constructor(board, channel, limit, failed) {
    this.pressure = element("div", { className: "pressure" }, "-");
    this.set = element("div", { className: "set" });
    this.canvas = element("canvas");
    this.root = element("div", { className: "chamber" },
      element("div", {}, element("div", { className: "name" }, "chamber " + channel), this.pressure, this.set), this.canvas);
    this.root.dataset.chamber = board + "." + channel;
    if (limit === null) return;
    this.range = element("input", { type: "range", min: 0, max: limit, step: 1, value: 0 });
    this.range.setAttribute("aria-label", "Set point of board " + board + ", chamber " + channel + ", kPa");
    this.output = element("output", {});
    this.slider = element("div", { className: "slider", hidden: true }, this.range, this.output);
    this.root.append(this.slider);
    const sender = new SetPoint(board, channel, failed);
    this.range.addEventListener("input", () => {
      // What the host says about the set point is older than the finger on the slider.
      this.touched = performance.now();
      this.output.textContent = this.range.value + " kPa";
      sender.send(Number(this.range.value));
    });
  }

  show(command, pressure, faulty) {
    if (pressure === null) this.pressure.textContent = faulty ? "sensor fault" : "---";
    else this.pressure.replaceChildren(pressure.toFixed(1), element("small", {}, " kPa"));
    this.pressure.classList.toggle("bad", faulty);
    this.set.textContent = "command " + command.toFixed(1);
    if (this.range && !(performance.now() - this.touched < 1000)) {
      this.range.value = command;
      this.output.textContent = Math.round(command) + " kPa";
    }
  }

  control(shown, enabled) {
    if (!this.range) return;
    this.slider.hidden = !shown;
    this.range.disabled = !enabled;
  }
}

class Board {
  constructor(number, channels, limit, failed) {
    this.number = number;
    this.state = element("span", { className: "pill" });
    this.text = element("small");
    this.chambers = Array.from({ length: channels }, (_, channel) => new Chamber(number, channel, limit, failed));
    this.root = element("section", { className: "board" },
      element("h2", {}, "Board " + number, this.state, this.text), ...this.chambers.map((chamber) => chamber.root));
    this.root.dataset.board = number;
  }

  show(picture) {
    const [word, kind] = STATES[picture.state] ?? [picture.state, "warn"];
    this.state.textContent = word;
    this.state.className = "pill " + kind;
    this.root.classList.toggle("old", picture.p.every((kpa, channel) => kpa === null && !picture.fault[channel]));
    this.age = picture.age;
    this.chambers.forEach((chamber, channel) =>
      chamber.show(picture.c[channel], picture.p[channel], picture.fault[channel]));
  }

  figures(statistics) {
    if (!statistics) return;
    const old = this.age > 0.5 ? "seen " + this.age.toFixed(1) + " s ago, " : "";
    this.text.textContent = old + statistics.lost + " lost of " + compact.format(statistics.answered + statistics.lost);
  }
}
