//! What clients can ask for and do.

use crate::access::{self, check_origin, check_token};
use crate::assets::page;
use crate::connections::Place;
use crate::download;
use crate::picture::{Hello, round};
use crate::recordings::{Recordings, check_name};
use crate::reply::{Refused, error, json, protect, refusal, refused, reply, text};
use crate::run::{Refusal, SetPoint};
use crate::server::{REQUEST_WITHIN, Shared};
use crate::stream;
use axum::body::{Body, HttpBody, to_bytes};
use axum::extract::{Request, State};
use axum::http::header::{CONTENT_TYPE, TRANSFER_ENCODING};
use axum::http::{Method, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::Response;
use axum::routing::{get, post};
use axum::{Extension, Router};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::json as value;
use std::net::IpAddr;
use std::sync::Arc;

/// Longest body, bytes.
const MOST_BODY: usize = 4 * 1024;
/// Longest name that a page gives itself.
const LONGEST_PAGE: usize = 64;

type Server = State<Arc<Shared>>;

/// Who asks, for all handlers.
#[derive(Clone)]
pub(crate) struct Client {
    pub(crate) address: IpAddr,
    pub(crate) place: Arc<Place>,
}

/// All requests that there are.
pub(crate) fn router(shared: &Arc<Shared>) -> Router {
    Router::new()
        .route("/", get(async || page()))
        .route("/events", get(events))
        .route("/api/state", get(state))
        .route("/api/vent", post(vent))
        .route("/api/token", post(token))
        .route("/api/release", post(release))
        .route("/api/set", post(set))
        .route("/api/deadman", post(deadman))
        .route("/api/heartbeat", post(heartbeat))
        .route("/api/record/start", post(start))
        .route("/api/record/stop", post(stop))
        .route("/api/recordings", get(download::list))
        .route("/api/recordings/{name}", get(download::file))
        .fallback(async || error(StatusCode::NOT_FOUND, "there is no such page or action"))
        .method_not_allowed_fallback(async || {
            error(StatusCode::METHOD_NOT_ALLOWED, "use GET for pages, POST for actions")
        })
        .layer(from_fn_with_state(Arc::clone(shared), guard))
        .with_state(Arc::clone(shared))
}

/// Comes before everything else, whatever is asked for.
async fn guard(State(server): Server, request: Request, next: Next) -> Response {
    let mut response = match check(&server, &request) {
        Ok(()) => next.run(request).await,
        Err(refused) => *refused.0,
    };
    protect(response.headers_mut());
    response
}

fn check(server: &Shared, request: &Request) -> Result<(), Refused> {
    server.names.check(request.headers()).map_err(|error| denied(&error))?;
    if request.uri().authority().is_some() {
        return Err(refused(StatusCode::MISDIRECTED_REQUEST, "this is no proxy"));
    }
    if request.headers().contains_key(TRANSFER_ENCODING) {
        return Err(refused(StatusCode::LENGTH_REQUIRED, "a body needs a Content-Length"));
    }
    if ![Method::GET, Method::HEAD].contains(request.method()) {
        check_origin(request.headers()).map_err(|error| denied(&error))?;
    }
    Ok(())
}

fn denied(error: &access::Refused) -> Refused {
    refused(error.status(), &error.to_string())
}

fn authorized(server: &Shared, request: &Request) -> Result<(), Refused> {
    let token = server.options.control.as_ref().map(|control| &control.token);
    check_token(request.headers(), token).map_err(|error| denied(&error))
}

fn done() -> Response {
    json(StatusCode::OK, &value!({}))
}

/// A picture and the figures, for scripts and for pages without a stream.
async fn state(State(server): Server) -> Response {
    let (picture, figures) = server.hub.newest();
    let part = |text: Option<Arc<str>>| text.unwrap_or_else(|| "null".into());
    let hello = text(&Hello::new(&server));
    let body = format!("{{\"hello\":{hello},\"picture\":{},\"figures\":{}}}", part(picture), part(figures));
    reply(StatusCode::OK, "application/json", body)
}

async fn events(State(server): Server, Extension(client): Extension<Client>) -> Response {
    if !client.place.become_stream() {
        return error(StatusCode::SERVICE_UNAVAILABLE, "too many clients; close other pages");
    }
    reply(StatusCode::OK, "text/event-stream", Body::from_stream(stream::of(server)))
}

/// Needs neither token nor body, and waits for nothing.
async fn vent(State(server): Server, Extension(client): Extension<Client>) -> Response {
    server.vent(&format!("from the web page ({})", client.address));
    json(StatusCode::OK, &value!({ "commanding": "vented" }))
}

async fn token(State(server): Server, request: Request) -> Result<Response, Refused> {
    authorized(&server, &request)?;
    Ok(done())
}

async fn release(
    State(server): Server,
    Extension(client): Extension<Client>,
    request: Request,
) -> Result<Response, Refused> {
    authorized(&server, &request)?;
    let set_points = if server.run.release() { "as before, by a ramp" } else { "at 0 kPa" };
    let from = client.address;
    server.run.notice(format!("boards released from the web page ({from}), set points {set_points}"));
    Ok(done())
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct NewSetPoint {
    board: u8,
    channel: usize,
    kpa: f64,
    /// The page that sends it, for the deadman.
    #[serde(default)]
    page: String,
}

async fn set(State(server): Server, request: Request) -> Result<Response, Refused> {
    authorized(&server, &request)?;
    let NewSetPoint { board, channel, kpa, page } = body(request).await?;
    check_page(&page)?;
    let limit_kpa = server.options.control.as_ref().map_or(0.0, |control| control.limit_kpa);
    if kpa > limit_kpa {
        let message =
            format!("{kpa} kPa is above the page's limit of {limit_kpa} kPa (--control-limit, or the rig's)");
        return Err(refused(StatusCode::UNPROCESSABLE_ENTITY, &message));
    }
    let commanded = server.run.set(SetPoint { board, channel, kpa }).map_err(|error| refusal(&error))?;
    // Nothing else runs on this thread in between.
    let (mut deadman, now) = server.deadman();
    deadman.commanded(&page, now);
    drop(deadman);
    Ok(json(StatusCode::OK, &value!({ "kpa": round(commanded.max(0.0)) })))
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Watch {
    page: String,
    armed: bool,
}

async fn deadman(State(server): Server, request: Request) -> Result<Response, Refused> {
    authorized(&server, &request)?;
    let Watch { page, armed } = body(request).await?;
    check_page(&page)?;
    let (mut deadman, now) = server.deadman();
    let armed = if armed {
        deadman.arm(&page, now);
        true
    } else {
        deadman.disarm(&page)
    };
    Ok(json(StatusCode::OK, &value!({ "armed": armed })))
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Heartbeat {
    page: String,
}

async fn heartbeat(State(server): Server, request: Request) -> Result<Response, Refused> {
    authorized(&server, &request)?;
    let Heartbeat { page } = body(request).await?;
    let (mut deadman, now) = server.deadman();
    let armed = deadman.heartbeat(&page, now);
    Ok(json(StatusCode::OK, &value!({ "armed": armed })))
}

fn check_page(page: &str) -> Result<(), Refused> {
    if page.len() > LONGEST_PAGE {
        let message = format!("a page's name has at most {LONGEST_PAGE} characters");
        return Err(refused(StatusCode::UNPROCESSABLE_ENTITY, &message));
    }
    Ok(())
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct NewRecording {
    #[serde(default)]
    name: String,
}

async fn start(
    State(server): Server,
    Extension(client): Extension<Client>,
    request: Request,
) -> Result<Response, Refused> {
    recordings(&server)?;
    let empty = request.body().is_end_stream();
    let NewRecording { name } = if empty { NewRecording::default() } else { body(request).await? };
    check_name(&name).map_err(|error| refusal(&error))?;
    let file = on_disk(&server, move |recordings| recordings.start(&name)).await?;
    server.run.notice(format!("recording {} from the web page ({})", file.display(), client.address));
    Ok(json(StatusCode::OK, &value!({ "file": file })))
}

async fn stop(State(server): Server, Extension(client): Extension<Client>) -> Result<Response, Refused> {
    recordings(&server)?;
    on_disk(&server, |recordings| recordings.stop()).await?;
    server.run.notice(format!("recording stopped from the web page ({})", client.address));
    Ok(done())
}

fn recordings(server: &Shared) -> Result<&dyn Recordings, Refused> {
    let message = "recordings by button need a folder: start the program with --record-folder";
    server.options.recordings.as_deref().ok_or_else(|| refused(StatusCode::FORBIDDEN, message))
}

/// Does what may wait for a disk where nobody else waits for it.
async fn on_disk<T: Send + 'static>(
    server: &Arc<Shared>,
    act: impl FnOnce(&dyn Recordings) -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refused> {
    let server = Arc::clone(server);
    let acted = tokio::task::spawn_blocking(move || recordings(&server).map(act)).await;
    match acted {
        Ok(Ok(result)) => result.map_err(|error| refusal(&error)),
        Ok(Err(refused)) => Err(refused),
        Err(_) => Err(refused(StatusCode::INTERNAL_SERVER_ERROR, "the program is ending")),
    }
}

/// The request's JSON. Its type must be said: a foreign page cannot send this one without asking
/// first.
async fn body<T: DeserializeOwned>(request: Request) -> Result<T, Refused> {
    let kind = access::single(request.headers(), CONTENT_TYPE).unwrap_or_default();
    if kind.split(';').next().map(str::trim) != Some("application/json") {
        let message = "send JSON, with Content-Type: application/json";
        return Err(refused(StatusCode::UNSUPPORTED_MEDIA_TYPE, message));
    }
    if request.body().size_hint().lower() > MOST_BODY as u64 {
        return Err(refused(StatusCode::PAYLOAD_TOO_LARGE, "the request's body is too long"));
    }
    let bytes = match tokio::time::timeout(REQUEST_WITHIN, to_bytes(request.into_body(), MOST_BODY)).await {
        Ok(Ok(bytes)) => bytes,
        Ok(Err(_)) => return Err(refused(StatusCode::BAD_REQUEST, "the request ended within its body")),
        Err(_) => return Err(refused(StatusCode::REQUEST_TIMEOUT, "the request took too long")),
    };
    serde_json::from_slice(&bytes).map_err(|error| refused(StatusCode::BAD_REQUEST, &error.to_string()))
}
