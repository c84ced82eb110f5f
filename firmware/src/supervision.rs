//! Watchdog, status LED, log.

use crate::{bus, shared};
use embassy_rp::Peri;
use embassy_rp::gpio::Output;
use embassy_rp::peripherals::WATCHDOG;
use embassy_rp::watchdog::Watchdog;
use embassy_time::{Duration, Ticker};

/// Five missed checks reset the chip, and its pull-ups vent the valves.
const WATCHDOG_TIMEOUT: Duration = Duration::from_millis(50);
const CHECK_PERIOD: Duration = Duration::from_millis(10);
const CHECKS_PER_REPORT: u8 = 100;

/// Starts the watchdog; from here on something must feed it.
pub fn start_watchdog(watchdog: Peri<'static, WATCHDOG>) -> Watchdog {
    let mut watchdog = Watchdog::new(watchdog);
    if watchdog.reset_reason().is_some() {
        defmt::error!("reset by the watchdog");
    }
    watchdog.start(WATCHDOG_TIMEOUT);
    watchdog
}

/// Feeds the watchdog if control loop and bus responder have both run since the last check.
#[embassy_executor::task]
pub async fn run(mut watchdog: Watchdog, mut led: Output<'static>) -> ! {
    let mut ticker = Ticker::every(CHECK_PERIOD);
    loop {
        for _ in 0..CHECKS_PER_REPORT {
            ticker.next().await;
            bus::ask_for_a_sign_of_life();
            if shared::with(|shared| shared.liveness.all_since_last_asked()) {
                watchdog.feed(WATCHDOG_TIMEOUT);
            }
            let status = shared::with(|shared| shared.status());
            led.set_level(status.led_is_on(shared::now()).into());
        }
        report();
    }
}

/// Several short lines: a line is written in one critical section, which an answer may have to wait for.
fn report() {
    let status = shared::with(|shared| shared.status());
    defmt::info!("{}", status.state);
    defmt::info!("channels {}", status.channels);
    defmt::info!("commands {}", status.commands.map(u16::from));
    defmt::info!("pressures {}", status.pressures.map(u16::from));
    let counters = status.counters;
    defmt::info!("requests {=u32}, answers {=u32}", counters.requests, counters.answers);
    defmt::info!(
        "line errors {=u32}, discarded {=u32}",
        counters.line_errors,
        counters.frames.discarded_bytes
    );
    defmt::info!("steps {=u32}, late {=u32}", counters.steps, counters.late_steps);
    defmt::info!("timeouts {=u32}, sensor faults {=u32}", counters.command_timeouts, counters.sensor_faults);
}
