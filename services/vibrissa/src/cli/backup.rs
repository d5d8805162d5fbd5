//! `vibrissa backup`: a copy of a SQLite database.

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
    /// The copy to make, on any disk; nothing is overwritten.
    file: PathBuf,
    #[command(flatten)]
    database: DatabaseArgs,
}

/// Copies, checks, and says what came of it; progress goes to standard error.
///
/// # Errors
/// There is no such database, the copy's name is taken, it cannot be written, or the copy is damaged.
pub fn run(args: &BackupArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let address = args.database.read()?.database;
    let DatabaseAddress::Sqlite(from) = &address else {
        bail!(
            "{address} is a PostgreSQL: back it up with its own tools, such as `pg_dump --format=custom` \
             (docs/operations.md has the commands)"
        );
    };
    let told = |written: u64, most: u64| {
        eprintln!("vibrissa: {} of at most {} written", mebibytes(written), mebibytes(most));
    };
    let bytes = runtime()?.block_on(async {
        tokio::select! {
            copied = backup::copy(from, &args.file, told) => Ok(copied?),
            asked = stop::asked() => {
                asked?;
                Err(anyhow::Error::from(Stopped("there is no copy, and nothing of it is left")))
            }
        }
    })?;
    writeln!(out, "{}: {} copied from {address} and checked", args.file.display(), mebibytes(bytes))?;
    Ok(())
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}
