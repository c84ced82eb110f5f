//! A live page of a run, for browsers: pressures of the last minute, losses, venting, recording, set points.
//!
//! ```text
//!   bus thread ──newest row──▶ sampler, 30 Hz ──text──▶ hub ──▶ one thread a client ──▶ browser
//!        ▲                                                                                │
//!        └── Override (atomics), RecordSwitch (channel) ◀── POST /api/... ◀───────────────┘
//! ```
//!
//! The bus thread does the same work whether somebody looks or not: it leaves its newest row where the sampler finds it
//! ([`Latest`](crate::poller::Latest)). A client that reads too slowly misses pictures, one that reads nothing is dropped after some
//! seconds, and neither is waited for by anything but its own thread.
//!
//! Pictures go out as server-sent events (WHATWG HTML, 9.2), actions come in as POST requests. `httparse` reads the requests.
//! Connections are our own (`http.rs`): blocking server libraries have no limit on how long a client may take, or collect what is
//! streamed in buffers.
//!
//! | request | what it does | needs |
//! | --- | --- | --- |
//! | `GET /` | the page, whole in one answer | |
//! | `GET /events` | pictures, 30 a second | |
//! | `GET /api/state` | one picture with the run's figures | |
//! | `POST /api/vent` | 0 kPa on all channels until released | |
//! | `POST /api/token` | nothing: finds out whether the token is right | token |
//! | `POST /api/release` | ends venting, at 0 kPa | token |
//! | `POST /api/set` | one set point: `{"board": 0, "channel": 1, "kpa": 50}` | token |
//! | `POST /api/record/start` | a new recording: `{"name": "grasp"}` or nothing | a folder |
//! | `POST /api/record/stop` | ends it | |
//!
//! `access.rs` says who is let in.

mod access;
mod api;
mod connections;
mod history;
mod http;
mod hub;
mod page;
mod picture;
mod sampler;
mod server;
mod stream;

pub use access::{Token, TokenError};
pub use server::{Listener, Server};

use crate::poller::Override;
use crate::record::RecordSwitch;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::mpsc::Receiver;

/// What is served.
pub struct WebOptions {
    /// Name of the boards' port, for people.
    pub port: String,
    /// Numbers of the boards in the poller's order.
    pub boards: Vec<u8>,
    /// Host names under which the page may be asked for, besides addresses, `localhost` and this computer's own name.
    pub names: Vec<String>,
    /// Vents and, with `control`, commands.
    pub overriding: Override,
    /// Set points by hand and release of a vent, for who has the token. `None`: nobody.
    pub control: Option<Control>,
    /// Recordings by button. `None`: none.
    pub recording: Option<Recording>,
    /// File to which the whole run is recorded anyway.
    pub whole_run: Option<PathBuf>,
    /// Lines about what happens on the bus, to be shown on the page.
    pub lines: Option<Mutex<Receiver<String>>>,
    /// Gets a line about everything that was done from the page. Called on the server's threads.
    pub notice: Box<dyn Fn(String) + Send + Sync>,
}

/// Set points by hand.
#[derive(Debug, Clone)]
pub struct Control {
    /// Who has it may command.
    pub token: Token,
    /// Highest pressure that may be commanded from the page, kPa gauge.
    pub limit_kpa: f64,
}

/// Recordings by button.
#[derive(Debug)]
pub struct Recording {
    /// Makes them.
    pub switch: RecordSwitch,
    /// Where they go.
    pub folder: PathBuf,
    /// Ending of their names, which is their format: `csv.zst`.
    pub ending: String,
}
