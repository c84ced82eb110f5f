//! The live page's HTTP side against boards behind a pty: who is let in, what the actions do to the boards, and that no client
//! stops the bus.

#![cfg(feature = "web")]

use crate::support::counts;
use crate::support::pty::PtyBoards;
use pneudrive_host::bus::{Bus, BusOptions, EchoMode};
use pneudrive_host::line::Clock;
use pneudrive_host::poller::{Override, Pace, Poller, PollerOptions, SetPoints};
use pneudrive_host::record::RecordSwitch;
use pneudrive_host::web::{Control, Labels, Listener, Recording, Server, Token, WebOptions};
use pneudrive_protocol::{Counts, Echo, SensorScale};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

const TOKEN: &str = "a-token-of-the-tests";
const PATIENCE: Duration = Duration::from_secs(60);

/// Two boards at 100 kPa, polled at 200 Hz, and their page.
struct Rig {
    boards: PtyBoards,
    poller: Poller,
    server: Server,
    address: SocketAddr,
    folder: tempfile::TempDir,
    notices: Arc<Mutex<Vec<String>>>,
}

/// Pages of all tests, each of which has one thread for its clients.
static RIGS: AtomicUsize = AtomicUsize::new(0);

impl Rig {
    fn start(control: bool) -> Self {
        Self::start_with(control, "csv", None)
    }

    /// The recording button makes files that end so.
    fn start_recording(control: bool, ending: &str) -> Self {
        Self::start_with(control, ending, None)
    }

    /// With `deadman`, whoever commands is watched.
    fn start_with(control: bool, ending: &str, deadman: Option<Duration>) -> Self {
        RIGS.fetch_add(1, Ordering::Relaxed);
        let boards = PtyBoards::start(2);
        let bus_options = BusOptions {
            echo: EchoMode::Known(Echo::Absent),
            answer_allowance_ns: 1_000_000_000,
            ..BusOptions::default()
        };
        let bus = Bus::open(boards.path(), bus_options).unwrap();
        let overriding = Override::manual(&[counts(221); 2]);
        let folder = tempfile::tempdir().unwrap();
        let (switch, tap) = RecordSwitch::new(&[0, 1], SensorScale::ORIGINAL);
        let notices = Arc::new(Mutex::new(Vec::new()));
        let heard = Arc::clone(&notices);
        let options = WebOptions {
            port: "the pty".into(),
            boards: vec![0, 1],
            labels: Labels::default(),
            calibration: SensorScale::ORIGINAL.into(),
            names: vec!["robot.example".into()],
            overriding: Some(overriding.clone()),
            control: control.then(|| Control {
                token: Token::new(TOKEN).unwrap(),
                limit_kpa: 150.0,
                deadman,
            }),
            recording: Some(Recording { switch, folder: folder.path().into(), ending: ending.into() }),
            whole_run: None,
            watch: None,
            lines: None,
            notice: Box::new(move |line| heard.lock().unwrap().push(line)),
        };
        let pace = Pace::Every { period_ns: 5_000_000, missed: Default::default() };
        let vent = overriding.latch();
        let poller_options = PollerOptions { pace, vent, ..PollerOptions::for_devices(2) };
        let source = overriding.over(Box::new(SetPoints::new(2)));
        let poller = Poller::start(bus, poller_options, source, vec![tap]).unwrap();
        let listener = Listener::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let address = listener.address();
        let server = listener.serve(options, poller.monitor(), Clock).unwrap();
        Self { boards, poller, server, address, folder, notices }
    }

    /// Status and JSON of an answer.
    fn send(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> (u16, Value) {
        let (status, text) = self.exchange(method, path, headers, body);
        (status, serde_json::from_str(&text).unwrap_or(Value::String(text)))
    }

    fn exchange(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> (u16, String) {
        let mut stream = self.request(method, path, headers, body);
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
    }

    fn request(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> TcpStream {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut text = format!("{method} {path} HTTP/1.1\r\nContent-Length: {}\r\n", body.len());
        if !headers.iter().any(|(name, _)| *name == "Host") {
            text += &format!("Host: {}\r\n", self.address);
        }
        for (name, value) in headers {
            text += &format!("{name}: {value}\r\n");
        }
        stream.write_all(format!("{text}\r\n{body}").as_bytes()).unwrap();
        stream
    }

    fn set(&self, token: Option<&str>, body: &Value) -> u16 {
        let bearer = token.map(|token| format!("Bearer {token}"));
        let mut headers = vec![("Content-Type", "application/json")];
        headers.extend(bearer.as_deref().map(|bearer| ("Authorization", bearer)));
        self.send("POST", "/api/set", &headers, &body.to_string()).0
    }

    /// Waits until the boards were sent this by the bus.
    fn until_commanded(&self, expected: [[Counts; 4]; 2]) {
        until("the commands", || {
            let boards = self.poller.latest().boards;
            boards.len() == 2 && [boards[0].command, boards[1].command] == expected
        });
    }

    fn pictures(&self) -> Pictures {
        Pictures(BufReader::new(self.request("GET", "/events", &[], "")))
    }
}

/// A client that looks.
struct Pictures(BufReader<TcpStream>);

impl Pictures {
    /// The data of the next event with this name.
    fn next(&mut self, name: &str) -> Value {
        let (mut line, mut event) = (String::new(), String::new());
        loop {
            line.clear();
            assert!(self.0.read_line(&mut line).unwrap() > 0, "the stream ended before an event {name}");
            if let Some(name) = line.strip_prefix("event: ") {
                event = name.trim().to_owned();
            }
            if let Some(data) = line.strip_prefix("data: ")
                && event == name
            {
                return serde_json::from_str(data).unwrap();
            }
        }
    }
}

#[track_caller]
fn until(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < PATIENCE, "waiting for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn pictures_come_and_go_on_for_every_client() {
    let rig = Rig::start(false);
    rig.until_commanded([counts(221); 2]);
    let (status, page) = rig.exchange("GET", "/", &[], "");
    assert!(status == 200 && page.contains("VENT ALL"), "{page}");
    let (mut one, mut other) = (rig.pictures(), rig.pictures());
    for client in [&mut one, &mut other] {
        let hello = client.next("hello");
        assert_eq!((&hello["boards"], &hello["control_limit_kpa"]), (&json!([0, 1]), &Value::Null));
        assert!(client.next("past")["t"].is_array());
        let mut before = -1.0;
        for _ in 0..3 {
            let picture = client.next("picture");
            assert!(picture["t"].as_f64().unwrap() > before, "{picture}");
            before = picture["t"].as_f64().unwrap();
            assert_eq!(picture["boards"][1]["c"], json!([99.8, 99.8, 99.8, 99.8]), "{picture}");
            assert_eq!(picture["boards"][1]["s"], picture["boards"][1]["c"], "{picture}");
        }
        // The first figures may be of before the first cycle.
        while client.next("figures")["statistics"]["exchanges"]
            .as_u64()
            .is_none_or(|exchanges| exchanges == 0)
        {}
    }
    let (_, state) = rig.send("GET", "/api/state", &[], "");
    assert_eq!(state["picture"]["commanding"], "set points", "{state}");
    assert_eq!(rig.send("GET", "/etc/passwd", &[], "").0, 404);
    assert_eq!(rig.send("PUT", "/", &[], "").0, 405);
}

/// No token, no body: and it holds until it is released.
#[test]
fn anybody_can_vent_and_it_holds() {
    let rig = Rig::start(true);
    let mut pictures = rig.pictures();
    rig.until_commanded([counts(221); 2]);
    assert_eq!(rig.send("POST", "/api/vent", &[], ""), (200, json!({ "commanding": "vented" })));
    rig.until_commanded([[Counts::ATMOSPHERE; 4]; 2]);
    until("the picture of it", || pictures.next("picture")["commanding"] == "vented");
    assert_eq!(rig.set(Some(TOKEN), &json!({ "board": 0, "channel": 0, "kpa": 50.0 })), 409);
    assert_eq!(rig.send("POST", "/api/release", &[], "").0, 401);
    assert_eq!(rig.send("POST", "/api/release", &[("Authorization", "Bearer wrong")], "").0, 403);
    rig.until_commanded([[Counts::ATMOSPHERE; 4]; 2]);
    let bearer = format!("Bearer {TOKEN}");
    assert_eq!(rig.send("POST", "/api/release", &[("Authorization", &bearer)], "").0, 200);
    assert_eq!(rig.set(Some(TOKEN), &json!({ "board": 1, "channel": 2, "kpa": 100.0 })), 200);
    let zero = Counts::ATMOSPHERE;
    rig.until_commanded([[zero; 4], [zero, zero, Counts::saturating(221), zero]]);
    let notices = rig.notices.lock().unwrap().join("\n");
    assert!(notices.contains("vented from the web page (127.0.0.1)"), "{notices}");
}

#[test]
fn set_points_need_the_token_and_sense() {
    let rig = Rig::start(true);
    let good = json!({ "board": 0, "channel": 3, "kpa": 50.0 });
    assert_eq!(rig.set(None, &good), 401);
    assert_eq!(rig.set(Some("a-token-of-the-testS"), &good), 403);
    for (nonsense, status) in [
        (json!({ "board": 0, "channel": 3, "kpa": 150.1 }), 422),
        (json!({ "board": 0, "channel": 3, "kpa": -1 }), 422),
        (json!({ "board": 0, "channel": 4, "kpa": 1 }), 422),
        (json!({ "board": 2, "channel": 0, "kpa": 1 }), 422),
        (json!({ "board": -1, "channel": 0, "kpa": 1 }), 400),
        (json!({ "board": 0, "channel": 0, "kpa": null }), 400),
        (json!({ "board": 0, "channel": 0 }), 400),
        (json!([]), 400),
    ] {
        assert_eq!(rig.set(Some(TOKEN), &nonsense), status, "{nonsense}");
    }
    rig.until_commanded([counts(221); 2]);
    assert_eq!(rig.set(Some(TOKEN), &good), 200);
    let set = Counts::saturating(162);
    rig.until_commanded([[counts(221)[0], counts(221)[1], counts(221)[2], set], counts(221)]);
    let as_text = rig.send(
        "POST",
        "/api/set",
        &[("Authorization", &format!("Bearer {TOKEN}")), ("Content-Type", "text/plain")],
        &good.to_string(),
    );
    assert_eq!(as_text.0, 415, "what a foreign page can send without asking");
    let looking = Rig::start(false);
    assert_eq!(looking.set(Some(TOKEN), &good), 403, "without --allow-control there is no token");
}

/// DNS rebinding and cross-site requests: also for what needs no token.
#[test]
fn foreign_pages_get_nothing_and_do_nothing() {
    let rig = Rig::start(true);
    for path in ["/", "/events", "/api/state"] {
        assert_eq!(rig.send("GET", path, &[("Host", "evil.example")], "").0, 421, "{path}");
    }
    let own = format!("http://{}", rig.address);
    for headers in [
        &[("Host", "evil.example")][..],
        &[("Origin", "http://evil.example")],
        &[("Origin", "null")],
        &[("Sec-Fetch-Site", "cross-site"), ("Origin", &own)],
    ] {
        let (status, said) = rig.send("POST", "/api/vent", headers, "");
        assert!(status == 421 || status == 403, "{headers:?}: {status} {said}");
        assert!(said["error"].is_string(), "{said}");
    }
    rig.until_commanded([counts(221); 2]);
    assert_eq!(rig.send("POST", "/api/vent", &[("Origin", &own)], "").0, 200);
    let named = [("Host", "robot.example:80"), ("Origin", "http://robot.example:80")];
    assert_eq!(rig.send("POST", "/api/vent", &named, "").0, 200);
}

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

/// Each in a folder of its own, or the next one's metadata.yaml would replace it.
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

/// One client that reads nothing, and more clients than there is room for.
#[test]
fn clients_that_do_not_read_stop_nobody() {
    let rig = Rig::start(false);
    rig.until_commanded([counts(221); 2]);
    let deaf = rig.pictures();
    let mut crowd: Vec<_> = (0..15).map(|_| rig.pictures()).collect();
    crowd.iter_mut().for_each(|client| drop(client.next("hello")));
    assert_eq!(rig.exchange("GET", "/events", &[], "").0, 503);
    let before = rig.poller.latest().cycle.unwrap();
    for client in &mut crowd {
        client.next("picture");
    }
    until("cycles", || rig.poller.latest().cycle.unwrap() > before + 100);
    assert_eq!(rig.send("POST", "/api/vent", &[], "").0, 200, "there is always room for this");
    rig.until_commanded([[Counts::ATMOSPHERE; 4]; 2]);
    // Half a request takes a place for some seconds, and stops nobody either.
    let mut half = TcpStream::connect(rig.address).unwrap();
    half.write_all(b"POST /api/vent HTTP/1.1\r\n").unwrap();
    assert_eq!(rig.send("POST", "/api/vent", &[], "").0, 200);
    drop(crowd.pop());
    until("a free place", || {
        let mut stream = rig.request("GET", "/events", &[], "");
        let mut start = [0; 12];
        stream.read_exact(&mut start).unwrap();
        &start == b"HTTP/1.1 200"
    });
    drop(deaf);
}

/// Half-sent heads, bodies that do not come, idle connections and streams that nobody reads, more
/// than there are places for.
#[test]
fn the_bus_does_not_feel_hostile_clients() {
    let rig = Rig::start(true);
    rig.until_commanded([counts(221); 2]);
    let token = format!("Bearer {TOKEN}");
    let mut crowd: Vec<_> = (0..300)
        .map(|number| {
            let mut stream = TcpStream::connect(rig.address).unwrap();
            let nuisance = match number % 4 {
                0 => "POST /api/vent HTTP/1.1\r\nHost: ".to_owned(),
                1 => format!(
                    "POST /api/set HTTP/1.1\r\nHost: {}\r\nAuthorization: {token}\r\nContent-Length: 99\r\n\r\n{{",
                    rig.address
                ),
                2 => format!("GET /events HTTP/1.1\r\nHost: {}\r\n\r\n", rig.address),
                _ => String::new(),
            };
            stream.write_all(nuisance.as_bytes()).unwrap();
            stream
        })
        .collect();
    let before = rig.poller.latest().cycle.unwrap();
    until("cycles", || rig.poller.latest().cycle.unwrap() > before + 200);
    assert_eq!(rig.send("POST", "/api/vent", &[], "").0, 200, "at the first try");
    rig.until_commanded([[Counts::ATMOSPHERE; 4]; 2]);
    // One thread serves all of them.
    let threads: Vec<_> = std::fs::read_dir("/proc/self/task")
        .unwrap()
        .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok())
        .filter(|name| name.starts_with("pneudrive-web") || name.starts_with("pneudrive-client"))
        .collect();
    let pages = threads.len();
    assert!(pages <= RIGS.load(Ordering::Relaxed), "{threads:?}");
    crowd.clear();
    let finished = rig.poller.stop().unwrap();
    let statistics = finished.statistics;
    assert_eq!((statistics.lost, statistics.rejected), (0, 0), "{statistics:?}");
    assert!(finished.not_safe.is_empty() && finished.error.is_none());
}

#[test]
fn whoever_commands_is_watched_with_a_deadman_for_everybody() {
    let rig = Rig::start_with(true, "csv", Some(Duration::from_millis(500)));
    let mut pictures = rig.pictures();
    let hello = pictures.next("hello");
    assert_eq!((&hello["deadman_s"], &hello["deadman_required"]), (&json!(0.5), &json!(true)));
    rig.until_commanded([counts(221); 2]);
    assert_eq!(pictures.next("picture")["deadman"], false, "set points of the command line are nobody's");
    // A script is watched too.
    assert_eq!(rig.set(Some(TOKEN), &json!({ "board": 0, "channel": 0, "kpa": 50.0 })), 200);
    until("the picture of it", || pictures.next("picture")["commanding"] == "vented");
    rig.until_commanded([[Counts::ATMOSPHERE; 4]; 2]);
    // Lines are kept for clients that come later.
    let line = rig.pictures().next("line")["text"].clone();
    assert!(line.as_str().unwrap().contains("the operator's page has been gone for"), "{line}");
    let notices = rig.notices.lock().unwrap().join("\n");
    assert!(notices.contains("(deadman mode)"), "{notices}");
}

#[test]
fn clients_are_told_why_it_ended() {
    let rig = Rig::start(false);
    let mut pictures = rig.pictures();
    pictures.next("picture");
    drop(rig.boards);
    until("the poller's end", || rig.poller.is_finished());
    let reason = rig.poller.stop().unwrap().error.unwrap().to_string();
    assert!(rig.server.end(Some(&reason)).is_none());
    assert_eq!(pictures.next("end"), json!({ "reason": reason }));
    let mut rest = String::new();
    pictures.0.read_to_string(&mut rest).unwrap();
    assert_eq!(rest.trim(), "0", "and then no more: the body's last chunk is empty");
}
