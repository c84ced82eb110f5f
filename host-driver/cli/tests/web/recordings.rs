//! Recordings that are started, stopped and fetched from the page.

use super::rig::{Rig, until};
use serde_json::json;

#[test]
fn recordings_start_and_stop_by_button() {
    let rig = Rig::start(false);
    let json_type = [("Content-Type", "application/json")];
    let start = |body: &str| rig.send("POST", "/api/record/start", &json_type, body);
    assert_eq!(rig.send("POST", "/api/record/stop", &[], "").0, 409);
    for name in ["../escape", "a b", "x/y", &"x".repeat(41)] {
        assert_eq!(start(&json!({ "name": name }).to_string()).0, 422, "{name}");
    }
    let (status, said) = start(r#"{"name": "grasp"}"#);
    let file = std::path::PathBuf::from(said["file"].as_str().unwrap());
    assert!(status == 200 && file.parent() == Some(rig.folder.path()), "{said}");
    assert!(file.to_str().unwrap().ends_with("Z-grasp.csv"), "{said}");
    assert_eq!(start("").0, 409, "one at a time");
    // With the header, without what the recording says of itself.
    let table = |text: String| text.lines().filter(|line| !line.starts_with('#')).count();
    let rows = || std::fs::read_to_string(&file).map_or(0, table);
    until("rows", || rows() > 10);
    assert_eq!(rig.send("POST", "/api/record/stop", &[], "").0, 200);
    let last = || rig.send("GET", "/api/state", &[], "").1["figures"]["recording"]["last"].clone();
    until("the end of the recording", || last().is_string());
    let said = format!("{} rows", rows() - 1);
    assert!(last().as_str().unwrap().contains(&said), "{} is not {said}", last());
}

/// Who made a recording from the page can have it there; nothing else in the folder can be had.
#[test]
fn recordings_by_button_can_be_downloaded() {
    let rig = Rig::start(false);
    std::fs::write(rig.folder.path().join("private.csv"), "secret").unwrap();
    let listed = || rig.send("GET", "/api/recordings", &[], "").1["recordings"].clone();
    assert_eq!(listed(), json!([]));
    let (status, said) = rig.send(
        "POST",
        "/api/record/start",
        &[("Content-Type", "application/json")],
        r#"{"name": "grasp"}"#,
    );
    assert_eq!(status, 200);
    let file = std::path::PathBuf::from(said["file"].as_str().unwrap());
    let name = file.file_name().unwrap().to_str().unwrap().to_owned();
    assert_eq!((&listed()[0]["name"], &listed()[0]["whole"]), (&json!(name), &json!(false)));
    rig.send("POST", "/api/record/stop", &[], "");
    until("the end of the recording", || listed()[0]["whole"] == true);
    let stored = std::fs::read_to_string(&file).unwrap();
    let (status, answer) = rig.exchange("GET", &format!("/api/recordings/{name}"), &[], "");
    assert_eq!(status, 200);
    assert!(answer.ends_with(&stored), "{answer}");
    for other in ["private.csv", "..%2Fprivate.csv", "%2Fetc%2Fpasswd", "."] {
        let (status, said) = rig.send("GET", &format!("/api/recordings/{other}"), &[], "");
        assert_eq!(status, 404, "{other}: {said}");
    }
}

/// Each in a folder of its own, or the next one's metadata.yaml would replace it.
#[test]
fn bags_by_button_are_folders() {
    let rig = Rig::start_recording(false, "mcap");
    let json_type = [("Content-Type", "application/json")];
    let start = |body: &str| rig.send("POST", "/api/record/start", &json_type, body);
    let bags = || std::fs::read_dir(rig.folder.path()).unwrap().count();
    let mut files = Vec::new();
    for name in ["first", "second"] {
        let (status, said) = start(&json!({ "name": name }).to_string());
        assert_eq!(status, 200, "{said}");
        let file = std::path::PathBuf::from(said["file"].as_str().unwrap());
        let folder = file.parent().unwrap();
        assert_eq!(folder.parent(), Some(rig.folder.path()));
        assert_eq!(file.file_stem(), folder.file_name());
        assert!(file.to_str().unwrap().ends_with(&format!("Z-{name}.mcap")), "{said}");
        files.push(file);
        assert_eq!(start(r#"{"name": "third"}"#).0, 409, "one at a time");
        assert_eq!(bags(), files.len(), "what was refused leaves no folder behind");
        until("rows", || {
            let size = |file: &std::path::PathBuf| std::fs::metadata(file).map_or(0, |data| data.len());
            size(files.last().unwrap()) > 10_000
        });
        assert_eq!(rig.send("POST", "/api/record/stop", &[], "").0, 200);
        let recording = || rig.send("GET", "/api/state", &[], "").1["figures"]["recording"].clone();
        until("the end of the recording", || {
            recording()["last"].as_str().is_some_and(|last| last.contains(name))
        });
    }
    for file in files {
        let content = std::fs::read(&file).unwrap();
        let messages = mcap::MessageStream::new(&content).unwrap().map(Result::unwrap).count();
        let metadata = std::fs::read_to_string(file.with_file_name("metadata.yaml")).unwrap();
        assert!(messages > 10, "{messages}");
        assert!(metadata.contains(&format!("  message_count: {messages}\n")), "{messages}: {metadata}");
        assert!(metadata.contains(file.file_name().unwrap().to_str().unwrap()), "{metadata}");
    }
}
