//! A board with an ADS1115 and a BMI323 on its I2C connector.

use pneudrive_chip::Ticks;
use pneudrive_chip::parts::{Ads1115, Bmi323};
use pneudrive_protocol::pages::{
    Acceleration, AngularRate, Electronics, Entry, PageEntry, SensorEntry, SensorStatus, SensorTimes,
    SupplyReading,
};
use pneudrive_protocol::{Address, AnswerDecoder, Echo, Heard, PageRequest, Sequence};
use system_tests::chip_bench::{BOOT, ChipBench, DIR, packet};

pub const SUPPLY_ADDRESS: u8 = 0x48;
pub const IMU_ADDRESS: u8 = 0x68;
/// The end of RAM.
pub const STACK_TOP: u32 = 0x2004_0000;
/// What the supply has at first.
pub const PRESSURE_PA: i32 = 653_210;
/// The transducer's.
const FULL_SCALE_PA: f64 = 1_000_000.0;
/// The transducer's supply.
const SUPPLY_UV: i32 = 5_020_000;
/// An answer begins 13.6 us after its request at the earliest.
const EARLIEST: Ticks = Ticks::new(1_700);
const LATEST: Ticks = Ticks::from_micros(20);

#[derive(Clone)]
pub struct SensorBoard {
    pub bench: ChipBench,
    /// A part holds SDA that often while [`use_bus`](Self::use_bus) runs.
    pub hang_every_ms: Option<u64>,
    pressure_pa: i32,
    acceleration: [f64; 3],
    rate: [f64; 3],
    imu_at: u8,
}

impl SensorBoard {
    /// Booted, with nothing on the connector.
    pub fn without_parts() -> Self {
        let mut bench = ChipBench::power_on(0);
        bench.chip.wire_i2c(4, 5);
        bench.run(BOOT);
        Self {
            bench,
            hang_every_ms: None,
            pressure_pa: PRESSURE_PA,
            acceleration: [1.25, -2.5, 9.75],
            rate: [0.5, -1.25, 3.0],
            imu_at: IMU_ADDRESS,
        }
    }

    /// Booted with both parts.
    pub fn booted() -> Self {
        let mut bench = ChipBench::power_on(0);
        bench.chip.wire_i2c(4, 5);
        let mut board = Self { bench, ..Self::without_parts() };
        board.plug_supply();
        board.plug_imu(IMU_ADDRESS);
        board.boot();
        board
    }

    pub fn boot(&mut self) {
        self.bench.run(BOOT);
    }

    pub fn run(&mut self, time: Ticks) {
        self.bench.run(time);
    }

    /// Puts a converter on the bus that has just got its power.
    pub fn plug_supply(&mut self) {
        self.bench.chip.attach_i2c(0, SUPPLY_ADDRESS, Ads1115::new());
        self.set_pressure(self.pressure_pa);
    }

    /// Puts an IMU on the bus that has just got its power.
    pub fn plug_imu(&mut self, address: u8) {
        self.bench.chip.attach_i2c(0, address, Bmi323::new());
        self.imu_at = address;
        self.set_motion(self.acceleration, self.rate);
    }

    pub fn set_pressure(&mut self, pa: i32) {
        self.pressure_pa = pa;
        let share = 0.1 + 0.8 * f64::from(pa) / FULL_SCALE_PA;
        self.set_voltages((f64::from(SUPPLY_UV) * share).round() as i32, SUPPLY_UV);
    }

    pub fn set_voltages(&mut self, output_uv: i32, supply_uv: i32) {
        let part: Option<&mut Ads1115> = self.bench.chip.i2c_part(0, SUPPLY_ADDRESS);
        let part = part.expect("plugged");
        part.set_input_uv(0, output_uv);
        part.set_input_uv(1, supply_uv);
    }

    pub fn set_motion(&mut self, acceleration: [f64; 3], rate: [f64; 3]) {
        (self.acceleration, self.rate) = (acceleration, rate);
        let part: Option<&mut Bmi323> = self.bench.chip.i2c_part(0, self.imu_at);
        part.expect("plugged").set_motion(acceleration, rate);
    }

    /// Asks for an entry of the sensors' page.
    ///
    /// # Panics
    /// As [`ask_page`](Self::ask_page).
    pub fn ask(&mut self, entry: SensorEntry) -> (Entry, Ticks) {
        self.ask_page(PageEntry::Sensor(entry))
    }

    /// Asks for an entry; gives its words and how long the board took.
    ///
    /// # Panics
    /// If it does not answer in time, or with a pause.
    pub fn ask_page(&mut self, entry: PageEntry) -> (Entry, Ticks) {
        let request = PageRequest::new(Address::of_board(0), entry, Sequence::new(3));
        let answer = self.bench.exchange_bytes(&request.encode());
        let answer = answer.unwrap_or_else(|| panic!("{entry:?} was not answered"));
        assert!(
            (EARLIEST..=LATEST).contains(&answer.delay),
            "{entry:?}: the answer began after {} us",
            answer.delay.as_micros()
        );
        let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
        match answer.bytes().into_iter().find_map(|byte| decoder.push(byte)) {
            Some(Heard::Answer(words)) => (words, answer.delay),
            other => panic!("{entry:?}: {other:?}"),
        }
    }

    pub fn electronics(&mut self) -> Electronics {
        Electronics::from_entry(self.ask_page(PageEntry::Electronics).0).expect("electronics")
    }

    pub fn status(&mut self) -> SensorStatus {
        SensorStatus::from_entry(self.ask(SensorEntry::Status).0).expect("a status")
    }

    pub fn supply(&mut self) -> SupplyReading {
        SupplyReading::from_entry(self.ask(SensorEntry::Supply).0).expect("a reading")
    }

    pub fn times(&mut self) -> SensorTimes {
        SensorTimes::from_entry(self.ask(SensorEntry::Times).0).expect("times")
    }

    /// That the pages have what the parts measure.
    ///
    /// # Panics
    /// If not.
    pub fn assert_measures(&mut self) {
        // Half a step of 187.5 uV at both inputs, and a step of the page.
        let kpa = self.supply().live_kpa().expect("live");
        let off = kpa - f64::from(self.pressure_pa) / 1_000.0;
        assert!(off.abs() < 0.06, "{kpa} kPa instead of {} Pa", self.pressure_pa);
        let acceleration = Acceleration::from_entry(self.ask(SensorEntry::Acceleration).0);
        let rate = AngularRate::from_entry(self.ask(SensorEntry::AngularRate).0);
        let (acceleration, rate) = (acceleration.expect("an acceleration"), rate.expect("a rate"));
        // Half a step of the page, half one of the part, and 3 of 100,000.
        for (measured, is) in acceleration.m_per_s2().expect("a part").into_iter().zip(self.acceleration) {
            assert!((measured - is).abs() < 0.0075, "{measured} m/s^2 instead of {is}");
        }
        for (measured, is) in rate.rad_per_s().expect("a part").into_iter().zip(self.rate) {
            assert!((measured - is).abs() < 0.0017, "{measured} rad/s instead of {is}");
        }
    }

    /// A bus in use for `steps` ms; gives the delays of all answers, and how far the worst interval
    /// of the control loop's outputs is off 1 ms, us.
    ///
    /// # Panics
    /// If an answer is late or missing.
    pub fn use_bus(&mut self, steps: u64) -> (Vec<Ticks>, f64) {
        self.bench.chip.watch_pins(1 << DIR[0]);
        let start = self.bench.chip.now();
        let mut delays = Vec::new();
        for n in 0..steps {
            self.run(Ticks::from_micros(200 + n * 37 % 150));
            // Turns the valve round: every control step moves the DIR pin.
            let commands = if n % 2 == 0 { [900; 4] } else { [0; 4] };
            let answer = self.bench.exchange(packet(0, commands)).expect("an answer");
            assert!((EARLIEST..=LATEST).contains(&answer.delay), "{} us", answer.delay.as_micros());
            delays.push(answer.delay);
            delays.push(self.ask_page(entry(n)).1);
            if self.hang_every_ms.is_some_and(|every| n % every == 0) {
                self.bench.chip.hold_i2c_sda(0, 1 + n as u32 % 9);
            }
            self.bench.chip.run_until(start + Ticks::from_millis(n + 1));
        }
        let edges: Vec<Ticks> = self.bench.chip.take_pin_edges().into_iter().map(|edge| edge.at).collect();
        assert!(edges.len() as u64 > steps * 9 / 10, "{} edges", edges.len());
        let off = |pair: &[Ticks]| (pair[1].saturating_sub(pair[0]).as_micros() - 1_000.0).abs();
        (delays, edges.windows(2).map(off).fold(0.0, f64::max))
    }
}

/// All that boards tell of sensors and electronics, in turn.
pub fn entry(n: u64) -> PageEntry {
    let number = n as usize % (SensorEntry::ALL.len() + 1);
    SensorEntry::ALL.get(number).map_or(PageEntry::Electronics, |entry| PageEntry::Sensor(*entry))
}

pub fn print_delays(what: &str, delays: &mut [Ticks]) {
    delays.sort();
    let us = |at: usize| delays[at].as_micros();
    let last = delays.len() - 1;
    println!("{what}: {} answers begin after {:.2} to {:.2} us", delays.len(), us(0), us(last));
}
