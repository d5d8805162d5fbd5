//! What went wrong, as people's programs read it: RFC 9457, with stable types.

use axum::extract::Path;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde::Serialize;
use serde_json::json;
use utoipa::ToSchema;

use vibrissa_store::StoreError;

/// The media type of problems.
pub const MEDIA_TYPE: &str = "application/problem+json";

/// Spells out the kinds with their names, status and meaning, so that none can lack one.
macro_rules! kinds {
    ($($kind:ident: $name:literal, $status:ident, $title:literal;)+) => {
        /// A kind of problem: a closed list, whose names never change.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Kind {
            $(#[doc = $title] $kind,)+
        }

        impl Kind {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$kind),+];

            /// Last part of its type's address.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$kind => $name,)+ }
            }

            /// Its status.
            #[must_use]
            pub const fn status(self) -> StatusCode {
                match self { $(Self::$kind => StatusCode::$status,)+ }
            }

            /// What it means, the same each time.
            #[must_use]
            pub const fn title(self) -> &'static str {
                match self { $(Self::$kind => $title,)+ }
            }
        }
    };
}

kinds! {
    Malformed: "malformed", BAD_REQUEST, "the request cannot be read";
    Unauthenticated: "unauthenticated", UNAUTHORIZED, "a valid token is needed";
    Forbidden: "forbidden", FORBIDDEN, "the token does not allow this";
    CrossSite: "cross-site", FORBIDDEN, "another site's page may not do this";
    NotFound: "not-found", NOT_FOUND, "there is no such thing";
    MethodNotAllowed: "method-not-allowed", METHOD_NOT_ALLOWED, "this cannot be done here";
    Refused: "refused", CONFLICT, "it cannot be done as things are";
    VersionChanged: "version-changed", PRECONDITION_FAILED, "it was changed since it was read";
    TooSlowBody: "too-slow-body", REQUEST_TIMEOUT, "the body did not arrive in time";
    TooLarge: "too-large", PAYLOAD_TOO_LARGE, "the body is too large";
    WrongMediaType: "wrong-media-type", UNSUPPORTED_MEDIA_TYPE, "the body is of another kind than is read here";
    Invalid: "invalid", UNPROCESSABLE_ENTITY, "a value is not what it must be";
    KeyReused: "key-reused", UNPROCESSABLE_ENTITY, "the idempotency key was used for another request";
    VersionMissing: "version-missing", PRECONDITION_REQUIRED, "what was read must be named with If-Match";
    TooManyRequests: "too-many-requests", TOO_MANY_REQUESTS, "too many requests in too short a time";
    Internal: "internal", INTERNAL_SERVER_ERROR, "a fault of the program";
    Unavailable: "unavailable", SERVICE_UNAVAILABLE, "the database does not answer";
    NotSupervised: "not-supervised", SERVICE_UNAVAILABLE, "nobody supervises the fleet now";
    TooSlow: "too-slow", GATEWAY_TIMEOUT, "no answer in time";
}

/// A problem, as the program tells it.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// What kind it is.
    pub kind: Kind,
    /// What was wrong this time, and what to do.
    pub detail: String,
    /// The fields that were wrong.
    pub errors: Vec<FieldError>,
}

/// A problem, as the answer's body has it (RFC 9457).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = Problem)]
pub struct ProblemBody {
    /// What kind it is: an address on this service that explains it.
    #[serde(rename = "type")]
    #[schema(example = "/problems/not-found")]
    pub type_uri: String,
    /// The kind in words, the same each time.
    pub title: String,
    /// The status of the answer.
    #[schema(minimum = 400, maximum = 599)]
    pub status: u16,
    /// What was wrong this time, and what to do.
    pub detail: String,
    /// What was asked for.
    pub instance: String,
    /// The request, as the log has it.
    pub request_id: String,
    /// The fields that were wrong; left out if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub errors: Vec<FieldError>,
}

/// A field that was wrong.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct FieldError {
    /// Which: a query parameter, a header, or a path into the body.
    #[schema(example = "pressure_mpa")]
    pub field: String,
    /// What was wrong with it.
    pub detail: String,
}

impl Problem {
    /// A problem of that kind.
    #[must_use]
    pub fn new(kind: Kind, detail: impl Into<String>) -> Self {
        Self { kind, detail: detail.into(), errors: Vec::new() }
    }

    /// The answer, now that the request's name is known.
    #[must_use]
    pub fn told(self, instance: String, request_id: String) -> Response {
        let kind = self.kind;
        let body = ProblemBody {
            type_uri: format!("/problems/{}", kind.name()),
            title: kind.title().to_owned(),
            status: kind.status().as_u16(),
            detail: self.detail,
            instance,
            request_id,
            errors: self.errors,
        };
        let json = serde_json::to_vec(&body).unwrap_or_default();
        (kind.status(), [(header::CONTENT_TYPE, MEDIA_TYPE)], json).into_response()
    }

    /// A value that is not what it must be.
    #[must_use]
    pub fn invalid(field: impl Into<String>, detail: impl Into<String>) -> Self {
        let (field, detail) = (field.into(), detail.into());
        let told = if field.is_empty() { detail.clone() } else { format!("{field}: {detail}") };
        Self { errors: vec![FieldError { field, detail }], ..Self::new(Kind::Invalid, told) }
    }

    /// A text with a NUL character, which no text here has: PostgreSQL cannot keep one.
    #[must_use]
    pub fn nul(field: impl Into<String>) -> Self {
        Self { kind: Kind::Malformed, ..Self::invalid(field, "must not contain a NUL character") }
    }

    /// Nothing is there.
    #[must_use]
    pub fn not_found(what: impl std::fmt::Display) -> Self {
        Self::new(Kind::NotFound, format!("there is no {what}, or your token does not cover its fleet"))
    }
}

/// What a kind of problem is: where its type's address leads.
pub async fn explain(Path(name): Path<String>) -> Response {
    match Kind::ALL.iter().find(|kind| kind.name() == name) {
        Some(kind) => {
            let told =
                json!({ "type": format!("/problems/{name}"), "title": kind.title(), "status": kind.status().as_u16() });
            Json(told).into_response()
        }
        None => Problem::not_found(format_args!("kind of problem called {name}")).into_response(),
    }
}

impl From<StoreError> for Problem {
    fn from(problem: StoreError) -> Self {
        // Within the request's span: the log has its name beside the database's own words, which nobody else gets.
        tracing::error!(%problem, "a query failed");
        Self::new(Kind::Unavailable, format!("{}; the log says more under this request_id", problem.told()))
    }
}

impl IntoResponse for Problem {
    /// The body is written at the very end, when the request's name is known: see `passage`.
    fn into_response(self) -> Response {
        let mut response = self.kind.status().into_response();
        if self.kind == Kind::Unauthenticated {
            response.headers_mut().insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
        }
        if self.kind == Kind::TooManyRequests {
            response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from_static("1"));
        }
        response.extensions_mut().insert(self);
        response
    }
}
