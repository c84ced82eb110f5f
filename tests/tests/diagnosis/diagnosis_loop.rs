//! The loop closes: a recording that cannot tell two causes apart, the commands that the diagnosis
//! asks for, the host playing them to the same boards, and a second diagnosis of both recordings
//! that can.
//!
//! Boards, host and recorder are the real ones, in virtual time: the result does not depend on the
//! machine.

use std::path::{Path, PathBuf};

use pneudrive_model::data::{ChannelId, LoadOptions, Recording, load};
use pneudrive_model::diagnosis::{Diagnosis, Request, diagnose};
use pneudrive_model::rig::Rig;
use pneudrive_sim::rig::RigOptions;
use system_tests::take::Take;

/// The only channel that is moved, recorded and diagnosed.
const CHANNEL: ChannelId = ChannelId { board: 0, channel: 0 };
const LAGS: [&str; 3] = ["transport_delay", "valve_lag", "sensor_lag"];

/// A rig that hides one effect, and the nominal description of it that the diagnosis gets.
struct HiddenRig {
    options: RigOptions,
    nominal: Rig,
    folder: tempfile::TempDir,
}

impl HiddenRig {
    fn hiding(effect: &str) -> Self {
        let options = RigOptions { effects: vec![effect.parse().unwrap()], seed: 3, ..RigOptions::default() };
        let nominal = Rig::parse("rig.toml", &options.rig_toml().unwrap()).unwrap();
        Self { options, nominal, folder: tempfile::tempdir().unwrap() }
    }

    /// The host plays a command file to the boards and records what they answer.
    fn play(&self, name: &str, commands: &str) -> PathBuf {
        let file = self.folder.path().join(name);
        let take = Take { commands, rate_hz: 100, drives: false, begins_s: 3.0 };
        take.record(&self.options, &file);
        file
    }

    fn load(&self, file: &Path) -> Recording {
        let limits = |channel| self.nominal.sensor_limits(channel);
        let channels = [CHANNEL];
        let options =
            LoadOptions { limits: Some(&limits), channels: Some(&channels), ..LoadOptions::default() };
        load(file, options).unwrap().recording
    }

    fn diagnose(&self, recording: &Recording) -> Diagnosis {
        diagnose(recording, &self.nominal, Request::default(), &|_, _| {}).unwrap()
    }
}

/// A minute of slow ramps between a few levels: the pressure follows, and any kind of lag does
/// nearly the same to it.
fn slow_ramps() -> String {
    let mut text = "t_s,b0_cmd0_kpa\n".to_owned();
    // From 0 to 1, and they look random.
    let scatter = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1_u32 << 24);
    let (mut t, mut level) = (0.5, 0.0);
    text.push_str("0,0\n");
    for k in 0.. {
        let seconds = if k == 0 { 4.0 } else { 0.5 + 3.5 * scatter(2 * k) };
        let next = 100.0 + 100.0 * scatter(2 * k + 1);
        for step in 0..(seconds / 0.02) as u32 {
            let part = f64::from(step) * 0.02 / seconds;
            text.push_str(&format!(
                "{:.2},{:.2}\n",
                t + f64::from(step) * 0.02,
                level + part * (next - level)
            ));
        }
        t += seconds;
        level = next;
        if t > 60.0 {
            return text;
        }
    }
    text
}

/// What a diagnosis names, with what it cannot be told from.
fn named(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let one = |c: &pneudrive_model::diagnosis::json::Cause| {
        std::iter::once(&c.effect).chain(&c.equivalent).cloned().collect()
    };
    diagnosis.report.causes.iter().map(one).collect()
}

fn the_loop_closes(hidden: &str, size: &str) {
    let rig = HiddenRig::hiding(&format!("{hidden}={size}"));
    let first = rig.load(&rig.play("first.csv", &slow_ramps()));
    let before = rig.diagnose(&first);
    let tie = named(&before);
    assert_eq!(tie.len(), 1, "{tie:?}");
    let lags = tie[0].iter().filter(|id| LAGS.contains(&id.as_str())).count();
    assert!(lags >= 2 && tie[0].iter().any(|id| id == hidden), "the first recording ties lags: {tie:?}");

    let plan = before.plan.as_ref().expect("a tie asks for an experiment");
    let experiment = &plan.experiment;
    assert_eq!(before.report.next_experiment.as_ref(), Some(experiment));
    assert!(experiment.expected_to_settle, "{}", experiment.reason);
    let considered: Vec<f64> = experiment.considered.iter().map(|c| c.separation_kpa).collect();
    assert!(considered.len() >= 6, "{considered:?}");
    let again_slow = experiment.considered.iter().find(|c| c.excitation == "slow_ramps").unwrap();
    assert!(
        experiment.separation_kpa > 3.0 * again_slow.separation_kpa,
        "better than more of the same: {considered:?}"
    );
    let [low, high] = experiment.range_kpa;
    assert!(low >= 0.0 && high <= 200.5, "no higher than before: {low} to {high} kPa");

    let second = rig.load(&rig.play("second.csv", &plan.trajectory));
    assert!((second.duration_s() - experiment.seconds).abs() < 0.1, "{} s", second.duration_s());
    let both = rig.diagnose(&first.followed_by(second).unwrap());
    assert_eq!(named(&both), [[hidden]], "told apart: {}", both.report.sentence);
    assert!(both.report.next_experiment.is_none(), "{:?}", both.report.next_experiment);
}

#[test]
fn a_dead_time_is_told_from_a_lag_by_the_experiment_that_was_asked_for() {
    the_loop_closes("transport_delay", "0.03");
}

#[test]
fn a_lag_is_told_from_a_dead_time_by_the_experiment_that_was_asked_for() {
    the_loop_closes("valve_lag", "0.035");
}
