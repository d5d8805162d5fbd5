//! Options of command lines: numbers below zero, numbers with exponents, and words in any case.

use std::ffi::OsString;
use std::fmt::Display;
use std::ops::RangeInclusive;

use clap::Command;

/// Accepts the closed words of all options in any case, and numbers below zero as their values, so that the range check
/// of the option answers them.
#[must_use]
pub fn lenient(command: Command) -> Command {
    let lenient_arg = |arg: clap::Arg| {
        let is_option = arg.get_action().takes_values() && !arg.is_positional();
        if is_option { arg.allow_negative_numbers(true).ignore_case(true) } else { arg }
    };
    command.mut_args(lenient_arg).mut_subcommands(lenient)
}

/// Writes a number below zero without an exponent: the parser would take `-1e-3` for an option.
#[must_use]
pub fn decimal(argument: OsString) -> OsString {
    let number = argument.to_str().filter(|text| text.starts_with('-')).and_then(|text| text.parse::<f64>().ok());
    number.filter(|number| number.is_finite()).map_or(argument, |number| number.to_string().into())
}

/// Takes a whole number in a range, also as `1e5`.
pub fn whole<T>(range: RangeInclusive<T>) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: TryFrom<u64> + PartialOrd + Display + Clone + Send + Sync + 'static,
{
    move |text| {
        let number = text.parse::<u64>().ok().or_else(|| whole_of(text));
        let number = number.and_then(|number| T::try_from(number).ok()).filter(|number| range.contains(number));
        number.ok_or_else(|| format!("must be a whole number from {} to {}", range.start(), range.end()))
    }
}

/// The whole number that a floating-point number is, unless it is too large to be exact.
fn whole_of(text: &str) -> Option<u64> {
    const EXACT_MAX: f64 = 9_007_199_254_740_992.0;
    let number = text.parse::<f64>().ok()?;
    let is_whole = number.fract() == 0.0 && (0.0..=EXACT_MAX).contains(&number);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is whole and within the bounds")]
    is_whole.then_some(number as u64)
}

/// Takes a number in a range.
pub fn number(range: RangeInclusive<f64>) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse::<f64>().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("must be a number from {} to {}", range.start(), range.end()))
    }
}

/// Takes a finite number above zero.
///
/// # Errors
/// The text is no such number.
pub fn above_zero(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "must be a number above 0".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_below_zero_lose_their_exponents_and_options_stay() {
        for (given, taken) in [("-1e-3", "-0.001"), ("-2.5E2", "-250"), ("-0.01", "-0.01"), ("-inf", "-inf")] {
            assert_eq!(decimal(given.into()), taken);
        }
        for option in ["-h", "--url", "1e-3", "-e", "-"] {
            assert_eq!(decimal(option.into()), option);
        }
    }

    #[test]
    fn numbers_outside_their_range_are_refused_with_it() {
        let robots = whole(1..=10_000_usize);
        for (text, number) in [("1", 1), ("1e3", 1000), ("10000", 10_000), ("2.0", 2)] {
            assert_eq!(robots(text), Ok(number), "{text}");
        }
        for text in ["0", "-5", "10001", "1.5", "1e-3", "many", "nan", "1e300", ""] {
            assert_eq!(robots(text), Err("must be a whole number from 1 to 10000".to_owned()), "{text}");
        }
        let every = number(0.1..=10.0);
        assert_eq!(every("1e-1"), Ok(0.1));
        for text in ["-0.01", "1e-3", "nan", "inf", "soon"] {
            assert_eq!(every(text), Err("must be a number from 0.1 to 10".to_owned()), "{text}");
        }
        assert_eq!(above_zero("1e-3"), Ok(1e-3));
        for text in ["0", "-0.01", "-0", "nan", "inf", "fast"] {
            assert_eq!(above_zero(text), Err("must be a number above 0".to_owned()), "{text}");
        }
    }
}
