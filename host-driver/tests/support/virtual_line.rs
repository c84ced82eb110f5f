//! A line in virtual time: what follows each request is up to the test.

use pneudrive_host::line::{Line, LineError, OpenError};
use pneudrive_protocol::Baud;
use std::collections::VecDeque;

/// Time of a character at 1 Mbaud, ns.
pub const CHARACTER_NS: u64 = 10_000;

/// What comes back for a request: (ns after the request's first bit, bytes). The bytes follow each
/// other at 1 Mbaud.
pub type Reply = Vec<(u64, Vec<u8>)>;

/// Decides what comes back for the request with this number and these bytes.
pub type Script = Box<dyn FnMut(usize, &[u8]) -> Reply + Send>;

pub struct VirtualLine {
    now_ns: u64,
    script: Script,
    pub requests: Vec<(u64, Vec<u8>)>,
    /// When a guard byte was sent alone, and how many requests had been sent before; no script
    /// hears of them.
    pub guards: Vec<(u64, usize)>,
    /// An answer begins only when the one before has ended, as those of one board do.
    pub one_speaker: bool,
    /// The adapter returns guard bytes, ns after their first bit (what it returns of requests is
    /// the script's business).
    pub guards_echo_after_ns: Option<u64>,
    /// When each byte is complete, in order.
    coming: VecDeque<(u64, u8)>,
    /// The adapter is unplugged: everything fails.
    pub gone: bool,
    /// It is unplugged when this many requests have been sent.
    pub goes_after: Option<usize>,
    /// The adapter can be opened again.
    pub back: bool,
    /// It has a name to be opened again by.
    pub named: bool,
    /// How long the next look at the line takes longer than planned, ns: the process is stopped.
    pub stops_for_ns: u64,
    /// The adapter does every line rate, not only its own.
    pub adapter_does_all: bool,
    /// What it gives for a random number.
    pub random: u32,
}

impl std::fmt::Debug for VirtualLine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "VirtualLine at {} ns", self.now_ns)
    }
}

impl VirtualLine {
    pub fn new(script: impl FnMut(usize, &[u8]) -> Reply + Send + 'static) -> Self {
        Self {
            now_ns: 0,
            script: Box::new(script),
            requests: Vec::new(),
            guards: Vec::new(),
            one_speaker: false,
            guards_echo_after_ns: None,
            coming: VecDeque::new(),
            gone: false,
            goes_after: None,
            back: false,
            named: true,
            stops_for_ns: 0,
            adapter_does_all: false,
            random: 0,
        }
    }

    fn working(&self) -> Result<(), LineError> {
        if self.gone { Err(LineError::Gone { port: "virtual".into() }) } else { Ok(()) }
    }

    /// Bytes that nobody asked for, from `at_ns` on.
    pub fn inject(&mut self, at_ns: u64, bytes: &[u8]) {
        let ends = bytes.iter().enumerate().map(|(i, &byte)| (at_ns + (i as u64 + 1) * CHARACTER_NS, byte));
        self.coming.extend(ends);
        self.coming.make_contiguous().sort_by_key(|&(end, _)| end);
    }
}

impl Line for VirtualLine {
    fn now_ns(&self) -> u64 {
        self.now_ns
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        if self.goes_after == Some(self.requests.len()) {
            (self.gone, self.goes_after) = (true, None);
        }
        self.working()?;
        let at = self.now_ns;
        if bytes == [0] {
            self.guards.push((at, self.requests.len()));
            if let Some(after_ns) = self.guards_echo_after_ns {
                self.inject(at + after_ns, bytes);
            }
            return Ok(());
        }
        for (after, reply) in (self.script)(self.requests.len(), bytes) {
            let busy_until = self.coming.back().map_or(0, |&(end, _)| end);
            self.inject((at + after).max(if self.one_speaker { busy_until } else { 0 }), &reply);
        }
        self.requests.push((at, bytes.to_vec()));
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError> {
        self.working()?;
        let wanted = wanted.min(into.len());
        let enough = wanted.checked_sub(1).and_then(|last| self.coming.get(last)).map(|&(end, _)| end);
        let until = if wanted == 0 { self.now_ns } else { enough.unwrap_or(u64::MAX).min(deadline_ns) };
        self.now_ns = self.now_ns.max(until) + std::mem::take(&mut self.stops_for_ns);
        let mut count = 0;
        while count < into.len() && self.coming.front().is_some_and(|&(end, _)| end <= self.now_ns) {
            into[count] = self.coming.pop_front().unwrap().1;
            count += 1;
        }
        Ok(count)
    }

    fn sleep_until(&mut self, at_ns: u64) {
        self.now_ns = self.now_ns.max(at_ns);
    }

    fn change_baud(&mut self, baud: Baud) -> Result<bool, LineError> {
        Ok(self.adapter_does_all || baud == Baud::ORIGINAL)
    }

    fn random(&mut self) -> u32 {
        self.random
    }

    fn can_reopen(&self) -> bool {
        self.named
    }

    fn reopen(&mut self) -> Result<(), OpenError> {
        if !self.back {
            return Err(OpenError::NotFound { port: "virtual".into() });
        }
        (self.gone, self.back) = (false, false);
        self.coming.clear();
        Ok(())
    }
}

/// Time from a request's first bit to the answer's first bit of a board that answers at once, ns.
pub const AT_ONCE: u64 = 10 * CHARACTER_NS;
