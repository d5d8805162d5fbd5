//! Times as RFC 3339 text: UTC with milliseconds.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A time in microseconds since 1970 UTC; as text `2026-11-21T08:00:00.000Z`.
///
/// Written with milliseconds (truncated), read with any number of decimals in up to 64 characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Timestamp(pub u64);

/// A text that is not a valid timestamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("invalid timestamp: expected RFC 3339 in UTC such as 2026-11-21T08:00:00.000Z, not before 1970")]
pub struct BadTimestamp;

/// Longest text that is read; it has room for some forty decimals.
const TEXT_MAX_BYTES: usize = 64;
const US_PER_S: u64 = 1_000_000;
const S_PER_DAY: u64 = 86_400;

/// Year, month and day of the proleptic Gregorian calendar, from days since 1970-01-01.
///
/// Counts in eras of 400 years that begin on 1 March, so that the leap day is the last day of its year.
fn date_of(days: u64) -> (u64, u64, u64) {
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    (era * 400 + year_of_era + u64::from(month <= 2), month, day)
}

/// The inverse of [`date_of`]; `None` for a date that does not exist or lies before 1970.
fn days_of(year: u64, month: u64, day: u64) -> Option<u64> {
    if year < 1970 || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    let year_from_march = year - u64::from(month <= 2);
    let (era, year_of_era) = (year_from_march / 400, year_from_march % 400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let days = era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    let days = days.checked_sub(719_468)?;
    (date_of(days) == (year, month, day)).then_some(days)
}

impl fmt::Display for Timestamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (seconds, ms) = (self.0 / US_PER_S, self.0 % US_PER_S / 1_000);
        let (year, month, day) = date_of(seconds / S_PER_DAY);
        let (hour, minute, second) = (seconds / 3_600 % 24, seconds / 60 % 60, seconds % 60);
        write!(f, "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{ms:03}Z")
    }
}

impl FromStr for Timestamp {
    type Err = BadTimestamp;

    fn from_str(text: &str) -> Result<Self, BadTimestamp> {
        parse(text).map(Self).ok_or(BadTimestamp)
    }
}

/// Parses the digits at fixed positions of a text.
fn digits(text: &str, from: usize, to: usize) -> Option<u64> {
    let part = text.get(from..to)?;
    if part.bytes().all(|b| b.is_ascii_digit()) { part.parse().ok() } else { None }
}

fn parse(text: &str) -> Option<u64> {
    if text.len() > TEXT_MAX_BYTES {
        return None;
    }
    let body = text.strip_suffix(['Z', 'z']).or_else(|| text.strip_suffix("+00:00"))?;
    let separators = [(4, "-"), (7, "-"), (10, "T"), (13, ":"), (16, ":")];
    if !separators.iter().all(|&(at, mark)| body.get(at..at + 1).is_some_and(|c| c.eq_ignore_ascii_case(mark))) {
        return None;
    }
    let days = days_of(digits(body, 0, 4)?, digits(body, 5, 7)?, digits(body, 8, 10)?)?;
    let (hour, minute, second) = (digits(body, 11, 13)?, digits(body, 14, 16)?, digits(body, 17, 19)?);
    // 60 is a leap second; it reads as the first instant of the next minute.
    if hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    let fraction_us = match body.get(19..)? {
        "" => 0,
        rest => {
            let decimals = rest.strip_prefix('.').filter(|d| !d.is_empty() && d.bytes().all(|b| b.is_ascii_digit()))?;
            format!("{decimals:0<6}").get(..6)?.parse::<u64>().ok()?
        }
    };
    let seconds = days * S_PER_DAY + hour * 3_600 + minute * 60 + second;
    // The leap second after the last minute of 9999 would need a year of five digits.
    (seconds < days_of(9999, 12, 31)? * S_PER_DAY + S_PER_DAY).then_some(seconds * US_PER_S + fraction_us)
}

impl Serialize for Timestamp {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The texts that [`Timestamp`] reads, except for the number of days in a month. RFC 3339 also allows other offsets
/// and earlier years.
#[cfg(feature = "documents")]
const PATTERN: &str = "^(19[7-9][0-9]|[2-9][0-9]{3})-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])[Tt]\
                       ([01][0-9]|2[0-3]):[0-5][0-9]:([0-5][0-9]|60)([.][0-9]+)?([Zz]|[+]00:00)$";

#[cfg(feature = "documents")]
impl schemars::JsonSchema for Timestamp {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Timestamp".into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "format": "date-time", "maxLength": TEXT_MAX_BYTES, "pattern": PATTERN })
    }
}

impl<'de> Deserialize<'de> for Timestamp {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_instant_is_that_of_the_year_9999() {
        let last = "9999-12-31T23:59:59.999Z";
        assert_eq!(last.parse::<Timestamp>().unwrap().to_string(), last);
        assert_eq!("9999-12-31T23:59:60Z".parse::<Timestamp>(), Err(BadTimestamp));
    }

    #[test]
    fn golden_dates_from_gnu_date() {
        // `date -u -d <text> +%s`
        for (text, seconds) in [
            ("1970-01-01T00:00:00.000Z", 0),
            ("1972-02-29T23:59:59.000Z", 68_255_999),
            ("2000-02-29T12:00:00.000Z", 951_825_600),
            ("2026-11-21T08:00:00.000Z", 1_795_248_000),
            ("2100-03-01T00:00:00.000Z", 4_107_542_400),
        ] {
            assert_eq!(Timestamp(seconds * US_PER_S).to_string(), text);
            assert_eq!(text.parse(), Ok(Timestamp(seconds * US_PER_S)));
        }
    }

    #[test]
    fn every_day_of_500_years_round_trips() {
        for day in 0..182_622 {
            let (year, month, day_of_month) = date_of(day);
            assert_eq!(days_of(year, month, day_of_month), Some(day));
        }
    }

    #[test]
    fn written_with_milliseconds_and_read_with_any_decimals() {
        assert_eq!(Timestamp(123_456).to_string(), "1970-01-01T00:00:00.123Z");
        assert_eq!("1970-01-01T00:00:00.5Z".parse(), Ok(Timestamp(500_000)));
        assert_eq!("1970-01-01t00:00:00.1234567z".parse(), Ok(Timestamp(123_456)));
        assert_eq!("1970-01-01T00:00:01+00:00".parse(), Ok(Timestamp(1_000_000)));
    }

    #[test]
    fn other_texts_are_refused() {
        for bad in [
            "",
            "now",
            "2026-02-30T00:00:00Z",
            "1969-12-31T23:59:59Z",
            "2026-11-21T24:00:00Z",
            "2026-11-21T08:00:00+01:00",
            "2026-11-21T08:00:00.Z",
            "2026-11-21 08:00:00Z",
            "2026-11-2éT08:00:00Z",
            &format!("2026-11-21T08:00:00.{}Z", "0".repeat(44)),
        ] {
            assert_eq!(bad.parse::<Timestamp>(), Err(BadTimestamp), "{bad}");
        }
    }
}
