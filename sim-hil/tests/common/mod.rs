//! What the tests share: a host in virtual time, boards that do as told, and air that holds still.
use pneudrive_protocol::{Address, Baud, CHANNELS, Counts, PACKET_LEN, Packet};
use pneudrive_sim::bus::{Air, Bus, BusNode, Character, Heard, Line};
use pneudrive_sim::fault::{FaultInjector, FaultSpec};
use pneudrive_sim::rig::RigOptions;
use std::sync::{Arc, Mutex};

pub const MS: u64 = 1_000_000;
pub const US: u64 = 1_000;
/// One character at 1 Mbaud.
pub const CHARACTER: u64 = 10 * US;

pub fn counts(value: u16) -> Counts {
    Counts::new(value).unwrap()
}

pub fn packet(board: u8, value: u16) -> Packet {
    Packet { address: Address::of_board(board), values: [counts(value); CHANNELS] }
}

/// Drives of a board and when they were set, ns.
pub type Drives = Arc<Mutex<Vec<(u8, u64, [f64; 4])>>>;

/// Sensors that always read the same code, and the drives that were set last.
#[derive(Debug, Clone, Default)]
pub struct StillAir {
    pub code: u16,
    pub drives: Drives,
}

impl Air for StillAir {
    fn sample(&mut self, _board: u8, _now_ns: u64) -> [u16; 4] {
        [self.code; 4]
    }

    fn drive(&mut self, board: u8, now_ns: u64, drives: [f64; 4]) {
        self.drives.lock().unwrap().push((board, now_ns, drives));
    }
}

/// A board that says what a test gave it to say, when it was told to, and writes down what it
/// hears.
#[derive(Debug)]
pub struct ScriptedBoard {
    address: Address,
    script: Vec<Character>,
    now_ns: u64,
    heard: Arc<Mutex<Vec<(u64, Heard)>>>,
}

impl ScriptedBoard {
    /// Says `bytes` from `start_ns` on, `spacing_ns` apart.
    pub fn new(board: u8, start_ns: u64, spacing_ns: u64, bytes: &[u8]) -> Self {
        let script =
            (0..).zip(bytes).map(|(n, &byte)| Character { start_ns: start_ns + n * spacing_ns, byte });
        Self { address: Address::of_board(board), script: script.collect(), now_ns: 0, heard: Arc::default() }
    }

    /// Pauses before the `index`-th byte.
    pub fn with_pause(mut self, index: usize, pause_ns: u64) -> Self {
        self.script[index..].iter_mut().for_each(|character| character.start_ns += pause_ns);
        self
    }

    pub fn heard(&self) -> Arc<Mutex<Vec<(u64, Heard)>>> {
        Arc::clone(&self.heard)
    }
}

impl BusNode for ScriptedBoard {
    fn address(&self) -> Address {
        self.address
    }

    fn next_event_ns(&self) -> u64 {
        self.script.first().map_or(u64::MAX, |character| character.start_ns)
    }

    fn advance(&mut self, now_ns: u64, _air: &mut dyn Air) {
        self.now_ns = now_ns;
    }

    fn transmit(&mut self) -> Option<Character> {
        self.script.first().filter(|character| character.start_ns <= self.now_ns)?;
        Some(self.script.remove(0))
    }

    fn receive(&mut self, now_ns: u64, heard: Heard) {
        self.heard.lock().unwrap().push((now_ns, heard));
    }

    fn set_powered(&mut self, _powered: bool, _now_ns: u64, _air: &mut dyn Air) {}
}

pub fn line() -> Line {
    Line::at_baud(Baud::ORIGINAL).unwrap()
}

/// A bus of scripted boards without faults.
pub fn scripted_bus(boards: Vec<ScriptedBoard>, strict: bool) -> Bus {
    faulty_scripted_bus(boards, &[], strict)
}

/// A bus of scripted boards with faults.
pub fn faulty_scripted_bus(boards: Vec<ScriptedBoard>, faults: &[&str], strict: bool) -> Bus {
    let specs: Vec<FaultSpec> = faults.iter().map(|text| text.parse().unwrap()).collect();
    let injector = FaultInjector::new(&specs, line(), boards.len(), 1).unwrap();
    let nodes = boards.into_iter().map(|board| Box::new(board) as Box<dyn BusNode + Send>).collect();
    Bus::new(line(), nodes, Box::new(StillAir { code: 410, ..StillAir::default() }), injector, strict)
}

/// Native boards with the plant, at 2 ms: each has measured its pressures, and answers.
pub fn rig(boards: usize, faults: &[&str]) -> Bus {
    let faults: Vec<FaultSpec> = faults.iter().map(|text| text.parse().unwrap()).collect();
    let strict = faults.is_empty();
    let mut bus = RigOptions { boards, faults, strict, seed: 1, ..RigOptions::default() }.build().unwrap();
    bus.run_until(2 * MS);
    bus
}

/// The host's side of one exchange in virtual time, as plain as the original's.
pub struct Host {
    pub timeout_ns: u64,
}

impl Default for Host {
    fn default() -> Self {
        Self { timeout_ns: MS }
    }
}

impl Host {
    /// Sends a request now; everything that comes back before the answer is whole or the time is
    /// up.
    pub fn exchange_bytes(&self, bus: &mut Bus, request: &[u8]) -> Vec<u8> {
        let end_ns = bus.now_ns() + self.timeout_ns;
        bus.send(bus.now_ns(), request);
        let mut heard = Vec::new();
        while heard.len() < PACKET_LEN && bus.now_ns() < end_ns {
            let next_ns = bus.next_event_ns().min(end_ns);
            bus.run_until(next_ns);
            heard.extend(std::iter::from_fn(|| bus.receive()).map(|byte| byte.byte));
        }
        heard
    }

    /// Sends a request now; the packet that comes back, if ten bytes come and are one.
    pub fn exchange(&self, bus: &mut Bus, request: Packet) -> Option<Packet> {
        let heard: [u8; PACKET_LEN] = self.exchange_bytes(bus, &request.encode()).try_into().ok()?;
        Packet::decode(&heard).ok()
    }
}

/// Everything that the host's adapter has handed over.
pub fn drain(bus: &mut Bus) -> Vec<u8> {
    std::iter::from_fn(|| bus.receive()).map(|byte| byte.byte).collect()
}
