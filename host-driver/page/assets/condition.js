// How it stands: the worst that is the case, for the pill, the banner and the title.

const DEAD = "Boards without a host hold, then vent.";

function names(boards) {
  return (boards.length > 1 ? "boards " : "board ") + boards.join(", ");
}

// The kind of trouble, in one word or two; and what it means, where that needs a sentence.
function condition() {
  const silent = (performance.now() - page.heard) / 1000, picture = page.picture;
  const is = (kind, word, text = null) => ({ kind, word, text });
  if (page.venting) return is("bad", "venting", page.venting);
  const recorded = picture?.commanding === "recording";
  if (page.ended && recorded) return is("warn", "closed", "The recording is not shown any more.");
  if (page.ended?.reason) {
    return is("bad", "bus dead", "The bus is dead: " + page.ended.reason + ". The pressures below are the last ones known. " + DEAD);
  }
  if (page.ended) return is("bad", "ended", "The run has ended; 0 kPa was commanded to all boards.");
  if (!picture) return is("bad", "connecting");
  // Without a stream there is a picture every second or two.
  if (silent > (stream.source?.readyState === EventSource.OPEN ? 1.5 : 5)) {
    return is("bad", "no connection", "Nothing from the host for " + silent.toFixed(0) + " s. The pressures below are old.");
  }
  if (picture.late > Math.max(1, 3 / (picture.hz || 1))) {
    return is("bad", "bus stands still", "The bus stands still: the last cycle was " + picture.late.toFixed(1) + " s ago.");
  }
  const away = picture.boards.flatMap((board, n) => STATES[board.state]?.[1] === "bad" ? [page.hello.boards[n]] : []);
  if (recorded && away.length) return is("warn", "recording: no answer", "In the recording " + names(away) + " did not answer here.");
  if (away.length === picture.boards.length) return is("bad", "bus dead", "The bus is dead: no board answers. " + DEAD);
  if (picture.commanding === "vented") {
    const release = page.hello.control_limit_kpa === null
      ? ". This page cannot release them (--allow-control lets it)." : " with the token.";
    const returns = picture.returns ? " A release returns to the set points of before, by a ramp." : "";
    const missing = away.length ? " Not answering: " + names(away) + "; without a host they hold, then vent." : "";
    return is("bad", "VENTED", "VENTED: 0 kPa is commanded to all boards until they are released" + release + returns + missing);
  }
  if (page.behind > 1) return is("warn", "slow", "Slow connection: this picture is " + page.behind.toFixed(1) + " s old.");
  if (away.length) return is("bad", names(away) + " missing");
  const faulty = picture.boards.flatMap((board, n) => board.fault.includes(true) ? [page.hello.boards[n]] : []);
  if (faulty.length) return is("bad", "sensor fault", "Sensor fault at " + names(faulty) + ": these channels vent.");
  if (page.recordingFailed) return is("bad", "not recording", "The recording has failed: " + page.recordingFailed);
  const doubtful = picture.boards.flatMap((board, n) => board.state === "doubtful" ? [page.hello.boards[n]] : []);
  if (doubtful.length) return is("warn", names(doubtful) + " did not answer");
  return is("good", recorded ? "a recording" : "live");
}

// Tabs show a few words of it.
function title(now) {
  const words = now.kind === "bad" && page.picture ? [now.word.toUpperCase()] : [];
  if (page.picture?.commanding === "vented" && !words.includes("VENTED")) words.push("VENTED");
  return [...words, "PneuDrive " + (page.hello?.port ?? "")].join(" - ");
}
