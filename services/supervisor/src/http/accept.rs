//! The header `Accept`: which of several media types a client prefers.

use axum::http::HeaderMap;
use axum::http::header::ACCEPT;

/// Position of the preferred media type among the offered ones: the first without a preference, `None` for a client that
/// accepts none of them.
pub(super) fn preferred(headers: &HeaderMap, offered: &[&str]) -> Option<usize> {
    if !headers.contains_key(ACCEPT) {
        return Some(0);
    }
    let values: Vec<&str> = headers.get_all(ACCEPT).iter().filter_map(|value| value.to_str().ok()).collect();
    let ranges: Vec<(&str, f64)> = values.iter().flat_map(|value| value.split(',')).filter_map(range).collect();
    let mut best = (None, 0.0);
    for (at, media_type) in offered.iter().enumerate() {
        let quality = quality(&ranges, media_type);
        if quality > best.1 {
            best = (Some(at), quality);
        }
    }
    best.0
}

/// A media range and its quality, 0 to 1.
fn range(text: &str) -> Option<(&str, f64)> {
    let mut parts = text.split(';').map(str::trim);
    let media_range = parts.next().filter(|media_range| !media_range.is_empty())?;
    let weight = parts.find_map(|part| part.strip_prefix("q=").or_else(|| part.strip_prefix("Q=")));
    Some((media_range, weight.and_then(|weight| weight.parse().ok()).unwrap_or(1.0)))
}

/// Quality of a media type: that of the most specific range that includes it.
fn quality(ranges: &[(&str, f64)], media_type: &str) -> f64 {
    let kind = media_type.split('/').next().unwrap_or_default();
    let of = |wanted: &str| {
        ranges.iter().find(|(offered, _)| offered.eq_ignore_ascii_case(wanted)).map(|(_, quality)| *quality)
    };
    of(media_type).or_else(|| of(&format!("{kind}/*"))).or_else(|| of("*/*")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_specific_range_and_the_highest_quality_win_and_the_first_offer_at_a_tie() {
        for (accept, expected) in [
            (None, Some(0)),
            (Some(""), None),
            (Some("*/*"), Some(0)),
            (Some("text/csv"), Some(1)),
            (Some("TEXT/CSV; q=0.1"), Some(1)),
            (Some("text/*"), Some(1)),
            (Some("application/json, text/csv"), Some(0)),
            (Some("application/json;q=0.5, text/csv"), Some(1)),
            (Some("text/csv;q=0.5, application/json"), Some(0)),
            (Some("text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"), Some(0)),
            (Some("application/json;q=0, */*"), Some(1)),
            (Some("image/png"), None),
            (Some("text/csv;q=x"), Some(1)),
        ] {
            let mut headers = HeaderMap::new();
            headers.extend(accept.map(|accept| (ACCEPT, accept.parse().unwrap())));
            assert_eq!(preferred(&headers, &["application/json", "text/csv"]), expected, "{accept:?}");
        }
    }
}
