//! Errors of the API: RFC 9457 problem documents with stable types.

use axum::extract::{Path, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde::Serialize;
use serde_json::json;
use utoipa::ToSchema;

use super::App;
use vibrissa_edge::guidance::RUNBOOKS;
use vibrissa_store::StoreError;

/// Media type of problem documents.
pub const MEDIA_TYPE: &str = "application/problem+json";

/// Defines the kinds of problems, each with its name, status and title.
macro_rules! kinds {
    ($($kind:ident: $name:literal, $status:ident, $title:literal;)+) => {
        /// Kind of a problem: a closed list, whose names never change.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Kind {
            $(#[doc = $title] $kind,)+
        }

        impl Kind {
            /// All kinds of problems.
            pub const ALL: &[Self] = &[$(Self::$kind),+];

            /// Last segment of the path of its type.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$kind => $name,)+ }
            }

            /// HTTP status of this kind.
            #[must_use]
            pub const fn status(self) -> StatusCode {
                match self { $(Self::$kind => StatusCode::$status,)+ }
            }

            /// Title, the same for every problem of this kind.
            #[must_use]
            pub const fn title(self) -> &'static str {
                match self { $(Self::$kind => $title,)+ }
            }
        }
    };
}

kinds! {
    Malformed: "malformed", BAD_REQUEST, "Malformed request";
    Unauthenticated: "unauthenticated", UNAUTHORIZED, "Valid token required";
    Forbidden: "forbidden", FORBIDDEN, "Not allowed with this token";
    CrossSite: "cross-site", FORBIDDEN, "Cross-site request refused";
    NotFound: "not-found", NOT_FOUND, "Not found";
    MethodNotAllowed: "method-not-allowed", METHOD_NOT_ALLOWED, "Method not allowed";
    Refused: "refused", CONFLICT, "Not possible in the current state";
    VersionChanged: "version-changed", PRECONDITION_FAILED, "Changed since it was read";
    TooSlowBody: "too-slow-body", REQUEST_TIMEOUT, "Request body timed out";
    TooLarge: "too-large", PAYLOAD_TOO_LARGE, "Request body too large";
    WrongMediaType: "wrong-media-type", UNSUPPORTED_MEDIA_TYPE, "Unsupported media type";
    Invalid: "invalid", UNPROCESSABLE_ENTITY, "Invalid value";
    KeyReused: "key-reused", CONFLICT, "Idempotency key already used";
    VersionMissing: "version-missing", PRECONDITION_REQUIRED, "If-Match header required";
    TooManyRequests: "too-many-requests", TOO_MANY_REQUESTS, "Too many requests";
    Internal: "internal", INTERNAL_SERVER_ERROR, "Internal error";
    Unavailable: "unavailable", SERVICE_UNAVAILABLE, "Database or identity provider unavailable";
    NotSupervised: "not-supervised", SERVICE_UNAVAILABLE, "No supervisor owns the fleet";
    TooSlow: "too-slow", GATEWAY_TIMEOUT, "Timed out";
}

impl Kind {
    /// Advice and the runbook, if the cause is the service and not the request.
    #[must_use]
    pub const fn guidance(self) -> Option<(&'static str, &'static str)> {
        #[allow(clippy::wildcard_enum_match_arm, reason = "most problems lie in the request")]
        match self {
            Self::Unavailable => Some(("Check the database, then repeat the request.", "VibrissaDatabaseDown.md")),
            Self::NotSupervised => {
                Some(("Start a supervisor of this fleet, then repeat the request.", "VibrissaFleetUnsupervised.md"))
            }
            Self::TooSlow => {
                Some(("Check the load of the database, then repeat the request.", "VibrissaDatabaseErrors.md"))
            }
            _ => None,
        }
    }
}

/// An error of the API.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Kind of the problem.
    pub kind: Kind,
    /// Cause of the problem in this request, and what to do.
    pub detail: String,
    /// Invalid fields of the request.
    pub errors: Vec<FieldError>,
}

/// Body of an error response (RFC 9457).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = Problem)]
pub struct ProblemBody {
    /// Kind of the problem: a path on this service that explains it.
    #[serde(rename = "type")]
    #[schema(example = "/problems/not-found")]
    pub type_uri: String,
    /// Title of the kind, always the same.
    pub title: String,
    /// HTTP status of the response.
    #[schema(minimum = 400, maximum = 599)]
    pub status: u16,
    /// Cause of the problem in this request, and what to do.
    pub detail: String,
    /// Path of the request.
    pub instance: String,
    /// Request ID, as in the log.
    pub request_id: String,
    /// Advice; omitted if the cause lies in the request.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false, nullable = false)]
    pub hint: Option<String>,
    /// Path of the runbook on this service; omitted like `hint`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false, nullable = false, example = "/runbooks/VibrissaDatabaseDown.md")]
    pub runbook_url: Option<String>,
    /// Invalid fields; omitted if empty.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub errors: Vec<FieldError>,
}

/// An invalid field.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct FieldError {
    /// Name: a query parameter, a header, or a path into the body.
    #[schema(example = "pressure_mpa")]
    pub field: String,
    /// Reason why it is invalid.
    pub detail: String,
}

impl Problem {
    /// A problem of this kind.
    #[must_use]
    pub fn new(kind: Kind, detail: impl Into<String>) -> Self {
        Self { kind, detail: detail.into(), errors: Vec::new() }
    }

    /// The response, once the request ID is known. `base` is the path below which browsers reach this service, or empty.
    #[must_use]
    pub fn respond(self, base: &str, path: &str, request_id: String) -> Response {
        let kind = self.kind;
        let body = ProblemBody {
            type_uri: format!("{base}/problems/{}", kind.name()),
            title: kind.title().to_owned(),
            status: kind.status().as_u16(),
            detail: self.detail,
            instance: format!("{base}{path}"),
            request_id,
            hint: kind.guidance().map(|(hint, _)| hint.to_owned()),
            runbook_url: kind.guidance().map(|(_, runbook)| format!("{base}{}/{runbook}", RUNBOOKS)),
            errors: self.errors,
        };
        let json = serde_json::to_vec(&body).unwrap_or_default();
        (kind.status(), [(header::CONTENT_TYPE, MEDIA_TYPE)], json).into_response()
    }

    /// An invalid value of a field.
    #[must_use]
    pub fn invalid(field: impl Into<String>, detail: impl Into<String>) -> Self {
        let (field, detail) = (field.into(), detail.into());
        let text = if field.is_empty() { detail.clone() } else { format!("{field}: {detail}") };
        Self { errors: vec![FieldError { field, detail }], ..Self::new(Kind::Invalid, text) }
    }

    /// The same problem with its fields inside another one.
    #[must_use]
    pub fn within(mut self, outer: &str) -> Self {
        for error in &mut self.errors {
            error.field = format!("{outer}.{}", error.field);
        }
        self.detail = format!("{outer}.{}", self.detail);
        self
    }

    /// A text with a NUL character, which PostgreSQL cannot store.
    #[must_use]
    pub fn nul(field: impl Into<String>) -> Self {
        Self { kind: Kind::Malformed, ..Self::invalid(field, "must not contain a NUL character") }
    }

    /// A missing object.
    #[must_use]
    pub fn not_found(what: impl std::fmt::Display) -> Self {
        Self::new(Kind::NotFound, format!("there is no {what}, or your token does not cover its fleet"))
    }

    /// A missing object in a fleet that the caller may access. The text says which part of its path is unknown.
    #[must_use]
    pub fn unknown(detail: impl Into<String>) -> Self {
        Self::new(Kind::NotFound, detail)
    }
}

/// Explains a kind of problem at the path of its type.
pub async fn explain(State(app): State<App>, Path(name): Path<String>) -> Response {
    match Kind::ALL.iter().find(|kind| kind.name() == name) {
        Some(kind) => {
            let type_uri = format!("{}/problems/{name}", app.base_path);
            Json(json!({ "type": type_uri, "title": kind.title(), "status": kind.status().as_u16() })).into_response()
        }
        None => Problem::not_found(format_args!("kind of problem called {name}")).into_response(),
    }
}

impl From<StoreError> for Problem {
    fn from(problem: StoreError) -> Self {
        // Inside the request's span, so that the log entry has its ID. Only the log gets the database's own message.
        tracing::error!(%problem, "database query failed");
        Self::new(Kind::Unavailable, format!("{}; see the log entry with this request_id", problem.message()))
    }
}

impl IntoResponse for Problem {
    /// `passage` writes the body once the request ID is known.
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
