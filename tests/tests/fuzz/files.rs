use super::mutation::contents;
use super::scripts;
use bolero::check;
use pneudrive_protocol::SensorScale;
use pneudrive_record::trajectory::Trajectory;

const TRAJECTORY: &[u8] = include_bytes!("seeds/trajectory.csv");

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
