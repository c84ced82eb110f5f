//! Answers.

use crate::run::Refusal;
use axum::body::Body;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_TYPE, HeaderName, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};

/// An answer that refuses a request. Boxed: errors are handed on.
#[derive(Debug)]
pub(crate) struct Refused(pub(crate) Box<Response>);

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        *self.0
    }
}

/// An answer with this content.
pub(crate) fn reply(status: StatusCode, content_type: &'static str, body: impl Into<Body>) -> Response {
    let mut response = Response::new(body.into());
    *response.status_mut() = status;
    response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(content_type));
    response
}

/// JSON.
pub(crate) fn json(status: StatusCode, value: &impl serde::Serialize) -> Response {
    reply(status, "application/json", text(value))
}

/// A value as JSON text.
pub(crate) fn text(value: &impl serde::Serialize) -> String {
    // These types have neither maps nor failing serializers.
    serde_json::to_string(value).unwrap_or_default()
}

/// `{"error": ...}`.
pub(crate) fn error(status: StatusCode, message: &str) -> Response {
    json(status, &serde_json::json!({ "error": message }))
}

/// The same for `?`.
pub(crate) fn refused(status: StatusCode, message: &str) -> Refused {
    Refused(Box::new(error(status, message)))
}

/// What has become of an action.
pub(crate) fn refusal(refusal: &Refusal) -> Refused {
    let status = match refusal {
        Refusal::Unusable(_) => StatusCode::UNPROCESSABLE_ENTITY,
        Refusal::Conflict(_) => StatusCode::CONFLICT,
        Refusal::Failed(_) => StatusCode::INTERNAL_SERVER_ERROR,
    };
    refused(status, &refusal.to_string())
}

/// Nobody may keep old pressures, guess types, or put the page into a frame and have its buttons
/// clicked there.
pub(crate) fn protect(headers: &mut HeaderMap) {
    let fixed: [(HeaderName, &str); 4] = [
        (CACHE_CONTROL, "no-store"),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (REFERRER_POLICY, "no-referrer"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
}
