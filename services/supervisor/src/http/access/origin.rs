//! The origin of a request: refuses requests through a proxy where no token is required, and requests from other sites.

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, Method, Version, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::http::problem::{Kind, Problem};

/// Headers that proxies add; so are all that begin with `x-forwarded-`.
const PROXY_HEADERS: [&str; 3] = ["via", "forwarded", "x-real-ip"];

/// Pages that links on other sites may open: they contain no data, and read their data from this origin. The identity
/// provider leads back to `/auth/callback`, which requires the cookie of an attempt.
const PAGES: [&str; 2] = ["/", "/auth/callback"];

/// Without a token, only a client on this machine that uses a local host name is admitted. A proxy would admit everyone
/// who reaches it, and a foreign host name may belong to another site whose name resolves to loopback.
pub(super) fn require_direct(version: Version, headers: &HeaderMap) -> Result<(), Problem> {
    let is_proxys =
        |name: &HeaderName| PROXY_HEADERS.contains(&name.as_str()) || name.as_str().starts_with("x-forwarded-");
    // Proxies such as nginx speak HTTP/1.0 to the server behind them by default; today's clients do not.
    if version < Version::HTTP_11 || headers.keys().any(is_proxys) {
        return Err(Problem::new(
            Kind::Unauthenticated,
            "the request came through a proxy (or in HTTP/1.0, as from a proxy); without tokens only direct requests \
             from this machine are answered: set http.token_file or http.oidc_issuer",
        ));
    }
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    let name = host.rsplit_once(':').filter(|(_, port)| port.bytes().all(|byte| byte.is_ascii_digit()));
    let name = name.map_or(host, |(name, _)| name).trim_start_matches('[').trim_end_matches(']');
    let is_local = name == "localhost" || name.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback());
    if is_local {
        return Ok(());
    }
    Err(Problem::new(
        Kind::CrossSite,
        format!("without a token only localhost and loopback addresses are accepted, not {name:?}: create a token"),
    ))
}

/// Refuses requests from pages of other sites, before they count for the rate limit of the user whose browser sends
/// them. Read requests are refused too: a page that cannot see an answer could still use up the limit, or learn from
/// the response time.
pub async fn refuse_other_sites(request: Request, next: Next) -> Response {
    match require_same_site(request.method(), request.uri().path(), request.headers()) {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    }
}

fn require_same_site(method: &Method, path: &str, headers: &HeaderMap) -> Result<(), Problem> {
    let text = |name: HeaderName| headers.get(name).map(|value| value.to_str().unwrap_or_default());
    let fetch = |name: &'static str| text(HeaderName::from_static(name));
    let is_foreign_site = fetch("sec-fetch-site").is_some_and(|site| !matches!(site, "same-origin" | "none"));
    let is_foreign_origin = match (text(header::ORIGIN), text(header::HOST)) {
        (Some(origin), Some(host)) => origin.split_once("://").is_none_or(|(_, from)| from != host),
        (Some(_), None) => true,
        (None, _) => false,
    };
    let is_opened_page = matches!(*method, Method::GET | Method::HEAD)
        && PAGES.contains(&path)
        && fetch("sec-fetch-mode") == Some("navigate")
        && fetch("sec-fetch-dest") == Some("document");
    if is_foreign_origin || (is_foreign_site && !is_opened_page) {
        return Err(Problem::new(Kind::CrossSite, "the request comes from another site's page"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    fn headers(pairs: &[(&'static str, &'static str)]) -> HeaderMap {
        pairs.iter().map(|&(name, value)| (HeaderName::from_static(name), HeaderValue::from_static(value))).collect()
    }

    #[test]
    fn a_request_through_a_proxy_is_refused_without_a_token() {
        let is_direct = |version, pairs: &[_]| {
            let headers = headers(&[&[("host", "localhost:8080")], pairs].concat());
            require_direct(version, &headers).is_ok()
        };
        assert!(is_direct(Version::HTTP_11, &[]) && is_direct(Version::HTTP_2, &[("accept", "*/*")]));
        assert!(!is_direct(Version::HTTP_10, &[]) && !is_direct(Version::HTTP_09, &[]));
        for name in ["via", "forwarded", "x-real-ip", "x-forwarded-for", "x-forwarded-proto", "x-forwarded-host"] {
            assert!(!is_direct(Version::HTTP_11, &[(name, "1.1 proxy")]), "{name}");
        }
    }

    #[test]
    fn another_sites_page_may_open_a_page_and_nothing_else() {
        let is_let_in = |method: &Method, path: &str, site, mode, destination| {
            let given = [
                ("host", "localhost:8080"),
                ("sec-fetch-site", site),
                ("sec-fetch-mode", mode),
                ("sec-fetch-dest", destination),
            ];
            require_same_site(method, path, &headers(&given)).is_ok()
        };
        for site in ["cross-site", "same-site", "nonsense"] {
            for path in PAGES {
                assert!(is_let_in(&Method::GET, path, site, "navigate", "document"), "{path}");
                assert!(!is_let_in(&Method::POST, path, site, "navigate", "document"), "{path}");
                assert!(!is_let_in(&Method::GET, path, site, "navigate", "iframe"), "{path}");
                assert!(!is_let_in(&Method::GET, path, site, "no-cors", "document"), "{path}");
            }
            for path in ["/v1/whiskers", "/v1/events", "/metrics", "/readyz", "/openapi.json", "/console/main.js"] {
                assert!(!is_let_in(&Method::GET, path, site, "navigate", "document"), "{path}");
                assert!(!is_let_in(&Method::GET, path, site, "no-cors", "image"), "{path}");
                assert!(is_let_in(&Method::GET, path, "same-origin", "cors", "empty"), "{path}");
                assert!(is_let_in(&Method::GET, path, "none", "navigate", "document"), "{path}");
            }
        }
        // An older browser, which tells the origin only.
        let from = |origin| {
            let headers = headers(&[("host", "localhost:8080"), ("origin", origin)]);
            require_same_site(&Method::GET, "/v1/whiskers", &headers).is_ok()
        };
        assert!(from("http://localhost:8080"));
        assert!(!from("http://localhost:3000") && !from("https://evil.example") && !from("null"));
    }
}
