//! Two boards behind a pty and their page, and clients of it.

use crate::support::counts;
use crate::support::pty::PtyBoards;
use pneudrive_host::bus::{Bus, BusOptions, EchoMode};
use pneudrive_host::line::Clock;
use pneudrive_host::poller::{Override, Pace, Poller, PollerOptions, SetPoints};
use pneudrive_host_cli::page::{Control, Labels, Listener, Recording, Server, Token, WebOptions};
use pneudrive_protocol::{Counts, Echo, SensorScale};
use pneudrive_record::RecordSwitch;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

pub(super) const TOKEN: &str = "a-token-of-the-tests";
pub(super) const PATIENCE: Duration = Duration::from_secs(60);

/// Two boards at 100 kPa, polled at 200 Hz, and their page.
pub(super) struct Rig {
    pub(super) boards: PtyBoards,
    pub(super) poller: Poller,
    pub(super) server: Server,
    pub(super) address: SocketAddr,
    pub(super) folder: tempfile::TempDir,
    pub(super) notices: Arc<Mutex<Vec<String>>>,
}

/// Pages of all tests, each of which has one thread for its clients.
pub(super) static RIGS: AtomicUsize = AtomicUsize::new(0);

impl Rig {
    pub(super) fn start(control: bool) -> Self {
        Self::start_with(control, "csv", None)
    }

    /// The recording button makes files that end so.
    pub(super) fn start_recording(control: bool, ending: &str) -> Self {
        Self::start_with(control, ending, None)
    }

    /// With `deadman`, whoever commands is watched.
    pub(super) fn start_with(control: bool, ending: &str, deadman: Option<Duration>) -> Self {
        RIGS.fetch_add(1, Ordering::Relaxed);
        let boards = PtyBoards::start(2);
        let bus_options = BusOptions::default()
            .echo(EchoMode::Known(Echo::Absent))
            .answer_allowance(Duration::from_secs(1));
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
        let pace = Pace::every(Duration::from_millis(5));
        let vent = overriding.latch();
        let poller_options = PollerOptions::for_devices(2).pace(pace).vent(vent);
        let source = overriding.over(Box::new(SetPoints::new(2)));
        let poller = Poller::start(bus, poller_options, source, vec![tap]).unwrap();
        let listener = Listener::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let address = listener.address();
        let server = listener.serve(options, poller.monitor(), Clock).unwrap();
        Self { boards, poller, server, address, folder, notices }
    }

    /// Status and JSON of an answer.
    pub(super) fn send(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> (u16, Value) {
        let (status, text) = self.exchange(method, path, headers, body);
        (status, serde_json::from_str(&text).unwrap_or(Value::String(text)))
    }

    pub(super) fn exchange(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> (u16, String) {
        let mut stream = self.request(method, path, headers, body);
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
    }

    pub(super) fn request(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> TcpStream {
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

    pub(super) fn set(&self, token: Option<&str>, body: &Value) -> u16 {
        let bearer = token.map(|token| format!("Bearer {token}"));
        let mut headers = vec![("Content-Type", "application/json")];
        headers.extend(bearer.as_deref().map(|bearer| ("Authorization", bearer)));
        self.send("POST", "/api/set", &headers, &body.to_string()).0
    }

    /// Waits until the boards were sent this by the bus.
    pub(super) fn until_commanded(&self, expected: [[Counts; 4]; 2]) {
        until("the commands", || {
            let boards = self.poller.latest().boards;
            boards.len() == 2 && [boards[0].command, boards[1].command] == expected
        });
    }

    pub(super) fn pictures(&self) -> Pictures {
        Pictures(BufReader::new(self.request("GET", "/events", &[], "")))
    }
}

/// A client that looks.
pub(super) struct Pictures(pub(super) BufReader<TcpStream>);

impl Pictures {
    /// The data of the next event with this name.
    pub(super) fn next(&mut self, name: &str) -> Value {
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
pub(super) fn until(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < PATIENCE, "waiting for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
