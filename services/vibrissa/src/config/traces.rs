//! Export of traces.

use super::address::web_url;
use super::keys::Key;
use super::reader::Reader;
use vibrissa_supervisor::trace::TraceOptions;

/// Path of an OTLP collector for traces.
const PATH: &str = "v1/traces";

/// The collector, if configured; outer `None` after a refusal.
#[expect(clippy::option_option, reason = "outer: None after a refusal; inner: None if not configured")]
pub(super) fn traces(reader: &mut Reader) -> Option<Option<TraceOptions>> {
    let is_set = reader.is_explicit(Key::TracesOtlpEndpoint);
    let url = reader.parsed(Key::TracesOtlpEndpoint, endpoint);
    let sample_ratio = reader.number(Key::TracesSampleRatio)?;
    if !is_set {
        return Some(None);
    }
    if !cfg!(feature = "traces") {
        let what = "this program was built without traces: build it with --features traces, or leave the key out";
        reader.refuse(Key::TracesOtlpEndpoint, what);
        return None;
    }
    Some(Some(TraceOptions { url: url?, sample_ratio }))
}

/// The URL for traces of the collector at an address.
fn endpoint(text: &str) -> Result<String, String> {
    let example = "write http://HOST:4318";
    let mut url = web_url(text).map_err(|problem| format!("{problem}: {example}"))?;
    if !matches!(url.scheme(), "http" | "https") || url.host().is_none() {
        return Err(format!("must begin with http:// or https://: {example}, the port for OTLP over HTTP"));
    }
    if !url.username().is_empty() || url.password().is_some() {
        return Err("must not hold a password: set OTEL_EXPORTER_OTLP_HEADERS=authorization=... instead".to_owned());
    }
    if url.query().is_some() || url.fragment().is_some() {
        return Err(format!("must end with its path: {example}"));
    }
    let path = url.path().trim_end_matches('/');
    if !path.ends_with(PATH) {
        let path = format!("{path}/{PATH}");
        url.set_path(&path);
    }
    Ok(url.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_for_traces_follows_the_address_unless_it_is_there() {
        for (text, url) in [
            ("http://127.0.0.1:4318", "http://127.0.0.1:4318/v1/traces"),
            ("http://h:4318/", "http://h:4318/v1/traces"),
            ("https://h/otlp/", "https://h/otlp/v1/traces"),
            ("https://h/v1/traces", "https://h/v1/traces"),
        ] {
            assert_eq!(endpoint(text).as_deref(), Ok(url));
        }
    }

    #[test]
    fn what_is_no_collectors_address_is_refused_with_what_to_write() {
        for (text, expected) in [
            ("http://b\u{fc}cher.example:4318", "write it in Punycode"),
            ("collector", "is not a URL (it has no scheme, such as https://): write http://HOST:4318"),
            ("localhost:4318", "must begin with http:// or https://"),
            ("grpc://h:4317", "must begin with http:// or https://"),
            ("http://u:hunter2@h:4318", "OTEL_EXPORTER_OTLP_HEADERS"),
            ("http://h:4318?x=1", "must end with its path"),
        ] {
            let problem = endpoint(text).unwrap_err();
            assert!(problem.contains(expected) && !problem.contains("hunter2"), "{text}: {problem}");
        }
    }
}
