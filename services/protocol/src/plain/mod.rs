//! Errors of libraries in plain English, with what to do: one text for each cause, in one place for each library.
//!
//! Here are those that several crates meet. A library that this crate does not know is classified by the name of its
//! variant, as its `Debug` output begins with it.

mod certificate;
mod json;
mod mqtt;
mod tls;

pub use certificate::{certificate, host_names};
pub use json::{data, in_file, json, not_json, required};
pub use mqtt::reason_code;
pub use tls::{alert, tls};

/// An error of the operating system, without its number.
#[must_use]
pub fn io(problem: &std::io::Error) -> String {
    text(&problem.to_string())
}

/// The text of another library, whose own words it may contain: numbers of the operating system, certificates.
#[must_use]
pub fn text(raw: &str) -> String {
    const CERTIFICATE: &str = "invalid peer certificate: ";
    if let Some((before, problem)) = raw.split_once(CERTIFICATE) {
        return format!("{}its certificate cannot be used: {}", without_numbers(before), certificate(problem));
    }
    without_numbers(raw)
}

/// An error of the crate `url`, by its text.
#[must_use]
pub fn url(raw: &str) -> String {
    match raw {
        "relative URL without a base" => "it has no scheme, such as https://".to_owned(),
        "empty host" => "it has no host".to_owned(),
        "invalid port number" => "its port is no number from 0 to 65535".to_owned(),
        "invalid international domain name" | "invalid domain character" => "its host is no host name".to_owned(),
        "invalid IPv4 address" | "invalid IPv6 address" => "its host is no IP address".to_owned(),
        other => other.to_owned(),
    }
}

/// The text without the numbers of the operating system: ` (os error 2)`.
fn without_numbers(raw: &str) -> String {
    let mut parts = raw.split(" (os error ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| match part.split_once(')') {
        Some((number, rest)) if number.bytes().all(|one| one.is_ascii_digit()) => text + rest,
        Some(_) | None => format!("{text} (os error {part}"),
    })
}

/// The name of a variant, from its `Debug` output: `A` of `Other(OtherError(A))` and of `A { b: 1 }`.
fn variant(debug: &str) -> &str {
    let debug =
        ["Other(", "OtherError("].into_iter().fold(debug, |text, outer| text.strip_prefix(outer).unwrap_or(text));
    debug.split(|one: char| !one.is_ascii_alphanumeric()).next().unwrap_or_default()
}

/// The name of a variant in words: `quota exceeded` of `QuotaExceeded(7)`, from its `Debug` output.
#[must_use]
pub fn name(debug: &str) -> String {
    words(variant(debug))
}

/// The words of a variant's name: `quota exceeded` of `QuotaExceeded`.
fn words(variant: &str) -> String {
    let mut text = String::new();
    let mut was_upper = true;
    for one in variant.chars() {
        if one.is_ascii_uppercase() && !was_upper {
            text.push(' ');
        }
        was_upper = one.is_ascii_uppercase();
        text.push(one.to_ascii_lowercase());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_lose_the_words_of_libraries() {
        let missing = std::io::Error::from_raw_os_error(2);
        assert_eq!(io(&missing), "No such file or directory");
        assert_eq!(text("a (os error 2); b (os error 13)"), "a; b");
        assert_eq!(text("a (os error x)"), "a (os error x)");
        let shown = text("connection failed: invalid peer certificate: Other(OtherError(UnsupportedCertVersion))");
        assert!(
            shown.starts_with("connection failed: its certificate cannot be used: it is of X.509 version 1"),
            "{shown}"
        );
    }

    #[test]
    fn addresses_lose_the_words_of_the_library() {
        for (raw, part) in
            [("relative URL without a base", "scheme"), ("invalid IPv6 address", "IP"), ("empty host", "no host")]
        {
            assert!(url(raw).contains(part), "{raw}");
        }
    }

    #[test]
    fn names_of_variants_become_words() {
        assert_eq!(variant("Other(OtherError(CaUsedAsEndEntity))"), "CaUsedAsEndEntity");
        assert_eq!(variant("ExpiredContext { time: 1 }"), "ExpiredContext");
        assert_eq!(words("QuotaExceeded"), "quota exceeded");
    }
}
