//! What the server makes of requests: limits, HEAD, and what is no HTTP.

use crate::support;
use crate::support::{Page, status};
use std::io::{Read, Write};
use std::net::Shutdown;

#[test]
fn what_is_too_much_or_no_http_is_refused() {
    let page = Page::start(None);
    let host = format!("Host: {}\r\n", page.address);
    let token = format!("Authorization: Bearer {}\r\nContent-Type: application/json\r\n", support::TOKEN);
    for (expected, request) in [
        (400, "\x16\x03\x01\x02 no plain text\r\n\r\n".to_owned()),
        (413, format!("POST /api/set HTTP/1.1\r\n{host}{token}Content-Length: 4097\r\n\r\n")),
        (400, format!("POST /api/set HTTP/1.1\r\n{host}Content-Length: -1\r\n\r\n")),
        (400, format!("POST /api/set HTTP/1.1\r\n{host}Content-Length: 1\r\nContent-Length: 2\r\n\r\nab")),
        (411, format!("POST /api/vent HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n")),
        (431, format!("GET /{} HTTP/1.1\r\n{host}\r\n", "x".repeat(10_000))),
        (431, format!("GET / HTTP/1.1\r\n{host}{}\r\n", "a: b\r\n".repeat(100))),
        (421, format!("GET / HTTP/1.1\r\n{host}{host}\r\n")),
        (421, format!("GET http://evil.example/ HTTP/1.1\r\n{host}\r\n")),
        (404, format!("GET /../../etc/passwd HTTP/1.1\r\n{host}\r\n")),
        (404, format!("GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1\r\n{host}\r\n")),
        (405, format!("GET /api/vent HTTP/1.1\r\n{host}\r\n")),
        (405, format!("DELETE / HTTP/1.1\r\n{host}\r\n")),
        (404, format!("POST /api/nothing HTTP/1.1\r\n{host}\r\n")),
    ] {
        let answer = page.raw(request.as_bytes());
        assert_eq!(status(&answer), expected, "{request:.60}: {answer}");
    }
    assert!(!page.run.is_vented() && page.run.set.lock().unwrap().is_empty());
    // One that is just small enough.
    let padding = "x".repeat(8 * 1024 - 100 - host.len());
    let large = page.raw(format!("GET / HTTP/1.1\r\n{host}Padding: {padding}\r\n\r\n").as_bytes());
    assert_eq!(status(&large), 200);
}

#[test]
fn a_client_may_end_its_side_when_it_has_asked() {
    let page = Page::start(None);
    let mut stream = page.connect();
    stream
        .write_all(format!("POST /api/vent HTTP/1.0\r\nHost: {}\r\n\r\n", page.address).as_bytes())
        .unwrap();
    stream.shutdown(Shutdown::Write).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert_eq!((status(&answer), page.run.is_vented()), (200, true));
}

#[test]
fn head_gives_what_get_gives_without_the_body() {
    let page = Page::start(None);
    let ask = |method: &str, path: &str| {
        page.raw(format!("{method} {path} HTTP/1.1\r\nHost: {}\r\n\r\n", page.address).as_bytes())
    };
    let fields = |answer: &str| {
        let head = answer.split_once("\r\n\r\n").unwrap().0;
        let names = head.lines().map(|line| line.split(':').next().unwrap().to_owned());
        let length = head.lines().find(|line| line.starts_with("content-length")).map(str::to_owned);
        (names.collect::<Vec<_>>(), length)
    };
    let (head, get) = (ask("HEAD", "/"), ask("GET", "/"));
    assert_eq!(fields(&head), fields(&get));
    assert!(head.ends_with("\r\n\r\n") && get.ends_with("</html>\n"), "{head}");
    assert_eq!(status(&ask("HEAD", "/api/state")), 200);
    assert_eq!(status(&ask("HEAD", "/nothing")), 404);
    // No stream is kept for it, however often.
    for _ in 0..40 {
        let events = ask("HEAD", "/events");
        assert!(status(&events) == 200 && events.contains("text/event-stream"), "{events}");
    }
}

/// Who asks again and again is told in one line that they are vented.
#[test]
fn a_vent_is_one_notice_however_often_it_is_asked() {
    let page = Page::start(None);
    for _ in 0..20 {
        let stream = page.connect();
        assert_eq!(support::try_to_vent(stream, page.address), Some(200));
    }
    assert_eq!(*page.run.notices.lock().unwrap(), ["all boards vented from the web page (127.0.0.1)"]);
    assert_eq!(page.act("/api/release", "").0, 200);
    assert_eq!(support::try_to_vent(page.connect(), page.address), Some(200));
    let notices = page.run.notices.lock().unwrap().clone();
    assert!(notices.len() == 3 && notices[1].contains("released"), "{notices:?}");
}
