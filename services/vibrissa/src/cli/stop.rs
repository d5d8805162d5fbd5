//! Ctrl-C and SIGTERM in commands that take long: they end within a second, say so, and leave nothing half-written.

use std::io::{IsTerminal, stderr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::Context;
use tokio::signal::unix::{Signal, SignalKind, signal};

/// The exit code of a command that was stopped: what shells have for Ctrl-C.
pub const EXIT_CODE: u8 = 130;
/// How long a command has to end in good order; then it is ended.
const GRACE: Duration = Duration::from_millis(300);

// Signals are the process's, and so is what is known of them.
static ASKED: AtomicBool = AtomicBool::new(false);
static WRITING: Mutex<()> = Mutex::new(());

/// Somebody has stopped the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("stopped: {0}")]
pub struct Stopped(pub &'static str);

/// From here on Ctrl-C and SIGTERM end the program in good order. `left` says what there is of its work then.
///
/// # Errors
/// Signals cannot be waited for.
pub fn watch(left: &'static str) -> anyhow::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().context("waiting for Ctrl-C")?;
    let (interrupt, terminate) = {
        let _entered = runtime.enter();
        both().context("waiting for Ctrl-C")?
    };
    std::thread::spawn(move || {
        runtime.block_on(either(interrupt, terminate));
        ASKED.store(true, Ordering::Relaxed);
        std::thread::sleep(GRACE);
        let _written = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
        // After a progress bar, which has no end of its line.
        let line = if stderr().is_terminal() { "\n" } else { "" };
        eprintln!("{line}vibrissa: {}", Stopped(left));
        std::process::exit(i32::from(EXIT_CODE));
    });
    Ok(())
}

/// Returns at Ctrl-C or SIGTERM: for commands that wait for something else besides.
///
/// # Errors
/// Signals cannot be waited for.
pub async fn asked() -> anyhow::Result<()> {
    let (interrupt, terminate) = both().context("waiting for Ctrl-C")?;
    either(interrupt, terminate).await;
    Ok(())
}

/// Whether a command that is [`watch`]ed has to end. It has [`GRACE`] to do so.
#[must_use]
pub fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Writes files that nobody shall find half-written: the program is not ended meanwhile.
pub fn whole<T>(write: impl FnOnce() -> T) -> T {
    let _writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    write()
}

fn both() -> std::io::Result<(Signal, Signal)> {
    Ok((signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?))
}

async fn either(mut interrupt: Signal, mut terminate: Signal) {
    tokio::select! {
        _ = interrupt.recv() => {}
        _ = terminate.recv() => {}
    }
}
