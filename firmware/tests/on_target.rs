//! What only a chip can show: clocks, memory, pins, converter, interrupts.
//!
//! On a board with a debug probe, valves' supply off (the pins are driven as a test needs them):
//!
//! ```console
//! $ cargo fw-test
//! ```
//!
//! `system-tests` runs the same bodies on the emulated chip (`tests/tests/firmware/on_target.rs`).
//! Required hardware: a board, or a bare RP2040 module; nothing need be connected.
#![no_std]
#![no_main]

use pneudrive_firmware as _;

#[embedded_test::tests(default_timeout = 10)]
mod tests {
    use cortex_m::peripheral::SYST;
    use cortex_m::peripheral::syst::SystClkSource;
    use embassy_rp::interrupt::{InterruptExt, Priority};
    use embassy_rp::{interrupt, pac};
    use pneudrive_control::{Board, DirPwm, ValveDrive};
    use pneudrive_firmware::config::VALVE_PINS;
    use pneudrive_firmware::pins::Hardware;
    use pneudrive_firmware::sensors::Sensors;
    use pneudrive_firmware::{bus, chip, config, shared};
    use pneudrive_protocol::Address;

    const MICROSECONDS_PER_SECOND: u64 = 1_000_000;

    #[init]
    fn init() -> Hardware {
        // SAFETY: each test is a run of its own, and this its first call.
        Hardware::split(unsafe { pneudrive_firmware::start() })
    }

    /// Cycles of the processor that `action` takes, up to 16 million.
    fn cycles(action: impl FnOnce()) -> u32 {
        // SAFETY: nothing else uses SysTick.
        let mut timer: SYST = unsafe { cortex_m::Peripherals::steal() }.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0xff_ffff);
        timer.clear_current();
        timer.enable_counter();
        let before = SYST::get_current();
        action();
        before.wrapping_sub(SYST::get_current()) & 0xff_ffff
    }

    /// Waits on the timer whose microseconds every byte is stamped with.
    fn wait_us(time: u32) {
        let start = chip::TIMER.timerawl().read();
        while chip::TIMER.timerawl().read().wrapping_sub(start) < time {}
    }

    /// The crystal, both PLLs and the timer's tick are as the firmware's times assume.
    #[test]
    fn processor_and_timer_agree_on_a_millisecond(_hardware: Hardware) {
        let cycles = cycles(|| wait_us(1_000));
        let expected = (u64::from(chip::SYSTEM_CLOCK_HZ) * 1_000 / MICROSECONDS_PER_SECOND) as u32;
        defmt::info!("{=u32} cycles in 1 ms, expected {=u32}", cycles, expected);
        // The wait ends up to a microsecond late and starts up to one early.
        assert!(cycles.abs_diff(expected) <= expected / 400);
    }

    /// Code in RAM does not touch flash, so no cache decides how long it takes.
    #[cfg(feature = "rp2040")]
    #[test]
    fn flash_is_not_read_while_the_firmware_runs(_hardware: Hardware) {
        let before = pac::XIP_CTRL.ctr_acc().read();
        wait_us(1_000);
        let read = pac::XIP_CTRL.ctr_acc().read() - before;
        defmt::info!("{=u32} words read from flash in 1 ms", read);
        assert_eq!(read, 0);
    }

    /// The emulated chip takes a miss for 50 cycles, from the datasheet and one assumption. Nothing
    /// depends on it since code runs from RAM, except how soon the pins are driven.
    #[cfg(feature = "rp2040")]
    #[test]
    fn a_word_that_the_cache_does_not_have_costs_some_50_cycles(_hardware: Hardware) {
        const WORDS: u32 = 256;
        /// The alias of flash that neither looks into the cache nor fills it.
        const UNCACHED: *const u32 = 0x1300_0000 as *const u32;
        let cycles = cycles(|| {
            for n in 0..WORDS {
                // SAFETY: reads flash, in which the program lies.
                unsafe { UNCACHED.add(n as usize).read_volatile() };
            }
        });
        defmt::info!("{=u32} cycles a word from flash, with the loop around it", cycles / WORDS);
        assert!((40..80).contains(&(cycles / WORDS)));
    }

    /// Both pins of every valve are high: vent.
    #[test]
    fn all_valve_pins_are_high_after_the_start(_hardware: Hardware) {
        let levels = pac::SIO.gpio_in(0).read();
        defmt::info!("GPIO {=u32:032b}", levels);
        assert_eq!(levels & VALVE_PINS, VALVE_PINS);
    }

    /// PWM at the frequency and the duty that a valve is to have.
    #[test]
    fn a_valve_pin_has_its_frequency_and_duty(mut hardware: Hardware) {
        const PWM_0: u32 = 1 << 6;
        const TIME_US: u32 = 10_000;
        // A quarter of full fill: not (DIR) - PWM across the coil, so DIR is low and PWM high for
        // three quarters.
        hardware.valves[0].apply(DirPwm::from(ValveDrive::saturating(i32::from(ValveDrive::FULL) / 4)));
        wait_us(100);
        let (mut rises, mut high, mut looks, mut before) = (0_u32, 0_u32, 0_u32, true);
        let start = chip::TIMER.timerawl().read();
        while chip::TIMER.timerawl().read().wrapping_sub(start) < TIME_US {
            let now = pac::SIO.gpio_in(0).read() & PWM_0 != 0;
            rises += u32::from(now && !before);
            high += u32::from(now);
            looks += 1;
            before = now;
        }
        let expected = config::PWM_HZ / (MICROSECONDS_PER_SECOND as u32 / TIME_US);
        let percent = high * 100 / looks;
        defmt::info!("{=u32} periods in 10 ms, expected {=u32}; high for {=u32} %", rises, expected, percent);
        assert!(rises.abs_diff(expected) <= 2);
        assert!(percent.abs_diff(75) <= 3);
    }

    /// 64 readings at 2 us each, and no conversion fails.
    #[test]
    async fn a_sample_takes_128_us(hardware: Hardware) {
        let mut sensors = Sensors::new(hardware.sensors);
        // Once for the converter's start.
        assert!(sensors.sample().await.is_ok());
        let start = chip::TIMER.timerawl().read();
        assert!(sensors.sample().await.is_ok());
        let time = chip::TIMER.timerawl().read().wrapping_sub(start);
        defmt::info!("{=u32} us a sample", time);
        assert!((126..160).contains(&time));
    }

    /// While Embassy or the log is in a critical section, the bus is served.
    #[test]
    fn critical_sections_let_the_bus_interrupt_in(hardware: Hardware) {
        let Ok(board) = Board::new(config::BOARD, Address::of_board(0)) else {
            defmt::panic!("configuration")
        };
        let (port, control) = board.split();
        shared::install(port, control.status());
        bus::start(hardware.bus, &config::BOARD);
        interrupt::DMA_IRQ_0.set_priority(Priority::P1);
        let ran = critical_section::with(|_| {
            shared::with(|shared| shared.liveness.take());
            bus::ask_for_a_sign_of_life();
            cortex_m::asm::isb();
            shared::with(|shared| shared.liveness.take())
        });
        assert!(ran.bus_has_run());
    }
}
