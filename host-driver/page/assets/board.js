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

// A pressure that is further from its set point than this is marked, kPa.
const FAR_KPA = 5;

// An armed board that nobody uses is disarmed after this, s.
const ARMED_S = 60;

class Chamber {
  // `used` is called with every set point.
  constructor(board, channel, name, limit, used) {
    Object.assign(this, { board, channel, limit, used });
    this.pressure = element("div", { className: "pressure" }, "-");
    this.set = element("div", { className: "set" });
    this.off = element("div", { className: "off", title: "measured minus commanded pressure" });
    this.canvas = element("canvas");
    this.root = element("div", { className: "chamber" },
      element("div", { className: "now" }, element("div", { className: "name" }, name ?? "chamber " + channel), this.pressure,
        element("div", { className: "aim" }, this.set, this.off)),
      element("div", { className: "plot" }, this.canvas));
    this.root.title = "chamber " + channel + " of board " + board;
    this.canvas.addEventListener("pointermove", (event) => {
      page.hovered = Minute.SECONDS * (1 - event.offsetX / this.canvas.clientWidth);
    });
    this.canvas.addEventListener("pointerleave", () => page.hovered = null);
    this.root.dataset.chamber = board + "." + channel;
    if (limit === null) return;
    this.slider = new Slider(limit, (kpa) => this.send(kpa));
    this.number = element("input", { type: "text", inputMode: "decimal", autocomplete: "off", placeholder: unit.name, maxLength: 7 });
    this.number.setAttribute("aria-label", "Set point of board " + board + ", chamber " + channel + ", " + unit.name);
    this.button = element("button", {}, "Set");
    this.form = element("form", { className: "number" }, this.number, this.button);
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.sendNumber();
    });
    this.setter = element("div", { className: "setter", hidden: true }, this.slider.track, this.slider.reading, this.form);
    this.root.append(this.setter);
    this.control(false, false);
  }

  sendNumber() {
    const text = this.number.value.trim().replace(",", "."), kpa = Number(text) * unit.kpa;
    const usable = text !== "" && kpa >= 0 && kpa <= this.limit * (1 + 1e-9);
    this.number.setAttribute("aria-invalid", String(!usable));
    if (!usable) {
      log("a set point is a number from 0 to " + unit.short(this.limit) + " " + unit.name + ", not \"" + this.number.value + "\"");
      return;
    }
    this.number.value = "";
    this.number.blur();
    this.send(Math.min(kpa, this.limit));
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
    else this.pressure.replaceChildren(unit.number(pressure), element("small", {}, " " + unit.name));
    this.pressure.classList.toggle("bad", faulty);
    const sent = this.sent && performance.now() < this.sent.until ? this.sent.kpa : null;
    const target = sent ?? picture.s[this.channel];
    // A set point that is limited in its rate of change is on its way.
    const onItsWay = Math.abs(picture.s[this.channel] - command) > 0.5;
    const way = onItsWay ? [element("span", {}, " \u2192 " + unit.number(target))] : [];
    this.set.replaceChildren(element("span", { className: "word" }, "command "), unit.number(command), ...way);
    this.off.textContent = pressure === null ? "" : "\u0394 " + unit.signed(pressure - command);
    this.off.classList.toggle("far", pressure !== null && Math.abs(pressure - command) > FAR_KPA);
    this.slider?.show(target, command);
    const chosen = this.slider?.drag?.chosen ?? null;
    if (chosen !== null) this.set.textContent = unit.short(chosen) + " " + unit.name + " when let go";
  }

  control(shown, enabled) {
    if (!this.slider) return;
    this.setter.hidden = !shown;
    this.slider.enable(enabled);
    this.number.disabled = this.button.disabled = !enabled;
  }
}

class Board {
  constructor(number, channels, labels, limit) {
    this.number = number;
    this.scale = labels?.scale_kpa ?? null;
    this.armed = false;
    this.state = element("span", { className: "pill" });
    this.sensors = element("span", { className: "sensors" });
    this.losses = element("span");
    this.text = element("small", {}, this.sensors, " ", this.losses);
    this.arming = element("button", { type: "button", className: "arm", hidden: true }, "Arm");
    this.arming.addEventListener("click", () => this.arm(!this.armed));
    const used = () => this.lastUse = performance.now();
    this.chambers = Array.from({ length: channels }, (_, channel) => new Chamber(number, channel, labels?.channels[channel], limit, used));
    this.root = element("section", { className: "board" },
      element("h2", {}, element("span", { className: "called" }, labels?.name ?? "Board " + number), this.state, this.text, this.arming), ...this.chambers.map((chamber) => chamber.root));
    this.root.dataset.board = number;
    this.root.querySelector("h2").title = "board " + number;
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
    this.arming.textContent = this.armed ? "Disarm " + left + " s" : "Arm";
  }

  show(picture) {
    const [word, kind] = STATES[picture.state] ?? [picture.state, "warn"];
    this.state.textContent = word;
    this.state.className = "pill " + kind;
    this.root.classList.toggle("old", picture.p.every((kpa, channel) => kpa === null && !picture.fault[channel]));
    this.age = picture.age;
    const supply = picture.supply === undefined ? [] : ["supply " + unit.text(picture.supply)];
    const chip = picture.chip_c === undefined ? [] : ["chip " + picture.chip_c.toFixed(0) + " \u00b0C"];
    this.sensors.textContent = [...supply, ...chip].join(", ");
    this.showArming();
    this.chambers.forEach((chamber) => chamber.show(picture));
  }

  figures(statistics) {
    if (!statistics) return;
    const old = this.age > 0.5 ? "seen " + this.age.toFixed(1) + " s ago, " : "";
    const all = statistics.answered + statistics.lost;
    const share = " (" + ((100 * statistics.lost) / Math.max(1, all)).toFixed(2) + " %)";
    const lost = compact.format(statistics.lost) + " lost" + share;
    this.losses.textContent = old + (statistics.lost ? lost : "");
    this.text.title = statistics.lost + " lost of " + all;
  }
}
