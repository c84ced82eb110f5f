// Where pictures come from: a stream while the page can be seen, single requests where there is
// none.

// Browsers have six connections to a host: some are left for pages that are being loaded, and for
// vents.
const MOST_STREAMS = 4;

const stream = {
  source: null,
  polling: false,
  // The other pages of this browser, and those of them that were opened, or seen again, after this
  // one.
  others: new BroadcastChannel("pneudrive-pages"),
  newer: new Set(),

  open() {
    if (this.source || document.hidden || this.newer.size >= MOST_STREAMS) return;
    const source = this.source = new EventSource("/events");
    const on = (name, what) => source.addEventListener(name, (event) => what(JSON.parse(event.data)));
    on("hello", begin);
    on("past", remember);
    on("picture", take);
    on("figures", showFigures);
    on("line", (line) => log(line.text, duration(line.t)));
    on("end", (end) => {
      page.ended = end;
      log(end.reason ?? "the run has ended");
    });
    // A browser tries again by itself where the connection broke, not where the host has refused
    // it.
    source.addEventListener("error", () => {
      if (source.readyState !== EventSource.CLOSED || this.source !== source) return;
      this.source = null;
      setTimeout(() => this.open(), 2000);
    });
  },

  close() {
    this.source?.close();
    this.source = null;
  },

  // Tells the other pages whether somebody sees this one.
  tell() {
    if (!document.hidden) this.newer.clear();
    this.others.postMessage({ page: this.name, seen: !document.hidden });
  },

  // Another page has told.
  hear({ page, seen }) {
    if (seen) this.newer.add(page);
    else this.newer.delete(page);
    if (this.newer.size >= MOST_STREAMS) this.close();
    else this.open();
  },

  // Not kept: a page that is loaded again is a new one here.
  name: Math.random(),

  // One picture.
  async poll() {
    if (this.polling) return;
    this.polling = true;
    try {
      const answer = await fetch("/api/state", { signal: AbortSignal.timeout(2000), credentials: "omit", cache: "no-store" });
      const state = await answer.json();
      if (answer.ok && state.picture) {
        const again = page.ended || (page.picture && state.picture.t < page.picture.t - 1);
        if (!page.hello || again) begin(state.hello);
        take(state.picture);
        if (state.figures) showFigures(state.figures);
      }
    } catch {
      // Nothing is heard, and the page says so.
    }
    this.polling = false;
  },
};

stream.others.addEventListener("message", (event) => stream.hear(event.data));
window.addEventListener("pagehide", () => stream.others.postMessage({ page: stream.name, seen: false }));
// A page that nobody sees leaves its connection to others. Its title still tells of a vent.
document.addEventListener("visibilitychange", () => {
  stream.tell();
  if (document.hidden) stream.close();
  else stream.open();
});
stream.tell();
setInterval(() => performance.now() - page.heard > 1500 && stream.poll(), 1000);
