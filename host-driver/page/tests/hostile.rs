//! Clients that want to keep others out.

use crate::support::{Page, TOKEN, try_to_vent};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{JoinHandle, sleep};
use std::time::Duration;

/// A vent that is not through after so many tries is kept out.
const MOST_TRIES: u32 = 10;

/// Two ends of every connection are in this process.
fn allow_many_files() {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    if current.is_some_and(|current| current < 4_096) {
        setrlimit(
            Resource::Nofile,
            Rlimit { current: maximum.map_or(Some(4_096), |m| Some(m.min(4_096))), maximum },
        )
        .unwrap();
    }
    let current = getrlimit(Resource::Nofile).current;
    assert!(current.is_none_or(|current| current >= 2_048), "this test needs 2048 files: {current:?}");
}

/// What hostile clients send, by turns.
fn nuisance(number: usize, host: SocketAddr) -> Vec<u8> {
    match number % 6 {
        0 => b"POST /api/vent HTTP/1.1\r\nHost: half".to_vec(),
        1 => format!(
            "POST /api/set HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {TOKEN}\r\n\
             Content-Type: application/json\r\nContent-Length: 4000\r\n\r\n{{"
        )
        .into_bytes(),
        2 => Vec::new(),
        3 => vec![0x16, 0x03, 0x01, 0xff, 0x00, 0x0a],
        4 => format!("GET /events HTTP/1.1\r\nHost: {host}\r\n\r\n").into_bytes(),
        _ => format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n").into_bytes(),
    }
}

/// Clients that keep so many connections open, reading nothing, and replace each that the server
/// ends.
struct Crowd {
    stop: Arc<AtomicBool>,
    replaced: Arc<AtomicU64>,
    threads: Vec<JoinHandle<()>>,
}

impl Crowd {
    fn gather(address: SocketAddr, threads: usize, each: usize) -> Self {
        let (stop, replaced) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let ready = Arc::new(AtomicU64::new(0));
        let threads: Vec<_> = (0..threads)
            .map(|_| {
                let (stop, replaced, ready) = (Arc::clone(&stop), Arc::clone(&replaced), Arc::clone(&ready));
                std::thread::spawn(move || {
                    let mut number = 0;
                    let mut client = move || {
                        number += 1;
                        let mut stream = TcpStream::connect(address).ok()?;
                        stream.set_nonblocking(true).ok()?;
                        stream.write_all(&nuisance(number, address)).ok()?;
                        Some(stream)
                    };
                    let mut clients: Vec<_> = (0..each).map(|_| client()).collect();
                    ready.fetch_add(1, Ordering::Relaxed);
                    while !stop.load(Ordering::Relaxed) {
                        for place in &mut clients {
                            let ended = place.as_ref().is_none_or(has_ended);
                            if ended {
                                *place = client();
                                replaced.fetch_add(1, Ordering::Relaxed);
                            }
                        }
                        sleep(Duration::from_millis(1));
                    }
                })
            })
            .collect();
        while ready.load(Ordering::Relaxed) < threads.len() as u64 {
            sleep(Duration::from_millis(5));
        }
        Self { stop, replaced, threads }
    }

    fn disperse(self) -> u64 {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads {
            thread.join().unwrap();
        }
        self.replaced.load(Ordering::Relaxed)
    }
}

/// Whether the server has ended this connection. Nothing is taken out of it: what is not read stays
/// unread.
fn has_ended(stream: &TcpStream) -> bool {
    let mut byte = [0];
    match stream.peek(&mut byte) {
        Ok(count) => count == 0,
        Err(error) => error.kind() != ErrorKind::WouldBlock,
    }
}

fn tries_to_vent(page: &Page) -> u32 {
    (1..=MOST_TRIES)
        .find(|_| try_to_vent(TcpStream::connect(page.address).unwrap(), page.address) == Some(200))
        .unwrap_or(u32::MAX)
}

/// All from one address, which is also the one that vents.
#[test]
fn half_sent_requests_do_not_keep_a_vent_out() {
    let page = Page::start(None);
    let _half: Vec<_> = (0..200)
        .map(|_| {
            let mut stream = page.connect();
            stream.write_all(b"POST /api/vent HTTP/1.1\r\nHost: ").unwrap();
            stream
        })
        .collect();
    assert_eq!(tries_to_vent(&page), 1);
    assert!(page.run.is_vented());
    assert!(page.server.dropped() >= 200 - 128, "{}", page.server.dropped());
}

/// Half-sent heads, bodies that do not come, idle connections, what is no HTTP, streams and pages
/// that nobody reads.
#[test]
fn a_vent_gets_past_a_thousand_hostile_clients() {
    allow_many_files();
    let page = Page::start(None);
    let crowd = Crowd::gather(page.address, 4, 250);
    let mut most = 0;
    for round in 1..=20 {
        let tries = tries_to_vent(&page);
        assert!(tries <= MOST_TRIES, "kept out in round {round}");
        assert!(page.run.is_vented());
        most = most.max(tries);
        let released = (0..MOST_TRIES).any(|_| {
            let request = format!(
                "POST /api/release HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {TOKEN}\r\n\r\n",
                page.address
            );
            let mut stream = page.connect();
            let _ = stream.write_all(request.as_bytes());
            let _ = stream.read_to_end(&mut Vec::new());
            !page.run.is_vented()
        });
        assert!(released, "in round {round}");
    }
    let replaced = crowd.disperse();
    assert!(page.server.dropped() > 100, "the crowd was there: {}", page.server.dropped());
    println!("at most {most} tries, {} dropped, {replaced} came again", page.server.dropped());
    assert!(page.run.set.lock().unwrap().is_empty(), "half a body is no set point");
    // Whatever the number of clients: one thread looks at the run, one other acts on it.
    let names = |threads: &std::sync::Mutex<std::collections::BTreeSet<String>>| {
        threads.lock().unwrap().iter().cloned().collect::<Vec<_>>()
    };
    assert_eq!(names(&page.run.lookers), ["pneudrive-look"]);
    assert_eq!(names(&page.run.actors), ["pneudrive-web"]);
}

/// Streams are the only connections that may last. One client cannot have all of them.
#[test]
fn streams_of_one_client_are_limited() {
    let page = Page::start(None);
    let open = || {
        let mut stream = page.connect();
        stream
            .write_all(format!("GET /events HTTP/1.1\r\nHost: {}\r\n\r\n", page.address).as_bytes())
            .unwrap();
        let mut start = [0; 12];
        stream.read_exact(&mut start).unwrap();
        (String::from_utf8(start.to_vec()).unwrap(), stream)
    };
    let mut streams: Vec<_> = (0..16).map(|_| open()).collect();
    assert!(streams.iter().all(|(start, _)| start == "HTTP/1.1 200"));
    assert_eq!(open().0, "HTTP/1.1 503");
    // Pages without a stream ask for single pictures; the first one may not have been taken yet.
    let state = || page.raw(format!("GET /api/state HTTP/1.1\r\nHost: {}\r\n\r\n", page.address).as_bytes());
    let mut told = state();
    while told.contains("\"picture\":null") {
        sleep(Duration::from_millis(5));
        told = state();
    }
    assert!(told.contains("\"hello\":{") && told.contains("\"commanding\":\"set points\""), "{told}");
    drop(streams.pop());
    while open().0 != "HTTP/1.1 200" {
        sleep(Duration::from_millis(5));
    }
}
