use super::truth::SharedTruth;
use crate::virtual_bus::VirtualBus;
use pneudrive_host::line::{Line, LineError};
use pneudrive_host::poller::{BoardCommand, CommandSource, Observer, Row, SourceStatus};
use pneudrive_protocol::{Baud, Counts};
use std::sync::{Arc, Mutex, PoisonError};

/// The host's line, with somebody listening at the host's end of it.
#[derive(Debug)]
pub struct TappedLine<L = VirtualBus> {
    line: L,
    truth: SharedTruth,
}

impl<L> TappedLine<L> {
    /// Notes in `truth` what is sent on `line`.
    pub fn new(line: L, truth: SharedTruth) -> Self {
        Self { line, truth }
    }

    /// The bus behind it.
    pub fn bus(&self) -> &L {
        &self.line
    }
}

impl<L: Line> Line for TappedLine<L> {
    fn now_ns(&self) -> u64 {
        self.line.now_ns()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        self.truth.lock().host_sends(self.line.now_ns(), bytes);
        self.line.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError> {
        self.line.receive(into, wanted, deadline_ns)
    }

    fn sleep_until(&mut self, at_ns: u64) {
        self.line.sleep_until(at_ns);
    }

    fn change_baud(&mut self, baud: Baud) -> Result<bool, LineError> {
        self.line.change_baud(baud)
    }
}

/// Commands that are new in every cycle, and different for each board and channel.
pub struct NewEveryCycle(
    /// Cycles so far, modulo 65,536.
    pub u16,
);

impl CommandSource for NewEveryCycle {
    fn fill(&mut self, _since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus {
        self.0 = self.0.wrapping_add(1);
        for (board, command) in commands.iter_mut().enumerate() {
            for (channel, value) in command.iter_mut().enumerate() {
                // 7 and 773 have no common factor: 773 cycles without a repetition.
                let step = (u32::from(self.0) * 7 + board as u32 * 200 + channel as u32 * 50) % 773;
                *value = Counts::saturating(102 + step as u16);
            }
        }
        SourceStatus::Continues
    }
}

/// What the host believes, and how long it is without an answer.
pub(super) struct Believer {
    truth: SharedTruth,
    silences: Silences,
}

/// The longest time without an answer of one board.
#[derive(Debug, Clone, Default)]
pub(super) struct Silences(Arc<Mutex<SilencesInner>>);

#[derive(Debug, Default)]
struct SilencesInner {
    last_ns: Vec<Option<u64>>,
    longest_ns: u64,
}

impl Silences {
    /// Longest so far, a silence that lasts at `now_ns` included, ns.
    pub(super) fn longest_ns(&self, now_ns: u64) -> u64 {
        let inner = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let open = inner.last_ns.iter().flatten().map(|&last| now_ns.saturating_sub(last)).max();
        inner.longest_ns.max(open.unwrap_or(0))
    }

    fn answered(&self, index: usize, asked_ns: u64) {
        let mut inner = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if inner.last_ns.len() <= index {
            inner.last_ns.resize(index + 1, None);
        }
        if let Some(last) = inner.last_ns[index].replace(asked_ns) {
            inner.longest_ns = inner.longest_ns.max(asked_ns - last);
        }
    }
}

impl Believer {
    pub(super) fn new(truth: SharedTruth) -> (Self, Silences) {
        let silences = Silences::default();
        (Self { truth, silences: silences.clone() }, silences)
    }
}

impl Observer for Believer {
    fn row(&mut self, row: &Row<'_>) {
        for (index, board) in row.boards.iter().enumerate() {
            if let Some(reading) = board.fresh() {
                self.truth.lock().host_believes(index, reading.asked_ns, reading.counts);
                self.silences.answered(index, reading.asked_ns);
            }
        }
    }
}
