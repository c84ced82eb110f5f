// What the page asks the host to do.

// The token comes in the address's fragment, which browsers do not send to servers, and leaves the address at once.
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

// Sends an action. Gives the answer, or throws an error that says what the host said.
async function act(path, body) {
  const headers = {};
  if (body !== undefined) headers["Content-Type"] = "application/json";
  if (token.value) headers.Authorization = "Bearer " + token.value;
  const answer = await fetch(path, {
    method: "POST", headers, body: body === undefined ? undefined : JSON.stringify(body),
    signal: AbortSignal.timeout(3000), credentials: "omit", cache: "no-store",
  });
  const said = await answer.json().catch(() => ({}));
  if (!answer.ok) {
    const error = new Error(said.error || "the host answered " + answer.status);
    error.status = answer.status;
    throw error;
  }
  return said;
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

// Tries until the host has taken it; `tell` hears what becomes of it.
async function vent(tell) {
  for (let tries = 1; ; tries++) {
    try {
      await act("/api/vent");
      tell(null);
      return;
    } catch (error) {
      if (error.status) {
        tell("NOT VENTED: " + error.message);
        return;
      }
      tell("NOT VENTED, the host does not answer (try " + tries + "). Use the hardware stop.");
      await pause(500);
    }
    if (tries >= 20) return;
  }
}

// Sends the newest value of a set point, at most one at a time and ten a second.
class SetPoint {
  constructor(board, channel, failed) {
    Object.assign(this, { board, channel, failed, next: null, busy: false });
  }

  async send(kpa) {
    this.next = kpa;
    if (this.busy) return;
    this.busy = true;
    while (this.next !== null) {
      const body = { board: this.board, channel: this.channel, kpa: this.next };
      this.next = null;
      try {
        await act("/api/set", body);
      } catch (error) {
        this.failed(error);
      }
      await pause(100);
    }
    this.busy = false;
  }
}
