//! Versions of resources: `ETag`, `If-None-Match` and `If-Match`.

use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde::Serialize;

/// `ETag` of a version.
#[must_use]
pub fn etag(version: i64) -> String {
    format!("\"{version}\"")
}

/// Whether a header lists the `ETag` of a version, or all of them by `*`. A weak tag counts.
#[must_use]
pub fn lists(headers: &HeaderMap, name: HeaderName, version: i64) -> bool {
    names(headers, name, &etag(version))
}

/// Codings by which proxies that compress an answer mark its tag: with `-`, `--` or `;`, at the end of the tag.
const CODINGS: [&str; 5] = ["gzip", "br", "zstd", "deflate", "compress"];

/// Whether a header lists this `ETag`, or all of them by `*`. A weak tag counts, as nginx makes of the tag of an answer that it
/// compresses; so does one with the mark of a coding, as of Apache, Caddy or Jetty.
pub(super) fn names(headers: &HeaderMap, name: HeaderName, own: &str) -> bool {
    let own = own.trim_matches('"');
    let values = headers.get_all(name).iter().filter_map(|tags| tags.to_str().ok()).flat_map(|tags| tags.split(','));
    values.map(|tag| tag.trim()).any(|tag| {
        let opaque = tag.strip_prefix("W/").unwrap_or(tag).strip_prefix('"').and_then(|tag| tag.strip_suffix('"'));
        tag == "*" || opaque.is_some_and(|opaque| opaque == own || uncoded(opaque) == Some(own))
    })
}

/// A tag without the mark of a coding; `None` if it has none.
fn uncoded(tag: &str) -> Option<&str> {
    let marked = CODINGS.iter().find_map(|coding| tag.strip_suffix(coding))?;
    ["--", "-", ";"].iter().find_map(|mark| marked.strip_suffix(mark))
}

/// The answer with a resource and its `ETag`: without its body (304) if `If-None-Match` lists the present version.
/// Version 0 is the configuration, whose content may change at a restart; it is always sent.
#[must_use]
pub fn versioned(headers: &HeaderMap, version: i64, body: &impl Serialize) -> Response {
    if version > 0 && lists(headers, header::IF_NONE_MATCH, version) {
        tagged(version, StatusCode::NOT_MODIFIED)
    } else {
        tagged(version, Json(body))
    }
}

/// An answer with the `ETag` of its version.
#[must_use]
pub fn tagged(version: i64, answer: impl IntoResponse) -> Response {
    let mut response = answer.into_response();
    if let Ok(tag) = HeaderValue::from_str(&etag(version)) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unchanged_version_is_not_sent_again() {
        for (tags, status) in [
            (None, 200),
            (Some("\"6\""), 200),
            (Some("7"), 200),
            (Some("\"7\""), 304),
            (Some("\"x\", W/\"7\""), 304),
            (Some("*"), 304),
            (Some("\"7-gzip\""), 304),
            (Some("\"7--gzip\""), 304),
            (Some("\"7;gzip\""), 304),
            (Some("W/\"7-br\", \"6\""), 304),
            (Some("\"7-zstd\""), 304),
            (Some("\"6-gzip\""), 200),
            (Some("\"7-gzip-gzip\""), 200),
            (Some("\"7gzip\""), 200),
            (Some("\"-gzip\""), 200),
            (Some("\"7-lzma\""), 200),
            (Some("W/7"), 200),
        ] {
            let mut headers = HeaderMap::new();
            headers.extend(tags.map(|tags| (header::IF_NONE_MATCH, tags.parse().unwrap())));
            let answer = versioned(&headers, 7, &"a policy");
            assert_eq!(answer.status().as_u16(), status, "{tags:?}");
            assert_eq!(answer.headers()[header::ETAG], "\"7\"");
            assert_eq!(versioned(&headers, 0, &"the configuration").status().as_u16(), 200);
        }
    }
}
