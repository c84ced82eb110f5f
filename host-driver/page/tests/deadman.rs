//! Deadman mode by requests. Its times are held in virtual time by `src/deadman.rs`.

use crate::support;
use crate::support::{PATIENCE, Page};
use std::thread::sleep;
use std::time::{Duration, Instant};

#[track_caller]
fn until(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < PATIENCE, "waiting for {what}");
        sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_set_point_without_heartbeats_vents() {
    let page = Page::start(Some(Duration::from_millis(500)));
    let (status, _) = page.act("/api/set", r#"{"board": 0, "channel": 1, "kpa": 50, "page": "one"}"#);
    assert_eq!((status, page.run.set.lock().unwrap().len()), (200, 1));
    until("the vent", || page.run.is_vented());
    let notices = page.run.notices.lock().unwrap().clone();
    assert!(
        notices[0].starts_with("all boards vented because the operator's page has been gone for 0."),
        "{notices:?}"
    );
    // Nobody is watched any more.
    assert_eq!(page.act("/api/heartbeat", r#"{"page": "one"}"#), (200, r#"{"armed":false}"#.into()));
    assert_eq!(page.act("/api/release", "").0, 200);
}

#[test]
fn the_mode_needs_the_token_and_a_name() {
    // Longer than this test can take.
    let page = Page::start(Some(Duration::from_secs(3_600)));
    let armed = r#"{"page": "one", "armed": true}"#;
    for path in ["/api/deadman", "/api/heartbeat"] {
        let request = format!(
            "POST {path} HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{armed}",
            page.address,
            armed.len()
        );
        assert_eq!(support::status(&page.raw(request.as_bytes())), 401, "{path}");
    }
    assert_eq!(page.act("/api/deadman", armed), (200, r#"{"armed":true}"#.into()));
    assert_eq!(page.act("/api/heartbeat", r#"{"page": "other"}"#), (200, r#"{"armed":false}"#.into()));
    assert_eq!(page.act("/api/heartbeat", r#"{"page": "one"}"#), (200, r#"{"armed":true}"#.into()));
    let long = format!(r#"{{"page": "{}", "armed": true}}"#, "x".repeat(65));
    assert_eq!(page.act("/api/deadman", &long).0, 422);
    assert_eq!(
        page.act("/api/deadman", r#"{"page": "one", "armed": false}"#),
        (200, r#"{"armed":true}"#.into())
    );
    assert!(!page.run.is_vented());
}
