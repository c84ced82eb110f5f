//! The page: markup, style and script in one answer.

use crate::access::hex;
use crate::reply::reply;
use axum::http::StatusCode;
use axum::http::header::{CONTENT_SECURITY_POLICY, HeaderValue};
use axum::response::Response;
use rustix::rand::{GetRandomFlags, getrandom};

const MARKUP: &str = include_str!("../assets/index.html");
const STYLE: &str = include_str!("../assets/style.css");
/// In this order: later ones use what earlier ones declare.
const SCRIPTS: [&str; 9] = [
    include_str!("../assets/unit.js"),
    include_str!("../assets/history.js"),
    include_str!("../assets/chart.js"),
    include_str!("../assets/actions.js"),
    include_str!("../assets/slider.js"),
    include_str!("../assets/board.js"),
    include_str!("../assets/condition.js"),
    include_str!("../assets/stream.js"),
    include_str!("../assets/main.js"),
];

/// A number that nobody can foresee.
fn nonce() -> String {
    let mut bits = [0u8; 16];
    // Without random bits the policy is that of a fixed number: weaker, and the page still shows
    // pressures.
    let _ = getrandom(&mut bits, GetRandomFlags::empty());
    hex(&bits)
}

fn markup(nonce: &str) -> String {
    let script = SCRIPTS.concat();
    MARKUP.replace("{nonce}", nonce).replace("{style}", STYLE).replace("{script}", &script)
}

/// The page. Nothing but its own script may run in it, and it may talk to nobody but this server.
pub(crate) fn page() -> Response {
    let nonce = nonce();
    let body = markup(&nonce);
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; connect-src 'self'; img-src data:; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    let mut response = reply(StatusCode::OK, "text/html; charset=utf-8", body);
    // Digits and letters only: it is a header's value.
    if let Ok(policy) = HeaderValue::try_from(policy) {
        response.headers_mut().insert(CONTENT_SECURITY_POLICY, policy);
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_needs_nothing_from_elsewhere() {
        let text = markup(&nonce());
        assert!(!text.contains("{nonce}") && !text.contains("{style}") && !text.contains("{script}"));
        for foreign in ["http://", "https://", "src=", "@import", "url("] {
            assert!(!text.contains(foreign), "{foreign}");
        }
        assert_eq!(text.matches("</script>").count(), 1);
    }
}
