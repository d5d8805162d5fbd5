//! Progress of long commands on standard error: a bar on a terminal, otherwise a line from time to time.

use std::io::{IsTerminal, Write, stderr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use tokio::time::Instant;

/// Interval of the lines without a terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);
/// Interval at which the bar is drawn, so that its clock runs while a long step lasts.
const DRAWN_EVERY: Duration = Duration::from_millis(200);

/// Progress of a command. Dropping it removes the bar, or ends the lines.
pub struct Progress(Shown);

enum Shown {
    Bar(ProgressBar),
    Lines(Lines),
}

impl Progress {
    /// Starts to show progress over so many steps; `what` names the steps.
    ///
    /// # Errors
    /// The template of the bar is invalid.
    pub fn start(steps: u64, what: &'static str) -> Result<Self> {
        if !stderr().is_terminal() {
            return Ok(Self(Shown::Lines(Lines::start(steps, what, LINE_EVERY, Box::new(stderr())))));
        }
        let style = ProgressStyle::with_template("{elapsed:>4} {bar:40} {pos}/{len} {msg}, {eta} left")?;
        let bar = ProgressBar::new(steps).with_style(style).with_message(what);
        bar.enable_steady_tick(DRAWN_EVERY);
        Ok(Self(Shown::Bar(bar)))
    }

    /// One step is done.
    pub fn step(&self) {
        match &self.0 {
            Shown::Bar(bar) => bar.inc(1),
            Shown::Lines(lines) => {
                lines.done.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Shown::Bar(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

/// Writes lines from a thread of its own until it is dropped.
struct Lines {
    done: Arc<AtomicU64>,
    /// Dropped to end the thread.
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Lines {
    /// Writes the first line at once.
    fn start(steps: u64, what: &'static str, every: Duration, mut out: Box<dyn Write + Send>) -> Self {
        let done = Arc::new(AtomicU64::new(0));
        let (end, ended) = channel::<()>();
        let counted = done.clone();
        let begun = Instant::now();
        let mut write = move || {
            let (steps_done, seconds) = (counted.load(Ordering::Relaxed), begun.elapsed().as_secs());
            let line = format!("vibrissa: {steps_done} of {steps} {what} done after {seconds} s\n");
            // A closed standard error is no reason to stop the work.
            let _ = out.write_all(line.as_bytes());
        };
        write();
        let thread = std::thread::spawn(move || {
            while ended.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
                write();
            }
        });
        Self { done, end: Some(end), thread: Some(thread) }
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        self.end = None;
        if let Some(thread) = self.thread.take() {
            // No line may follow the output of the command; a panic of the thread lost only lines.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::Receiver;

    use super::*;

    struct Told(Sender<String>);

    impl Write for Told {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            let text = String::from_utf8_lossy(bytes).into_owned();
            self.0.send(text).map_err(|_| std::io::Error::from(std::io::ErrorKind::BrokenPipe))?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    fn lines(every: Duration) -> (Lines, Receiver<String>) {
        let (sender, receiver) = channel();
        (Lines::start(40, "cases", every, Box::new(Told(sender))), receiver)
    }

    #[test]
    fn lines_follow_the_steps_and_end_with_the_work() {
        let (lines, receiver) = lines(Duration::from_millis(1));
        assert!(receiver.recv().unwrap().starts_with("vibrissa: 0 of 40 cases done after "));
        lines.done.fetch_add(7, Ordering::Relaxed);
        // Without a second line this would wait for ever.
        while !receiver.recv().unwrap().starts_with("vibrissa: 7 of 40 cases done after ") {}
        drop(lines);
        // The thread has ended, and its end of the channel with it.
        assert_eq!(receiver.iter().find(|line| !line.starts_with("vibrissa: 7 of 40")), None);
    }

    #[test]
    fn the_end_of_the_work_does_not_wait_for_the_next_line() {
        let (lines, receiver) = lines(Duration::from_secs(3600));
        drop(lines);
        assert_eq!(receiver.iter().count(), 1);
    }
}
