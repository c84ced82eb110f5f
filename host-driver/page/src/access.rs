//! Who is let in.
//!
//! - Every request must name a host that is ours: an address, `localhost`, this computer's name
//!   (also with `.local`), or a name that the user gave. A foreign page that had its own name
//!   resolve to this computer (DNS rebinding) is refused here.
//! - An action that a browser sends must come from our own page: its `Origin` is the host asked,
//!   and `Sec-Fetch-Site`, where sent, says `same-origin`. A foreign page can make a browser send a
//!   request, but cannot change these.
//! - Set points and release of a vent need the token, compared in constant time.
//! - Venting needs no token: it is the safe direction, and a forgotten token must not stand in its
//!   way.

use axum::http::header::{AUTHORIZATION, HOST, HeaderName, ORIGIN};
use axum::http::{HeaderMap, StatusCode};
use rustix::rand::{GetRandomFlags, getrandom};
use std::fmt;
use std::net::{Ipv4Addr, Ipv6Addr};
use subtle::ConstantTimeEq;
use thiserror::Error;

/// A secret. Clients that send it may command.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

/// A token that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TokenError {
    /// The user's is easily guessed, or cannot stand in a header.
    #[error(
        "a token has 16 to 256 characters, all of them letters, digits or -._~; this one has {length} characters"
    )]
    Unusable {
        /// Its length.
        length: usize,
    },
    /// The system gave no random numbers.
    #[error("no random numbers for a token: {reason}")]
    NoRandomness {
        /// What the system said.
        reason: String,
    },
}

impl Token {
    /// 128 random bits as 32 hexadecimal digits.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn random() -> Result<Self, TokenError> {
        let mut bits = [0u8; 16];
        match getrandom(&mut bits, GetRandomFlags::empty()) {
            Ok(length) if length == bits.len() => Ok(Self(hex(&bits))),
            Ok(length) => Err(TokenError::NoRandomness { reason: format!("only {length} bytes came") }),
            Err(error) => Err(TokenError::NoRandomness { reason: error.to_string() }),
        }
    }

    /// The user's own.
    ///
    /// # Errors
    /// It is too short or too long, or has characters that an address or a header cannot have as
    /// they are.
    pub fn new(text: &str) -> Result<Self, TokenError> {
        let usable = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
        if (16..=256).contains(&text.len()) && text.bytes().all(usable) {
            Ok(Self(text.to_owned()))
        } else {
            Err(TokenError::Unusable { length: text.chars().count() })
        }
    }

    /// The token, to be shown to whoever starts the server.
    pub fn reveal(&self) -> &str {
        &self.0
    }

    /// Whether `other` is the token, in a time that does not tell how much of it is right.
    pub fn matches(&self, other: &str) -> bool {
        self.0.as_bytes().ct_eq(other.as_bytes()).into()
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(..)")
    }
}

/// Hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    use fmt::Write as _;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Why a request is refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub(crate) enum Refused {
    #[error("\"{host}\" is not a name of this server; use its address, or start it with --web-name {host}")]
    Host { host: String },
    #[error("an action must come from this server's own page, not from \"{origin}\"")]
    Origin { origin: String },
    #[error("this needs the token that was printed when the program started with --allow-control")]
    NoToken,
    #[error("that is not the token")]
    WrongToken,
    #[error("this page only looks: the program was started without --allow-control")]
    LookOnly,
}

impl Refused {
    pub(crate) fn status(&self) -> StatusCode {
        match self {
            Self::Host { .. } => StatusCode::MISDIRECTED_REQUEST,
            Self::NoToken => StatusCode::UNAUTHORIZED,
            Self::Origin { .. } | Self::WrongToken | Self::LookOnly => StatusCode::FORBIDDEN,
        }
    }
}

/// The names under which the server may be asked.
#[derive(Debug, Clone)]
pub(crate) struct Names(Vec<String>);

impl Names {
    pub(crate) fn new(of_user: &[String]) -> Self {
        let mut names = vec!["localhost".to_owned()];
        if let Ok(own) = rustix::system::uname().nodename().to_str() {
            names.extend([own.to_owned(), format!("{own}.local")]);
        }
        names.extend_from_slice(of_user);
        Self(names)
    }

    /// Whether the request's `Host` is one of ours.
    pub(crate) fn check(&self, headers: &HeaderMap) -> Result<(), Refused> {
        let authority = single(headers, HOST).unwrap_or_default();
        let host = host_of(authority);
        let address = host.parse::<Ipv4Addr>().is_ok()
            || host
                .strip_prefix('[')
                .and_then(|rest| rest.strip_suffix(']'))
                .is_some_and(|inside| inside.parse::<Ipv6Addr>().is_ok());
        if address || self.0.iter().any(|name| name.eq_ignore_ascii_case(host)) {
            Ok(())
        } else {
            Err(Refused::Host { host: host.chars().take(100).collect() })
        }
    }
}

/// The host in `host:port`.
fn host_of(authority: &str) -> &str {
    match authority.rsplit_once(':') {
        // The colons of an IPv6 address stand in brackets.
        Some((host, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => host,
        _ => authority,
    }
}

/// The value of a header that occurs once. One that occurs twice has no value: whoever sends it
/// wants to be read in two ways.
pub(crate) fn single(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?;
    value.to_str().ok().filter(|_| values.next().is_none())
}

/// Whether an action comes from our own page, or from no page at all.
pub(crate) fn check_origin(headers: &HeaderMap) -> Result<(), Refused> {
    let refused = |origin: &str| Err(Refused::Origin { origin: origin.chars().take(100).collect() });
    let site = HeaderName::from_static("sec-fetch-site");
    if headers.contains_key(&site) {
        let site = single(headers, site).unwrap_or_default();
        if site != "same-origin" {
            return refused(site);
        }
    }
    if headers.contains_key(ORIGIN) {
        let origin = single(headers, ORIGIN).unwrap_or_default();
        let authority = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        if authority.is_none() || authority != single(headers, HOST) {
            return refused(origin);
        }
    }
    Ok(())
}

/// Whether the request carries the token, as `Authorization: Bearer ...`.
pub(crate) fn check_token(headers: &HeaderMap, token: Option<&Token>) -> Result<(), Refused> {
    let token = token.ok_or(Refused::LookOnly)?;
    let given = single(headers, AUTHORIZATION).and_then(|value| value.strip_prefix("Bearer "));
    match given {
        None => Err(Refused::NoToken),
        Some(given) if token.matches(given) => Ok(()),
        Some(_) => Err(Refused::WrongToken),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(headers: &[(&str, &str)]) -> HeaderMap {
        let mut map = HeaderMap::new();
        for (name, value) in headers {
            map.append(HeaderName::from_bytes(name.as_bytes()).unwrap(), value.parse().unwrap());
        }
        map
    }

    #[test]
    fn a_header_given_twice_has_no_value() {
        let twice = request(&[("Host", "127.0.0.1"), ("Host", "127.0.0.1")]);
        assert_eq!(single(&twice, HOST), None);
        assert!(Names::new(&[]).check(&twice).is_err());
        let origins = [("Host", "a:1"), ("Origin", "http://a:1"), ("Origin", "http://a:1")];
        assert!(check_origin(&request(&origins)).is_err());
        let sites = [("Sec-Fetch-Site", "same-origin"), ("Sec-Fetch-Site", "cross-site")];
        assert!(check_origin(&request(&sites)).is_err());
    }

    #[test]
    fn foreign_names_are_refused() {
        let names = Names::new(&["robot.example".into()]);
        let check = |host| names.check(&request(&[("Host", host)]));
        for ours in [
            "127.0.0.1:8080",
            "127.0.0.1",
            "192.168.7.2:8080",
            "localhost:9000",
            "LOCALHOST",
            "[::1]:8080",
            "[fe80::1]",
            "robot.example:8080",
        ] {
            assert_eq!(check(ours), Ok(()), "{ours}");
        }
        for foreign in
            ["evil.example:8080", "", "127.0.0.1.evil.example", "localhost.evil.example", "[evil]:80", "::1"]
        {
            assert!(check(foreign).is_err(), "{foreign}");
        }
        assert!(names.check(&request(&[])).is_err(), "no host at all");
    }

    #[test]
    fn actions_come_from_our_own_page_or_from_no_page() {
        let host = ("Host", "robot:8080");
        let ok = |headers: &[(&str, &str)]| check_origin(&request(headers)).is_ok();
        assert!(ok(&[host]), "a script");
        assert!(ok(&[host, ("Origin", "http://robot:8080")]));
        assert!(ok(&[host, ("Origin", "https://robot:8080"), ("Sec-Fetch-Site", "same-origin")]));
        for origin in
            ["http://evil.example", "http://robot:80", "null", "", "robot:8080", "http://robot:8080/"]
        {
            assert!(!ok(&[host, ("Origin", origin)]), "{origin}");
        }
        assert!(!ok(&[host, ("Sec-Fetch-Site", "cross-site")]));
        assert!(!ok(&[host, ("Sec-Fetch-Site", "same-site")]));
    }

    #[test]
    fn only_the_whole_token_will_do() {
        let token = Token::new("0123456789abcdef").unwrap();
        let check = |value: &str| check_token(&request(&[("Authorization", value)]), Some(&token));
        assert_eq!(check("Bearer 0123456789abcdef"), Ok(()));
        for wrong in
            ["Bearer 0123456789abcdeX", "Bearer 0123456789abcde", "Bearer ", "Bearer 0123456789abcdef0"]
        {
            assert_eq!(check(wrong), Err(Refused::WrongToken), "{wrong}");
        }
        assert_eq!(check("0123456789abcdef"), Err(Refused::NoToken));
        assert_eq!(check_token(&request(&[]), Some(&token)), Err(Refused::NoToken));
        assert_eq!(check_token(&request(&[]), None), Err(Refused::LookOnly));
    }

    #[test]
    fn tokens_that_are_easily_guessed_are_refused() {
        assert_eq!(Token::new("short"), Err(TokenError::Unusable { length: 5 }));
        assert!(Token::new("with spaces and so on").is_err());
        let (one, other) = (Token::random().unwrap(), Token::random().unwrap());
        assert!(one != other && one.reveal().len() == 32, "{}", one.reveal());
        assert_eq!(format!("{one:?}"), "Token(..)");
    }
}
