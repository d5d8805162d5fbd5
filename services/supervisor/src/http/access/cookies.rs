//! Cookies of the console. Scripts cannot read them. Over HTTPS their names bind them to this host alone, and below a path to
//! that path: other services of the host do not get them, and two supervisors of a host do not share a session.

use axum::http::{HeaderMap, HeaderName, header};
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;

use crate::http::problem::{Kind, Problem};
use vibrissa_store::secret::Secret;

/// A cookie of this service.
#[derive(Debug)]
pub struct Cookie {
    name: &'static str,
    /// Which requests from other sites carry it: `Strict` none, `Lax` opened links.
    same_site: &'static str,
}

/// Where browsers reach the console.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Site {
    /// Whether browsers use HTTPS.
    is_secure: bool,
    /// Path of the public address, such as `/vibrissa`; `/` for that of a whole host.
    path: String,
}

impl Site {
    /// The site of a public address.
    #[must_use]
    pub fn of(public_url: &str) -> Self {
        let path = url::Url::parse(public_url).map_or_else(|_| String::new(), |url| url.path().to_owned());
        let path = path.trim_end_matches('/');
        Self {
            is_secure: public_url.starts_with("https://"),
            path: if path.is_empty() { "/".to_owned() } else { path.to_owned() },
        }
    }
}

/// The session of a person who has signed in.
pub const SESSION: Cookie = Cookie { name: "vibrissa-session", same_site: "Strict" };
/// Length of the identifier in a session's cookie, in bytes.
pub(super) const ID_BYTES: usize = 16;
/// Length of the key that follows the identifier, in bytes. Only the browser has it.
pub(super) const KEY_BYTES: usize = 32;
/// A sign-in that is under way.
pub const ATTEMPT: Cookie = Cookie { name: "vibrissa-sign-in", same_site: "Lax" };

impl Cookie {
    /// Browsers take `__Host-` only with the path of the whole host.
    fn name(&self, site: &Site) -> String {
        let prefix = match (site.is_secure, site.path.as_str()) {
            (true, "/") => "__Host-",
            (true, _) => "__Secure-",
            (false, _) => "",
        };
        format!("{prefix}{}", self.name)
    }
}

/// The value of `Set-Cookie`. Without a lifetime the cookie ends with the browser.
#[must_use]
pub fn set(cookie: &Cookie, value: &str, site: &Site, lifetime_s: Option<i64>) -> String {
    let (name, path, same_site) = (cookie.name(site), &site.path, cookie.same_site);
    let secure = if site.is_secure { "; Secure" } else { "" };
    let lifetime = lifetime_s.map_or_else(String::new, |seconds| format!("; Max-Age={seconds}"));
    format!("{name}={value}; Path={path}; HttpOnly; SameSite={same_site}{secure}{lifetime}")
}

/// The value of `Set-Cookie` that removes a cookie.
#[must_use]
pub fn clear(cookie: &Cookie, site: &Site) -> String {
    set(cookie, "", site, Some(0))
}

/// The value of a request's cookie.
#[must_use]
pub fn value(headers: &HeaderMap, cookie: &Cookie, site: &Site) -> Option<String> {
    let name = cookie.name(site);
    let line = headers.get_all(header::COOKIE).iter().filter_map(|line| line.to_str().ok());
    let mut pairs = line.flat_map(|line| line.split(';')).filter_map(|pair| pair.trim().split_once('='));
    pairs.find(|(one, value)| *one == name && !value.is_empty()).map(|(_, value)| value.to_owned())
}

/// Refuses a request that changes something unless the browser says that a page of this service sends it. Requests of other
/// sites are refused anyway; this one must not come from a browser that does not say where from.
///
/// # Errors
/// Neither `Sec-Fetch-Site` nor `Origin` names this service.
pub fn require_own_page(headers: &HeaderMap) -> Result<(), Problem> {
    let text = |name: HeaderName| headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let is_own = text(HeaderName::from_static("sec-fetch-site")) == "same-origin"
        || text(header::ORIGIN).split_once("://").is_some_and(|(_, from)| from == text(header::HOST));
    if is_own {
        return Ok(());
    }
    Err(Problem::new(Kind::CrossSite, "with a session, changes are accepted from the console's own pages only"))
}

/// The answer to a cookie whose session does not exist any more.
pub(super) fn session_ended() -> Problem {
    Problem::new(Kind::Unauthenticated, "the session has ended: sign in again")
}

/// Hash of the identifier in a session's cookie, by which the database knows the session; `None` if the cookie has another format.
pub(super) fn session_hash(cookie: &Secret) -> Option<[u8; 32]> {
    let bytes = URL_SAFE_NO_PAD.decode(cookie.reveal()).ok().filter(|bytes| bytes.len() == ID_BYTES + KEY_BYTES)?;
    Some(*blake3::hash(&bytes[..ID_BYTES]).as_bytes())
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    fn headers(pairs: &[(&'static str, &'static str)]) -> HeaderMap {
        pairs.iter().map(|&(name, value)| (HeaderName::from_static(name), HeaderValue::from_static(value))).collect()
    }

    #[test]
    fn a_cookie_is_found_among_others_by_its_whole_name() {
        let given = headers(&[("cookie", "a=1; vibrissa-session=x.y; __Host-vibrissa-session=z; b=")]);
        let [plain, secure] = ["http://h", "https://h/"].map(Site::of);
        assert_eq!(value(&given, &SESSION, &plain).as_deref(), Some("x.y"));
        assert_eq!(value(&given, &SESSION, &secure).as_deref(), Some("z"));
        assert_eq!(value(&given, &ATTEMPT, &plain), None);
        assert_eq!(value(&headers(&[("cookie", "vibrissa-session=")]), &SESSION, &plain), None);
    }

    #[test]
    fn over_https_cookies_are_secure_and_bound_to_the_host() {
        let cookie = set(&SESSION, "x", &Site::of("https://h"), None);
        assert_eq!(cookie, "__Host-vibrissa-session=x; Path=/; HttpOnly; SameSite=Strict; Secure");
        let cookie = clear(&ATTEMPT, &Site::of("http://h:1"));
        assert_eq!(cookie, "vibrissa-sign-in=; Path=/; HttpOnly; SameSite=Lax; Max-Age=0");
    }

    #[test]
    fn regress_below_a_path_cookies_are_bound_to_it() {
        for public_url in ["https://h/west", "https://h/west/"] {
            let line = set(&SESSION, "x", &Site::of(public_url), None);
            assert_eq!(line, "__Secure-vibrissa-session=x; Path=/west; HttpOnly; SameSite=Strict; Secure");
        }
        let line = clear(&ATTEMPT, &Site::of("http://h:1/a/b"));
        assert_eq!(line, "vibrissa-sign-in=; Path=/a/b; HttpOnly; SameSite=Lax; Max-Age=0");
    }

    #[test]
    fn a_change_must_come_from_an_own_page() {
        let is_own = |pairs: &[_]| require_own_page(&headers(&[&[("host", "h:1")], pairs].concat())).is_ok();
        assert!(is_own(&[("sec-fetch-site", "same-origin")]) && is_own(&[("origin", "https://h:1")]));
        assert!(!is_own(&[]) && !is_own(&[("sec-fetch-site", "none")]) && !is_own(&[("origin", "https://h:2")]));
    }
}
