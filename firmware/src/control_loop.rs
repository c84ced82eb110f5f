//! The control loop: samples to the board, its drives to the valves.

use crate::sensors::Sensors;
use crate::valves::Valve;
use crate::{bus, config, shared};
use embassy_time::{Duration, Ticker};
use pneudrive_control::{ChipThermometer, ControlLoop, DirPwm, Micros};

/// One control step every `period`, at absolute times.
#[embassy_executor::task]
pub async fn run(
    mut control: ControlLoop,
    period: Micros,
    mut sensors: Sensors,
    mut valves: [Valve; 4],
) -> ! {
    let mut thermometer = ChipThermometer::new();
    let mut ticker = Ticker::every(Duration::from_micros(period.get()));
    loop {
        ticker.next().await;
        let started = shared::now();
        // Without samples there is no step; if that goes on, the watchdog resets the chip.
        let Ok(samples) = sensors.sample().await else { continue };
        let orders = shared::with(|shared| shared.port.orders());
        let step = control.step(shared::now(), samples, orders);
        for (valve, drive) in valves.iter_mut().zip(step.drives) {
            valve.apply(DirPwm::from(drive));
        }
        let took = shared::now().since(started);
        shared::with(|shared| {
            shared.control = step.report.status;
            shared.port.report(step.report);
            shared.port.loop_took(took);
            shared.liveness.control_ran();
        });
        bus::look_after_line_rate();
        // After the valves, while the converter has nothing else to do: the step that needs it is a
        // period away.
        if step.report.status.steps.is_multiple_of(config::TEMPERATURE_EVERY_STEPS)
            && let Ok(code) = sensors.chip_temperature()
            && let Some(temperature) = thermometer.reading(code)
        {
            shared::with(|shared| shared.port.sensors().chip_read(temperature));
        }
    }
}
