//! Four valves, a DIR and a PWM pin each.

use crate::{chip, config};
use embassy_rp::Peri;
use embassy_rp::gpio::Output;
use embassy_rp::pwm::{self, ChannelAPin, Pwm, Slice};
use pneudrive_control::DirPwm;

/// The PWM counts from 0 to this. 65534 at most, so that "always high" can be expressed.
const TOP: u16 = {
    let top = chip::SYSTEM_CLOCK_HZ / config::PWM_HZ - 1;
    assert!(top < u16::MAX as u32);
    top as u16
};

/// One valve's two driver pins.
pub struct Valve {
    dir: Output<'static>,
    pwm: Pwm<'static>,
    pwm_config: pwm::Config,
}

impl Valve {
    /// Vents fully until it is told otherwise.
    pub fn new<T: Slice>(
        dir: Output<'static>,
        slice: Peri<'static, T>,
        pin: Peri<'static, impl ChannelAPin<T>>,
    ) -> Self {
        let mut pwm_config = pwm::Config::default();
        pwm_config.top = TOP;
        pwm_config.compare_a = DirPwm::SAFE.compare(TOP);
        let pwm = Pwm::new_output_a(slice, pin, pwm_config.clone());
        Self { dir, pwm, pwm_config }
    }

    /// Sets both pins. The PWM takes its new duty at its next wrap, at most 32 us after DIR has
    /// changed.
    pub fn apply(&mut self, levels: DirPwm) {
        self.pwm_config.compare_a = levels.compare(TOP);
        self.pwm.set_config(&self.pwm_config);
        self.dir.set_level(levels.dir_is_high().into());
    }
}
