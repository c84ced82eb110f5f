//! What cannot be created is refused with a sentence that names the file, the channel or the step.

use crate::support::{Driven, extended, generator};
use pneudrive_capi::{Channel, Control};
use pneudrive_model::simulation::CalibratedModel;

fn refusal(driven: Driven, name: &str, step_s: f64, control: Control) -> String {
    let model = CalibratedModel::from(extended(&mut generator(1), driven, 2, &[]));
    match Channel::of(&model, name, step_s, control) {
        Ok(_) => panic!("{driven:?} {name} {step_s} {control:?} is possible"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn what_cannot_be_created_is_refused_with_a_sentence() {
    use Control::{AsCalibrated, Drive, SetPoint};
    let says = |text: String, words: &str| assert!(text.contains(words), "{text}");
    says(refusal(Driven::Spool, "b0c7", 0.001, AsCalibrated), "the file has b0c0, b0c1");
    says(refusal(Driven::Spool, "0", 0.001, AsCalibrated), "expected a channel such as b0c2");
    says(refusal(Driven::Spool, "b0c0", 0.0, AsCalibrated), "a step of 0 s is not possible");
    says(refusal(Driven::Spool, "b0c0", f64::NAN, AsCalibrated), "is not possible");
    says(refusal(Driven::Board, "b0c0", 0.0015, AsCalibrated), "not a whole number of loops");
    says(refusal(Driven::Spool, "b0c0", 0.0005, SetPoint), "runs at 1000 Hz");
    says(refusal(Driven::Command, "b0c0", 0.001, Drive), "is a regulator");
    let missing = Channel::create("nowhere.toml".as_ref(), "b0c0", 0.001, AsCalibrated);
    says(missing.err().unwrap().to_string(), "nowhere.toml");
}

#[test]
fn a_channel_calibrated_with_drives_can_follow_set_points() {
    let model = CalibratedModel::from(extended(&mut generator(2), Driven::Spool, 1, &["valve_lag"]));
    let mut channel = Channel::of(&model, "b0c0", 0.001, Control::SetPoint).unwrap();
    let mut inputs = *channel.nominal();
    channel.start(0.0, &inputs).unwrap();
    inputs.set_point_kpa = 150.0;
    for _ in 0..3000 {
        channel.step(&inputs).unwrap();
    }
    let outputs = channel.outputs();
    assert!((outputs.reading_kpa - 150.0).abs() < 5.0, "{outputs:?}");
    assert!((outputs.time_s - 3.0).abs() < 1e-9);
}
