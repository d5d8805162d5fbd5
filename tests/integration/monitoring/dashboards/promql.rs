//! A parser of the part of PromQL that the lint rules need: selectors of series and the functions around them.

/// A selector of series.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Selector<'a> {
    /// Name of the metric.
    pub(super) metric: &'a str,
    /// Text between the braces. None without braces.
    pub(super) matchers: Option<&'a str>,
    /// Text between the brackets of a range selector.
    pub(super) range: Option<&'a str>,
    /// The innermost function or aggregation around the selector; empty without one.
    pub(super) within: &'a str,
}

/// All selectors of the supervisor's metrics.
pub(super) fn selectors(expression: &str) -> Vec<Selector<'_>> {
    let mut found = Vec::new();
    let mut begin = 0;
    while begin < expression.len() {
        let length = word(&expression[begin..]);
        let metric = &expression[begin..begin + length];
        if ["vibrissa_", "process_"].iter().any(|prefix| metric.starts_with(prefix)) {
            let (matchers, rest) = enclosed(&expression[begin + length..], '{', '}');
            let (range, _) = enclosed(rest, '[', ']');
            found.push(Selector { metric, matchers, range, within: caller(&expression[..begin]) });
        }
        // Matchers are skipped, because the words in them are not metrics.
        begin += length.max(1);
    }
    found
}

/// Length of the word at the start of the text.
fn word(text: &str) -> usize {
    text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == ':')).unwrap_or(text.len())
}

/// The text between two brackets, and the rest. A bracket between quotes closes nothing.
fn enclosed(text: &str, open: char, close: char) -> (Option<&str>, &str) {
    let Some(inner) = text.strip_prefix(open) else { return (None, text) };
    let mut is_quoted = false;
    let end = inner.find(|letter| {
        is_quoted ^= letter == '"';
        letter == close && !is_quoted
    });
    end.map_or((None, text), |end| (Some(&inner[..end]), &inner[end + 1..]))
}

/// The word before the parenthesis at the end of the text.
fn caller(before: &str) -> &str {
    let Some(before) = before.trim_end().strip_suffix('(') else { return "" };
    let begin = before.rfind(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).map_or(0, |at| at + 1);
    &before[begin..]
}

#[test]
fn selectors_are_found_with_what_is_asked_of_them() {
    let text =
        r#"sum by (vibe) (rate(vibrissa_a_total{job=~"${job:x}"}[$__rate_interval])) / vibrissa_b + time() - x{y="z"}"#;
    let [a, b] = selectors(text).try_into().unwrap();
    let matchers = Some(r#"job=~"${job:x}""#);
    let range = Some("$__rate_interval");
    assert_eq!(a, Selector { metric: "vibrissa_a_total", matchers, range, within: "rate" });
    assert_eq!(b, Selector { metric: "vibrissa_b", matchers: None, range: None, within: "" });
}
