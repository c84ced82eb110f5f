//! The live page of a run: an HTTP server, and what browsers get from it.
//!
//! ```text
//!   a run ──newest cycle──▶ one thread, 30 Hz ──text──▶ hub ──▶ one for all clients ──▶ browsers
//!     ▲                                                                   │
//!     └──────────── Run::vent, Run::set, Recordings::start ◀── POST /api/...
//! ```
//!
//! This crate knows nothing of the bus. It is given a [`Run`], which it looks at thirty times a
//! second, whatever the number of clients, and through which it acts. What serves the clients waits
//! for nothing that the run's own thread holds, and holds nothing that it waits for.
//!
//! | request | what it does | needs |
//! | --- | --- | --- |
//! | `GET /` | the page, whole in one answer | |
//! | `GET /events` | pictures, 30 a second, as server-sent events (WHATWG HTML, 9.2) | |
//! | `GET /api/state` | one picture with the run's figures | |
//! | `POST /api/vent` | 0 kPa on all channels until released | |
//! | `POST /api/token` | nothing: finds out whether the token is right | token |
//! | `POST /api/release` | ends venting, at 0 kPa | token |
//! | `POST /api/set` | one set point: `{"board": 0, "channel": 1, "kpa": 50}` | token |
//! | `POST /api/deadman` | `{"page": "..", "armed": true}`: vents when this page is gone | token |
//! | `POST /api/heartbeat` | `{"page": ".."}`: that page is still there | token |
//! | `POST /api/record/start` | a new recording: `{"name": "grasp"}` or nothing | a folder |
//! | `POST /api/record/stop` | ends it | |
//! | `GET /api/recordings` | the recordings made by button: name, bytes, whether it is whole | a folder |
//! | `GET /api/recordings/NAME` | one of them, as a download | a folder |
//!
//! `HEAD` gives what `GET` gives, without the body. `access.rs` says who is let in,
//! `connections.rs` how many at a time.
#![forbid(unsafe_code)]

mod access;
mod api;
mod assets;
mod connections;
mod deadman;
mod download;
mod history;
mod hub;
mod labels;
mod picture;
mod recordings;
mod reply;
mod run;
mod sampler;
mod server;
mod stream;

pub use access::{Token, TokenError};
pub use labels::{BoardLabel, Labels, UnitLabel};
pub use recordings::{MadeRecording, RecordingStatus, Recordings};
pub use run::{
    BoardMoment, BoardState, Commanding, Moment, ReadingMoment, Refusal, Run, SetPoint, WatchMoment,
};
pub use server::{Listener, Server};

use std::path::PathBuf;
use std::time::Duration;

/// What is served beside the run itself.
pub struct PageOptions {
    /// Name of the boards' port, for people.
    pub port: String,
    /// Numbers of the boards in the order of [`Moment::boards`].
    pub boards: Vec<u8>,
    /// Names and the unit, for people.
    pub labels: Labels,
    /// Highest pressure that a sensor can show, kPa gauge.
    pub full_scale_kpa: f64,
    /// Host names under which the page may be asked for, besides addresses, `localhost` and this
    /// computer's own name.
    pub names: Vec<String>,
    /// Set points by hand and release of a vent. `None`: nobody may.
    pub control: Option<Control>,
    /// Recordings by button. `None`: there are none.
    pub recordings: Option<Box<dyn Recordings>>,
    /// File to which the whole run is recorded anyway.
    pub whole_run: Option<PathBuf>,
}

/// Set points by hand.
#[derive(Debug, Clone)]
pub struct Control {
    /// Clients that send it may command.
    pub token: Token,
    /// Highest pressure that may be commanded from the page, kPa gauge.
    pub limit_kpa: f64,
    /// How long the operator's page may be silent before everything vents. `None`: the operator may
    /// ask for it on the page, with 3 s.
    pub deadman: Option<Duration>,
}
