//! The live page's HTTP side against boards behind a pty: who is let in, what the actions do to the
//! boards, and that no client stops the bus.

mod hostile;
mod recordings;
mod rig;

use crate::support::counts;
use pneudrive_protocol::Counts;
use rig::{Rig, TOKEN, until};
use serde_json::{Value, json};
use std::io::Read;
use std::time::Duration;

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
