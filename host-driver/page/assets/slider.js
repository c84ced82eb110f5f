// A slider that moves by its thumb only. Nothing is sent before the finger leaves it: scrolling
// past it, a tap beside the thumb, the wheel and keys do nothing.

// So far the finger must go sideways before the thumb follows, CSS pixels.
const DRAG_FROM = 6;

class Slider {
  // `send` gets the pressure that was chosen, kPa.
  constructor(limit, send) {
    Object.assign(this, { limit, send, enabled: false, value: 0, drag: null });
    this.fill = element("div", { className: "fill" });
    this.thumb = element("div", { className: "thumb" });
    this.track = element("div", { className: "track" }, this.fill, this.thumb);
    // Where the set point is, of the highest that the page may command: another source may command
    // more, which stands at the stop, too.
    this.reading = element("div", { className: "reading", title: "set point, of the highest that this page may command" });
    // The number field beside it says the same to people who cannot see or drag.
    this.track.setAttribute("aria-hidden", "true");
    const listen = (event, what) => this.thumb.addEventListener(event, what);
    listen("pointerdown", (event) => this.press(event));
    listen("pointermove", (event) => this.move(event));
    listen("pointerup", (event) => this.release(event));
    // The browser scrolls the page instead.
    listen("pointercancel", () => this.giveUp());
    window.addEventListener("keydown", (event) => event.key === "Escape" && this.giveUp());
  }

  press(event) {
    if (!this.enabled || event.button !== 0 || this.drag) return;
    this.thumb.setPointerCapture(event.pointerId);
    this.drag = { pointer: event.pointerId, from: event.clientX, start: this.value, chosen: null };
  }

  move(event) {
    const drag = this.drag;
    if (drag?.pointer !== event.pointerId) return;
    const way = event.clientX - drag.from;
    if (drag.chosen === null && Math.abs(way) < DRAG_FROM) return;
    const kpa = drag.start + way / (this.track.clientWidth - this.thumb.offsetWidth) * this.limit;
    drag.chosen = Math.round(Math.min(this.limit, Math.max(0, kpa)));
    this.draw();
  }

  release(event) {
    const drag = this.drag;
    if (drag?.pointer !== event.pointerId) return;
    this.drag = null;
    if (this.enabled && drag.chosen !== null) {
      this.value = drag.chosen;
      this.send(drag.chosen);
    }
    this.draw();
  }

  giveUp() {
    this.drag = null;
    this.draw();
  }

  // What the host says: where the set point is, and how far the command has come.
  show(target, command) {
    this.value = target;
    this.command = command;
    this.draw();
  }

  enable(enabled) {
    if (!enabled && this.drag) this.giveUp();
    this.enabled = enabled;
    this.track.classList.toggle("inert", !enabled);
  }

  draw() {
    const along = (kpa) => "calc(" + Math.min(1, Math.max(0, kpa / this.limit)) + " * (100% - var(--thumb)))";
    const chosen = this.drag?.chosen ?? null;
    this.thumb.style.left = along(chosen ?? this.value);
    this.fill.style.width = along(this.command ?? 0);
    this.track.classList.toggle("dragged", chosen !== null);
    this.reading.textContent = unit.short(chosen ?? this.value) + " of " + unit.short(this.limit) + " " + unit.name;
    this.reading.classList.toggle("beyond", this.value > this.limit * 1.005);
    this.thumb.dataset.kpa = chosen === null ? "" : unit.short(chosen) + " " + unit.name;
  }
}
