//! A run that is not there, its page, and clients that send whatever they like.

use pneudrive_page::{
    BoardMoment, BoardState, Commanding, Control, Listener, Moment, PageOptions, Refusal, Run, Server,
    SetPoint, Token, WatchMoment,
};
use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

pub const TOKEN: &str = "a-token-of-the-tests";
pub const PATIENCE: Duration = Duration::from_secs(60);

/// One board that obeys at once. It notes which threads ask it what.
#[derive(Default)]
pub struct FakeRun {
    vented: AtomicBool,
    pub vents: AtomicU64,
    cycles: AtomicU64,
    pub set: Mutex<Vec<SetPoint>>,
    pub notices: Mutex<Vec<String>>,
    pub lookers: Mutex<BTreeSet<String>>,
    pub actors: Mutex<BTreeSet<String>>,
}

fn note(threads: &Mutex<BTreeSet<String>>) {
    let name = std::thread::current().name().unwrap_or("nameless").to_owned();
    threads.lock().unwrap().insert(name);
}

impl FakeRun {
    pub fn is_vented(&self) -> bool {
        self.vented.load(Ordering::Relaxed)
    }
}

impl Run for FakeRun {
    fn moment(&self) -> Option<Moment> {
        note(&self.lookers);
        let cycle = self.cycles.fetch_add(1, Ordering::Relaxed);
        let command_kpa = if self.is_vented() { [0.0; 4] } else { [100.0; 4] };
        Some(Moment {
            cycle,
            since_start_ns: cycle * 33_000_000,
            age: Duration::ZERO,
            commanding: self.commanding(),
            release_returns: false,
            boards: vec![BoardMoment {
                state: BoardState::Present,
                command_kpa,
                target_kpa: command_kpa,
                supply_kpa: None,
                chip_c: None,
                reading: None,
            }],
        })
    }

    fn statistics(&self) -> serde_json::Value {
        note(&self.lookers);
        serde_json::json!({ "lost": 0 })
    }

    fn watch(&self) -> Option<WatchMoment> {
        note(&self.lookers);
        Some(WatchMoment { words: "watch learns (1 of 4)".into(), warning: false })
    }

    fn lines(&self) -> Vec<String> {
        note(&self.lookers);
        Vec::new()
    }

    fn vent(&self) -> bool {
        note(&self.actors);
        self.vents.fetch_add(1, Ordering::Relaxed);
        !self.vented.swap(true, Ordering::Relaxed)
    }

    fn release(&self) -> bool {
        note(&self.actors);
        self.vented.store(false, Ordering::Relaxed);
        false
    }

    fn set(&self, set_point: SetPoint) -> Result<f64, Refusal> {
        note(&self.actors);
        self.set.lock().unwrap().push(set_point);
        Ok(set_point.kpa)
    }

    fn commanding(&self) -> Commanding {
        if self.is_vented() { Commanding::Vented } else { Commanding::SetPoints }
    }

    fn notice(&self, line: String) {
        self.notices.lock().unwrap().push(line);
    }
}

/// A page of such a run.
pub struct Page {
    pub run: Arc<FakeRun>,
    pub server: Server,
    pub address: SocketAddr,
}

impl Page {
    pub fn start(deadman: Option<Duration>) -> Self {
        let run = Arc::new(FakeRun::default());
        let options = PageOptions {
            port: "nowhere".into(),
            boards: vec![0],
            labels: pneudrive_page::Labels::default(),
            full_scale_kpa: 689.5,
            names: Vec::new(),
            control: Some(Control { token: Token::new(TOKEN).unwrap(), limit_kpa: 150.0, deadman }),
            recordings: None,
            whole_run: None,
        };
        let listener = Listener::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let address = listener.address();
        let server = listener.serve(options, Arc::clone(&run) as Arc<dyn Run>).unwrap();
        Self { run, server, address }
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends these bytes and reads until the server ends the connection.
    pub fn raw(&self, bytes: &[u8]) -> String {
        let mut stream = self.connect();
        stream.write_all(bytes).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8(answer).unwrap()
    }

    /// An action with the token; status and body.
    pub fn act(&self, path: &str, body: &str) -> (u16, String) {
        let answer = self.raw(
            format!(
                "POST {path} HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {TOKEN}\r\nContent-Type: application/json\r\n\
                 Content-Length: {}\r\n\r\n{body}",
                self.address,
                body.len()
            )
            .as_bytes(),
        );
        (status(&answer), answer.split_once("\r\n\r\n").unwrap().1.to_owned())
    }
}

/// An answer's status.
pub fn status(answer: &str) -> u16 {
    answer.split(' ').nth(1).unwrap_or_else(|| panic!("no answer: {answer:?}")).parse().unwrap()
}

/// One try to vent. `None` where the server ends the connection without an answer.
pub fn try_to_vent(mut stream: TcpStream, host: SocketAddr) -> Option<u16> {
    stream.set_read_timeout(Some(PATIENCE)).ok()?;
    stream.write_all(format!("POST /api/vent HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes()).ok()?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).ok()?;
    (!answer.is_empty()).then(|| status(&answer))
}
