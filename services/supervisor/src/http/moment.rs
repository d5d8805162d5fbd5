//! Time parameters of requests.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use vibrissa_protocol::Timestamp;

use vibrissa_store::list::{Filter, Value};
use vibrissa_store::time::Time;

/// A time: RFC 3339 with any offset and any number of decimals, in the years 0000 to 9999.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Moment(pub Time);

impl Serialize for Moment {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

/// The calendar repeats after 400 years.
const US_OF_400_YEARS: i64 = 146_097 * 86_400_000_000;
const US_PER_MINUTE: i64 = 60_000_000;

fn parse(text: &str) -> Option<i64> {
    let (local, offset_minutes) = match text.strip_suffix(['Z', 'z']) {
        Some(local) => (local, 0),
        None => {
            let (local, offset) = text.split_at_checked(text.len().checked_sub(6)?)?;
            (local, offset_minutes(offset)?)
        }
    };
    let (year, rest) = local.split_at_checked(4)?;
    let year: i64 = year.bytes().all(|byte| byte.is_ascii_digit()).then(|| year.parse().ok())??;
    // `Timestamp` has no years before 1970, so the same day of a later 400-year cycle is parsed.
    let shifted = format!("{:04}{rest}Z", year.rem_euclid(400) + 2000);
    let shifted_us = i64::try_from(shifted.parse::<Timestamp>().ok()?.0).ok()?;
    let eras = (year.rem_euclid(400) + 2000 - year) / 400;
    Some(shifted_us - eras * US_OF_400_YEARS - offset_minutes * US_PER_MINUTE)
}

/// Minutes of an offset `+hh:mm`.
fn offset_minutes(text: &str) -> Option<i64> {
    let sign = match text.get(..1)? {
        "+" => 1,
        "-" => -1,
        _ => return None,
    };
    let (hours, minutes) = text.get(1..)?.split_once(':')?;
    let part =
        |part: &str| (part.len() == 2 && part.bytes().all(|byte| byte.is_ascii_digit())).then(|| part.parse().ok())?;
    let (hours, minutes): (i64, i64) = (part(hours)?, part(minutes)?);
    (hours < 24 && minutes < 60).then_some(sign * (hours * 60 + minutes))
}

impl<'de> Deserialize<'de> for Moment {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let expected = "not a time: expected RFC 3339 such as 2026-11-21T08:00:00Z or 2026-11-21T09:00:00+01:00";
        parse(&text).map(|us| Self(Time(us))).ok_or_else(|| serde::de::Error::custom(expected))
    }
}

/// Limits a column to a time range: `from` inclusive, `to` exclusive.
pub fn between(column: &'static str, from: Option<Moment>, to: Option<Moment>) -> impl Iterator<Item = Filter> {
    let from = from.map(|Moment(from)| Filter::AtLeast(column, Value::Whole(from.0)));
    from.into_iter().chain(to.map(|Moment(to)| Filter::Below(column, Value::Whole(to.0))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_moments_from_gnu_date() {
        // `date -u -d <text> +%s`
        for (text, seconds) in [
            ("2026-11-21T08:00:00Z", 1_795_248_000),
            ("2026-11-21T09:30:00+01:30", 1_795_248_000),
            ("2026-11-21t02:00:00.000-06:00", 1_795_248_000),
            ("1969-12-31T23:59:59Z", -1),
            ("1600-02-29T00:00:00Z", -11_670_998_400),
            ("0001-01-01T00:00:00Z", -62_135_596_800),
            ("9999-12-31T23:59:59Z", 253_402_300_799),
        ] {
            assert_eq!(parse(text), Some(seconds * 1_000_000), "{text}");
        }
        assert_eq!(parse("1969-12-31T23:59:59.5Z"), Some(-500_000));
    }

    #[test]
    fn what_is_no_moment_is_refused() {
        let bad = ["", "Z", "2026-11-21", "2026-11-21T08:00:00", "2026-11-21T08:00:00 01:00", "2026-02-30T08:00:00Z"];
        for text in bad.into_iter().chain(["2026-11-21T08:00:00+24:00", "-001-11-21T08:00:00Z", "2026-11-21T25:00:00Z"])
        {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
