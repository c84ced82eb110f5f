//! The page: markup, style and script in one answer.

use super::access::hex;
use super::http::Response;
use rustix::rand::{GetRandomFlags, getrandom};

const MARKUP: &str = include_str!("page/index.html");
const STYLE: &str = include_str!("page/style.css");
/// In this order: later ones use what earlier ones declare.
const SCRIPTS: [&str; 5] = [
    include_str!("page/history.js"),
    include_str!("page/chart.js"),
    include_str!("page/actions.js"),
    include_str!("page/board.js"),
    include_str!("page/main.js"),
];

/// The page. Nothing but its own script may run in it, and it may talk to nobody but this server.
pub(super) fn page() -> Response {
    let mut bits = [0u8; 16];
    // Without random bits the policy is that of a fixed number: weaker, and the page still shows pressures.
    let _ = getrandom(&mut bits, GetRandomFlags::empty());
    let nonce = hex(&bits);
    let script = SCRIPTS.concat();
    let body = MARKUP.replace("{nonce}", &nonce).replace("{style}", STYLE).replace("{script}", &script);
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; connect-src 'self'; img-src data:; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    Response {
        status: 200,
        content_type: "text/html; charset=utf-8",
        headers: vec![("Content-Security-Policy", policy)],
        body: body.into_bytes(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_needs_nothing_from_elsewhere() {
        let text = String::from_utf8(page().body).unwrap();
        assert!(!text.contains("{nonce}") && !text.contains("{style}") && !text.contains("{script}"));
        for foreign in ["http://", "https://", "src=", "@import", "url("] {
            assert!(!text.contains(foreign), "{foreign}");
        }
        assert_eq!(text.matches("</script>").count(), 1);
    }
}
