//! What makes an effect different from most.

use super::inputs::ChannelInputs;

/// A sine in the supply that a recording shows, `cosine cos(w t) + sine sin(w t)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Amplitude of the cosine, over the gauge supply pressure.
    pub cosine: f64,
    /// Amplitude of the sine, over the gauge supply pressure.
    pub sine: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Gauge supply pressure, Pa.
    pub gauge_pa: f64,
}

impl Wave {
    /// Amplitude over the gauge supply pressure.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.cosine.hypot(self.sine)
    }

    /// Period, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.frequency_hz.recip()
    }
}

/// A size that several parameters of an effect make together and that is better known than each of
/// them.
#[derive(Debug, Clone, Copy)]
pub struct DerivedSize {
    /// Name in reports, unique within the effect.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// What it means, in a few words.
    pub meaning: &'static str,
    /// From the effect's parameters and a flow, as the rate in kPa/s at which it changes the
    /// pressure of the nominal volume.
    pub of: fn(&[f64], f64) -> f64,
}

/// What makes an effect different from most, wherever it matters.
#[derive(Debug, Clone, Copy)]
pub enum Trait {
    /// Needs the pressure in the chamber on the other side of the joint.
    NeedsOpposite,
    /// Needs the pressure of the channel that the converter samples before.
    NeedsSampledBefore,
    /// Needs the drive of the channel that the board handles before.
    NeedsNeighbourDrive,
    /// Needs the flow that the other channels draw from the supply.
    NeedsOthersDraw,
    /// Needs a supply that is stated, not measured: one level throughout.
    NeedsStatedSupply,
    /// Needs one spool for both ways: two valves have a gain each in the base model.
    NeedsOneSpool,
    /// Its first parameter is a threshold: where it is passed a little later, everything after it
    /// is different, and there is no derivative.
    Thresholded,
    /// With it a board's loop hunts.
    LimitCycle,
    /// With it what a board's loop controls moves within a few milliseconds.
    FastInLoop,
    /// It happens at times that the rows tell only roughly.
    RoughlyTimed,
    /// A channel's rows show by themselves whether it is there, whatever else a model lacks.
    Shown(fn(&ChannelInputs) -> bool),
    /// It belongs to a recording of some minutes and means nothing over months: then another offset
    /// or gain is seen.
    WithinARecording,
    /// Its first parameter is the scale of the load: openings of valves cannot be told from it, but
    /// its ratios between recordings can.
    ScaleOfLoad,
    /// Its parameters make up for each other; together they are a size.
    Derives(DerivedSize),
    /// It comes back with a period of its own; its probes follow from a wave that the recording
    /// shows.
    Periodic(fn(&Wave) -> Vec<Vec<f64>>),
    /// Sound rigs have it also in a size that hardly acts and still shifts what else is estimated:
    /// its parameters, from the mean volume of a chamber (m^3).
    Unnoticed(fn(f64) -> Vec<f64>),
}
