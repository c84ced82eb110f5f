// What the page asks the host to do.

// The token comes in the address's fragment, which browsers do not send to servers, and leaves the
// address at once.
const token = {
  value: sessionStorage.getItem("token"),
  use(text) {
    this.value = text || null;
    if (this.value) sessionStorage.setItem("token", this.value);
    else sessionStorage.removeItem("token");
  },
};
{
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    token.use(given);
    window.history.replaceState(null, "", location.pathname);
  }
}

// Sends an action. Gives the answer, or throws an error that says what the host said; without a
// status, the host has not answered within `patience`, ms, or its answer has broken off.
async function act(path, body, patience = 3000) {
  const headers = {};
  if (body !== undefined) headers["Content-Type"] = "application/json";
  if (token.value) headers.Authorization = "Bearer " + token.value;
  const answer = await fetch(path, {
    method: "POST", headers, body: body === undefined ? undefined : JSON.stringify(body),
    signal: AbortSignal.timeout(patience), credentials: "omit", cache: "no-store",
  });
  if (!answer.ok) {
    const said = await answer.json().catch(() => ({}));
    const error = new Error(said.error || "the host answered " + answer.status);
    error.status = answer.status;
    throw error;
  }
  return answer.json();
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

// Whether a picture shows that every board that answers was sent 0 kPa.
function showsVent(picture) {
  const sent = (board) => STATES[board.state]?.[1] === "bad" || board.c.every((kpa) => kpa === 0);
  return picture.commanding === "vented" && picture.boards.every(sent);
}

// Vents, and goes on trying until the host reports it. `tell` hears what is going on, and null at
// the end.
const venting = {
  busy: false,

  async start(tell) {
    if (this.busy) return;
    this.busy = true;
    for (let tries = 1; ; tries++) {
      try {
        await act("/api/vent", undefined, 1500);
        tell("Venting: the host has taken it (try " + tries + "), waiting until it reports 0 kPa at all boards.");
        if (await this.isReported(2000)) break;
        tell("NOT VENTED, the host has taken it but does not report it (try " + tries + "). Trying on; use the hardware stop.");
      } catch (error) {
        const why = error.status ? "the host says: " + error.message : "the host does not answer";
        tell("NOT VENTED, " + why + " (try " + tries + "). Trying on; use the hardware stop.");
      }
      // It has ended by itself, with 0 kPa.
      if (page.ended && !page.ended.reason) break;
      await pause(Math.min(1000, 100 * tries));
    }
    this.busy = false;
    tell(null);
  },

  async isReported(patience) {
    const since = performance.now();
    while (performance.now() < since + patience) {
      if (page.heard > since && page.picture && showsVent(page.picture)) return true;
      if (performance.now() - page.heard > 500) await stream.poll();
      await pause(50);
    }
    return false;
  },
};

// Deadman mode: says that this page is there, for as long as somebody can see it.
const deadman = {
  armed: sessionStorage.getItem("deadman") === "armed",
  busy: false,
  // What the operator has asked for and the host has not answered yet.
  asked: null,
  // This page's name. A page that is loaded again keeps it.
  page: sessionStorage.getItem("page") ?? Array.from(crypto.getRandomValues(new Uint32Array(4))).join("-"),

  set(armed) {
    this.armed = armed;
    sessionStorage.setItem("deadman", armed ? "armed" : "");
  },

  // By the operator.
  async ask(armed) {
    this.asked = armed;
    try {
      const said = await act("/api/deadman", { page: this.page, armed });
      this.set(said.armed);
    } finally {
      this.asked = null;
    }
  },

  async beat() {
    if (!this.armed || this.busy || document.hidden) return;
    this.busy = true;
    try {
      const said = await act("/api/heartbeat", { page: this.page }, 1000);
      if (!said.armed) this.set(false);
    } catch {
      // The next one may arrive. If none does, the host vents, which is what this is for.
    }
    this.busy = false;
  },
};
sessionStorage.setItem("page", deadman.page);

async function sendSetPoint(board, channel, kpa) {
  try {
    await act("/api/set", { board, channel, kpa, page: deadman.page });
  } finally {
    // With a deadman for everybody, whoever commands is watched, also where the answer is lost.
    // Where the host has refused it, the next heartbeat's answer says that nobody is.
    if (page.hello.deadman_required) deadman.set(true);
  }
}
