//! One parameter of an effect: its range, what of it is usual, where it is fitted.

use crate::model::Scale;

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParameter {
    /// Name in reports and files, unique within the effect.
    pub name: &'static str,
    /// Unit, `1` when it has none.
    pub unit: &'static str,
    /// Smallest value that is fitted.
    pub lower: f64,
    /// Largest value that is fitted.
    pub upper: f64,
    /// Value at which the effect is absent (as closely as the bounds allow).
    pub null: f64,
    /// Scale of fitting.
    pub scale: Scale,
    /// Largest distance from `null` that is usual on sound rigs, of the logarithm where that is
    /// fitted; infinite where the parameter says nothing about how large the effect is.
    pub usual: f64,
    /// By how much more a sound rig's may seem to differ in a board's loop, where the drive is not
    /// recorded: what the rig file's tolerances look like there.
    pub seeming_in_loop: f64,
    /// Is it free, as far as is usual, in every base model of a valve?
    pub in_base: bool,
    /// Does it belong to what hangs on the valves, which may differ between recordings of one
    /// machine?
    pub of_load: bool,
    /// What it means, in a few words.
    pub meaning: &'static str,
}

impl EffectParameter {
    /// A parameter fitted as it is; the range is (lower, null, upper).
    #[must_use]
    pub const fn linear(
        name: &'static str,
        unit: &'static str,
        (lower, null, upper): (f64, f64, f64),
        meaning: &'static str,
    ) -> Self {
        Self {
            name,
            unit,
            lower,
            upper,
            null,
            scale: Scale::Linear,
            usual: f64::INFINITY,
            seeming_in_loop: 0.0,
            in_base: false,
            of_load: false,
            meaning,
        }
    }

    /// A positive parameter fitted by its logarithm; the range is (lower, null, upper).
    #[must_use]
    pub const fn logarithmic(
        name: &'static str,
        unit: &'static str,
        (lower, null, upper): (f64, f64, f64),
        meaning: &'static str,
    ) -> Self {
        let mut parameter = Self::linear(name, unit, (lower, null, upper), meaning);
        parameter.scale = Scale::Logarithmic;
        parameter
    }

    /// With the largest value that is usual on sound rigs.
    #[must_use]
    pub const fn usual_to(mut self, distance: f64) -> Self {
        self.usual = distance;
        self
    }

    /// As [`usual_to`](Self::usual_to), and free that far in every base model of a valve: without
    /// it, a fit bends what is there instead.
    #[must_use]
    pub const fn in_base_to(mut self, distance: f64) -> Self {
        self.in_base = true;
        self.usual_to(distance)
    }

    /// With a further distance that a sound rig's may seem to have in a board's loop.
    #[must_use]
    pub const fn seeming_in_loop(mut self, distance: f64) -> Self {
        self.seeming_in_loop = distance;
        self
    }

    /// It belongs to what hangs on the valves: each recording of a machine may have its own.
    #[must_use]
    pub const fn of_load(mut self) -> Self {
        self.of_load = true;
        self
    }

    /// Where it is fitted: anywhere, or as far as is usual.
    #[must_use]
    pub fn bounds(&self, usual: bool) -> (f64, f64) {
        let (low, high) = match self.scale {
            Scale::Linear => (self.null - self.usual, self.null + self.usual),
            Scale::Logarithmic => (self.null * (-self.usual).exp(), self.null * self.usual.exp()),
        };
        if usual { (low.max(self.lower), high.min(self.upper)) } else { (self.lower, self.upper) }
    }

    /// Largest distance from `null` that says nothing against a rig; `looped`: of a board's loop
    /// whose drive is not recorded.
    #[must_use]
    pub fn unsuspicious(&self, looped: bool) -> f64 {
        self.usual + if looped { self.seeming_in_loop } else { 0.0 }
    }

    /// Distance of a value from `null`, on the scale of fitting.
    #[must_use]
    pub fn distance(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.null).abs(),
            Scale::Logarithmic => (value / self.null).ln().abs(),
        }
    }
}
