//! Server-sent events: the same text to everybody, each as fast as it reads.

use super::WebOptions;
use super::http::{WRITE_WITHIN, head};
use super::hub::{Hub, News, Seen};
use super::picture::Hello;
use super::sampler::PICTURES_HZ;
use rustix::net::sockopt::set_socket_send_buffer_size;
use std::io::{self, Write};
use std::net::TcpStream;
use std::time::Duration;

/// What the kernel may keep of what a client has not read, bytes: a few seconds. More would show a slow client the past.
const SEND_BUFFER: usize = 32 * 1024;

/// Sends pictures until the client is gone or the run has ended.
pub(super) fn serve(stream: &mut TcpStream, hub: &Hub, options: &WebOptions) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITE_WITHIN))?;
    // A system that does not want to is no reason to show nothing.
    let _ = set_socket_send_buffer_size(&*stream, SEND_BUFFER);
    stream.write_all(&head(200, "text/event-stream", None, &[]))?;
    let hello = json(&Hello::new(options, PICTURES_HZ));
    // A browser that loses the connection tries again after half a second.
    write!(stream, "retry: 500\nevent: hello\ndata: {hello}\n\n")?;
    write!(stream, "event: past\ndata: {}\n\n", json(&hub.history().past()))?;
    let mut seen = Seen::default();
    loop {
        let News { picture, figures, lines, end } = hub.news(&mut seen, Duration::from_secs(1));
        let mut text = String::new();
        for line in lines {
            text += &format!("event: line\ndata: {line}\n\n");
        }
        for (event, data) in [("figures", figures), ("picture", picture), ("end", end.clone())] {
            if let Some(data) = data {
                text += &format!("event: {event}\ndata: {data}\n\n");
            }
        }
        if text.is_empty() {
            // Before the first cycle: a comment finds out whether the client is still there.
            text += ":\n\n";
        }
        stream.write_all(text.as_bytes())?;
        if end.is_some() {
            return Ok(());
        }
    }
}

fn json(value: &impl serde::Serialize) -> String {
    // These types have neither maps nor failing serializers.
    serde_json::to_string(value).unwrap_or_default()
}
