//! The page of the console to which a sign-in leads back. It travels through the browser, so it is checked whenever it is
//! read.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use url::Url;

/// Maximum length, in characters.
const CHARS_MAX: usize = 1000;

/// A page of the console: a fragment such as `#/fleets/f`. Nothing else is one, so it cannot lead to another origin.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub(in crate::http) struct ReturnPage(String);

/// The text is no page of the console.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "a page of the console begins with #/, and has at most {CHARS_MAX} characters, none of them a control character"
)]
pub(in crate::http) struct NoPage;

impl Default for ReturnPage {
    /// Where people arrive who came from nowhere.
    fn default() -> Self {
        Self("#/fleets".to_owned())
    }
}

impl FromStr for ReturnPage {
    type Err = NoPage;

    fn from_str(text: &str) -> Result<Self, NoPage> {
        let path = text.strip_prefix("#/").filter(|path| !path.starts_with(['/', '\\'])).ok_or(NoPage)?;
        if text.chars().count() > CHARS_MAX || text.contains(char::is_control) {
            return Err(NoPage);
        }
        // Headers are in ASCII: this encodes other letters.
        let mut url = Url::parse("http://console/").map_err(|_| NoPage)?;
        url.set_fragment(Some(path));
        Ok(Self(format!("#/{}", url.fragment().unwrap_or_default())))
    }
}

impl TryFrom<String> for ReturnPage {
    type Error = NoPage;

    fn try_from(text: String) -> Result<Self, NoPage> {
        text.parse()
    }
}

impl From<ReturnPage> for String {
    fn from(page: ReturnPage) -> Self {
        page.0
    }
}

impl fmt::Display for ReturnPage {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;
    use proptest::prelude::*;

    use super::*;

    const ELSEWHERE: [&str; 16] = [
        "",
        "/",
        "//evil.example",
        "/\\evil.example",
        "\\\\evil.example",
        "https://evil.example",
        "https:evil.example",
        "javascript:alert(1)",
        "#//evil.example",
        "#/\\evil.example",
        "#",
        "#x",
        " #/fleets",
        "#/fleets\r\nSet-Cookie: a=b",
        "#/fl\teets",
        "#/fleets\u{0}",
    ];

    #[test]
    fn regress_only_pages_of_the_console_are_led_back_to() {
        for text in ELSEWHERE {
            assert_eq!(text.parse::<ReturnPage>(), Err(NoPage), "{text:?}");
            // As it comes back in the cookie of the attempt.
            assert!(serde_json::from_value::<ReturnPage>(text.into()).is_err(), "{text:?}");
        }
        for text in ["#/fleets", "#/fleets/f?sort=-length_mm&a=b", "#/"] {
            assert_eq!(text.parse::<ReturnPage>().unwrap().to_string(), text);
        }
        assert_eq!("#/search/Gr\u{fc}n x".parse::<ReturnPage>().unwrap().to_string(), "#/search/Gr%C3%BCn%20x");
    }

    proptest! {
        #[test]
        fn property_a_return_page_stays_at_its_origin(text in r"#?[/\\#]{0,3}\PC{0,12}") {
            if let Ok(page) = text.parse::<ReturnPage>() {
                let place = format!("/{page}");
                let console = Url::parse("https://console.example:8443/auth/callback").unwrap();
                let reached = console.join(&place).unwrap();
                prop_assert_eq!(reached.origin(), console.origin());
                prop_assert_eq!(reached.path(), "/");
                prop_assert!(HeaderValue::from_str(&place).is_ok());
            }
        }
    }
}
