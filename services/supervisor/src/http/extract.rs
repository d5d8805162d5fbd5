//! Extractors for requests. Each value is checked once; an error names its field.

use axum::body::Bytes;
use axum::extract::path::ErrorKind;
use axum::extract::rejection::PathRejection;
use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::http::header;
use axum::http::request::Parts;
use serde::de::DeserializeOwned;
use serde_json::Value;
use tokio::time::{Duration, timeout};
use vibrissa_protocol::plain;

use super::problem::{Kind, Problem};

/// Query parameters. The type's `deny_unknown_fields` refuses unknown ones.
#[derive(Debug)]
pub struct Query<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Query<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Problem> {
        let query = parts.uri.query().unwrap_or_default();
        let pairs = url::form_urlencoded::parse(query.as_bytes());
        serde_path_to_error::deserialize(serde_urlencoded::Deserializer::new(pairs)).map(Self).map_err(field)
    }
}

/// Path parameters of a route.
#[derive(Debug)]
pub struct Path<T>(pub T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for Path<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        match axum::extract::Path::<T>::from_request_parts(parts, state).await {
            Ok(axum::extract::Path(value)) => Ok(Self(value)),
            Err(PathRejection::FailedToDeserializePathParams(problem)) => Err(of_path(problem.into_kind())),
            Err(_) => Err(Problem::new(Kind::Internal, "the route has no parameters")),
        }
    }
}

/// Names the parameter of a path that cannot be used.
fn of_path(problem: ErrorKind) -> Problem {
    let wrong = |field: String, value: &str, type_name| {
        Problem::invalid(field, format!("{value:?} was given, {} is required", plain::required(type_name)))
    };
    match problem {
        ErrorKind::ParseErrorAtKey { key, value, expected_type } => wrong(key, &value, expected_type),
        ErrorKind::ParseErrorAtIndex { value, expected_type, .. } | ErrorKind::ParseError { value, expected_type } => {
            wrong("path".to_owned(), &value, expected_type)
        }
        ErrorKind::InvalidUtf8InPathParam { key } => Problem::invalid(key, "it is not text in UTF-8"),
        ErrorKind::DeserializeError { key, message, .. } => Problem::invalid(key, plain::json(&message)),
        ErrorKind::Message(message) => Problem::invalid("path", plain::json(&message)),
        // The library may add variants.
        ErrorKind::WrongNumberOfParameters { .. } | ErrorKind::UnsupportedType { .. } | _ => {
            Problem::new(Kind::Internal, "the parameters of the route cannot be read")
        }
    }
}

/// Time limit for receiving a body.
const BODY_PATIENCE: Duration = Duration::from_secs(10);

/// A JSON body. The type's `deny_unknown_fields` refuses unknown fields.
#[derive(Debug)]
pub struct Body<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for Body<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        let kind = request.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
        let essence = kind.split(';').next().unwrap_or_default().trim();
        if !essence.eq_ignore_ascii_case("application/json") {
            return Err(Problem::new(Kind::WrongMediaType, "send the body as Content-Type: application/json"));
        }
        let read = timeout(BODY_PATIENCE, Bytes::from_request(request, state)).await.map_err(|_| {
            Problem::new(Kind::TooSlowBody, format!("the body must arrive within {} s", BODY_PATIENCE.as_secs()))
        })?;
        let bytes = read.map_err(|problem| match problem.status().as_u16() {
            413 => Problem::new(Kind::TooLarge, "the body exceeds the size limit"),
            _ => Problem::new(Kind::Malformed, "the body did not arrive whole: send it again"),
        })?;
        if let Some(field) = field_with_nul(&bytes) {
            return Err(Problem::nul(field));
        }
        let mut json = serde_json::Deserializer::from_slice(&bytes);
        let value =
            serde_path_to_error::deserialize(&mut json).map_err(|problem| match problem.inner().classify() {
                serde_json::error::Category::Data => field(problem),
                serde_json::error::Category::Syntax
                | serde_json::error::Category::Eof
                | serde_json::error::Category::Io => {
                    Problem::new(Kind::Malformed, plain::not_json(&problem.inner().to_string()))
                }
            })?;
        json.end().map_err(|problem| Problem::new(Kind::Malformed, plain::not_json(&problem.to_string())))?;
        Ok(Self(value))
    }
}

/// An optional JSON body.
#[derive(Debug)]
pub struct OptionalBody<T>(pub T);

impl<T: DeserializeOwned + Default, S: Send + Sync> FromRequest<S> for OptionalBody<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        let is_empty = axum::body::HttpBody::is_end_stream(request.body());
        if is_empty && !request.headers().contains_key(header::CONTENT_TYPE) {
            return Ok(Self(T::default()));
        }
        // A body of `null` counts as no body.
        Body::<Option<T>>::from_request(request, state).await.map(|Body(value)| Self(value.unwrap_or_default()))
    }
}

/// Path of the first text or name that contains a NUL character, which JSON writes as an escape.
fn field_with_nul(json: &[u8]) -> Option<String> {
    // Escaped NULs are rare: most bodies are parsed only once.
    json.windows(6).find(|window| window == b"\\u0000")?;
    nul_in(&serde_json::from_slice(json).ok()?)
}

fn nul_in(value: &Value) -> Option<String> {
    let below = |name: String, inner: &Value| {
        nul_in(inner)
            .map(|path| if path.is_empty() || path.starts_with('[') { name + &path } else { name + "." + &path })
    };
    match value {
        Value::String(text) => text.contains('\0').then(String::new),
        Value::Array(items) => items.iter().enumerate().find_map(|(index, item)| below(format!("[{index}]"), item)),
        Value::Object(fields) => fields.iter().find_map(|(name, inner)| {
            if name.contains('\0') { Some(name.replace('\0', "\\u0000")) } else { below(name.clone(), inner) }
        }),
        Value::Null | Value::Bool(_) | Value::Number(_) => None,
    }
}

/// Names the field of a parse error. Serde's path does not contain an unknown or missing field; its message does.
fn field<E: std::fmt::Display>(problem: serde_path_to_error::Error<E>) -> Problem {
    let text = problem.inner().to_string();
    let path = problem.path().to_string();
    let inner =
        text.split('`').nth(1).filter(|_| text.starts_with("unknown field") || text.starts_with("missing field"));
    let field = match (path.as_str(), inner) {
        ("." | "", Some(inner)) => inner.to_owned(),
        (".", None) => String::new(),
        (path, Some(inner)) if !path.ends_with(inner) => format!("{path}.{inner}"),
        (path, _) => path.to_owned(),
    };
    Problem::invalid(field, plain::json(&text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nul_in_a_body_is_found_with_its_field() {
        for (body, field) in [
            (r#"{"reason":"a\u0000b"}"#, Some("reason")),
            (r#""\u0000""#, Some("")),
            (r#"{"rows":[{"a":1},{"b":["x","\u0000"]}]}"#, Some("rows[1].b[1]")),
            (r#"{"a\u0000b":1}"#, Some("a\\u0000b")),
            (r#"{"reason":"a\\u0000b"}"#, None),
            (r#"{"reason":"a\u0001b"}"#, None),
            ("", None),
        ] {
            assert_eq!(field_with_nul(body.as_bytes()).as_deref(), field, "{body}");
        }
    }
}
