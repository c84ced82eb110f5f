//! From the drive a board asks for to the spool: the driver's resolution, crosstalk, dead time,
//! current limit, lag, friction.

use std::collections::VecDeque;

use super::physics::DrivePhysics;

/// Spool positions at the start, middle and end of an integration step, -1 to 1.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SpoolStep {
    pub start: f64,
    pub middle: f64,
    pub end: f64,
}

/// One channel's chain. The order is that of the hardware: the driver's output reaches the coil
/// (crosstalk, dead time, current limit), the force follows the current (lag), and friction stands
/// between force and spool.
#[derive(Debug, Clone)]
pub struct DriveChain {
    resolution: f64,
    crosstalk: f64,
    limit: f64,
    queue: Option<VecDeque<f64>>,
    /// Share of the way to the drive the force makes in half a step and in a whole one; `None`
    /// without lag.
    lag: Option<(f64, f64)>,
    friction: Friction,
    force: f64,
    spool: f64,
    coil: f64,
}

#[derive(Debug, Clone, Default)]
struct Friction {
    active: bool,
    play: f64,
    stiction: f64,
    spot: Option<(f64, f64)>,
    play_out: f64,
    stiction_out: f64,
    spot_out: f64,
}

impl DriveChain {
    pub fn new(p: &DrivePhysics, step_s: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "validated: 0 to 1 s over 1 us"
        )]
        let steps = (p.delay_s / step_s).round() as usize;
        let lag = (p.lag_s > 0.0).then(|| {
            let share = |h: f64| -(-h / p.lag_s).exp_m1();
            (share(0.5 * step_s), share(step_s))
        });
        let active = p.play_half_width > 0.0 || p.stiction_threshold > 0.0 || p.sticking_spot.is_some();
        Self {
            resolution: p.resolution,
            crosstalk: p.crosstalk,
            limit: p.limit.unwrap_or(1.0),
            queue: (steps > 0).then(|| core::iter::repeat_n(0.0, steps).collect()),
            lag,
            friction: Friction {
                active,
                play: p.play_half_width,
                stiction: p.stiction_threshold,
                spot: p.sticking_spot,
                ..Friction::default()
            },
            force: 0.0,
            spool: 0.0,
            coil: 0.0,
        }
    }

    /// Moves the spool over one step during which this channel's driver puts out `drive` and its
    /// neighbour's `neighbour`.
    #[inline]
    pub fn step(&mut self, drive: f64, neighbour: f64) -> SpoolStep {
        let drive =
            if self.resolution > 0.0 { (drive / self.resolution).round() * self.resolution } else { drive };
        let mut coil = (drive + self.crosstalk * neighbour).clamp(-1.0, 1.0);
        if let Some(queue) = &mut self.queue {
            queue.push_back(coil);
            coil = queue.pop_front().unwrap_or(coil);
        }
        coil = coil.clamp(-self.limit, self.limit);
        self.coil = coil;
        let Some((half, whole)) = self.lag else {
            self.force = coil;
            let spool = self.friction.apply(coil);
            self.spool = spool;
            return SpoolStep { start: spool, middle: spool, end: spool };
        };
        let before = self.force;
        self.force = before + whole * (coil - before);
        let start = self.spool;
        self.spool = self.friction.apply(self.force);
        let middle =
            if self.friction.active { 0.5 * (start + self.spool) } else { before + half * (coil - before) };
        SpoolStep { start, middle, end: self.spool }
    }

    /// Spool position at the end of the last step, -1 to 1.
    pub fn spool(&self) -> f64 {
        self.spool
    }

    /// What reached the coil in the last step, -1 to 1.
    pub fn coil(&self) -> f64 {
        self.coil
    }
}

impl Friction {
    /// Play, then stick-and-jump, then the sticking spot; each passes its input through when it is
    /// off.
    #[inline]
    fn apply(&mut self, force: f64) -> f64 {
        if !self.active {
            return force;
        }
        // Play: the spool is pushed by whichever face of the gap touches it.
        self.play_out = self.play_out.clamp(force - self.play, force + self.play);
        // Stiction: nothing moves until the force has gone a threshold away, then the spool jumps
        // after it.
        if (self.play_out - self.stiction_out).abs() >= self.stiction {
            self.stiction_out = self.play_out;
        }
        self.stick_at_spot(self.stiction_out)
    }

    /// A burr: a spool that crosses or reaches the spot stays there until pulled away by the
    /// tear-off distance.
    fn stick_at_spot(&mut self, wanted: f64) -> f64 {
        let Some((spot, tear_off)) = self.spot else {
            return wanted;
        };
        let held = self.spot_out.total_cmp(&spot).is_eq();
        let crosses = (self.spot_out - spot) * (wanted - spot) <= 0.0;
        self.spot_out = if (held || crosses) && (wanted - spot).abs() < tear_off { spot } else { wanted };
        self.spot_out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 50e-6;

    fn run(p: &DrivePhysics, drives: &[f64]) -> Vec<f64> {
        let mut chain = DriveChain::new(p, H);
        drives.iter().map(|&d| chain.step(d, 0.0).end).collect()
    }

    #[test]
    fn plain_chain_is_prompt() {
        assert_eq!(run(&DrivePhysics::default(), &[0.3, -0.7, 1.0]), [0.3, -0.7, 1.0]);
    }

    #[test]
    fn dead_time_is_whole_steps() {
        let p = DrivePhysics { delay_s: 2.0 * H, ..DrivePhysics::default() };
        assert_eq!(run(&p, &[0.1, 0.2, 0.3, 0.4]), [0.0, 0.0, 0.1, 0.2]);
    }

    /// Against the closed form 1 - exp(-t / tau), at the end and in the middle of a step.
    #[test]
    fn lag_is_exact_for_a_held_drive() {
        let p = DrivePhysics { lag_s: 0.01, ..DrivePhysics::default() };
        let mut chain = DriveChain::new(&p, H);
        let mut last = SpoolStep::default();
        for _ in 0..100 {
            last = chain.step(1.0, 0.0);
        }
        assert!((last.end - (1.0 - (-0.5_f64).exp())).abs() < 1e-12);
        assert!((last.middle - (1.0 - (-0.4975_f64).exp())).abs() < 1e-12);
        assert!((last.start - (1.0 - (-0.495_f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn play_follows_one_gap_behind_on_each_side() {
        let p = DrivePhysics { play_half_width: 0.1, ..DrivePhysics::default() };
        let out = run(&p, &[0.5, 0.45, 0.2, 0.25]);
        for (got, want) in out.iter().zip([0.4, 0.4, 0.3, 0.3]) {
            assert!((got - want).abs() < 1e-12, "{out:?}");
        }
    }

    #[test]
    fn stiction_stays_then_jumps() {
        let p = DrivePhysics { stiction_threshold: 0.1, ..DrivePhysics::default() };
        assert_eq!(run(&p, &[0.05, 0.09, 0.12, 0.2, 0.23]), [0.0, 0.0, 0.12, 0.12, 0.23]);
    }

    #[test]
    fn sticking_spot_holds_only_near_itself() {
        let p = DrivePhysics { sticking_spot: Some((0.2, 0.1)), ..DrivePhysics::default() };
        assert_eq!(run(&p, &[0.15, 0.25, 0.28, 0.31, 0.35, 0.05]), [0.15, 0.2, 0.2, 0.31, 0.35, 0.05]);
    }

    #[test]
    fn a_coarse_driver_puts_out_the_nearest_of_its_steps() {
        let p = DrivePhysics { resolution: 0.25, ..DrivePhysics::default() };
        assert_eq!(run(&p, &[0.1, 0.13, -0.4, 0.9, 1.0]), [0.0, 0.25, -0.5, 1.0, 1.0]);
    }

    #[test]
    fn limit_and_crosstalk_act_before_the_coil() {
        let p = DrivePhysics { limit: Some(0.7), crosstalk: 0.1, ..DrivePhysics::default() };
        let mut chain = DriveChain::new(&p, H);
        assert!((chain.step(0.5, 1.0).end - 0.6).abs() < 1e-12);
        assert!((chain.step(-1.0, -1.0).end + 0.7).abs() < 1e-12);
        assert!((chain.coil() + 0.7).abs() < 1e-12);
    }
}
