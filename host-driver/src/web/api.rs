//! What clients can ask for and do.

use super::access::{Names, check_origin, check_token};
use super::http::{Request, Response};
use super::hub::{Hub, Seen};
use super::page::page;
use super::{Recording, WebOptions};
use crate::poller::OverrideError;
use crate::record::{RecordError, SwitchError};
use pneudrive_protocol::SensorScale;
use serde::Deserialize;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// What to do with a request.
pub(super) enum Reply {
    /// Answer it.
    Whole(Response),
    /// Send pictures.
    Pictures,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SetPoint {
    board: u8,
    channel: usize,
    kpa: f64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct NewRecording {
    #[serde(default)]
    name: String,
}

/// Answers a request. `from` is who asks, for the notices.
pub(super) fn reply(request: &Request, hub: &Hub, options: &WebOptions, names: &Names, from: &str) -> Reply {
    if let Err(refused) = names.check(request) {
        return Reply::Whole(Response::error(refused.status(), &refused.to_string()));
    }
    Reply::Whole(match (&*request.method, &*request.path) {
        ("GET", "/") => page(),
        ("GET", "/events") => return Reply::Pictures,
        ("GET", "/api/state") => state(hub),
        ("POST", path) => match act(request, path, options, from) {
            Ok(response) | Err(response) => response,
        },
        ("GET", _) => Response::error(404, "there is no such page"),
        _ => Response::error(405, "use GET or POST"),
    })
}

/// A picture and the figures, for scripts.
fn state(hub: &Hub) -> Response {
    let news = hub.news(&mut Seen::default(), Duration::ZERO);
    let part = |text: Option<std::sync::Arc<str>>| text.unwrap_or_else(|| "null".into());
    let body = format!("{{\"picture\":{},\"figures\":{}}}", part(news.picture), part(news.figures));
    Response { status: 200, content_type: "application/json", headers: Vec::new(), body: body.into_bytes() }
}

fn act(request: &Request, path: &str, options: &WebOptions, from: &str) -> Result<Response, Response> {
    check_origin(request).map_err(|refused| Response::error(refused.status(), &refused.to_string()))?;
    match path {
        "/api/vent" => {
            options.overriding.vent();
            (options.notice)(format!("all boards vented from the web page ({from})"));
            Ok(Response::json(200, &json!({ "commanding": "vented" })))
        }
        "/api/token" => {
            authorized(request, options)?;
            Ok(Response::json(200, &json!({})))
        }
        "/api/release" => {
            authorized(request, options)?;
            options.overriding.release();
            (options.notice)(format!("boards released from the web page ({from}), set points at 0 kPa"));
            Ok(Response::json(200, &json!({})))
        }
        "/api/set" => {
            authorized(request, options)?;
            set(request, options)
        }
        "/api/record/start" => start(request, options, from),
        "/api/record/stop" => {
            recording(options)?.switch.stop().map_err(|error| Response::error(409, &error.to_string()))?;
            (options.notice)(format!("recording stopped from the web page ({from})"));
            Ok(Response::json(200, &json!({})))
        }
        _ => Err(Response::error(404, "there is no such action")),
    }
}

fn authorized(request: &Request, options: &WebOptions) -> Result<(), Response> {
    let token = options.control.as_ref().map(|control| &control.token);
    check_token(request, token).map_err(|refused| Response::error(refused.status(), &refused.to_string()))
}

fn set(request: &Request, options: &WebOptions) -> Result<Response, Response> {
    let SetPoint { board, channel, kpa } = body(request)?;
    let limit_kpa = options.control.as_ref().map_or(0.0, |control| control.limit_kpa);
    let counts = SensorScale::ORIGINAL.counts(kpa).map_err(|e| Response::error(422, &e.to_string()))?;
    if kpa > limit_kpa {
        let message = format!("{kpa} kPa is above the page's limit of {limit_kpa} kPa (--control-limit)");
        return Err(Response::error(422, &message));
    }
    let index = options.boards.iter().position(|polled| *polled == board);
    let index =
        index.ok_or_else(|| Response::error(422, &format!("board {board} is not polled in this run")))?;
    options.overriding.set(index, channel, counts).map_err(|error| {
        let status = match error {
            OverrideError::Vented | OverrideError::Following => 409,
            OverrideError::NoSuchBoard(_) | OverrideError::NoSuchChannel { .. } => 422,
        };
        Response::error(status, &error.to_string())
    })?;
    Ok(Response::json(
        200,
        &json!({ "kpa": super::picture::round(SensorScale::ORIGINAL.kpa(counts).max(0.0)) }),
    ))
}

fn start(request: &Request, options: &WebOptions, from: &str) -> Result<Response, Response> {
    let recording = recording(options)?;
    let new = if request.body.is_empty() { NewRecording::default() } else { body(request)? };
    let file = file(recording, &new.name).map_err(|message| Response::error(422, &message))?;
    let made = bag_folder(&file, recording).map_err(|message| Response::error(500, &message))?;
    recording.switch.start(&file).map_err(|error| {
        if made && let Some(folder) = file.parent() {
            // It is empty, or it stays.
            let _ = fs::remove_dir(folder);
        }
        let status = match error {
            SwitchError::Running { .. } | SwitchError::NotRunning => 409,
            SwitchError::Record(RecordError::Exists { .. }) => 409,
            SwitchError::Record(_) => 500,
        };
        Response::error(status, &error.to_string())
    })?;
    (options.notice)(format!("recording {} from the web page ({from})", file.display()));
    Ok(Response::json(200, &json!({ "file": file })))
}

fn recording(options: &WebOptions) -> Result<&Recording, Response> {
    let message = "recordings by button need a folder: start the program with --record-folder";
    options.recording.as_ref().ok_or_else(|| Response::error(403, message))
}

/// Makes the folder of a bag, if `file` has one; returns whether it did.
fn bag_folder(file: &Path, recording: &Recording) -> Result<bool, String> {
    match file.parent() {
        Some(folder) if folder != recording.folder && !folder.exists() => match fs::create_dir(folder) {
            Ok(()) => Ok(true),
            Err(error) => Err(format!("{}: {error}", folder.display())),
        },
        _ => Ok(false),
    }
}

/// A new file's name: the time, and what the user calls it. A bag has a folder of its own of this name, as `ros2 bag` makes them: its
/// metadata.yaml has the same name in all of them.
fn file(recording: &Recording, name: &str) -> Result<PathBuf, String> {
    const LONGEST: usize = 40;
    if name.len() > LONGEST || !name.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_".contains(&b)) {
        return Err(format!("a recording's name has at most {LONGEST} letters, digits, - and _"));
    }
    let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    // As ISO 8601's basic format has it, 20261121T163343Z: colons are trouble in file names.
    let now = now.replace(['-', ':'], "");
    let label = if name.is_empty() { String::new() } else { format!("-{name}") };
    let stem = format!("{now}{label}");
    let name = format!("{stem}.{}", recording.ending);
    let folder =
        if recording.ending == "mcap" { recording.folder.join(stem) } else { recording.folder.clone() };
    Ok(folder.join(name))
}

/// The request's JSON. Its type must be said: a foreign page cannot send this one without asking first.
fn body<'a, T: Deserialize<'a>>(request: &'a Request) -> Result<T, Response> {
    let kind = request.header("content-type").unwrap_or_default();
    if kind.split(';').next().map(str::trim) != Some("application/json") {
        return Err(Response::error(415, "send JSON, with Content-Type: application/json"));
    }
    serde_json::from_slice(&request.body).map_err(|error| Response::error(400, &error.to_string()))
}
