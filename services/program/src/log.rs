//! The log of a program on standard error. Each place in the code that logs has a rate: a fault that repeats without end does
//! not fill the disk. The line after a gap says how many were left out.

use std::collections::HashMap;
use std::fmt;
use std::io::{self, IsTerminal, Write, stderr};
use std::sync::{Mutex, PoisonError};

use tokio::time::Instant;
use tracing::callsite::Identifier;
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::util::{SubscriberInitExt, TryInitError};

/// Lines that a place may log at once.
const BURST: f64 = 200.0;
/// Lines a second that a place may log in the long run.
const PER_S: f64 = 5.0;

/// Logs to standard error, in colours on a terminal, but not with `NO_COLOR`.
///
/// # Errors
/// The process has a log already.
pub fn start(filter: EnvFilter) -> Result<(), TryInitError> {
    let has_colours = stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|asked| asked.is_empty());
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_ansi(has_colours);
    let log = log.with_writer(|| WithoutNumbers(stderr()));
    log.map_event_format(Limited::new).finish().try_init()
}

/// Writes lines without the numbers of the operating system, such as ` (os error 2)`: the words before it say the same.
struct WithoutNumbers<W>(W);

impl<W: Write> Write for WithoutNumbers<W> {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        const BEFORE: &str = " (os error ";
        let text = String::from_utf8_lossy(line);
        let mut parts = text.split(BEFORE);
        let mut plain = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let rest = part.split_once(')').filter(|(number, _)| number.bytes().all(|one| one.is_ascii_digit()));
            match rest {
                Some((_, rest)) => plain.push_str(rest),
                None => plain.extend([BEFORE, part]),
            }
        }
        self.0.write_all(plain.as_bytes())?;
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// What a place in the code may still log.
#[derive(Debug)]
struct CallSite {
    allowed: f64,
    at: Instant,
    left_out: u64,
}

impl CallSite {
    /// Counts a line. `None` if there are too many; else how many were left out before it.
    fn line(&mut self, now: Instant) -> Option<u64> {
        let elapsed_s = now.saturating_duration_since(self.at).as_secs_f64();
        self.allowed = (self.allowed + PER_S * elapsed_s).min(BURST);
        self.at = now;
        if self.allowed < 1.0 {
            self.left_out += 1;
            return None;
        }
        self.allowed -= 1.0;
        Some(std::mem::take(&mut self.left_out))
    }
}

/// A format that leaves out lines beyond the rate of their place. Debugging is not limited: somebody asked for it.
#[derive(Debug)]
struct Limited<F> {
    format: F,
    /// As many as there are places in the code.
    places: Mutex<HashMap<Identifier, CallSite>>,
}

impl<F> Limited<F> {
    fn new(format: F) -> Self {
        Self { format, places: Mutex::default() }
    }

    fn line(&self, event: &Event<'_>) -> Option<u64> {
        if *event.metadata().level() > Level::INFO {
            return Some(0);
        }
        let now = Instant::now();
        let mut places = self.places.lock().unwrap_or_else(PoisonError::into_inner);
        let place = places.entry(event.metadata().callsite());
        place.or_insert(CallSite { allowed: BURST, at: now, left_out: 0 }).line(now)
    }
}

impl<S, N, F> FormatEvent<S, N> for Limited<F>
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
    F: FormatEvent<S, N>,
{
    fn format_event(&self, context: &FmtContext<'_, S, N>, mut writer: Writer<'_>, event: &Event<'_>) -> fmt::Result {
        let Some(left_out) = self.line(event) else { return Ok(()) };
        if left_out > 0 {
            writeln!(writer, "{left_out} lines like the next one were left out: there were too many")?;
        }
        self.format.format_event(context, writer, event)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use super::*;

    #[test]
    fn regress_a_fault_that_repeats_without_end_logs_little() {
        let begun = Instant::now();
        let mut place = CallSite { allowed: BURST, at: begun, left_out: 0 };
        // A minute of 70,000 lines a second.
        let logged: Vec<u64> = (0..4_200_000_u32)
            .filter_map(|number| place.line(begun + Duration::from_micros(u64::from(number) * 14)))
            .collect();
        assert!((490..=500).contains(&logged.len()), "{}", logged.len());
        let left_out: u64 = logged.iter().sum::<u64>() + place.left_out;
        assert_eq!(left_out + logged.len() as u64, 4_200_000, "each line is counted");
        let later = begun + Duration::from_secs(120);
        assert!(place.line(later).is_some_and(|left_out| left_out > 0), "after the fault the next line tells");
        assert_eq!(place.line(later), Some(0));
    }

    #[derive(Debug, Clone, Default)]
    struct Written(Arc<Mutex<Vec<u8>>>);

    impl Write for Written {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn regress_one_place_does_not_silence_another() {
        let written = Written::default();
        let writer = written.clone();
        let log = tracing_subscriber::fmt().with_max_level(Level::DEBUG).with_writer(move || writer.clone());
        let log = log.with_ansi(false).map_event_format(Limited::new).finish();
        tracing::subscriber::with_default(log, || {
            for number in 0..1000 {
                tracing::error!(number, "the same fault");
                tracing::debug!("asked for");
            }
            tracing::error!("another fault");
        });
        let text = String::from_utf8(written.0.lock().unwrap().clone()).unwrap();
        let count = |what: &str| text.lines().filter(|line| line.contains(what)).count();
        assert!((200..300).contains(&count("the same fault")), "{}", count("the same fault"));
        assert_eq!((count("another fault"), count("asked for")), (1, 1000));
    }
    #[test]
    fn regress_no_line_has_a_number_of_the_operating_system() {
        let written = Written::default();
        let writer = written.clone();
        let log = tracing_subscriber::fmt().with_writer(move || WithoutNumbers(writer.clone()));
        let log = log.with_ansi(false).map_event_format(Limited::new).finish();
        tracing::subscriber::with_default(log, || {
            for number in [13, 111] {
                let problem = io::Error::from_raw_os_error(number);
                tracing::warn!(%problem, "a: {problem}; again");
            }
            tracing::warn!("b (os error x)");
        });
        let text = String::from_utf8(written.0.lock().unwrap().clone()).unwrap();
        let ends: Vec<&str> = text.lines().filter_map(|line| line.split_once("tests: ").map(|(_, end)| end)).collect();
        assert_eq!(ends[0], "a: Permission denied; again problem=Permission denied");
        assert_eq!(ends[1], "a: Connection refused; again problem=Connection refused");
        assert_eq!(ends[2..], ["b (os error x)"]);
    }
}
