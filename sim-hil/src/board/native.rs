use super::Turnaround;
use super::i2c_parts::I2cParts;
use super::i2c_world::I2cConfig;
use super::memory_flash::MemoryFlash;
use crate::bus::{Air, BusNode, Character, Heard, Line};
use pneudrive_control::{
    AdcSample, Board, BoardConfig, BoardStart, BoardStatus, ConfigError, DirPwm, Identity, Micros,
};
use pneudrive_protocol::pages::ChipKind;
use pneudrive_protocol::{Address, Baud};
use std::collections::VecDeque;

/// A board that runs the control crate natively, with its own loop and its own clock.
///
/// Parameters that a host changes are kept as long as the simulator runs. It reads its four sensors
/// once a loop, at the beginning; the drives that the control step computes act at once, with the
/// resolution of the PWM. Its clock counts microseconds since its own power-up, as the chip's does.
#[derive(Debug)]
pub struct NativeBoard {
    board: Board,
    config: NativeBoardConfig,
    /// Where its address switch stands.
    switch: Address,
    flash: MemoryFlash,
    parts: I2cParts,
    start: BoardStart,
    position: u8,
    line: Line,
    /// `None` while it has no supply.
    powered_since_ns: Option<u64>,
    advanced_to_ns: u64,
    next_step_ns: u64,
    last_heard_ns: u64,
    idle_told: bool,
    answer: VecDeque<Character>,
    /// When the last stop bit of the answer under way ends, ns.
    answer_ends_ns: Option<u64>,
}

/// What an erase and a program of flash take on the chip.
const FLASH_NS: u64 = 45_400_000;

/// How a native board behaves beyond what the control crate decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NativeBoardConfig {
    /// The control crate's configuration; its loop period is the board's.
    pub control: BoardConfig,
    /// When answers begin. Default: as the firmware.
    pub turnaround: Turnaround,
    /// First control step after time 0, ns; boards are not in step with each other. Default 0.
    pub phase_ns: u64,
    /// From power-up to the first control step, ns. Default 128 ms, the RP2040's crystal and boot
    /// delay. It does not apply at time 0: the rig has been on for a while.
    pub boot_ns: u64,
    /// What is on its I2C connector.
    pub i2c: I2cConfig,
}

impl Default for NativeBoardConfig {
    fn default() -> Self {
        Self {
            control: BoardConfig::default(),
            turnaround: Turnaround::FIRMWARE,
            phase_ns: 0,
            boot_ns: 128_000_000,
            i2c: I2cConfig::default(),
        }
    }
}

impl NativeBoard {
    /// A board with this address, at this position of the rig (which four channels of the air it
    /// has).
    ///
    /// # Errors
    /// A control parameter outside its limits.
    pub fn new(
        config: NativeBoardConfig,
        address: Address,
        position: u8,
        line: Line,
    ) -> Result<Self, ConfigError> {
        let flash = MemoryFlash::new();
        let mut parts = I2cParts::new(config.i2c, position);
        let mut board = Board::new(config.control, address)?;
        parts.found_by(board.port().sensors());
        Ok(Self {
            board,
            parts,
            config,
            switch: address,
            start: BoardStart::load(&flash, config.control, address),
            flash,
            position,
            line,
            powered_since_ns: Some(0),
            advanced_to_ns: 0,
            next_step_ns: config.phase_ns,
            last_heard_ns: 0,
            idle_told: true,
            answer: VecDeque::new(),
            answer_ends_ns: None,
        })
    }

    /// The control crate's view of the board.
    pub fn status(&self) -> BoardStatus {
        self.board.status()
    }

    fn clock(&self, now_ns: u64) -> Option<Micros> {
        self.powered_since_ns.map(|since| Micros::new(now_ns.saturating_sub(since) / 1_000))
    }

    fn idle_at_ns(&self) -> u64 {
        self.last_heard_ns + self.line.at_rate(self.baud()).idle_gap_ns()
    }

    /// The answer has been sent, if one was.
    fn end_answer(&mut self, now_ns: u64) {
        let Some(ends_ns) = self.answer_ends_ns.take_if(|ends_ns| *ends_ns <= now_ns) else { return };
        if let Some(clock) = self.clock(ends_ns) {
            // What the rate is now, the port tells.
            let _ = self.board.port().answer_sent(clock);
        }
    }

    fn control_step(&mut self, air: &mut dyn Air) {
        let step_ns = self.next_step_ns;
        let Some(clock) = self.clock(step_ns) else { return };
        let samples = air.sample(self.position, step_ns).map(AdcSample::from_reading);
        let drives = self.board.control_step(clock, samples);
        let coil = drives.map(|drive| f64::from(DirPwm::from(drive).coil()) / f64::from(DirPwm::DUTY_MAX));
        air.drive(self.position, step_ns, coil);
        self.parts.read(step_ns, clock, air, self.board.port().sensors());
        self.next_step_ns += self.start.config().loop_period.get() * 1_000;
        if self.answer_ends_ns.is_none() {
            let _ = self.board.port().line_rate_due(clock);
        }
        self.obey_commit(step_ns, air);
    }

    /// Keeps what a host has committed, and restarts with it; or says why not.
    fn obey_commit(&mut self, now_ns: u64, air: &mut dyn Air) {
        let Some(set) = self.board.port().take_commit() else { return };
        match self.start.check(&set) {
            Err(refusal) => self.board.port().end_commit(refusal),
            Ok(()) => {
                // As on the chip, a flash that fails shows in the record's number after the
                // restart.
                let _ = self.start.keep(&mut self.flash, &set);
                self.set_powered(false, now_ns, air);
                self.set_powered(true, now_ns + FLASH_NS, air);
            }
        }
    }
}

impl BusNode for NativeBoard {
    fn address(&self) -> Address {
        self.start.address()
    }

    fn baud(&self) -> Option<Baud> {
        Some(self.board.baud()).filter(|baud| *baud != self.start.config().baud)
    }

    fn next_event_ns(&self) -> u64 {
        if self.powered_since_ns.is_none() {
            return u64::MAX;
        }
        let idle = if self.idle_told { u64::MAX } else { self.idle_at_ns() };
        let answer = self.answer.front().map_or(u64::MAX, |character| character.start_ns);
        let ends = self.answer_ends_ns.unwrap_or(u64::MAX);
        self.next_step_ns.min(idle).min(answer).min(ends)
    }

    fn advance(&mut self, now_ns: u64, air: &mut dyn Air) {
        if self.powered_since_ns.is_none() {
            return;
        }
        self.end_answer(now_ns);
        while self.next_step_ns <= now_ns {
            self.control_step(air);
        }
        if !self.idle_told && self.idle_at_ns() <= now_ns {
            self.idle_told = true;
            if let Some(clock) = self.clock(self.idle_at_ns()) {
                self.board.line_idle(clock);
            }
        }
        self.advanced_to_ns = now_ns;
    }

    fn transmit(&mut self) -> Option<Character> {
        self.answer.front().filter(|character| character.start_ns <= self.advanced_to_ns)?;
        self.answer.pop_front()
    }

    fn receive(&mut self, now_ns: u64, heard: Heard) {
        let Some(clock) = self.clock(now_ns) else { return };
        self.last_heard_ns = now_ns;
        self.idle_told = false;
        if heard.damaged {
            self.board.line_error(clock);
            return;
        }
        let Some(answer) = self.board.receive_byte(clock, heard.byte) else { return };
        let first_ns = self.config.turnaround.answer_start_ns(now_ns);
        let line = self.line.at_rate(self.baud());
        self.answer_ends_ns = Some(first_ns + line.characters_ns(answer.len() as u64));
        self.answer.extend(
            (0..).zip(answer).map(|(n, byte)| Character { start_ns: first_ns + line.characters_ns(n), byte }),
        );
    }

    fn set_powered(&mut self, powered: bool, now_ns: u64, air: &mut dyn Air) {
        self.answer.clear();
        self.answer_ends_ns = None;
        if !powered {
            self.powered_since_ns = None;
            air.drive(self.position, now_ns, [-1.0; 4]);
            return;
        }
        self.powered_since_ns = Some(now_ns);
        self.next_step_ns = now_ns + self.config.boot_ns;
        self.idle_told = true;
        self.start = BoardStart::load(&self.flash, self.config.control, self.switch);
        // Its configuration was accepted once, or when it was loaded.
        if let Ok(mut board) = Board::new(*self.start.config(), self.start.address()) {
            self.start.tell(board.port());
            self.parts.found_by(board.port().sensors());
            // Its clock starts anew, and its sessions' numbers do not.
            let session_seed = (now_ns / 1_000) as u32;
            board.identify(Identity { session_seed, ..Identity::of_chip(ChipKind::Native) });
            self.board = board;
        }
    }
}
