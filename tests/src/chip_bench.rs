//! One emulated chip on the bench: its pins wired as a board wires them, and a bus at 1 Mbaud or
//! another rate.

use crate::firmware;
use pneudrive_chip::{Chip, Level, LineErrors, Ticks, Transmitted};
use pneudrive_protocol::{Address, Baud, CHANNELS, Counts, PACKET_LEN, Packet};

/// UART of the bus.
pub const BUS: usize = 0;
/// DIR pins of valves 0 to 3 (firmware/src/pins.rs).
pub const DIR: [usize; CHANNELS] = [7, 9, 11, 13];
/// PWM pins of valves 0 to 3.
pub const PWM: [usize; CHANNELS] = [6, 8, 10, 12];
/// Driver enable pin.
pub const DRIVER_ENABLE: usize = 2;
/// Address switch, first and second.
pub const SWITCH: [usize; 2] = [14, 15];
/// Status LED.
pub const LED: usize = 25;
/// Time of a character at 1 Mbaud.
pub const CHARACTER: Ticks = Ticks::from_micros(10);
/// More than the time from power-on to the first control step, which is the crystal's start-up
/// delay and little more.
pub const BOOT: Ticks = Ticks::from_millis(140);
/// All coils driven to vent.
pub const VENT: [f64; CHANNELS] = [-1.0; CHANNELS];
/// All coils driven to fill.
pub const FILL: [f64; CHANNELS] = [1.0; CHANNELS];

/// A chip that runs the firmware. A clone goes on from the same state.
#[derive(Clone)]
pub struct ChipBench {
    /// The chip.
    pub chip: Chip,
    /// The rate of whoever else is on the bus.
    pub baud: Baud,
    line_free_at: Ticks,
}

/// An answer as it stood on the wire.
#[derive(Debug, Clone)]
pub struct Answer {
    /// From the request's last stop bit to the answer's first start bit.
    pub delay: Ticks,
    /// Its characters.
    pub characters: Vec<Transmitted>,
}

impl Answer {
    /// Its ten bytes.
    ///
    /// # Panics
    /// If there are more or fewer.
    pub fn bytes(&self) -> [u8; PACKET_LEN] {
        let bytes: Vec<u8> = self.characters.iter().map(|character| character.byte).collect();
        bytes.try_into().unwrap_or_else(|bytes| panic!("not ten bytes: {bytes:02X?}"))
    }

    /// It as an unchecked packet.
    ///
    /// # Panics
    /// If it is none.
    pub fn packet(&self) -> Packet {
        let bytes = self.bytes();
        Packet::decode(&bytes).unwrap_or_else(|error| panic!("{bytes:02X?}: {error}"))
    }
}

/// A packet to or from board `board`.
///
/// # Panics
/// If a value is above 1023.
pub fn packet(board: u8, values: [u16; CHANNELS]) -> Packet {
    let values = values.map(|value| Counts::new(value).unwrap_or_else(|error| panic!("{error}")));
    Packet { address: Address::of_board(board), values }
}

impl ChipBench {
    /// Power on, with the switch at this address and atmosphere in all chambers.
    ///
    /// # Panics
    /// If the firmware does not build or is no program for this chip.
    pub fn power_on(board: u8) -> Self {
        Self::power_on_with(firmware::elf(), board)
    }

    /// The same with another program.
    ///
    /// # Panics
    /// If it is no program for this chip.
    pub fn power_on_with(elf: &[u8], board: u8) -> Self {
        Self::on_board(Chip::from_elf(elf).unwrap_or_else(|error| panic!("{error}")), board)
    }

    /// The same with a chip whose flash has been written already.
    pub fn on_board(mut chip: Chip, board: u8) -> Self {
        for (bit, pin) in SWITCH.into_iter().enumerate() {
            if board >> bit & 1 == 1 {
                chip.set_pin_input(pin, Level::Low);
            }
        }
        // The board's pull-ups. A pin that the chip drives is not affected.
        for pin in DIR.into_iter().chain(PWM) {
            chip.set_pin_input(pin, Level::High);
        }
        let mut bench = Self { chip, baud: Baud::ORIGINAL, line_free_at: Ticks::ZERO };
        bench.read([102; CHANNELS]);
        bench
    }

    /// The same, after its boot.
    ///
    /// # Panics
    /// As [`power_on`](Self::power_on).
    pub fn booted(board: u8) -> Self {
        let mut bench = Self::power_on(board);
        bench.run(BOOT);
        bench
    }

    /// The same, after its power-up vent.
    ///
    /// # Panics
    /// As [`power_on`](Self::power_on).
    pub fn running(board: u8) -> Self {
        let mut bench = Self::booted(board);
        bench.run(Ticks::from_millis(2_000));
        bench
    }

    /// Board 0 filling all four chambers, 5 ms after a request was answered.
    ///
    /// # Panics
    /// As [`power_on`](Self::power_on), and when the firmware does not answer or does not fill.
    pub fn filling() -> Self {
        let mut bench = Self::running(0);
        assert!(bench.exchange(packet(0, [500; CHANNELS])).is_some());
        bench.run(Ticks::from_millis(5));
        assert_eq!(bench.coils(), FILL);
        bench
    }

    /// Lets time pass.
    pub fn run(&mut self, time: Ticks) {
        self.chip.run_until(self.chip.now() + time);
    }

    /// What the sensors read from now on, counts of the bus.
    pub fn read(&mut self, counts: [u16; CHANNELS]) {
        for (channel, counts) in counts.into_iter().enumerate() {
            self.chip.set_adc(channel, 4 * counts);
        }
    }

    /// Somebody sends these bytes back to back; gives the time of the last stop bit.
    pub fn send(&mut self, bytes: &[u8]) -> Ticks {
        let start = self.line_free_at.max(self.chip.now());
        let mut end = start;
        for (count, byte) in (1..).zip(bytes) {
            end = start + Ticks::new(self.baud.characters_ns(count) * Ticks::PER_SECOND / 1_000_000_000);
            self.chip.uart_receive(BUS, end, *byte, LineErrors::NONE);
        }
        self.line_free_at = end;
        end
    }

    /// Sends a request, gives the board 150 us, and returns what it said.
    ///
    /// # Panics
    /// If the board speaks before it was asked.
    pub fn exchange(&mut self, request: Packet) -> Option<Answer> {
        self.exchange_bytes(&request.encode())
    }

    /// The same with any bytes.
    ///
    /// # Panics
    /// As [`exchange`](Self::exchange).
    pub fn exchange_bytes(&mut self, request: &[u8]) -> Option<Answer> {
        let _ = self.chip.take_transmitted(BUS).count();
        let request_end = self.send(request);
        self.chip.run_until(request_end + Ticks::from_micros(150));
        let characters: Vec<Transmitted> = self.chip.take_transmitted(BUS).collect();
        let first = characters.first()?;
        assert!(first.start >= request_end, "the board spoke before it was asked");
        Some(Answer { delay: first.start.saturating_sub(request_end), characters })
    }

    /// Lets time pass until `seen`, looked at every 8 ns; gives how long it took.
    ///
    /// # Panics
    /// If it is not seen within `limit`.
    pub fn run_until_seen(&mut self, limit: Ticks, mut seen: impl FnMut(&Self) -> bool) -> Ticks {
        let start = self.chip.now();
        while !seen(self) {
            let passed = self.chip.now().saturating_sub(start);
            assert!(passed < limit, "not seen within {} us", limit.as_micros());
            // Nothing changes before the chip's next event.
            let next = self.chip.next_event().min(start + limit).max(self.chip.now() + Ticks::new(1));
            self.chip.run_until(next);
        }
        self.chip.now().saturating_sub(start)
    }

    /// Whether both pins of every valve are driven high: vent, whatever the pull-ups do.
    pub fn drives_vent(&self) -> bool {
        let high = |pin: &usize| {
            self.chip.pin_output(*pin) == Level::High
                && self.chip.pwm_duty(*pin).is_none_or(|duty| duty == 1.0)
        };
        DIR.iter().chain(&PWM).all(high)
    }

    /// Voltage across the four coils as a share of the supply: 1 fills fully, -1 vents fully.
    pub fn coils(&self) -> [f64; CHANNELS] {
        std::array::from_fn(|valve| {
            let high = |pin| self.chip.pin_level(pin) == Level::High;
            let pwm = self.chip.pwm_duty(PWM[valve]).unwrap_or(f64::from(u8::from(high(PWM[valve]))));
            if high(DIR[valve]) { -pwm } else { 1.0 - pwm }
        })
    }
}

/// Prints how long answers took to begin, as docs/firmware.md states it.
pub fn print_delays(name: &str, delays: &mut [Ticks]) {
    delays.sort();
    let at = |part: usize| delays[(delays.len() - 1) * part / 1_000].as_micros();
    println!(
        "{name}: from stop bit to start bit {:.2} us at least, {:.2} median, {:.2} 99th percentile, {:.2} at most",
        at(0),
        at(500),
        at(990),
        at(1_000)
    );
}
