//! Refuses requests that a proxy may read in another way than this service: then the proxy's rules would apply to another
//! request than the one that is answered here.

use axum::extract::Request;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderName, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::problem::{Kind, Problem};

/// Headers that decide on a request, and which it may have once. Some programs take the first of several, others the last.
static SINGLE: [HeaderName; 9] = [
    header::HOST,
    header::AUTHORIZATION,
    header::ORIGIN,
    header::CONTENT_TYPE,
    header::CONTENT_LENGTH,
    HeaderName::from_static("idempotency-key"),
    HeaderName::from_static("sec-fetch-site"),
    HeaderName::from_static("sec-fetch-mode"),
    HeaderName::from_static("sec-fetch-dest"),
];

/// Lets a request pass that has one meaning.
pub(super) async fn refuse(request: Request, next: Next) -> Response {
    match require_one_meaning(request.uri(), request.headers()) {
        Ok(()) => next.run(request).await,
        Err(detail) => Problem::new(Kind::Malformed, detail).into_response(),
    }
}

fn require_one_meaning(target: &Uri, headers: &HeaderMap) -> Result<(), String> {
    if let Some(name) = SINGLE.iter().find(|name| headers.get_all(*name).iter().nth(1).is_some()) {
        return Err(format!("the request has several {name} headers: send one"));
    }
    let Some(value) = headers.get(header::HOST) else { return Ok(()) };
    let value = value.to_str().unwrap_or("\u{fffd}");
    if value.is_empty() && target.authority().is_none() {
        return Ok(());
    }
    let invalid = || format!("the Host header {value:?} is no host name with or without a port");
    let host = value.parse::<Authority>().ok().and_then(|host| split(&host)).ok_or_else(invalid)?;
    let Some(authority) = target.authority() else { return Ok(()) };
    let default = match target.scheme_str() {
        Some("https") => 443,
        _ => 80,
    };
    let with_port = |(name, port): (String, Option<u16>)| (name, port.unwrap_or(default));
    if split(authority).map(with_port) == Some(with_port(host)) {
        return Ok(());
    }
    Err(format!("the request's target names {authority}, but its Host header {value:?}: send the path only"))
}

/// Name in small letters, and port. `None` with a user's name or a port that is no number.
fn split(authority: &Authority) -> Option<(String, Option<u16>)> {
    let name = authority.host().to_ascii_lowercase();
    let port = authority.as_str().get(name.len()..)?;
    let port = if port.is_empty() { None } else { Some(port.strip_prefix(':')?.parse().ok()?) };
    (!name.is_empty()).then_some((name, port))
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    fn check(target: &str, pairs: &[(&'static str, &'static str)]) -> Result<(), String> {
        let mut headers = HeaderMap::new();
        for (name, value) in pairs {
            headers.append(*name, HeaderValue::from_static(value));
        }
        require_one_meaning(&target.parse().unwrap(), &headers)
    }

    fn hosted(target: &str, host: &'static str) -> bool {
        check(target, &[("host", host)]).is_ok()
    }

    #[test]
    fn regress_a_header_that_decides_is_there_once() {
        let host = ("host", "localhost:8080");
        for name in &SINGLE {
            let name: &'static str = name.as_str().to_owned().leak();
            for values in [["localhost", "evil.example"], ["localhost", "localhost"]] {
                let twice = values.map(|value| (name, value));
                let pairs = if name == "host" { twice.to_vec() } else { [&[host][..], &twice].concat() };
                let refused = check("/v1/me", &pairs).unwrap_err();
                assert!(refused.contains(name), "{refused}");
            }
        }
        let twice = [host, ("accept", "a/b"), ("accept", "c/d"), ("if-match", "\"1\""), ("if-match", "\"2\"")];
        assert_eq!(check("/v1/me", &twice), Ok(()), "lists may come in parts");
    }

    #[test]
    fn regress_an_absolute_target_names_the_host_of_the_header() {
        for (target, host) in [
            ("http://localhost:8080/v1/me", "localhost:8080"),
            ("http://LOCALHOST/v1/me", "localhost"),
            ("http://localhost/v1/me", "localhost:80"),
            ("https://localhost:443/", "localhost"),
            ("http://[::1]:8080/", "[::1]:8080"),
        ] {
            assert!(hosted(target, host), "{target} {host}");
        }
        for (target, host) in [
            ("http://evil.example/v1/me", "localhost:8080"),
            ("http://localhost:8081/v1/me", "localhost:8080"),
            ("http://localhost/v1/me", "localhost:8080"),
            ("http://a@localhost:8080/", "localhost:8080"),
            ("http://localhost:8080/", ""),
            ("https://localhost/", "localhost:80"),
            ("localhost:8080", "evil.example"),
        ] {
            assert!(!hosted(target, host), "{target} {host}");
        }
    }

    #[test]
    fn a_host_is_a_name_with_or_without_a_port() {
        for host in ["localhost", "localhost:8080", "[::1]:9", "10.0.0.1", "a-b.example:1", ""] {
            assert!(hosted("/", host), "{host}");
        }
        for host in ["a, b", "a b", "a@b", "http://a", "a/b", "a:b", "a:99999", ":80", "a?b", "a#b", "[::1", "a:1:2"] {
            assert!(!hosted("/", host), "{host}");
        }
        assert_eq!(check("/", &[]), Ok(()), "where a host is needed, its absence is refused");
    }
}
