//! A diagnosis that is asked about some effects only.

use crate::common::Folder;
use crate::common::cli::run;
use crate::common::regulator::regulator;
use serde_json::Value;

#[test]
fn nothing_is_named_but_what_is_asked_about_and_the_answer_says_so() {
    let folder = Folder::new();
    folder.write("run.csv", regulator(6).as_bytes());
    let diagnosed = |only: &str| {
        let done = run(folder.root(), &["diagnose", "run.csv", "--only", only, "--out", "d"]);
        assert_eq!(done.status, 0, "{}", done.stderr);
        let report: Value =
            serde_json::from_slice(&std::fs::read(folder.path("d/report.json")).unwrap()).unwrap();
        let causes = report["causes"].as_array().unwrap().clone();
        let names: Vec<String> = causes.iter().map(|c| c["effect"].as_str().unwrap().to_owned()).collect();
        assert_eq!(report["asked"], Value::from(only.split(',').collect::<Vec<_>>()));
        (names, done.stdout)
    };
    let (names, said) = diagnosed("rate_limit,transport_delay");
    assert_eq!(names, ["transport_delay"]);
    assert!(said.contains("Nothing but ") && said.contains(" was asked about."), "{said}");
    let (names, said) = diagnosed("rate_limit");
    assert!(!names.contains(&"transport_delay".to_owned()), "{said}");
}

#[test]
fn what_no_effect_is_called_and_what_the_recording_has_no_room_for_is_refused() {
    let folder = Folder::new();
    folder.write("run.csv", regulator(6).as_bytes());
    for (only, said) in [
        ("transport_dealy", "no effect is called transport_dealy; there are drive_saturation,"),
        // What stands for things outside the catalogue is never a name.
        ("coil_heating", "no effect is called coil_heating"),
        ("transport_delay,line_restriction", "line_restriction cannot be asked about"),
    ] {
        let done = run(folder.root(), &["diagnose", "run.csv", "--only", only, "--out", "d"]);
        assert_eq!(done.status, 2, "{only}: {}", done.stdout);
        assert!(done.stderr.contains(said), "{only}: {}", done.stderr);
        assert!(!folder.path("d").exists());
    }
}
