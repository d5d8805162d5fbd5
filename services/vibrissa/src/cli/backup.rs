//! `vibrissa backup`: copies a SQLite database while it is in use.

use std::io::Write;
use std::path::PathBuf;

use anyhow::bail;
use clap::Args;

use super::config::DatabaseArgs;
use super::serve::runtime;
use super::stop::{self, Stopped};
use vibrissa_store::{DatabaseAddress, backup};

/// Arguments of `vibrissa backup`.
#[derive(Debug, Args)]
pub struct BackupArgs {
    /// File of the copy, on any disk; an existing file is never overwritten.
    file: PathBuf,
    #[command(flatten)]
    database: DatabaseArgs,
}

/// Copies the database, checks the copy, and prints its size. Progress goes to standard error.
///
/// # Errors
/// The database does not exist, a file with the copy's name exists, or the copy cannot be written or is damaged.
pub fn run(args: &BackupArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let address = args.database.read()?.database;
    let DatabaseAddress::Sqlite(from) = &address else {
        bail!(
            "{address} is a PostgreSQL database: back it up with its own tools, such as `pg_dump --format=custom` \
             (see docs/operations.md for the commands)"
        );
    };
    let show_progress = |written: u64, most: u64| {
        eprintln!("vibrissa: {} of at most {} written", mebibytes(written), mebibytes(most));
    };
    let bytes = runtime()?.block_on(async {
        tokio::select! {
            copied = backup::copy(from, &args.file, show_progress) => Ok(copied?),
            asked = stop::asked() => {
                asked?;
                Err(anyhow::Error::from(Stopped("no back-up was made, and no file is left behind")))
            }
        }
    })?;
    writeln!(out, "{}: {} copied from {address} and checked", args.file.display(), mebibytes(bytes))?;
    Ok(())
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}
