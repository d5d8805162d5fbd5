//! `vibrissa export`: tables of the database as CSV or Parquet files, and recordings as MCAP files.

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{ArgGroup, Args};
use vibrissa_edge::fleets::FleetPattern;
use vibrissa_store::Store;
use vibrissa_store::export::{EXPORTS, ExportTable, Which};

use super::config::DatabaseArgs;
use super::contract::schema_of;
use super::progress::Progress;
use super::serve::runtime;
use super::stop::{self, Stopped};
use super::words::one_of;
use crate::export::RowFile;
use crate::export::csv_file::CsvFile;
use crate::export::mcap_file;
use crate::export::parquet_file::ParquetFile;

/// Arguments of `vibrissa export`.
#[derive(Debug, Args)]
#[command(
    group = ArgGroup::new("target").required(true),
    after_long_help = "\
Reads the database directly, also while supervisors use it. Times are in UTC, and units are in the names of the columns;
docs/commands.md explains them. The file appears under its name only when it is complete; an existing file is never
overwritten. Memory does not grow with the number of rows, which come in the order of storage.

  vibrissa export contacts --fleet lab --from 2026-11-01 --parquet contacts.parquet
  vibrissa export errors --csv errors.csv
  vibrissa export --mcap lab.jsonl lab.mcap"
)]
pub struct ExportArgs {
    /// Table to export.
    #[arg(value_parser = one_of(EXPORTS.to_vec(), |table| table.name), required_unless_present = "mcap",
          conflicts_with = "mcap")]
    table: Option<&'static ExportTable>,
    /// Write the rows to this CSV file (RFC 4180).
    #[arg(long, value_name = "FILE", group = "target")]
    csv: Option<PathBuf>,
    /// Write the rows to this Parquet file.
    #[arg(long, value_name = "FILE", group = "target")]
    parquet: Option<PathBuf>,
    /// Convert a recording of `vibrissa record` to an MCAP file, for example for Foxglove.
    #[arg(long, num_args = 2, value_names = ["RECORDING", "FILE"], group = "target")]
    mcap: Option<Vec<PathBuf>>,
    /// Fleet of the rows, or a pattern such as 'hall-*'; may be given several times. Default: all fleets.
    #[arg(long, value_name = "FLEET", conflicts_with = "mcap")]
    fleet: Vec<FleetPattern>,
    /// Earliest time, inclusive: RFC 3339 such as 2026-11-21T08:00:00Z, or a day (UTC).
    #[arg(long, value_name = "TIME", value_parser = time, conflicts_with = "mcap")]
    from: Option<i64>,
    /// Latest time, exclusive, in the same form.
    #[arg(long, value_name = "TIME", value_parser = time, conflicts_with = "mcap")]
    to: Option<i64>,
    #[command(flatten)]
    database: DatabaseArgs,
}

/// State of the work after a stop.
const LEFT: &str = "nothing was exported, and no file is left behind";

/// A time or a day, in µs since 1970 UTC.
fn time(text: &str) -> Result<i64, String> {
    let is_day = text.len() == "2026-11-21".len();
    let whole = if is_day { format!("{text}T00:00:00Z") } else { text.to_owned() };
    let expected = "must be RFC 3339 in UTC such as 2026-11-21T08:00:00Z, or a day such as 2026-11-21";
    let at = humantime::parse_rfc3339(&whole).map_err(|_| expected.to_owned())?;
    let since = at.duration_since(std::time::UNIX_EPOCH).map_err(|_| expected.to_owned())?;
    i64::try_from(since.as_micros()).map_err(|_| expected.to_owned())
}

/// Exports, and prints the number of rows or messages. Progress goes to standard error.
///
/// # Errors
/// The database or the recording cannot be read, or the file exists or cannot be written.
pub fn run(args: &ExportArgs, out: &mut impl Write) -> anyhow::Result<()> {
    if let Some([recording, file]) = args.mcap.as_deref() {
        return mcap(recording, file, out);
    }
    let table = args.table.context("name a table")?;
    let (file, path): (Box<dyn RowFile>, _) = match (&args.csv, &args.parquet) {
        (Some(path), _) => (Box::new(CsvFile::create(path, table)?), path),
        (_, Some(path)) => (Box::new(ParquetFile::create(path, table)?), path),
        (None, None) => anyhow::bail!("name the file: --csv FILE or --parquet FILE"),
    };
    let which = Which { fleets: args.fleet.clone(), from_us: args.from, to_us: args.to };
    let database = args.database.read_database()?;
    let rows = runtime()?.block_on(async {
        tokio::select! {
            rows = async {
                let store = Store::open_for_command(&database).await?;
                let rows = export(&store, table, &which, file).await;
                store.close().await;
                rows
            } => rows,
            asked = stop::asked() => {
                asked?;
                Err(anyhow::Error::from(Stopped(LEFT)))
            }
        }
    })?;
    writeln!(out, "{}: {rows} rows of {} exported from {database}", path.display(), table.name)?;
    Ok(())
}

async fn export(
    store: &Store,
    table: &'static ExportTable,
    which: &Which,
    mut file: Box<dyn RowFile>,
) -> anyhow::Result<u64> {
    // Rows that are written meanwhile may be missing or not.
    let progress = Progress::start(store.count_export(table, which).await?, "rows")?;
    let mut rows = 0;
    store
        .export(table, which, |cells| {
            rows += 1;
            progress.step();
            file.row(cells)
        })
        .await?;
    file.finish()?;
    Ok(rows)
}

fn mcap(recording: &Path, file: &Path, out: &mut impl Write) -> anyhow::Result<()> {
    const MEBIBYTE: u64 = 1 << 20;
    let opened = File::open(recording).with_context(|| format!("cannot read {}", recording.display()))?;
    let progress = Progress::start(opened.metadata()?.len().div_ceil(MEBIBYTE), "MiB")?;
    let mut shown = 0;
    stop::watch(LEFT)?;
    let report = mcap_file::write(BufReader::new(opened), file, schema_of, |read| {
        if stop::is_asked() {
            return Err(Stopped(LEFT).into());
        }
        while shown < read / MEBIBYTE {
            shown += 1;
            progress.step();
        }
        Ok(())
    })?;
    drop(progress);
    writeln!(out, "{}: {} messages converted", file.display(), report.messages)?;
    if report.left_out > 0 {
        eprintln!("vibrissa: {} lines without a JSON object were left out", report.left_out);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_rfc_3339_or_days() {
        // `date -u -d <text> +%s`
        assert_eq!(time("2026-11-21T08:00:00Z"), Ok(1_795_248_000_000_000));
        assert_eq!(time("2026-11-21"), Ok(1_795_219_200_000_000));
        for bad in ["", "yesterday", "2026-13-01", "2026-11-21 08:00", "1960-01-01"] {
            assert!(time(bad).unwrap_err().contains("RFC 3339"), "{bad}");
        }
    }
}
