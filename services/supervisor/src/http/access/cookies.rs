//! Cookies of the console. Scripts cannot read them. Over HTTPS their names bind them to this host alone.

use axum::http::{HeaderMap, HeaderName, header};

use crate::http::problem::{Kind, Problem};

/// A cookie of this service.
#[derive(Debug)]
pub struct Cookie {
    name: &'static str,
    /// Which requests from other sites carry it: `Strict` none, `Lax` opened links.
    same_site: &'static str,
}

/// The session of a person who has signed in.
pub const SESSION: Cookie = Cookie { name: "vibrissa-session", same_site: "Strict" };
/// A sign-in that is under way.
pub const ATTEMPT: Cookie = Cookie { name: "vibrissa-sign-in", same_site: "Lax" };

impl Cookie {
    fn name(&self, is_secure: bool) -> String {
        format!("{}{}", if is_secure { "__Host-" } else { "" }, self.name)
    }
}

/// The value of `Set-Cookie`. Without a lifetime the cookie ends with the browser.
#[must_use]
pub fn set(cookie: &Cookie, value: &str, is_secure: bool, lifetime_s: Option<i64>) -> String {
    let (name, same_site) = (cookie.name(is_secure), cookie.same_site);
    let secure = if is_secure { "; Secure" } else { "" };
    let lifetime = lifetime_s.map_or_else(String::new, |seconds| format!("; Max-Age={seconds}"));
    format!("{name}={value}; Path=/; HttpOnly; SameSite={same_site}{secure}{lifetime}")
}

/// The value of `Set-Cookie` that removes a cookie.
#[must_use]
pub fn clear(cookie: &Cookie, is_secure: bool) -> String {
    set(cookie, "", is_secure, Some(0))
}

/// The value of a request's cookie.
#[must_use]
pub fn value(headers: &HeaderMap, cookie: &Cookie, is_secure: bool) -> Option<String> {
    let name = cookie.name(is_secure);
    let told = headers.get_all(header::COOKIE).iter().filter_map(|told| told.to_str().ok());
    let mut pairs = told.flat_map(|told| told.split(';')).filter_map(|pair| pair.trim().split_once('='));
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

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    fn headers(told: &[(&'static str, &'static str)]) -> HeaderMap {
        told.iter().map(|&(name, value)| (HeaderName::from_static(name), HeaderValue::from_static(value))).collect()
    }

    #[test]
    fn a_cookie_is_found_among_others_by_its_whole_name() {
        let told = headers(&[("cookie", "a=1; vibrissa-session=x.y; __Host-vibrissa-session=z; b=")]);
        assert_eq!(value(&told, &SESSION, false).as_deref(), Some("x.y"));
        assert_eq!(value(&told, &SESSION, true).as_deref(), Some("z"));
        assert_eq!(value(&told, &ATTEMPT, false), None);
        assert_eq!(value(&headers(&[("cookie", "vibrissa-session=")]), &SESSION, false), None);
    }

    #[test]
    fn over_https_cookies_are_secure_and_bound_to_the_host() {
        let told = set(&SESSION, "x", true, None);
        assert_eq!(told, "__Host-vibrissa-session=x; Path=/; HttpOnly; SameSite=Strict; Secure");
        let told = clear(&ATTEMPT, false);
        assert_eq!(told, "vibrissa-sign-in=; Path=/; HttpOnly; SameSite=Lax; Max-Age=0");
    }

    #[test]
    fn a_change_must_come_from_an_own_page() {
        let is_own = |told: &[_]| require_own_page(&headers(&[&[("host", "h:1")], told].concat())).is_ok();
        assert!(is_own(&[("sec-fetch-site", "same-origin")]) && is_own(&[("origin", "https://h:1")]));
        assert!(!is_own(&[]) && !is_own(&[("sec-fetch-site", "none")]) && !is_own(&[("origin", "https://h:2")]));
    }
}
