use super::chip_parts::ChipParts;
use super::i2c_world::I2cConfig;
use super::pin_map::{BUS_UART, DIR, PRESSURE, PWM, SWITCH};
use crate::bus::{Air, BusNode, Character, Heard, Line};
use pneudrive_chip::{Chip, ElfError, Level, LineErrors, Ticks};
use pneudrive_protocol::{Address, Baud};
use std::collections::VecDeque;

/// A board with an emulated RP2040 that runs the firmware's ELF, wired as `pin_map` says.
///
/// It boots at time 0, as after power-on, and answers some 130 ms later. Its loop, its line rate
/// and its turnaround are the firmware's own.
pub struct ChipBoard {
    chip: Chip,
    address: Address,
    line: Line,
    position: u8,
    /// How far it may run ahead of what it can hear, ns.
    quantum_ns: u64,
    /// Chip time 0 in virtual time, ns: the chip's clock stands still while the board has no
    /// supply.
    origin_ns: u64,
    advanced_to_ns: u64,
    powered: bool,
    drives: [f64; 4],
    sensors: SensorWiring,
    parts: ChipParts,
    sending: VecDeque<Character>,
}

/// When the voltages at the ADC are renewed: once a control loop, just before the firmware converts
/// them, because that is what one sample of the plant stands for.
#[derive(Debug)]
struct SensorWiring {
    renew_ns: u64,
    /// The firmware's control period as seen, ns.
    period_ns: u64,
    /// When the first conversion of the last loop was seen, ns.
    loop_ns: u64,
    conversions: u64,
    converting_ns: u64,
}

/// The firmware's control period until it has been seen, ns.
const LOOP_NS: u64 = 1_000_000;
/// The longest that a board can be set to, ns.
const LONGEST_LOOP_NS: u64 = 10_000_000;
/// To which a period is rounded, because it is seen with the bus's resolution, ns.
const LOOP_STEP_NS: u64 = 50_000;
/// Before conversions begin, their voltages are renewed by so much, ns.
const RENEW_AHEAD_NS: u64 = 30_000;
/// A pause of the converter that has a new loop behind it, ns.
const CONVERTER_PAUSE_NS: u64 = 300_000;
/// One tick of the chip's time, ns.
const TICK_NS: u64 = 1_000_000_000 / Ticks::PER_SECOND;

impl ChipBoard {
    /// Positions that the two-way address switch can be set to.
    pub const POSITIONS: usize = 4;

    /// Powers a board whose address switch stands at `position`, 0 to 3, which is also its place in
    /// the rig, with these parts on its I2C connector.
    ///
    /// # Errors
    /// The file is no program for this chip.
    pub fn from_elf(elf: &[u8], position: u8, line: Line, i2c: I2cConfig) -> Result<Self, ElfError> {
        let mut chip = Chip::from_elf(elf)?;
        for (bit, pin) in SWITCH.into_iter().enumerate() {
            let closed = position >> bit & 1 == 1;
            chip.set_pin_input(pin, if closed { Level::Low } else { Level::Floating });
        }
        for pin in DIR.into_iter().chain(PWM) {
            chip.set_pin_input(pin, Level::High);
        }
        ChipParts::wire(&mut chip);
        let parts = ChipParts::new(i2c, position);
        parts.power_on(&mut chip);
        Ok(Self {
            chip,
            address: Address::of_board(position),
            line,
            position,
            quantum_ns: line.character_ns() / 2,
            origin_ns: 0,
            advanced_to_ns: 0,
            powered: true,
            drives: [f64::NAN; 4],
            sensors: SensorWiring {
                renew_ns: 0,
                period_ns: LOOP_NS,
                loop_ns: 0,
                conversions: 0,
                converting_ns: 0,
            },
            parts,
            sending: VecDeque::new(),
        })
    }

    fn ticks(&self, at_ns: u64) -> Ticks {
        Ticks::new(at_ns.saturating_sub(self.origin_ns) / TICK_NS)
    }

    fn renew_sensors(&mut self, air: &mut dyn Air) {
        let codes = air.sample(self.position, self.sensors.renew_ns);
        for (channel, code) in PRESSURE.into_iter().zip(codes) {
            self.chip.set_adc(channel, code);
        }
        self.parts.renew(&mut self.chip, self.sensors.renew_ns, air);
        self.sensors.renew_ns += self.sensors.period_ns;
    }

    /// Keeps the renewal in step with the firmware's loop.
    fn watch_converter(&mut self, now_ns: u64) {
        let count = self.chip.adc_conversions(PRESSURE[0]).count;
        if count == self.sensors.conversions {
            return;
        }
        if now_ns - self.sensors.converting_ns > CONVERTER_PAUSE_NS {
            let seen_ns = (now_ns - self.sensors.loop_ns + LOOP_STEP_NS / 2) / LOOP_STEP_NS * LOOP_STEP_NS;
            if (LOOP_STEP_NS..=LONGEST_LOOP_NS).contains(&seen_ns) {
                self.sensors.period_ns = seen_ns;
            }
            self.sensors.loop_ns = now_ns;
            self.sensors.renew_ns = now_ns + self.sensors.period_ns - RENEW_AHEAD_NS;
        }
        self.sensors.conversions = count;
        self.sensors.converting_ns = now_ns;
    }

    /// Mean voltage across each valve's coil as a share of the supply: the driver puts (not DIR) -
    /// PWM across it.
    fn coils(&self) -> [f64; 4] {
        std::array::from_fn(|valve| {
            let level = |pin| f64::from(u8::from(self.chip.pin_level(pin) == Level::High));
            let not_dir = 1.0 - level(DIR[valve]);
            let pwm = self.chip.pwm_duty(PWM[valve]).unwrap_or_else(|| level(PWM[valve]));
            (not_dir - pwm).clamp(-1.0, 1.0)
        })
    }

    fn set_drives(&mut self, now_ns: u64, air: &mut dyn Air, drives: [f64; 4]) {
        if drives != self.drives {
            self.drives = drives;
            air.drive(self.position, now_ns, drives);
        }
    }
}

impl BusNode for ChipBoard {
    fn address(&self) -> Address {
        self.address
    }

    fn baud(&self) -> Option<Baud> {
        let baud = u32::try_from(self.chip.uart_baud(BUS_UART)).ok().and_then(|rate| Baud::new(rate).ok())?;
        // What its divisors make of the rig's rate is that rate.
        let as_set = self.line.at_rate(Some(baud));
        (self.powered && !self.line.understands(&as_set)).then_some(baud)
    }

    fn set_shortest_character(&mut self, ns: u64) {
        self.quantum_ns = ns / 2;
    }

    fn next_event_ns(&self) -> u64 {
        if !self.powered {
            return u64::MAX;
        }
        let chip_ns = match self.chip.next_event() {
            Ticks::NEVER => u64::MAX,
            at => self.origin_ns + at.get() * TICK_NS,
        };
        // An event of the chip is handled late by at most the quantum, which is what it may run
        // ahead.
        chip_ns.max(self.advanced_to_ns + self.quantum_ns).min(self.sensors.renew_ns)
    }

    fn advance(&mut self, now_ns: u64, air: &mut dyn Air) {
        if !self.powered {
            return;
        }
        while self.sensors.renew_ns <= now_ns {
            self.renew_sensors(air);
        }
        self.chip.run_until(self.ticks(now_ns));
        self.advanced_to_ns = now_ns;
        self.watch_converter(now_ns);
        let origin_ns = self.origin_ns;
        self.sending.extend(
            self.chip
                .take_transmitted(BUS_UART)
                .map(|sent| Character { start_ns: origin_ns + sent.start.get() * TICK_NS, byte: sent.byte }),
        );
        self.set_drives(now_ns, air, self.coils());
    }

    fn transmit(&mut self) -> Option<Character> {
        self.sending.front().filter(|character| character.start_ns <= self.advanced_to_ns)?;
        self.sending.pop_front()
    }

    fn receive(&mut self, now_ns: u64, heard: Heard) {
        if self.powered {
            let errors = LineErrors { framing: heard.damaged, ..LineErrors::NONE };
            self.chip.uart_receive(BUS_UART, self.ticks(now_ns), heard.byte, errors);
        }
    }

    fn set_powered(&mut self, powered: bool, now_ns: u64, air: &mut dyn Air) {
        self.powered = powered;
        self.sending.clear();
        if !powered {
            self.set_drives(now_ns, air, [-1.0; 4]);
            return;
        }
        self.origin_ns = now_ns.saturating_sub(self.chip.now().get() * TICK_NS);
        self.advanced_to_ns = now_ns;
        self.sensors = SensorWiring { renew_ns: now_ns, converting_ns: now_ns, ..self.sensors };
        self.chip.power_cycle();
        self.parts.power_on(&mut self.chip);
    }
}
