//! URLs of other services.

use url::{ParseError, Url};
use vibrissa_protocol::plain;

/// Parses the URL of a web service.
///
/// # Errors
/// It is malformed, or its host is not in ASCII: this program has no Unicode tables.
pub fn web_url(text: &str) -> Result<Url, String> {
    Url::parse(text).map_err(|problem| {
        if problem == ParseError::IdnaError && !text.is_ascii() {
            "has a host name that is not in ASCII: write it in Punycode, such as xn--bcher-kva.example for \
             b\u{fc}cher.example"
                .to_owned()
        } else {
            format!("is not a URL ({})", plain::url(&problem.to_string()))
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_in_ascii_and_others_are_refused_with_what_to_write() {
        let url = web_url("https://xn--bcher-kva.example:8443/realms/b\u{fc}cher").unwrap();
        assert_eq!(url.host_str(), Some("xn--bcher-kva.example"));
        assert_eq!(web_url("https://B%C3%BCcher.example").unwrap_err(), "is not a URL (its host is no host name)");
        for host in ["b\u{fc}cher.example", "\u{4f8b}\u{3048}.jp:8443", "user@\u{e9}.fr"] {
            let problem = web_url(&format!("https://{host}/")).unwrap_err();
            assert!(problem.starts_with("has a host name that is not in ASCII: write it in Punycode"), "{problem}");
        }
        assert_eq!(web_url("issuer").unwrap_err(), "is not a URL (it has no scheme, such as https://)");
    }
}
