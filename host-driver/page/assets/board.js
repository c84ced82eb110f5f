// A board's card: its state, its arming, and four chambers with number, chart and set point.

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

// An armed board that nobody uses is disarmed after this, s.
const ARMED_S = 60;

class Chamber {
  // `used` is called with every set point.
  constructor(board, channel, limit, used) {
    Object.assign(this, { board, channel, limit, used });
    this.pressure = element("div", { className: "pressure" }, "-");
    this.set = element("div", { className: "set" });
    this.canvas = element("canvas");
    this.root = element("div", { className: "chamber" },
      element("div", {}, element("div", { className: "name" }, "chamber " + channel), this.pressure, this.set), this.canvas);
    this.root.dataset.chamber = board + "." + channel;
    if (limit === null) return;
    this.slider = new Slider(limit, (kpa) => this.send(kpa));
    this.number = element("input", { type: "text", inputMode: "decimal", autocomplete: "off", placeholder: "kPa", maxLength: 6 });
    this.number.setAttribute("aria-label", "Set point of board " + board + ", chamber " + channel + ", kPa");
    this.button = element("button", {}, "Set");
    this.form = element("form", { className: "number" }, this.number, this.button);
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.sendNumber();
    });
    this.setter = element("div", { className: "setter", hidden: true }, this.slider.track, this.form);
    this.root.append(this.setter);
    this.control(false, false);
  }

  sendNumber() {
    const text = this.number.value.trim().replace(",", "."), kpa = Number(text);
    const usable = text !== "" && kpa >= 0 && kpa <= this.limit;
    this.number.setAttribute("aria-invalid", String(!usable));
    if (!usable) {
      log("a set point is a number from 0 to " + this.limit + " kPa, not \"" + this.number.value + "\"");
      return;
    }
    this.number.value = "";
    this.number.blur();
    this.send(kpa);
  }

  send(kpa) {
    // What the host says about the set point is older than this for a moment.
    this.sent = { kpa, until: performance.now() + 1500 };
    this.used();
    sendSetPoint(this.board, this.channel, kpa).catch((error) => {
      this.sent = null;
      refused(error);
    });
  }

  show(picture) {
    const command = picture.c[this.channel], pressure = picture.p[this.channel], faulty = picture.fault[this.channel];
    if (pressure === null) this.pressure.textContent = faulty ? "sensor fault" : "---";
    else this.pressure.replaceChildren(pressure.toFixed(1), element("small", {}, " kPa"));
    this.pressure.classList.toggle("bad", faulty);
    const sent = this.sent && performance.now() < this.sent.until ? this.sent.kpa : null;
    const target = sent ?? picture.s[this.channel];
    // A set point that is limited in its rate of change is on its way.
    const onItsWay = Math.abs(picture.s[this.channel] - command) > 0.5;
    this.set.textContent = "command " + command.toFixed(1) + (onItsWay ? " \u2192 " + target.toFixed(1) : "");
    this.slider?.show(target, command);
    const chosen = this.slider?.drag?.chosen ?? null;
    if (chosen !== null) this.set.textContent = chosen + " kPa when let go";
  }

  control(shown, enabled) {
    if (!this.slider) return;
    this.setter.hidden = !shown;
    this.slider.enable(enabled);
    this.number.disabled = this.button.disabled = !enabled;
  }
}

class Board {
  constructor(number, channels, limit) {
    this.number = number;
    this.armed = false;
    this.state = element("span", { className: "pill" });
    this.text = element("small");
    this.arming = element("button", { type: "button", className: "arm", hidden: true }, "Arm");
    this.arming.addEventListener("click", () => this.arm(!this.armed));
    const used = () => this.lastUse = performance.now();
    this.chambers = Array.from({ length: channels }, (_, channel) => new Chamber(number, channel, limit, used));
    this.root = element("section", { className: "board" },
      element("h2", {}, "Board " + number, this.state, this.text, this.arming), ...this.chambers.map((chamber) => chamber.root));
    this.root.dataset.board = number;
  }

  // Whether controls are shown at all, and whether the host takes set points now.
  control(shown, possible) {
    Object.assign(this, { shown, possible });
    this.arm(this.armed && shown && possible);
  }

  arm(armed) {
    this.armed = armed;
    this.lastUse = performance.now();
    this.arming.hidden = !this.shown;
    this.arming.disabled = !this.possible;
    this.arming.setAttribute("aria-pressed", String(armed));
    this.root.classList.toggle("armed", armed);
    for (const chamber of this.chambers) chamber.control(Boolean(this.shown), armed);
    this.showArming();
  }

  showArming() {
    const left = Math.ceil(ARMED_S - (performance.now() - this.lastUse) / 1000);
    if (this.armed && left <= 0) {
      log("board " + this.number + " is disarmed: not used for " + ARMED_S + " s");
      this.arm(false);
      return;
    }
    this.arming.textContent = this.armed ? "Disarm (" + left + " s)" : "Arm";
  }

  show(picture) {
    const [word, kind] = STATES[picture.state] ?? [picture.state, "warn"];
    this.state.textContent = word;
    this.state.className = "pill " + kind;
    this.root.classList.toggle("old", picture.p.every((kpa, channel) => kpa === null && !picture.fault[channel]));
    this.age = picture.age;
    this.showArming();
    this.chambers.forEach((chamber) => chamber.show(picture));
  }

  figures(statistics) {
    if (!statistics) return;
    const old = this.age > 0.5 ? "seen " + this.age.toFixed(1) + " s ago, " : "";
    const all = statistics.answered + statistics.lost;
    this.text.textContent = old + compact.format(statistics.lost) + " lost of " + compact.format(all);
  }
}
