//! A PneuDrive board: Embassy on the RP2040 (or RP2350).
//!
//! All behaviour is in `pneudrive-control`. What is here moves bytes, samples and duties, at these
//! priorities:
//!
//! | priority | what | when |
//! | --- | --- | --- |
//! | P0 | [`bus`]: bytes to the board, its answers to the wire | every byte heard; every answer |
//! | P1 | Embassy's timer and DMA interrupts | |
//! | P2 | [`control_loop`]: samples to the board, its drives to the valves | every loop period |
//! | P3 | Embassy's I2C interrupt: wakes [`i2c`] | up to twice a transfer |
//! | thread | [`supervision`]: watchdog, LED, log | every 10 ms |
//! | thread | [`i2c`]: the sensors on the I2C connector | every 10 ms |
//!
//! All code runs from RAM (`program.x`, `ram.x`) but what starts it and what first handles a
//! HardFault, so that no cache decides how long something takes. Nothing makes the bus wait for
//! more than about a microsecond: critical sections leave its interrupts alone ([`masking`]), and
//! what it shares with the control loop is little ([`shared`]). What the two chips do not have in
//! common is in [`chip`]. `docs/firmware.md` has the pin map, the wiring, and what was measured.
//!
//! A library, so that tests on the chip (`tests/on_target.rs`) can call its parts. The program
//! itself (`main.rs`) adds what there can be one of: `main`, the panic handler and that of the
//! HardFault.
#![no_std]

pub mod bus;
pub mod chip;
pub mod config;
pub mod control_loop;
pub mod i2c;
#[cfg(feature = "rp2040")]
pub mod inbox;
mod masking;
pub mod parameters;
pub mod pins;
pub mod post_mortem;
pub mod safe_state;
pub mod sensors;
pub mod shared;
pub mod supervision;
pub mod updates;
pub mod valves;
#[cfg(feature = "rp2350")]
mod vectors;

use defmt_rtt as _;
use embassy_executor::{InterruptExecutor, Spawner};
use embassy_rp::Peripherals;
use embassy_rp::clocks::RoscRng;
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use pneudrive_control::{Board, Identity};

/// Runs the control loop above everything but the interrupts.
static CONTROL_EXECUTOR: InterruptExecutor = InterruptExecutor::new();

/// Chip and clocks ready, and all valve pins at vent.
///
/// # Safety
/// Called once, before anything has enabled an interrupt.
pub unsafe fn start() -> Peripherals {
    // SAFETY: the caller's promise.
    #[cfg(feature = "rp2350")]
    unsafe {
        vectors::move_to_ram();
    }
    chip::wait_for_crystal();
    // Resets the pins and lets them go for a moment, in which the board's pull-ups vent the valves.
    let peripherals = embassy_rp::init(embassy_rp::config::Config::default());
    safe_state::enter();
    peripherals
}

/// The whole board, for ever. Called once.
pub async fn run(spawner: Spawner) {
    // SAFETY: nothing has enabled an interrupt yet.
    let hardware = pins::Hardware::split(unsafe { start() });
    let watchdog = supervision::start_watchdog(hardware.watchdog);

    let parameters = parameters::Parameters::load(hardware.flash, hardware.switch.read().await);
    let updates = updates::Updates::at_start();
    let (mut config, address) = (*parameters.start().config(), parameters.start().address());
    config.power_up_vent = config.power_up_vent.max(updates.vent());
    // Checked when it compiled (config.rs), and with what flash keeps when that was loaded.
    let Ok(board) = Board::new(config, address) else { defmt::unreachable!() };
    let (mut port, control) = board.split();
    port.identify(Identity {
        watchdog_resets: post_mortem::watchdog_resets(),
        post_mortem: post_mortem::last(),
        // The ring oscillator's jitter: other numbers after each reset.
        session_seed: RoscRng.next_u32(),
        ..Identity::of_chip(chip::KIND)
    });
    parameters.start().tell(&mut port);
    updates.tell(&mut port);
    shared::install(port, control.status());
    defmt::info!("board {=u8}", address.board());

    let sensors = sensors::Sensors::new(hardware.sensors);
    bus::start(hardware.bus, &config);

    chip::EMBASSY_TIMER_IRQ.set_priority(Priority::P1);
    interrupt::DMA_IRQ_0.set_priority(Priority::P1);
    interrupt::SWI_IRQ_0.set_priority(Priority::P2);
    let control_spawner = CONTROL_EXECUTOR.start(interrupt::SWI_IRQ_0);

    // A task can be spawned once, and is.
    let (Ok(control_loop), Ok(supervision), Ok(i2c)) = (
        control_loop::run(control, config.loop_period, sensors, hardware.valves),
        supervision::run(watchdog, hardware.led, parameters, updates),
        i2c::run(hardware.i2c),
    ) else {
        defmt::unreachable!()
    };
    control_spawner.spawn(control_loop);
    spawner.spawn(supervision);
    spawner.spawn(i2c);
    // What this task still owns (the pins of the address switch) stays as it is.
    core::future::pending().await
}

#[interrupt]
// SAFETY: called by the hardware only, as the executor's interrupt.
unsafe fn SWI_IRQ_0() {
    // SAFETY: this is the interrupt that the executor was started with.
    unsafe { CONTROL_EXECUTOR.on_interrupt() }
}
