//! Watchdog, status LED, log.

use crate::parameters::Parameters;
use crate::updates::Updates;
use crate::{bus, post_mortem, shared};
use embassy_rp::Peri;
use embassy_rp::gpio::Output;
use embassy_rp::peripherals::WATCHDOG;
use embassy_rp::watchdog::Watchdog;
use embassy_time::{Duration, Ticker};
use pneudrive_protocol::pages::StopCause;

/// Five missed checks reset the chip, and its pull-ups vent the valves.
const WATCHDOG_TIMEOUT: Duration = Duration::from_millis(50);
const CHECK_PERIOD: Duration = Duration::from_millis(10);
const CHECKS_PER_REPORT: u8 = 100;

/// Starts the watchdog; from here on something must feed it.
pub fn start_watchdog(watchdog: Peri<'static, WATCHDOG>) -> Watchdog {
    let mut watchdog = Watchdog::new(watchdog);
    post_mortem::report(watchdog.reset_reason());
    watchdog.start(WATCHDOG_TIMEOUT);
    watchdog
}

/// Feeds the watchdog if control loop and bus responder have both run since the last check;
/// restarts with other parameters when a host has committed them, and with another program when one
/// has brought it.
#[embassy_executor::task]
pub async fn run(
    mut watchdog: Watchdog,
    mut led: Output<'static>,
    mut parameters: Parameters,
    mut updates: Updates,
) -> ! {
    let mut ticker = Ticker::every(CHECK_PERIOD);
    loop {
        for _ in 0..CHECKS_PER_REPORT {
            ticker.next().await;
            bus::ask_for_a_sign_of_life();
            let ran = shared::with(|shared| shared.liveness.take());
            post_mortem::keep(StopCause::LastCheck {
                control_ran: ran.control_has_run(),
                bus_ran: ran.bus_has_run(),
            });
            if ran.all() {
                watchdog.feed(WATCHDOG_TIMEOUT);
            }
            let status = shared::with(|shared| shared.status());
            led.set_level(status.led_is_on(shared::now()).into());
            parameters.obey(&mut watchdog).await;
            updates.obey(&mut watchdog).await;
        }
        report();
    }
}

/// Many short lines: while one is written, which takes about 0.3 us a byte, the control loop waits.
fn report() {
    let status = shared::with(|shared| shared.status());
    defmt::info!("{}", status.state);
    for (n, channel) in (0_u8..).zip(status.channels) {
        defmt::info!("{=u8} {}", n, channel);
    }
    for (n, command) in (0_u8..).zip(status.commands) {
        defmt::info!("{=u8} command {=u16}", n, command.get());
    }
    for (n, pressure) in (0_u8..).zip(status.pressures) {
        defmt::info!("{=u8} pressure {=u16}", n, pressure.get());
    }
    let counters = status.counters;
    defmt::info!("requests {=u32}", counters.requests);
    defmt::info!("answers {=u32}", counters.answers);
    defmt::info!("page requests {=u32}", counters.page_requests);
    defmt::info!("line errors {=u32}", counters.line_errors);
    defmt::info!("discarded bytes {=u32}", counters.frames.discarded_bytes);
    defmt::info!("steps {=u32}", counters.steps);
    defmt::info!("late steps {=u32}", counters.late_steps);
    defmt::info!("command timeouts {=u32}", counters.command_timeouts);
    defmt::info!("sensor faults {=u32}", counters.sensor_faults);
}
