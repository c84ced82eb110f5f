//! As much HTTP/1.1 (RFC 9112) as the page needs: one request a connection, small bodies, a limit on everything.

use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// A client has this long for its whole request, however it is cut up.
const REQUEST_WITHIN: Duration = Duration::from_secs(5);
/// A client that takes nothing for so long is gone.
pub(super) const WRITE_WITHIN: Duration = Duration::from_secs(5);
const MOST_HEAD: usize = 8 * 1024;
const MOST_HEADERS: usize = 64;
const MOST_BODY: usize = 4 * 1024;

/// A request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Request {
    pub(super) method: String,
    /// Without the query.
    pub(super) path: String,
    headers: Vec<(String, String)>,
    pub(super) body: Vec<u8>,
}

/// A request that could not be read.
#[derive(Debug)]
pub(super) enum BadRequest {
    /// There is nobody to answer.
    Gone,
    /// To be answered with this status.
    Status(u16, &'static str),
}

impl From<io::Error> for BadRequest {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => Self::Status(408, "the request took too long"),
            _ => Self::Gone,
        }
    }
}

impl Request {
    /// The value of a header that occurs once. One that occurs twice has no value: whoever sends it wants to be read in two ways.
    pub(super) fn header(&self, name: &str) -> Option<&str> {
        let mut values = self.headers.iter().filter(|(given, _)| given.eq_ignore_ascii_case(name));
        let (_, value) = values.next()?;
        values.next().is_none().then_some(value)
    }

    /// Reads one request.
    pub(super) fn read(stream: &mut TcpStream) -> Result<Self, BadRequest> {
        let deadline = Instant::now() + REQUEST_WITHIN;
        let mut bytes = Vec::with_capacity(1024);
        let (mut request, head_length) = loop {
            more(stream, deadline, &mut bytes)?;
            if let Some(head) = Self::parse(&bytes)? {
                break head;
            }
            if bytes.len() > MOST_HEAD {
                return Err(BadRequest::Status(431, "the request's head is too long"));
            }
        };
        if request.headers.iter().any(|(name, _)| name.eq_ignore_ascii_case("transfer-encoding")) {
            return Err(BadRequest::Status(411, "a body needs a Content-Length"));
        }
        let length = match request.headers.iter().any(|(name, _)| name.eq_ignore_ascii_case("content-length"))
        {
            false => 0,
            true => request
                .header("content-length")
                .and_then(|text| text.parse().ok())
                .ok_or(BadRequest::Status(400, "unusable Content-Length"))?,
        };
        if length > MOST_BODY {
            return Err(BadRequest::Status(413, "the request's body is too long"));
        }
        while bytes.len() < head_length + length {
            more(stream, deadline, &mut bytes)?;
        }
        request.body = bytes[head_length..head_length + length].to_vec();
        Ok(request)
    }

    /// The head and its length, if it is complete.
    fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, BadRequest> {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut parsed = httparse::Request::new(&mut headers);
        let length = match parsed.parse(bytes) {
            Ok(httparse::Status::Complete(length)) => length,
            Ok(httparse::Status::Partial) => return Ok(None),
            Err(httparse::Error::TooManyHeaders) => {
                return Err(BadRequest::Status(431, "the request has too many headers"));
            }
            Err(_) => return Err(BadRequest::Status(400, "that is not HTTP/1.1")),
        };
        let target = parsed.path.unwrap_or_default();
        let path = target.split_once('?').map_or(target, |(path, _)| path);
        let headers = parsed
            .headers
            .iter()
            .map(|header| (header.name.to_owned(), String::from_utf8_lossy(header.value).into_owned()))
            .collect();
        let method = parsed.method.unwrap_or_default().to_owned();
        Ok(Some((Self { method, path: path.to_owned(), headers, body: Vec::new() }, length)))
    }

    #[cfg(test)]
    pub(super) fn for_test(method: &str, path: &str, headers: &[(&str, &str)]) -> Self {
        let headers = headers.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
        Self { method: method.to_owned(), path: path.to_owned(), headers, body: Vec::new() }
    }
}

/// Appends what comes next.
fn more(stream: &mut TcpStream, deadline: Instant, bytes: &mut Vec<u8>) -> Result<(), BadRequest> {
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() {
        return Err(BadRequest::from(io::Error::from(ErrorKind::TimedOut)));
    }
    stream.set_read_timeout(Some(left))?;
    let mut buffer = [0; 1024];
    match stream.read(&mut buffer)? {
        0 => Err(BadRequest::Gone),
        count => {
            bytes.extend_from_slice(&buffer[..count]);
            Ok(())
        }
    }
}

/// An answer with everything in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Response {
    pub(super) status: u16,
    pub(super) content_type: &'static str,
    /// Further headers.
    pub(super) headers: Vec<(&'static str, String)>,
    pub(super) body: Vec<u8>,
}

impl Response {
    /// JSON.
    pub(super) fn json(status: u16, value: &impl serde::Serialize) -> Self {
        // The types that are served have neither maps nor failing serializers.
        let body = serde_json::to_vec(value).unwrap_or_default();
        Self { status, content_type: "application/json", headers: Vec::new(), body }
    }

    /// `{"error": ...}`.
    pub(super) fn error(status: u16, message: &str) -> Self {
        Self::json(status, &serde_json::json!({ "error": message }))
    }

    pub(super) fn write(&self, stream: &mut TcpStream) -> io::Result<()> {
        let mut bytes = head(self.status, self.content_type, Some(self.body.len()), &self.headers);
        bytes.extend_from_slice(&self.body);
        stream.set_write_timeout(Some(WRITE_WITHIN))?;
        stream.write_all(&bytes)
    }
}

/// Status line and headers. Without a length the body lasts until the connection ends.
pub(super) fn head(
    status: u16,
    content_type: &str,
    length: Option<usize>,
    headers: &[(&'static str, String)],
) -> Vec<u8> {
    let mut text = format!("HTTP/1.1 {status} {}\r\nContent-Type: {content_type}\r\n", reason(status));
    if let Some(length) = length {
        text += &format!("Content-Length: {length}\r\n");
    }
    for (name, value) in headers {
        text += &format!("{name}: {value}\r\n");
    }
    // Nobody may keep old pressures, guess types, or put the page into a frame and have its buttons clicked there.
    text += "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
             X-Frame-Options: DENY\r\nReferrer-Policy: no-referrer\r\n\r\n";
    text.into_bytes()
}

fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        204 => "No Content",
        400 => "Bad Request",
        401 => "Unauthorized",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        409 => "Conflict",
        411 => "Length Required",
        413 => "Content Too Large",
        415 => "Unsupported Media Type",
        421 => "Misdirected Request",
        422 => "Unprocessable Content",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Internal Server Error",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    /// What the server reads when a client sends this.
    fn read(sent: &[u8]) -> Result<Request, BadRequest> {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let (mut stream, _) = listener.accept().unwrap();
        client.write_all(sent).unwrap();
        client.shutdown(std::net::Shutdown::Write).unwrap();
        Request::read(&mut stream)
    }

    fn status(sent: &[u8]) -> Option<u16> {
        match read(sent) {
            Err(BadRequest::Status(status, _)) => Some(status),
            Err(BadRequest::Gone) => None,
            Ok(request) => panic!("accepted: {request:?}"),
        }
    }

    #[test]
    fn a_request_with_a_body() {
        let request =
            read(b"POST /api/set?x=1 HTTP/1.1\r\nHOST: a:1\r\nContent-Length: 2\r\n\r\n{}more").unwrap();
        assert_eq!((&*request.method, &*request.path), ("POST", "/api/set"));
        assert_eq!((request.header("host"), &*request.body), (Some("a:1"), &b"{}"[..]));
    }

    #[test]
    fn a_header_given_twice_has_no_value() {
        let request = read(b"GET / HTTP/1.1\r\nHost: ours\r\nHost: theirs\r\n\r\n").unwrap();
        assert_eq!(request.header("host"), None);
    }

    #[test]
    fn what_is_too_much_or_no_http_is_refused() {
        assert_eq!(status(b"\x16\x03\x01\x02\x00 no plain text\r\n\r\n"), Some(400));
        assert_eq!(status(b"POST / HTTP/1.1\r\nContent-Length: 99999\r\n\r\n"), Some(413));
        assert_eq!(status(b"POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"), Some(400));
        assert_eq!(status(b"POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\nab"), Some(400));
        assert_eq!(status(b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"), Some(411));
        let long = format!("GET /{} HTTP/1.1\r\n\r\n", "x".repeat(10_000));
        assert_eq!(status(long.as_bytes()), Some(431));
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(100));
        assert_eq!(status(many.as_bytes()), Some(431));
        assert_eq!(status(b"GET / HTTP/1.1\r\nHost: a"), None);
        assert_eq!(status(b"POST / HTTP/1.1\r\nContent-Length: 5\r\n\r\nab"), None);
    }
}
