//! What recordings say of themselves and of what happened, in every format; and that they can be
//! played again.

use crate::support::answer;
use crate::support::virtual_line::{AT_ONCE, VirtualLine};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::notices::{Notice, NoticeKind};
use pneudrive_host::poller::{
    BoardCommand, CommandSource, Pace, PollerOptions, Polling, SourceStatus, VENTED,
};
use pneudrive_protocol::{Counts, Echo, SensorScale};
use pneudrive_record::replay::Rows;
use pneudrive_record::trajectory::{AtEnd, Interpolation, Trajectory};
use pneudrive_record::{Contents, Description, Recorder, RecorderOptions};
use std::io::{Cursor, Read};
use std::path::Path;
use std::time::Duration;

const SCALE: SensorScale = SensorScale::ORIGINAL;
const PERIOD_NS: u64 = 2_000_000;
const FORMATS: [&str; 4] = ["run.csv", "run.csv.gz", "run.csv.zst", "run.mcap"];

/// Another command in each cycle, for every channel its own.
struct Counting(u16);

impl CommandSource for Counting {
    fn fill(&mut self, _: u64, commands: &mut [BoardCommand]) -> SourceStatus {
        self.0 += 1;
        for (board, command) in commands.iter_mut().enumerate() {
            *command = std::array::from_fn(|k| {
                Counts::new(270 + self.0 + 10 * k as u16 + 40 * board as u16).unwrap()
            });
        }
        SourceStatus::Continues
    }
}

/// Records 300 cycles of two boards at 500 Hz. After 100 cycles the adapter is unplugged for a
/// while.
fn record(file: &Path) {
    let line = VirtualLine::new(|_, request| vec![(AT_ONCE, answer(0xFF - request[1], 300))]);
    let options = BusOptions::default().formats(FormatPolicy::Unchecked).echo(EchoMode::Known(Echo::Absent));
    let pace = Pace::every(Duration::from_nanos(PERIOD_NS));
    let polled = PollerOptions::for_devices(2).pace(pace);
    let description =
        Description::default().with("port", "sim").with("rig", "[supply]\npressure_kpa = 550.0\n");
    let names = serde_json::json!({ "1": { "board": "elbow", "3": "front left" } });
    let description = description.with("names", names);
    let how = RecorderOptions::default().description(description);
    let (recorder, tap) = Recorder::create_with(file, &polled.boards, SCALE, &how).unwrap();
    let bus = Bus::new(line, options).unwrap();
    let mut polling = Polling::new(bus, polled, Box::new(Counting(0)), vec![tap]);
    for cycle in 0..300 {
        let due_ns = polling.next_cycle_ns();
        let line = polling.bus_mut().line_mut();
        line.sleep_until(due_ns);
        line.gone |= cycle == 100;
        line.back |= cycle == 110;
        polling.cycle().unwrap();
    }
    drop(polling);
    recorder.notes().add(Notice::new(NoticeKind::End, "duration: the end of \"the test\""));
    recorder.finish().unwrap();
}

/// The text of a table.
fn text(file: &Path) -> String {
    let stored = std::fs::read(file).unwrap();
    let mut text = String::new();
    match file.extension().unwrap().to_str().unwrap() {
        "gz" => drop(flate2::read::MultiGzDecoder::new(&stored[..]).read_to_string(&mut text).unwrap()),
        "zst" => text = String::from_utf8(zstd::decode_all(&stored[..]).unwrap()).unwrap(),
        _ => text = String::from_utf8(stored).unwrap(),
    }
    text
}

/// Time (s; none where the clock is not the line's), kind and text of each event, and what the file
/// says of itself.
type Found = (Vec<(Option<f64>, String, String)>, Vec<(String, serde_json::Value)>);

fn contents_of_table(file: &Path) -> Found {
    let (mut events, mut entries) = (Vec::new(), Vec::new());
    for line in text(file).lines().filter_map(|line| line.strip_prefix("# ")) {
        let (key, value) = line.split_once(": ").unwrap();
        let value: serde_json::Value = serde_json::from_str(value).unwrap();
        if key == "event" {
            let (kind, text) = (value["kind"].as_str().unwrap(), value["text"].as_str().unwrap());
            let t_s = value["t_s"].as_f64().filter(|_| kind != "end");
            events.push((t_s, kind.to_owned(), text.to_owned()));
        } else {
            entries.push((key.to_owned(), value));
        }
    }
    (events, entries)
}

fn contents_of_bag(file: &Path) -> Found {
    use mcap::records::Record;
    let stored = std::fs::read(file).unwrap();
    let mut entries = Vec::new();
    for record in mcap::read::LinearReader::new(&stored).unwrap() {
        if let Record::Metadata(metadata) = record.unwrap()
            && metadata.name == "pneudrive"
        {
            let json = |text: &String| serde_json::from_str(text).unwrap();
            entries.extend(metadata.metadata.iter().map(|(key, value)| (key.clone(), json(value))));
        }
    }
    let (mut events, mut first_ns) = (Vec::new(), None);
    for message in mcap::MessageStream::new(&stored).unwrap() {
        let message = message.unwrap();
        let start_ns = *first_ns.get_or_insert(message.log_time);
        if message.channel.topic == "/pneudrive/events" {
            assert_eq!(message.channel.schema.as_ref().unwrap().name, "rcl_interfaces/msg/Log");
            let (log, _): (pneudrive_record::messages::Log, _) =
                cdr_encoding::from_bytes::<_, byteorder::LittleEndian>(&message.data[4..]).unwrap();
            assert_eq!(log.stamp.unix_ns(), message.log_time);
            let t_s = message.log_time.saturating_sub(start_ns) as f64 * 1e-9;
            events.push((Some(t_s).filter(|_| log.function != "end"), log.function, log.msg));
        }
    }
    (events, entries)
}

#[test]
fn a_recording_says_what_it_is_and_what_happened() {
    for name in FORMATS {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        record(&file);
        let (events, entries) = match name {
            "run.mcap" => contents_of_bag(&file),
            _ => contents_of_table(&file),
        };
        let value = |key: &str| &entries.iter().find(|(found, _)| found == key).expect(key).1;
        assert_eq!(value("pneudrive_recording"), 1, "{name}");
        assert_eq!(value("program"), &format!("pneudrive-host {}", env!("CARGO_PKG_VERSION")));
        assert_eq!(value("port"), "sim");
        assert_eq!(value("boards"), &serde_json::json!([0, 1]));
        assert_eq!(value("rig"), "[supply]\npressure_kpa = 550.0\n", "line ends and quotes survive");
        let created = value("created_utc").as_str().unwrap();
        assert!(created.starts_with("20") && created.ends_with('Z') && created.len() == 24, "{created}");

        let kinds: Vec<_> = events.iter().map(|(_, kind, _)| kind.as_str()).collect();
        assert_eq!(kinds, ["line_lost", "line_back", "vented", "end"], "{name}");
        // The line went in the cycle of row 100; tries to open it again are further apart than
        // cycles.
        let t_s = |event: usize| events[event].0.unwrap();
        assert!((t_s(0) - 0.2).abs() < 1e-6, "{name}: {events:?}");
        assert!(t_s(1) > 0.2 && t_s(1) < 3.0 && t_s(1) == t_s(2), "{name}: {events:?}");
        assert!(events[0].2.contains("virtual"), "{name}: {events:?}");
        assert_eq!(events[3].2, "duration: the end of \"the test\"", "{name}");
    }
}

/// What the views show of a recording is what was recorded, in every format.
#[test]
fn rows_can_be_looked_at_again() {
    let mut all = Vec::new();
    for name in FORMATS {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        record(&file);
        let rows: Vec<_> = Rows::open(&file).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 300, "{name}");
        let first = &rows[0];
        assert_eq!(first.boards.iter().map(|board| board.board).collect::<Vec<_>>(), [0, 1]);
        assert!((first.boards[1].command_kpa[2] - SCALE.kpa(Counts::new(331).unwrap())).abs() < 1e-3);
        assert!((first.boards[0].kpa.unwrap()[0] - SCALE.kpa(Counts::new(300).unwrap())).abs() < 1e-3);
        // While the adapter is away nobody answers.
        assert!(rows.iter().filter(|row| row.boards.iter().any(|board| board.kpa.is_none())).count() > 0);
        all.push(rows);
    }
    // Tables round to 1 Pa and 1 us.
    let near = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-3);
    for pair in all.windows(2) {
        assert_eq!(pair[0].len(), pair[1].len());
        for (a, b) in pair[0].iter().zip(&pair[1]) {
            assert!((a.t_s - b.t_s).abs() < 2e-6, "{a:?}\n{b:?}");
            for (a, b) in a.boards.iter().zip(&b.boards) {
                assert!(near(&a.command_kpa, &b.command_kpa), "{a:?}\n{b:?}");
                match (&a.kpa, &b.kpa) {
                    (Some(a), Some(b)) => assert!(near(a, b), "{a:?}\n{b:?}"),
                    (None, None) => {}
                    _ => panic!("{a:?}\n{b:?}"),
                }
            }
        }
    }
}

/// Who opens a bag elsewhere sees the rig's names at its topics.
#[test]
fn topics_of_a_bag_have_the_names_of_the_rig_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let stored = std::fs::read(&file).unwrap();
    let channels = mcap::Summary::read(&stored).unwrap().unwrap().channels;
    let metadata =
        |topic: &str| channels.values().find(|channel| channel.topic == topic).unwrap().metadata.clone();
    for topic in ["/pneudrive/joint_1/pressure_state", "/pneudrive/joint_1/pressure_command"] {
        let found = metadata(topic);
        assert_eq!((found["name"].as_str(), found["channel_3_name"].as_str()), ("elbow", "front left"));
        assert!(!found.contains_key("channel_0_name"), "{found:?}");
    }
    assert!(!metadata("/pneudrive/joint_0/pressure_state").contains_key("name"));
}

/// Comments between rows, and where they stand: events before the row of their cycle.
#[test]
fn the_rows_of_a_table_are_what_they_are_without_comments() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    record(&file);
    let text = text(&file);
    let lines: Vec<_> = text.lines().collect();
    let header = lines.iter().position(|line| line.starts_with("t_s,")).unwrap();
    assert!(lines[..header].iter().all(|line| line.starts_with("# ")), "{text}");
    assert!(lines[header + 1].starts_with("# t0_utc: \"20"), "{}", lines[header + 1]);
    assert!(lines[header + 2].starts_with("0.000000000,"), "{}", lines[header + 2]);
    let rows: Vec<_> = lines[header + 1..].iter().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(rows.len(), 300);
    assert!(rows.iter().all(|row| row.split(',').count() == 17));
    let lost = lines.iter().position(|line| line.contains("\"line_lost\"")).unwrap();
    assert!(lines[lost + 1].starts_with("0.200"), "{}", lines[lost + 1]);
}

/// Every row comes back at its time, from every format.
#[test]
fn what_was_recorded_can_be_played_again() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("table.csv");
    record(&table);
    let table = text(&table);
    let rows: Vec<_> = table.lines().filter(|line| !line.starts_with('#')).collect();
    for name in FORMATS {
        let file = folder.path().join(name);
        record(&file);
        let trajectory = Trajectory::read(&file, 2, SCALE).unwrap();
        assert_eq!(trajectory.rows(), 300, "{name}");
        assert_eq!(trajectory.first_row_s(), 0.0, "{name}");
        // Cycles without a line are as far apart as the tries to open it.
        let last = rows.last().unwrap().split(',').next().unwrap().parse::<f64>().unwrap();
        assert!(last > 0.6 && (trajectory.seconds() - last).abs() < 1e-6, "{name}: {last} s");
        let mut source = trajectory.play(Interpolation::Hold, AtEnd::Stop, SCALE, vec![VENTED; 2]);
        let mut expected = Counting(0);
        for cycle in 0..100u64 {
            let (mut played, mut recorded) = ([VENTED; 2], [VENTED; 2]);
            source.fill(cycle * PERIOD_NS + 1_000, &mut played);
            expected.fill(0, &mut recorded);
            assert_eq!(played, recorded, "{name}, cycle {cycle}");
        }
        let refused = Trajectory::read(&file, 1, SCALE).unwrap_err().to_string();
        assert!(refused.contains("column b1_cmd0_kpa: there are boards 0 to 0"), "{refused}");
    }
}

/// A bag that was killed has no end.
#[test]
fn a_bag_is_played_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let whole = std::fs::read(&file).unwrap();
    std::fs::write(&file, &whole[..whole.len() - 20]).unwrap();
    assert_eq!(Trajectory::read(&file, 2, SCALE).unwrap().rows(), 300);
    std::fs::write(&file, &whole[..20]).unwrap();
    let refused = Trajectory::read(&file, 2, SCALE).unwrap_err().to_string();
    assert!(refused.contains("run.mcap: not readable as a bag: "), "{refused}");
}

/// Its channel would stay at 0 kPa without a word.
#[test]
fn a_bag_with_a_misspelt_command_is_not_played() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    // Without compression, so that names can be changed in place.
    let mut renamed = Vec::new();
    let mut writer = mcap::WriteOptions::new().compression(None).create(Cursor::new(&mut renamed)).unwrap();
    for message in mcap::MessageStream::new(&std::fs::read(&file).unwrap()).unwrap() {
        let mut message = message.unwrap();
        let data = message.data.to_mut();
        let found = data.windows(11).position(|window| window == b"b0_cmd0_kpa");
        if let Some(at) = found {
            data[at..at + 11].copy_from_slice(b"b0_cmd0_bar");
        }
        writer.write(&message).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    std::fs::write(&file, renamed).unwrap();
    let refused = Trajectory::read(&file, 2, SCALE).unwrap_err().to_string();
    assert!(refused.contains("b0_cmd0_bar"), "{refused}");
}

/// The library's own reader says the same of all formats, and of a file that was cut off.
#[test]
fn every_format_has_the_same_contents() {
    let folder = tempfile::tempdir().unwrap();
    for name in FORMATS {
        let file = folder.path().join(name);
        record(&file);
        let contents = Contents::read(&file).unwrap();
        assert_eq!(contents.rows, 300, "{name}");
        assert_eq!(contents.first_s, Some(0.0), "{name}");
        assert!(contents.last_s.unwrap() > 0.6 && contents.unfinished.is_none(), "{name}: {contents:?}");
        assert_eq!(contents.description["rig"], "[supply]\npressure_kpa = 550.0\n", "{name}");
        let kinds: Vec<_> = contents.events.iter().map(|event| event.kind.as_str()).collect();
        assert_eq!(kinds, ["line_lost", "line_back", "vented", "end"], "{name}");
        assert!((contents.events[0].t_s - 0.2).abs() < 1e-6, "{name}: {contents:?}");
        assert_eq!(contents.end().unwrap().text, "duration: the end of \"the test\"", "{name}");

        let whole = std::fs::read(&file).unwrap();
        std::fs::write(&file, &whole[..whole.len() - 1000]).unwrap();
        let contents = Contents::read(&file).unwrap();
        assert!(contents.description.contains_key("created_utc"), "{name}: {contents:?}");
        assert_eq!(contents.unfinished.is_some(), name != "run.csv", "{name}: {contents:?}");
    }
    let other = folder.path().join("other.csv");
    std::fs::write(&other, "# a list: of things\na,b\n1,2\n").unwrap();
    assert!(Contents::read(&other).unwrap_err().to_string().starts_with("no recording: "));
}
