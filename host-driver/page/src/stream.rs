//! Server-sent events: the same text to everybody, each as fast as it reads.

use crate::hub::{News, Seen};
use crate::picture::Hello;
use crate::reply::text;
use crate::server::Shared;
use futures_util::Stream;
use futures_util::stream::unfold;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

/// What goes out without news: it finds out whether the client is still there.
const NOTHING: &str = ":\n\n";

/// Where a client's stream is.
struct Progress {
    server: Arc<Shared>,
    seen: Seen,
    /// Nothing has gone out yet.
    first: bool,
    ended: bool,
}

/// Pictures until the run has ended. A client that reads slowly misses some: what is sent is the
/// newest when there is room for it.
pub(crate) fn of(server: Arc<Shared>) -> impl Stream<Item = Result<String, Infallible>> {
    let seen = server.hub.reader();
    let progress = Progress { server, seen, first: true, ended: false };
    unfold(progress, |mut progress| async move {
        if progress.ended {
            return None;
        }
        let text = if std::mem::take(&mut progress.first) { progress.hello() } else { progress.next().await };
        Some((Ok(text), progress))
    })
}

impl Progress {
    fn hello(&self) -> String {
        let hello = text(&Hello::new(&self.server));
        let past = text(&self.server.hub.history().past());
        // A browser that loses the connection tries again after half a second.
        format!("retry: 500\nevent: hello\ndata: {hello}\n\nevent: past\ndata: {past}\n\n")
    }

    async fn next(&mut self) -> String {
        let News { picture, figures, lines, end } =
            self.server.hub.news(&mut self.seen, Duration::from_secs(1)).await;
        self.ended = end.is_some();
        let mut text = String::new();
        for line in lines {
            text += &format!("event: line\ndata: {line}\n\n");
        }
        for (event, data) in [("figures", figures), ("picture", picture), ("end", end)] {
            if let Some(data) = data {
                text += &format!("event: {event}\ndata: {data}\n\n");
            }
        }
        if text.is_empty() { NOTHING.to_owned() } else { text }
    }
}
