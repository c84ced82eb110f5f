use super::*;
use pneudrive_host::notices::{Notice, NoticeKind};
use pneudrive_host::poller::{BoardRow, BoardSensors, BoardState, Outcome, VENTED};
use std::time::{Duration, Instant};

fn cycle(observer: &mut dyn Observer, cycle: u64) {
    let board = BoardRow {
        board: 0,
        command: VENTED,
        wanted: VENTED,
        outcome: Outcome::Lost,
        reading: None,
        drives: None,
        sensors: BoardSensors::default(),
        state: BoardState::Present,
    };
    let at_ns = cycle * 1_000_000;
    observer.row(&Row { cycle, at_ns, since_start_ns: at_ns, boards: &[board] });
}

fn settled(switch: &RecordSwitch) -> SwitchStatus {
    let started = Instant::now();
    loop {
        let status = switch.status();
        if !status.finishing && status.running.is_none() {
            return status;
        }
        assert!(started.elapsed() < Duration::from_secs(60), "{status:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn only_what_passes_between_start_and_stop_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let (switch, mut observer) = RecordSwitch::new(&[0], Calibration::default());
    assert_eq!(switch.stop(), Err(SwitchError::NotRunning));
    cycle(&mut *observer, 0);
    switch.start(&file).unwrap();
    assert_eq!(switch.start(&file), Err(SwitchError::Running { file: file.clone() }));
    (1..4).for_each(|number| cycle(&mut *observer, number));
    switch.stop().unwrap();
    cycle(&mut *observer, 4);
    let status = settled(&switch);
    assert_eq!(status.last.unwrap().unwrap().rows, 3);
    let text = std::fs::read_to_string(&file).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let times: Vec<_> = lines.skip(1).filter_map(|line| line.split(',').next()).collect();
    assert_eq!(times, ["0.001000000", "0.002000000", "0.003000000"]);
    assert_eq!(switch.start(&file), Err(SwitchError::Record(RecordError::Exists { file: file.clone() })));
}

/// The reader of a pipe goes: nobody asks for the status, and still it is told, at once and in
/// the end.
#[test]
fn a_recording_that_fails_is_told_and_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let mode = rustix::fs::Mode::from_raw_mode(0o600);
    rustix::fs::mknodat(rustix::fs::CWD, &file, rustix::fs::FileType::Fifo, mode, 0).unwrap();
    let theirs = file.clone();
    // Opening the pipe waits for both ends; what comes before the rows is written at once.
    let reader = std::thread::spawn(move || {
        use std::io::Read;
        std::fs::File::open(theirs).unwrap().read_exact(&mut [0]).unwrap();
    });
    let (told, hears) = channel();
    let (switch, mut observer) = RecordSwitch::new(&[0], Calibration::default());
    let switch = switch.on_failure(move |error| told.send(error.to_string()).unwrap());
    switch.start(&file).unwrap();
    reader.join().unwrap();
    (0..100).for_each(|number| cycle(&mut *observer, number));
    let error = hears.recv_timeout(Duration::from_secs(60)).unwrap();
    assert!(error.contains("Broken pipe"), "{error}");
    // Another one succeeds; the run has failed all the same.
    settled(&switch);
    let second = folder.path().join("second.csv");
    switch.start(&second).unwrap();
    drop(observer);
    assert_eq!(switch.finish().unwrap().unwrap_err().to_string(), error);
    assert!(second.exists());
}

#[test]
fn what_is_noted_goes_into_the_recording_in_progress() {
    let folder = tempfile::tempdir().unwrap();
    let (switch, mut observer) = RecordSwitch::new(&[0], Calibration::default());
    let switch = switch.describe(Description::default().with("port", "sim"));
    let note = |text: &str| switch.notes().add(Notice::new(NoticeKind::Page, text));
    note("before");
    for name in ["first.csv", "second.csv"] {
        switch.start(&folder.path().join(name)).unwrap();
        cycle(&mut *observer, 1);
        note(name);
        observer.event(&Event::Vented);
        cycle(&mut *observer, 2);
        switch.stop().unwrap();
        cycle(&mut *observer, 3);
        settled(&switch);
        note("between");
        let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(text.starts_with("# pneudrive_recording: 1\n"), "{text}");
        assert!(text.contains("\n# port: \"sim\"\n"), "{text}");
        let events: Vec<_> = text.lines().filter(|line| line.starts_with("# event: ")).collect();
        assert_eq!(events.len(), 2, "{text}");
        assert!(text.contains(&format!("\"kind\":\"page\",\"text\":\"{name}\"}}\n")), "{text}");
        // What happens on the bus has the time of its cycle, and stands before its row.
        assert!(text.contains("{\"t_s\":0.002,\"kind\":\"vented\""), "{text}");
    }
}

#[test]
fn the_end_of_the_poller_ends_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let (switch, mut observer) = RecordSwitch::new(&[0], Calibration::default());
    switch.start(&folder.path().join("run.csv")).unwrap();
    cycle(&mut *observer, 0);
    drop(observer);
    assert_eq!(switch.finish().unwrap().unwrap().rows, 1);
    assert!(switch.finish().is_none());
}
