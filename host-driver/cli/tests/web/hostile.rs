//! Clients that do not read, do not finish, or are too many: the bus feels none of them.

use super::rig::{RIGS, Rig, TOKEN, until};
use crate::support::counts;
use pneudrive_protocol::Counts;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::atomic::Ordering;

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
