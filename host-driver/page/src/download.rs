//! Downloads of the recordings that were made from the page: a list, and each as a file.

use crate::recordings::MadeRecording;
use crate::reply::{Refused, json, refused};
use crate::server::Shared;
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_LENGTH, CONTENT_TYPE};
use axum::http::{HeaderValue, StatusCode};
use axum::response::Response;
use futures_util::stream::unfold;
use serde_json::json as value;
use std::fs::File;
use std::io::{self, Read};
use std::sync::Arc;

/// Bytes that are read at a time.
const PIECE: u64 = 64 * 1024;

type Server = State<Arc<Shared>>;

/// The recordings made by button in this run.
pub(crate) async fn list(State(server): Server) -> Result<Response, Refused> {
    Ok(json(StatusCode::OK, &value!({ "recordings": made(&server).await? })))
}

/// One of them. Names are looked up, never opened: nothing else in the folder can be had.
pub(crate) async fn file(State(server): Server, Path(name): Path<String>) -> Result<Response, Refused> {
    let none =
        || refused(StatusCode::NOT_FOUND, "no recording of this name was made from the page in this run");
    let made = made(&server).await?.into_iter().find(|made| made.name == name).ok_or_else(none)?;
    let failed = |error: io::Error| refused(StatusCode::INTERNAL_SERVER_ERROR, &format!("{name}: {error}"));
    let (opened, bytes) = tokio::task::spawn_blocking(move || {
        let opened = File::open(&made.file)?;
        // One that is being written is as long as it is now.
        let bytes = opened.metadata()?.len();
        Ok::<_, io::Error>((opened, bytes))
    })
    .await
    .map_err(|_| none())?
    .map_err(failed)?;
    let mut response = Response::new(Body::from_stream(pieces(opened, bytes)));
    let headers = response.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"));
    headers.insert(CONTENT_LENGTH, HeaderValue::from(bytes));
    // Names are letters, digits, dots, - and _: see `check_name`.
    if let Ok(kept) = HeaderValue::try_from(format!("attachment; filename=\"{name}\"")) {
        headers.insert(CONTENT_DISPOSITION, kept);
    }
    Ok(response)
}

async fn made(server: &Arc<Shared>) -> Result<Vec<MadeRecording>, Refused> {
    let message = "there are no recordings by button: start the program with --record-folder";
    let shared = Arc::clone(server);
    let made = tokio::task::spawn_blocking(move || shared.options.recordings.as_ref().map(|all| all.made()));
    made.await.ok().flatten().ok_or_else(|| refused(StatusCode::FORBIDDEN, message))
}

/// `bytes` of a file, read where nobody else waits for the disk.
fn pieces(file: File, bytes: u64) -> impl futures_util::Stream<Item = io::Result<Vec<u8>>> {
    unfold(Some((file, bytes)), |state| async move {
        let (mut file, left) = state.filter(|(_, left)| *left > 0)?;
        let read = tokio::task::spawn_blocking(move || {
            let mut piece = Vec::new();
            let read = (&mut file).take(left.min(PIECE)).read_to_end(&mut piece)?;
            if read == 0 {
                // Shorter than it was: the client must not take it for whole.
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            Ok((file, piece))
        });
        match read.await.unwrap_or_else(|_| Err(io::Error::other("the program is ending"))) {
            Ok((file, piece)) => {
                let left = left - piece.len() as u64;
                Some((Ok(piece), Some((file, left))))
            }
            Err(error) => Some((Err(error), None)),
        }
    })
}
