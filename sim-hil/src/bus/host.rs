use super::Line;
use std::collections::VecDeque;

/// The host adapter's transmitter: sends its queue back to back.
#[derive(Debug)]
pub(super) struct HostTransmitter {
    line: Line,
    queue: VecDeque<Queued>,
    burst_first_ns: u64,
    burst_sent: u64,
}

#[derive(Debug, Clone, Copy)]
struct Queued {
    not_before_ns: u64,
    byte: u8,
}

impl HostTransmitter {
    pub fn new(line: Line) -> Self {
        Self { line, queue: VecDeque::new(), burst_first_ns: 0, burst_sent: 0 }
    }

    /// The adapter's line rate is this from now on.
    pub fn set_line(&mut self, line: Line) {
        (self.burst_first_ns, self.burst_sent) = (self.free_at_ns(), 0);
        self.line = line;
    }

    pub fn push(&mut self, not_before_ns: u64, byte: u8) {
        self.queue.push_back(Queued { not_before_ns, byte });
    }

    pub fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// When the last character sent or queued will have ended, if nothing else delays it.
    pub fn done_at_ns(&self) -> u64 {
        let back_to_back = self.free_at_ns() + self.line.characters_ns(self.queue.len() as u64);
        let held_back = self.queue.back().map_or(0, |last| last.not_before_ns + self.line.character_ns());
        back_to_back.max(held_back)
    }

    /// When the next start bit falls.
    pub fn next_start_ns(&self) -> Option<u64> {
        self.queue.front().map(|next| next.not_before_ns.max(self.free_at_ns()))
    }

    /// Takes the next character if its start bit has fallen by `now_ns`: start time, byte, and
    /// whether it opens a burst.
    pub fn take(&mut self, now_ns: u64) -> Option<(u64, u8, bool)> {
        let start_ns = self.next_start_ns().filter(|&start| start <= now_ns)?;
        let free_at_ns = self.free_at_ns();
        let next = self.queue.pop_front()?;
        let opens_burst = start_ns > free_at_ns || self.burst_sent == 0;
        if opens_burst {
            self.burst_first_ns = start_ns;
            self.burst_sent = 0;
        }
        self.burst_sent += 1;
        Some((start_ns, next.byte, opens_burst))
    }

    /// End of the last stop bit sent; counted from the burst's first start bit, so that rounding
    /// does not add up.
    fn free_at_ns(&self) -> u64 {
        self.burst_first_ns + self.line.characters_ns(self.burst_sent)
    }
}

/// A character that reached the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HostByte {
    /// When the adapter hands it over, ns: the end of its stop bit unless a fault holds it back.
    pub at_ns: u64,
    /// The eight data bits.
    pub byte: u8,
    /// Whether the adapter's receiver flagged it. A tty hands such bytes over like any other.
    pub damaged: bool,
}

/// The host adapter's receiver: a queue in order of time.
#[derive(Debug, Default)]
pub(super) struct HostReceiver {
    queue: VecDeque<HostByte>,
    newest_ns: u64,
}

impl HostReceiver {
    pub fn push(&mut self, mut byte: HostByte) {
        // A byte that is held back holds back those behind it.
        self.newest_ns = self.newest_ns.max(byte.at_ns);
        byte.at_ns = self.newest_ns;
        self.queue.push_back(byte);
    }

    pub fn next_at_ns(&self) -> Option<u64> {
        self.queue.front().map(|byte| byte.at_ns)
    }

    pub fn pop(&mut self, now_ns: u64) -> Option<HostByte> {
        self.queue.front().filter(|byte| byte.at_ns <= now_ns)?;
        self.queue.pop_front()
    }
}
