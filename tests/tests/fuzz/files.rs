use super::mutation::mutated;
use super::scripts;
use bolero::check;
use pneudrive_host::trajectory::Trajectory;
use pneudrive_protocol::SensorScale;

const TRAJECTORY: &[u8] = include_bytes!("seeds/trajectory.csv");

/// The first byte decides between a damaged good file and anything at all.
fn contents(seed: &[u8], script: &[u8]) -> Vec<u8> {
    match script {
        [0..16, anything @ ..] => anything.to_vec(),
        [_, edits @ ..] => mutated(seed, edits),
        [] => seed.to_vec(),
    }
}

#[test]
fn trajectories() {
    check!().with_iterations(5_000).with_generator(scripts(64)).for_each(|script: &Vec<u8>| {
        let text = contents(TRAJECTORY, script);
        match Trajectory::parse("fuzzed.csv", text.as_slice(), 2, SensorScale::ORIGINAL) {
            Ok(trajectory) => assert!(trajectory.rows() > 0 && trajectory.seconds().is_finite()),
            Err(error) => assert!(error.to_string().contains("fuzzed.csv"), "{error}"),
        }
    });
}
