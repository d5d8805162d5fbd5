//! Ctrl-C and SIGTERM in long commands: they end within a second with a message, and leave no half-written file.

use std::io::{IsTerminal, stderr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::Context;
use vibrissa_host::task;
use vibrissa_program::signals::StopSignals;

/// Exit code of a stopped command: that of shells for Ctrl-C.
pub const EXIT_CODE: u8 = 130;
/// Time for a command to end in good order before the process exits.
const GRACE: Duration = Duration::from_millis(300);

// Static, because signals concern the whole process.
static ASKED: AtomicBool = AtomicBool::new(false);
static WRITING: Mutex<()> = Mutex::new(());

/// The command was stopped by a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("stopped: {0}")]
pub struct Stopped(pub &'static str);

/// Installs the handlers: from now on Ctrl-C and SIGTERM end the program in good order. `left` describes the state of
/// its work for the message.
///
/// # Errors
/// The signal handlers cannot be installed.
pub fn watch(left: &'static str) -> anyhow::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().context("waiting for Ctrl-C")?;
    let mut signals = {
        let _entered = runtime.enter();
        StopSignals::install().context("waiting for Ctrl-C")?
    };
    std::thread::spawn(move || {
        runtime.block_on(signals.received());
        ASKED.store(true, Ordering::Relaxed);
        task::block_for(GRACE);
        let _written = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
        // A progress bar does not end its line.
        let line = if stderr().is_terminal() { "\n" } else { "" };
        eprintln!("{line}vibrissa: {}", Stopped(left));
        std::process::exit(i32::from(EXIT_CODE));
    });
    Ok(())
}

/// Returns at Ctrl-C or SIGTERM, for commands that also wait for something else.
///
/// # Errors
/// The signal handlers cannot be installed.
pub async fn asked() -> anyhow::Result<()> {
    StopSignals::install().context("waiting for Ctrl-C")?.received().await;
    Ok(())
}

/// Whether a command under [`watch`] must end. It has [`GRACE`] to do so.
#[must_use]
pub fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Writes files that must not be left half-written: the process does not exit meanwhile.
pub fn whole<T>(write: impl FnOnce() -> T) -> T {
    let _writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    write()
}
