//! The sensors on the I2C connector: the firmware's drivers against emulated parts.
//!
//! `cargo test -p system-tests --test firmware i2c:: -- --nocapture` prints the figures that
//! docs/firmware.md states.

mod board;
mod strangers;

use board::{IMU_ADDRESS, PRESSURE_PA, SUPPLY_ADDRESS, SensorBoard};
use pneudrive_chip::{Level, Ticks};
use pneudrive_protocol::pages::{Electronics, SensorPart, SensorState, SensorStatus, Temperature, Voltage};
use strangers::Stranger;

const MS: Ticks = Ticks::from_millis(1);
/// Between two searches for a part that is not there.
const SEARCH: Ticks = Ticks::from_millis(1_000);

const BOTH_LIVE: SensorStatus = SensorStatus {
    supply: SensorPart::Ads1115,
    supply_state: SensorState::Live,
    imu: SensorPart::Bmi323,
    imu_state: SensorState::Live,
    errors: 0,
    recoveries: 0,
};

#[test]
fn parts_are_found_at_boot_and_measure() {
    let mut board = SensorBoard::booted();
    board.run(MS * 60);
    assert_eq!(board.status(), BOTH_LIVE);
    board.assert_measures();
    // Well after a reading, so that the time that asking takes does not hold one more.
    while !(2..=4).contains(&board.times().imu_age_ms) {
        board.run(MS);
    }
    let before = board.times();
    board.run(MS * 1_000);
    let after = board.times();
    assert_eq!(after.imu_readings - before.imu_readings, 100, "every 10 ms");
    assert_eq!(after.supply_readings - before.supply_readings, 50, "every 20 ms");
    assert!(after.imu_age_ms <= 11 && after.supply_age_ms <= 21, "{after:?}");
    assert_eq!(board.status(), BOTH_LIVE);
    let unmodelled: Vec<_> = board.bench.chip.unmodelled_accesses().collect();
    assert!(unmodelled.is_empty(), "{unmodelled:?}");
}

#[test]
fn what_is_measured_changes_with_the_world() {
    let mut board = SensorBoard::booted();
    board.run(MS * 60);
    for (pa, acceleration, rate) in [
        (0, [0.0, 0.0, -9.80665], [0.0; 3]),
        (1_000_000, [39.0, -39.0, 0.5], [8.7, -8.7, 0.01]),
        (-40_000, [0.02, 0.04, 0.06], [-0.005, 0.0, 0.0025]),
    ] {
        board.set_pressure(pa);
        board.set_motion(acceleration, rate);
        board.run(MS * 45);
        board.assert_measures();
    }
}

#[test]
fn a_board_without_sensors_has_none() {
    let mut board = SensorBoard::without_parts();
    board.run(MS * 2_500);
    assert_eq!(board.status(), SensorStatus::NONE);
}

/// Degrees Celsius and V, as far as they are known.
fn told(electronics: Electronics) -> (Option<f64>, Option<f64>) {
    let Electronics { chip_temperature, rail_voltage } = electronics;
    (chip_temperature.map(Temperature::celsius), rail_voltage.map(Voltage::volts))
}

/// 16 readings of the chip's sensor, one in 64 ms; 0.706 V at 27 degrees Celsius, 1.721 mV less for
/// each degree more.
#[test]
fn the_chip_tells_its_temperature_and_the_rail() {
    let mut board = SensorBoard::booted();
    board.run(MS * 60);
    assert_eq!(told(board.electronics()), (None, Some(5.02)), "no mean so far");
    for celsius in [27.0, -20.0, 85.0] {
        let volts = 0.706 - 0.001_721 * (celsius - 27.0);
        board.bench.chip.set_adc(4, (volts / 3.3 * 4_096.0_f64).round() as u16);
        board.run(MS * 2_100);
        let (measured, rail) = told(board.electronics());
        let measured = measured.expect("a mean");
        // Half a code is 0.24 degrees, half a step of the page 0.1.
        assert!((measured - celsius).abs() < 0.35, "{measured} degrees instead of {celsius}");
        assert_eq!(rail, Some(5.02));
    }
    board.set_voltages(1_000_000, 3_210_000);
    board.run(MS * 45);
    assert_eq!(told(board.electronics()).1, Some(3.21), "too low for the transducer, and told");
    board.bench.chip.detach_i2c(0, SUPPLY_ADDRESS);
    board.run(MS * 90);
    let (celsius, rail) = told(board.electronics());
    assert!(celsius.is_some() && rail.is_none(), "{celsius:?} {rail:?}");
    let unmodelled: Vec<_> = board.bench.chip.unmodelled_accesses().collect();
    assert!(unmodelled.is_empty(), "{unmodelled:?}");
}

/// The loop that reads the temperature, too, takes its samples when the others do.
#[test]
fn the_pressures_are_sampled_in_step_whether_the_temperature_is_read_or_not() {
    let mut board = SensorBoard::without_parts();
    board.run(MS * 100);
    let (mut sampled, mut read) = (Vec::new(), 0);
    let readings = |board: &SensorBoard| board.bench.chip.adc_conversions(4).count;
    let before = readings(&board);
    for _ in 0..1_000 {
        board.run(MS);
        sampled.push(board.bench.chip.adc_conversions(0).last_sampled);
        read = readings(&board) - before;
    }
    assert!((15..=16).contains(&read), "{read} readings in a second");
    let off = |pair: &[Ticks]| (pair[1].saturating_sub(pair[0]).as_micros() - 1_000.0).abs();
    let worst_us = sampled.windows(2).map(off).fold(0.0, f64::max);
    println!("sampling with the temperature read: the worst interval is {worst_us:.2} us off");
    assert!(worst_us < 25.0, "{worst_us} us");
}

#[test]
fn an_unplugged_part_is_absent_and_a_plugged_one_is_back() {
    let mut board = SensorBoard::booted();
    board.run(MS * 500);
    let imu = board.bench.chip.detach_i2c(0, IMU_ADDRESS);
    assert!(imu.is_some());
    board.run(MS * 45);
    let status = board.status();
    assert_eq!((status.imu, status.imu_state, status.errors), (SensorPart::None, SensorState::Absent, 3));
    assert_eq!((status.supply_state, status.recoveries), (SensorState::Live, 0), "the other goes on");
    board.run(MS * 3_000);
    assert_eq!(board.status().errors, 3, "looking for a part is no error");

    // Another one, as it is after power-on.
    board.plug_imu(IMU_ADDRESS + 1);
    board.run(SEARCH + MS * 50);
    let back = board.status();
    assert_eq!((back.imu, back.imu_state, back.errors), (SensorPart::Bmi323, SensorState::Live, 3));
    board.assert_measures();

    board.bench.chip.detach_i2c(0, SUPPLY_ADDRESS);
    board.run(MS * 90);
    let status = board.status();
    assert_eq!((status.supply, status.supply_state), (SensorPart::None, SensorState::Absent));
    assert_eq!(status.imu_state, SensorState::Live);
    board.plug_supply();
    board.run(SEARCH + MS * 50);
    assert_eq!(board.status().supply_state, SensorState::Live);
    board.assert_measures();
}

/// A loose plug, for less than the time between two readings: the part answers, but measures
/// nothing.
#[test]
fn an_imu_that_lost_its_power_is_set_up_again() {
    let mut board = SensorBoard::booted();
    board.run(MS * 500);
    board.plug_imu(IMU_ADDRESS);
    board.run(MS * 50);
    assert_eq!(board.status().imu_state, SensorState::Absent, "nothing of its readings makes sense");
    board.run(SEARCH);
    assert_eq!(board.status().imu_state, SensorState::Live);
    board.assert_measures();
}

/// The converter's configuration goes along with every conversion.
#[test]
fn a_converter_that_lost_its_power_measures_on() {
    let mut board = SensorBoard::booted();
    board.run(MS * 500);
    let before = board.status();
    board.plug_supply();
    board.run(MS * 45);
    assert_eq!(board.status().supply_state, SensorState::Live);
    assert!(board.status().errors <= before.errors + 1, "at most the conversion that was going on");
    board.assert_measures();
}

#[test]
fn a_transducer_that_is_not_connected_is_out_of_range() {
    let mut board = SensorBoard::booted();
    board.run(MS * 100);
    for (output_uv, supply_uv) in [(0, 5_000_000), (5_000_000, 5_000_000), (2_500_000, 0), (0, 0)] {
        board.set_voltages(output_uv, supply_uv);
        board.run(MS * 45);
        assert_eq!(board.supply().state, SensorState::OutOfRange, "{output_uv} of {supply_uv} uV");
        assert_eq!(board.status().supply_state, SensorState::OutOfRange);
    }
    board.set_pressure(PRESSURE_PA);
    board.run(MS * 45);
    board.assert_measures();
    assert_eq!(board.status(), BOTH_LIVE, "no errors of the bus");
}

#[test]
fn other_parts_at_these_addresses_are_left_alone() {
    let mut board = SensorBoard::without_parts();
    board.bench.chip.attach_i2c(0, SUPPLY_ADDRESS, Stranger::thermometer());
    board.bench.chip.attach_i2c(0, IMU_ADDRESS, Stranger::other_imu());
    board.run(MS * 2_500);
    assert_eq!(board.status(), SensorStatus::NONE);
    let imu: Option<&mut Stranger> = board.bench.chip.i2c_part(0, IMU_ADDRESS);
    assert_eq!(imu.map(|imu| imu.written), Some(0), "nothing is written to it");
}

/// For every number of clocks that a part can need, at whatever phase of the transfers.
#[test]
fn a_hung_bus_is_freed() {
    let mut running = SensorBoard::booted();
    running.run(MS * 500);
    for clocks in 1..=9_u32 {
        let mut board = running.clone();
        board.run(Ticks::from_micros(u64::from(clocks) * 1_237));
        board.bench.chip.hold_i2c_sda(0, clocks);
        board.run(MS * 100);
        let status = board.status();
        assert_eq!(status.recoveries, 1, "{clocks} clocks: {status:?}");
        assert!(status.errors <= 2, "{clocks} clocks: {status:?}");
        assert_eq!((status.supply_state, status.imu_state), (SensorState::Live, SensorState::Live));
        board.assert_measures();
    }
}

#[test]
fn a_line_that_stays_low_makes_parts_absent_until_it_is_free() {
    for pin in [4, 5] {
        let mut board = SensorBoard::booted();
        board.run(MS * 500);
        board.bench.chip.set_pin_input(pin, Level::Low);
        board.run(MS * 3_500);
        let status = board.status();
        assert_eq!((status.supply, status.imu), (SensorPart::None, SensorPart::None), "GPIO {pin}");
        assert_eq!(status.recoveries, 0, "GPIO {pin} was not freed");
        board.bench.chip.set_pin_input(pin, Level::Floating);
        board.run(SEARCH + MS * 200);
        let status = board.status();
        assert_eq!((status.supply_state, status.imu_state), (SensorState::Live, SensorState::Live));
        board.assert_measures();
    }
}

/// The parts keep their power and do not notice: one that was sending holds the line until it is
/// clocked on.
#[test]
fn a_board_that_restarts_in_a_transfer_finds_its_parts() {
    let mut running = SensorBoard::booted();
    running.run(MS * 300);
    let mut freed = 0;
    for phase in 0..24 {
        let mut board = running.clone();
        board.run(Ticks::from_micros(313 * phase));
        board.bench.chip.power_cycle();
        board.boot();
        board.run(MS * 120);
        let status = board.status();
        assert_eq!(status.imu_state, SensorState::Live, "phase {phase}: {status:?}");
        assert_eq!(status.supply_state, SensorState::Live, "phase {phase}: {status:?}");
        board.assert_measures();
        freed += status.recoveries;
    }
    println!("{freed} of 24 restarts left SDA low");
    assert!(freed > 0, "none of the restarts hit a 0 that a part was sending");
}

/// The entries are asked for at many phases of loop, log and I2C.
#[test]
fn sensor_pages_are_answered_within_20_us() {
    let mut board = SensorBoard::booted();
    board.run(MS * 2_000);
    let mut delays = Vec::new();
    for n in 0..1_500_u64 {
        delays.push(board.ask_page(board::entry(n)).1);
        board.run(Ticks::new(n * 7 % 20_011));
    }
    board::print_delays("sensor pages", &mut delays);
}

#[test]
fn neither_answers_nor_the_loop_wait_for_the_sensors() {
    let busy = |board: &mut SensorBoard, what: &str| {
        let (mut delays, worst_us) = board.use_bus(1_500);
        board::print_delays(what, &mut delays);
        println!("{what}: the worst interval of the control loop is {worst_us:.1} us off");
        assert!(worst_us < 30.0, "{what}: jitter {worst_us} us");
    };
    let mut without = SensorBoard::without_parts();
    without.run(MS * 2_000);
    busy(&mut without, "without sensors");

    let mut board = SensorBoard::booted();
    board.run(MS * 2_000);
    let mut hung = board.clone();
    busy(&mut board, "with sensors");
    assert_eq!(board.status(), BOTH_LIVE);

    hung.bench.chip.set_pin_input(4, Level::Low);
    busy(&mut hung, "with SDA held low");
    let mut flapping = board.clone();
    flapping.hang_every_ms = Some(37);
    busy(&mut flapping, "with a bus that hangs every 37 ms");
    assert!(flapping.status().recoveries > 10, "{:?}", flapping.status());
}

/// What the sensors cost the processor, beside what it does anyway.
#[test]
fn the_sensors_take_little_of_the_processor() {
    let load = |board: &mut SensorBoard| {
        board.run(MS * 2_000);
        let (cycles, now) = (board.bench.chip.cycles(), board.bench.chip.now());
        board.run(MS * 1_000);
        let share = (board.bench.chip.cycles() - cycles) as f64 / (board.bench.chip.now() - now).get() as f64;
        100.0 * share
    };
    let without = load(&mut SensorBoard::without_parts());
    let mut board = SensorBoard::booted();
    let with = load(&mut board);
    println!("processor load on a silent bus: {without:.1} % without sensors, {with:.1} % with them");
    assert!(with - without < 5.0, "{without} % without, {with} % with sensors");
    board.hang_every_ms = Some(37);
    board.use_bus(1_000);
    let stack = board::STACK_TOP - board.bench.chip.lowest_stack_pointer();
    println!("stack with sensors, requests and a bus that hangs: {stack} bytes");
    assert!(stack < 8 * 1024, "{stack} bytes of stack");
}

/// The watchdog is fed by the thread that reads the sensors, too.
#[test]
fn a_bus_that_stands_still_causes_no_reset() {
    let mut board = SensorBoard::booted();
    board.bench.chip.set_pin_input(5, Level::Low);
    board.run(MS * 5_000);
    assert_eq!(board.bench.chip.resets().len(), 1, "one power-on, no reset by the watchdog");
}
