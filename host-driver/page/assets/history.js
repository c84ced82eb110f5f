// The last minute of every chamber. NaN stands where there was no fresh reading.
class Minute {
  static SECONDS = 60;

  constructor(chambers, hz) {
    // Some more than a minute, so that the chart's left edge is never empty.
    this.size = Math.ceil((Minute.SECONDS + 2) * hz);
    this.times = new Float64Array(this.size);
    const lines = () => Array.from({ length: chambers }, () => new Float32Array(this.size));
    this.command = lines();
    this.measured = lines();
    this.count = 0;
  }

  add(t, command, measured) {
    // Time goes on only: what overlaps (the past that a new connection brings again) is left out.
    if (this.count && t <= this.times[(this.count - 1) % this.size]) return;
    const at = this.count % this.size;
    this.times[at] = t;
    for (let chamber = 0; chamber < command.length; chamber++) {
      this.command[chamber][at] = command[chamber];
      this.measured[chamber][at] = measured[chamber] ?? NaN;
    }
    this.count++;
  }

  // Calls `visit(place)` from the oldest moment within `seconds` of `now` to the newest.
  each(now, seconds, visit) {
    for (let n = Math.max(0, this.count - this.size); n < this.count; n++) {
      const at = n % this.size;
      if (this.times[at] >= now - seconds) visit(at);
    }
  }

  // The place of the moment nearest to `t`, or null.
  near(t) {
    let best = null;
    this.each(t, 1, (at) => {
      if (best === null || Math.abs(this.times[at] - t) < Math.abs(this.times[best] - t)) best = at;
    });
    return best !== null && Math.abs(this.times[best] - t) < 1 ? best : null;
  }

  // The highest value of some chambers within the last minute, kPa.
  highest(now, from, count) {
    let top = 0;
    this.each(now, Minute.SECONDS, (at) => {
      for (let chamber = from; chamber < from + count; chamber++) {
        top = Math.max(top, this.command[chamber][at], this.measured[chamber][at] || 0);
      }
    });
    return top;
  }
}
