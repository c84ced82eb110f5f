use super::adapter::AdapterFault;
use super::episode::{EpisodeFault, Turn};
use super::kind::RateUnit;
use super::{FaultError, FaultSpec, Path};
use crate::bus::{BusCounters, Character, Line, Talker};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// All faults of a bus. One without any lets everything pass.
#[derive(Debug)]
pub struct FaultInjector {
    adapter: Vec<AdapterFault>,
    echo: Vec<AdapterFault>,
    episodes: Vec<EpisodeFault>,
    echoing: bool,
}

/// How a character leaves the host's adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Passage {
    /// 0 lost, 1 as it should be, 2 or more repeated.
    pub copies: u32,
    /// The data bits.
    pub byte: u8,
    /// How long the adapter holds it back, ns.
    pub hold_ns: u64,
}

/// Something that happens to the board at this position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "every variant has the board's position and nothing else")]
pub enum LineEvent {
    /// It comes off the bus.
    Unplugged { board: usize },
    /// It is back on the bus.
    Replugged { board: usize },
    /// It begins to send without end.
    BabbleBegins { board: usize },
    /// It stops.
    BabbleEnds { board: usize },
    /// Its supply fails.
    PowerOff { board: usize },
    /// Its supply is back.
    PowerOn { board: usize },
}

impl LineEvent {
    /// Position of the board.
    pub const fn board(self) -> usize {
        match self {
            Self::Unplugged { board }
            | Self::Replugged { board }
            | Self::BabbleBegins { board }
            | Self::BabbleEnds { board }
            | Self::PowerOff { board }
            | Self::PowerOn { board } => board,
        }
    }
}

impl FaultInjector {
    /// The given faults on a line with `boards` boards. Equal seeds give equal faults for equal
    /// traffic.
    ///
    /// # Errors
    /// A fault of a board that is not there.
    pub fn new(specs: &[FaultSpec], line: Line, boards: usize, seed: u64) -> Result<Self, FaultError> {
        let mut injector =
            Self { adapter: Vec::new(), echo: Vec::new(), episodes: Vec::new(), echoing: false };
        for (stream, spec) in (0..).zip(specs) {
            if let Some(board) = spec.board.filter(|&board| board >= boards) {
                return Err(FaultError::NoSuchBoard { kind: spec.kind, board, boards });
            }
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream);
            let spec = spec.clone();
            match spec.kind.rate_unit() {
                RateUnit::Character => injector.adapter.push(AdapterFault::new(spec, rng)),
                RateUnit::Request => injector.echo.push(AdapterFault::new(spec, rng)),
                RateUnit::Second => injector.episodes.push(EpisodeFault::new(spec, rng, line, boards)),
            }
        }
        Ok(injector)
    }

    /// An adapter, a pair and boards without fault.
    pub fn none() -> Self {
        Self { adapter: Vec::new(), echo: Vec::new(), episodes: Vec::new(), echoing: false }
    }

    pub(crate) fn host_to_wire(&mut self, now_ns: u64, byte: u8, counters: &mut BusCounters) -> Passage {
        self.pass(Path::Requests, now_ns, byte, counters)
    }

    pub(crate) fn wire_to_host(&mut self, now_ns: u64, byte: u8, counters: &mut BusCounters) -> Passage {
        self.pass(Path::Answers, now_ns, byte, counters)
    }

    fn pass(&mut self, path: Path, now_ns: u64, byte: u8, counters: &mut BusCounters) -> Passage {
        let mut passage = Passage { copies: 1, byte, hold_ns: 0 };
        for fault in &mut self.adapter {
            fault.pass(path, now_ns, &mut passage, counters);
        }
        passage
    }

    /// The host begins a character; the first of a run decides whether the run is echoed.
    pub(crate) fn host_begins(&mut self, now_ns: u64, opens_run: bool) {
        if opens_run {
            self.echoing = false;
            for fault in &mut self.echo {
                self.echoing |= fault.strikes(now_ns);
            }
        }
    }

    /// Whether the host's character that ends now comes back to it.
    pub(crate) fn echoes(&mut self, counters: &mut BusCounters) -> bool {
        if self.echoing {
            counters.count_fault(super::FaultKind::Echo.name());
        }
        self.echoing
    }

    pub(crate) fn next_event_ns(&self) -> Option<u64> {
        self.episodes.iter().filter_map(EpisodeFault::next_event_ns).min()
    }

    /// The next thing that happens to a board by `now_ns`.
    pub(crate) fn take_event(&mut self, now_ns: u64, counters: &mut BusCounters) -> Option<LineEvent> {
        for fault in &mut self.episodes {
            while let Some(Turn { begins, event }) = fault.turn(now_ns) {
                if begins {
                    counters.count_fault(fault.name());
                }
                if event.is_some() {
                    return event;
                }
            }
        }
        None
    }

    /// The next character of noise or babble by `now_ns`.
    pub(crate) fn take_character(&mut self, now_ns: u64) -> Option<(Talker, Character)> {
        self.episodes.iter_mut().find_map(|fault| fault.character(now_ns))
    }
}
