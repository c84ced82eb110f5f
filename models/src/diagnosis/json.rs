//! `report.json`: the result for programs. The format is `pneudrive-diagnosis/1`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Name of the format.
pub const SCHEMA: &str = "pneudrive-diagnosis/1";

/// The whole file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: String,
    /// The recording.
    pub data: Data,
    /// What was found, in a word.
    pub verdict: Verdict,
    /// What was found, in a sentence.
    pub sentence: String,
    /// The base model alone.
    pub baseline: Baseline,
    /// What the base model's residual depends on.
    pub symptoms: Vec<Symptom>,
    /// What was named, in the order of the gain.
    pub causes: Vec<Cause>,
    /// What the extended model holds beside them, without a name: sound rigs have it too, or it may
    /// gain nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub imperfections: Vec<Imperfection>,
    /// What no name fits.
    pub unexplained: Unexplained,
    /// How to tell rivals apart.
    pub next_experiment: Option<NextExperiment>,
    /// File of the extended model, beside this one.
    pub extended_model: Option<String>,
    /// What was noticed about the data.
    pub notes: Vec<String>,
    /// Checks of the simulation itself.
    pub checks: Checks,
    /// Every level, prior and threshold that decided, by its name in
    /// [`settings`](crate::diagnosis::settings); the page says what and why.
    #[serde(default)]
    pub settings: BTreeMap<String, f64>,
    /// Explanations with their probabilities, the most probable first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<Alternative>,
    /// The machine, where several recordings of one were given, or one of a machine that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineReport>,
    /// Ids of the effects that were in question, where it was not the whole catalogue.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub asked: Vec<String>,
}

/// A set of causes with its probability.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alternative {
    /// Ids of effects, `none`, `something_else`.
    pub causes: Vec<String>,
    /// Probability. What all that are listed leave to 1 is that of sets that were not fitted, or
    /// are less probable than those.
    pub probability: f64,
    /// RMS error of rollouts over the parts where causes are chosen, kPa.
    pub select_rmse_kpa: f64,
}

/// Several recordings of one machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MachineReport {
    /// Were valves, supply and sensor taken from a calibrated model?
    pub known: bool,
    /// RMS error of rollouts over the last parts of all recordings when the machine is fitted to
    /// the first parts of all of them, without causes, kPa. Of a known machine there is no other
    /// error.
    pub joint_rmse_before_kpa: f64,
    /// The same with the causes.
    pub joint_rmse_after_kpa: f64,
    /// The recordings, in the order in which they were given.
    pub recordings: Vec<MachineRecord>,
}

/// One of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MachineRecord {
    /// Its file.
    pub file: String,
    /// RMS error of rollouts over its last part with the curves of the other recordings, without
    /// causes, kPa.
    pub test_rmse_before_kpa: f64,
    /// The same with the causes.
    pub test_rmse_after_kpa: f64,
    /// Deviation of the reading that the likelihood needs beside the noise, without causes, kPa
    /// RMS.
    pub discrepancy_before_kpa: f64,
    /// The same with the causes.
    pub discrepancy_after_kpa: f64,
    /// Parameters of its load, `effect.parameter`, by channel.
    pub load: BTreeMap<String, BTreeMap<String, Estimate>>,
    /// File of its extended model, beside this one.
    pub extended_model: String,
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing is missing that this recording could show.
    Adequate,
    /// Named causes, and nothing left.
    Explained,
    /// Named causes, and something left.
    PartlyExplained,
    /// Something is wrong and no name fits.
    Unexplained,
}

/// An effect that is modelled and not named.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Imperfection {
    /// Why it is not named.
    pub why: Unnamed,
    /// The effect, as a cause would be.
    #[serde(flatten)]
    pub cause: Cause,
}

/// Why an effect is not named.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unnamed {
    /// It is no larger than on sound rigs, or something else that is not does as well.
    Usual,
    /// It gains nothing on the test blocks, or may, and be of no size too; or beside a larger cause
    /// the gain is not sure, or a trace of the whole error.
    Gainless,
    /// Beside what is named, a smooth function of one measured variable does as much.
    Imitated,
    /// Less probable than not, beside what is more, where none of its sizes is determined or in
    /// closed loop, and not sure by size and gain; or so improbable that it is not listed.
    Improbable,
    /// By its intervals it may be nothing, and in closed loop it stands beside what may not.
    Undetermined,
}

/// The recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Data {
    /// File name.
    pub file: String,
    /// Rows used.
    pub rows: usize,
    /// Rows a second, Hz.
    pub rate_hz: f64,
    /// Length, s.
    pub seconds: f64,
}

/// The base model alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Baseline {
    /// Its name.
    pub model: String,
    /// RMS error of rollouts over the test blocks, all channels, kPa.
    pub test_rmse_kpa: f64,
    /// Noise of the measurement, kPa RMS.
    pub noise_floor_kpa: f64,
    /// By channel.
    pub channels: BTreeMap<String, BaselineChannel>,
}

/// The base model of one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BaselineChannel {
    /// Fitted parameters.
    pub parameters: BTreeMap<String, f64>,
    /// RMS error over its test blocks, kPa.
    pub test_rmse_kpa: f64,
}

/// Something the residual depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Symptom {
    /// Channel, or `all`.
    pub channel: String,
    /// In words.
    pub what: String,
    /// Name of the statistic.
    pub statistic: String,
    /// Its value.
    pub value: f64,
    /// Share of random-sign draws that reach it.
    pub p_value: f64,
    /// Part of the squared residual on blocks not fitted that the dependence accounts for.
    pub share: f64,
}

/// A named cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    /// Its id.
    pub effect: String,
    /// Where it acts.
    pub channels: Vec<String>,
    /// Effects that explain the recording as well.
    pub equivalent: Vec<String>,
    /// Its parameters, over the channels where it acts.
    pub parameters: BTreeMap<String, Estimate>,
    /// The same, channel by channel.
    pub by_channel: BTreeMap<String, BTreeMap<String, Estimate>>,
    /// p-value of the gate, corrected for the whole catalogue.
    pub p_value: f64,
    /// Probability of all explanations with it, where those were weighed; not of what is modelled
    /// without a name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// What modelling it gains.
    pub gain: Gain,
}

/// A parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Best value.
    pub value: f64,
    /// 95 % interval; `None` where the recording does not determine it.
    pub ci95: Option<[f64; 2]>,
    /// Unit.
    pub unit: String,
    /// `identified` or `not identifiable here`.
    pub state: String,
}

/// Gain on the test blocks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gain {
    /// RMS error without the cause, everything else fitted again, kPa.
    pub test_rmse_before_kpa: f64,
    /// RMS error with it, kPa.
    pub test_rmse_after_kpa: f64,
    /// One minus their ratio.
    pub reduction: f64,
    /// 95 % interval of the reduction (moving-block bootstrap).
    pub ci95: [f64; 2],
    /// The same of errors weighted by what noise, the wander of the supply and the hunting of a
    /// loop explain: slow drifts, which say little about a fast effect, count less in it, and so
    /// does where in its cycle a loop hunts.
    #[serde(default)]
    pub weighted_ci95: [f64; 2],
}

/// What no name fits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unexplained {
    /// Part of the base model's squared test residual above the noise that is left.
    pub share: f64,
    /// RMS error of the extended model over the test blocks, kPa.
    pub test_rmse_kpa: f64,
    /// What the remaining residual depends on.
    pub depends_on: Vec<Symptom>,
    /// A smooth correction without a name, where one helps. It is part of the extended model.
    pub correction: Option<Corrected>,
    /// A name that was not given, since something that is never named explains as well.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub withheld: Option<Withheld>,
}

/// A name that was not given, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Withheld {
    /// Id of the effect in the catalogue.
    pub effect: String,
    /// Id of what explains as well; it stands for causes outside the catalogue.
    pub foil: String,
}

/// A smooth correction of what no name fits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Corrected {
    /// What it depends on, by channel, in words.
    pub along: BTreeMap<String, String>,
    /// What it gains on the test blocks, beyond the causes.
    #[serde(flatten)]
    pub gain: Gain,
}

/// An experiment that tells rivals apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NextExperiment {
    /// The cause it is about.
    pub cause: String,
    /// The explanations it tells apart, the cause's own first; `nothing` stands for no effect at
    /// all.
    pub rivals: Vec<String>,
    /// Name of the excitation.
    pub excitation: String,
    /// Command file beside the report, for `pneudrive-host --trajectory`.
    pub trajectory: String,
    /// Length, s.
    pub seconds: f64,
    /// Lowest and highest command, kPa gauge.
    pub range_kpa: [f64; 2],
    /// Expected difference of the predictions of the two nearest rivals, RMS kPa, after refitting.
    pub separation_kpa: f64,
    /// The same over the noise of the measurement.
    pub separation_noise: f64,
    /// Is that enough to settle the question, by the rule for ties?
    pub expected_to_settle: bool,
    /// Why this one, in words.
    pub reason: String,
    /// What to do.
    pub instruction: String,
    /// All that were considered, the best first.
    pub considered: Vec<ConsideredExperiment>,
}

/// An excitation that was considered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConsideredExperiment {
    /// Its name.
    pub excitation: String,
    /// Its length, s.
    pub seconds: f64,
    /// Expected difference of the two nearest rivals, RMS kPa, after refitting.
    pub separation_kpa: f64,
}

/// Checks of the simulation itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checks {
    /// RMS error over the test blocks that noise and a wander of the supply by about 1 % leave
    /// where the model is right, kPa.
    pub allowed_rmse_kpa: f64,
    /// RMS change of the final simulation when the integration step is halved, kPa.
    pub halved_step_rms_kpa: f64,
    /// Blocks to fit, to choose and to test.
    pub blocks: [usize; 3],
    /// Length of a block, s.
    pub block_s: f64,
    /// Share of the readings of the test blocks that the 95 % band of the extended model holds; of
    /// a machine, of the last parts of all recordings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub band_holds: Option<f64>,
}
