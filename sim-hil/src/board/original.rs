use crate::bus::{Air, BusNode, Character, Heard, Line};
use pneudrive_control::{DirPwm, ValveDrive};
use pneudrive_protocol::{Address, CHANNELS, Counts, PACKET_LEN, Packet};
use std::collections::VecDeque;

/// A board with the original's firmware, as that behaves on the bus, with its faults.
///
/// - It looks at its receive buffer once a loop of 859 us. It compares each byte and the one before
///   it with its address, and keeps nothing else: no idle gap starts a frame, and no whole frame
///   aligns the next one. So 0xFF before `FF FF` makes board 0 read its request one byte early.
/// - After its address it takes the next eight bytes, whatever they are, for four commands. It
///   waits for them for 1 ms each.
/// - It answers first, always, in the original's format. Then it looks at the commands: one above
///   1023, and all four are dropped. So a checked request is answered and dropped.
/// - It has no command timeout: set points hold for ever.
/// - Its filter (210/256 of the old value) cuts off, so that it settles up to 5 counts low, and
///   starts at 0.
/// - After power-up it vents for 2 s, and neither listens nor answers.
///
/// Source: the published firmware of the original. Versions of it forget the byte before when their
/// receive buffer is empty; this board never does, which is the worse case for a host.
#[derive(Debug)]
pub struct OriginalBoard {
    address: Address,
    position: u8,
    line: Line,
    phase_ns: u64,
    powered: bool,
    /// It has set its valves to vent after power-up.
    vents: bool,
    advanced_to_ns: u64,
    next_loop_ns: u64,
    received: VecDeque<u8>,
    last_byte_ns: u64,
    before: u8,
    /// The bytes after its address that have come so far, while it waits for all eight.
    reading: Option<Vec<u8>>,
    commands: [Counts; CHANNELS],
    pressures: [u16; CHANNELS],
    previous: [u16; CHANNELS],
    answer: VecDeque<Character>,
}

impl OriginalBoard {
    /// Time of one turn of its main loop, ns: 1164 Hz, the published rate with one board.
    pub const LOOP_NS: u64 = 859_000;
    /// How long it vents after power-up, ns.
    pub const POWER_UP_VENT_NS: u64 = 2_000_000_000;
    /// How long it waits for each of the eight bytes, ns.
    const READ_TIMEOUT_NS: u64 = 1_000_000;
    /// From the look at the buffer, or from the last byte it waited for, to its start bit, ns.
    const WRITE_NS: u64 = 4_000;
    /// Bytes that its receive buffer holds; what comes beyond them is lost. The published firmware
    /// has room for 63. Here it is a whole loop's bytes at the wire's limit, so that a host that
    /// loses no time (one in virtual time) sees the losses that a test is about, and no others.
    const RECEIVE_BUFFER: usize = 90;
    /// Bytes of the four commands.
    const COMMAND_BYTES: usize = PACKET_LEN - 2;
    const KP: i32 = 10;
    const KD: i32 = 20;
    const OLD_WEIGHT: u32 = 210;

    /// A board with this address, at this position of the rig, whose loop begins `phase_ns` after
    /// its power-up vent. At time 0 it has just been powered up.
    pub fn new(address: Address, position: u8, line: Line, phase_ns: u64) -> Self {
        Self {
            address,
            position,
            line,
            phase_ns,
            powered: true,
            vents: false,
            advanced_to_ns: 0,
            next_loop_ns: Self::POWER_UP_VENT_NS + phase_ns,
            received: VecDeque::new(),
            last_byte_ns: 0,
            before: 0,
            reading: None,
            commands: [Counts::ATMOSPHERE; CHANNELS],
            pressures: [0; CHANNELS],
            previous: [0; CHANNELS],
            answer: VecDeque::new(),
        }
    }

    /// The set points that it regulates, ADC counts.
    pub fn commands(&self) -> [Counts; CHANNELS] {
        self.commands
    }

    fn turn(&mut self, air: &mut dyn Air) {
        let now_ns = self.next_loop_ns;
        for (channel, code) in air.sample(self.position, now_ns).into_iter().enumerate() {
            // The original's converter has 10 bits, the air's codes have 12.
            let (old, sample) = (u32::from(self.pressures[channel]), u32::from(code / 4));
            self.previous[channel] = self.pressures[channel];
            self.pressures[channel] =
                ((Self::OLD_WEIGHT * old + (256 - Self::OLD_WEIGHT) * sample) / 256) as u16;
        }
        self.look(now_ns);
        let coil = std::array::from_fn(|channel| {
            let pressure = i32::from(self.pressures[channel]);
            let error = i32::from(self.commands[channel].get()) - pressure;
            let rise = pressure - i32::from(self.previous[channel]);
            let drive = ValveDrive::saturating(Self::KP * error - Self::KD * rise);
            f64::from(DirPwm::from(drive).coil()) / f64::from(DirPwm::DUTY_MAX)
        });
        air.drive(self.position, now_ns, coil);
        self.next_loop_ns += Self::LOOP_NS;
    }

    /// Takes what has been received.
    fn look(&mut self, now_ns: u64) {
        self.stop_waiting(now_ns);
        while let Some(byte) = self.received.pop_front() {
            if self.reading.is_some() {
                self.read(now_ns, byte);
            } else if u16::from_be_bytes([self.before, byte]) == self.address.word() {
                self.reading = Some(Vec::with_capacity(Self::COMMAND_BYTES));
            } else {
                self.before = byte;
            }
        }
    }

    /// Takes one of the eight bytes after its address; after the last one it answers.
    fn read(&mut self, now_ns: u64, byte: u8) {
        let Some(mut bytes) = self.reading.take() else { return };
        bytes.push(byte);
        if bytes.len() < Self::COMMAND_BYTES {
            self.reading = Some(bytes);
            return;
        }
        self.before = 0;
        self.write(now_ns + Self::WRITE_NS);
        let words = bytes.chunks_exact(2).map(|word| u16::from_be_bytes([word[0], word[1]]));
        let commands: Vec<Counts> = words.filter_map(|word| Counts::new(word).ok()).collect();
        if let Ok(commands) = commands.try_into() {
            self.commands = commands;
        }
    }

    fn write(&mut self, start_ns: u64) {
        // It writes only when its last answer has gone.
        let free_ns = self.answer.back().map_or(0, |last| last.start_ns + self.line.character_ns());
        let first_ns = start_ns.max(free_ns);
        let packet = Packet { address: self.address, values: self.pressures.map(Counts::saturating) };
        let line = self.line;
        self.answer.extend(
            (0..)
                .zip(packet.encode())
                .map(|(n, byte)| Character { start_ns: first_ns + line.characters_ns(n), byte }),
        );
    }

    /// Gives up waiting for the rest of the eight bytes, if it has waited long enough.
    fn stop_waiting(&mut self, now_ns: u64) {
        if now_ns.saturating_sub(self.last_byte_ns) >= Self::READ_TIMEOUT_NS {
            self.reading = None;
        }
    }
}

impl BusNode for OriginalBoard {
    fn address(&self) -> Address {
        self.address
    }

    fn next_event_ns(&self) -> u64 {
        if !self.powered {
            return u64::MAX;
        }
        if !self.vents {
            return self.advanced_to_ns;
        }
        let answer = self.answer.front().map_or(u64::MAX, |character| character.start_ns);
        self.next_loop_ns.min(answer).max(self.advanced_to_ns)
    }

    fn advance(&mut self, now_ns: u64, air: &mut dyn Air) {
        if !self.powered {
            return;
        }
        if !self.vents {
            self.vents = true;
            air.drive(self.position, now_ns, [-1.0; CHANNELS]);
        }
        while self.next_loop_ns <= now_ns {
            self.turn(air);
        }
        self.advanced_to_ns = now_ns;
    }

    fn transmit(&mut self) -> Option<Character> {
        self.answer.front().filter(|character| character.start_ns <= self.advanced_to_ns)?;
        self.answer.pop_front()
    }

    fn receive(&mut self, now_ns: u64, heard: Heard) {
        if !self.powered {
            return;
        }
        self.stop_waiting(now_ns);
        self.last_byte_ns = now_ns;
        // A byte that it waits for is taken at once. Its receiver does not look at framing errors.
        match self.reading {
            Some(_) => self.read(now_ns, heard.byte),
            None if self.received.len() < Self::RECEIVE_BUFFER => self.received.push_back(heard.byte),
            None => {}
        }
    }

    fn set_powered(&mut self, powered: bool, now_ns: u64, air: &mut dyn Air) {
        let fresh = Self::new(self.address, self.position, self.line, self.phase_ns);
        *self = Self {
            powered,
            vents: true,
            advanced_to_ns: now_ns,
            next_loop_ns: now_ns + Self::POWER_UP_VENT_NS + self.phase_ns,
            ..fresh
        };
        air.drive(self.position, now_ns, [-1.0; CHANNELS]);
    }
}
