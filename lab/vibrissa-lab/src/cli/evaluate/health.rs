//! `vibrissa-lab evaluate health`: the confusion matrix, as a table, as JSON, and as a figure.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde_json::{Value, json};
use vibrissa_evaluation::health::{Class, ClassReport, Outcome, Plan, Report, evaluate};

use crate::figures;
use vibrissa::cli::progress::Progress;
use vibrissa::cli::stop;

/// Arguments of `vibrissa-lab evaluate health`.
#[derive(Debug, Args)]
pub struct HealthArgs {
    /// Seed: equal seeds give equal cases, on any number of processors.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of cases per class.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    cases: u32,
    /// Print everything as JSON instead of a table.
    #[arg(long)]
    json: bool,
    /// Draw the matrix as an SVG file into this folder.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

/// Runs the cases, prints the matrix, and draws it on request.
///
/// # Errors
/// The output or a file cannot be written.
pub fn run(args: &HealthArgs, out: &mut dyn Write) -> Result<()> {
    let plan = Plan { seed: args.seed, cases: args.cases, classes: Class::ALL.to_vec() };
    let progress = Progress::start(plan.total(), "cases")?;
    let report = evaluate(&plan, || progress.step());
    drop(progress);
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&json(&report))?)?;
    } else {
        print(&report, out)?;
    }
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder).with_context(|| format!("creating the folder {}", folder.display()))?;
        let path = stop::whole(|| figures::health::draw(&report, folder))?;
        if !args.json {
            writeln!(out, "drawn: {}", path.display())?;
        }
    }
    Ok(())
}

fn print(report: &Report, out: &mut dyn Write) -> Result<()> {
    writeln!(
        out,
        "\
Cases by true class (rows) and first reported class (columns). The robots report no faults themselves.
right       classified correctly, and nothing reported about any other whisker of the array
wrong trims reports of a trim where there was none
contacts    from the onset to the correct report: median, and 95th percentile
"
    )?;
    write!(out, "{:<16}", "")?;
    for column in Report::columns() {
        write!(out, "{:>8}", short(column))?;
    }
    writeln!(out, "{:>9} {:>12} {:>13}", "right", "wrong trims", "contacts")?;
    for class in &report.classes {
        print_row(class, out)?;
    }
    let (right, trims) = (100.0 * report.right(), report.wrong_trims());
    writeln!(out, "\n{right:.2} % right, {trims} wrong trims, {} cases, seed {}", report.outcomes.len(), report.seed)?;
    Ok(())
}

fn print_row(class: &ClassReport, out: &mut dyn Write) -> Result<()> {
    write!(out, "{:<16}", class.truth.word())?;
    for &count in &class.called {
        if count == 0 { write!(out, "{:>8}", "-")? } else { write!(out, "{count:>8}")? }
    }
    let delay = class.delay_contacts.map_or("-".to_owned(), |(median, most)| format!("{median:.0}, {most:.0}"));
    let right = 100.0 * f64::from(class.right) / f64::from(class.cases.max(1));
    writeln!(out, "{right:>7.1} % {:>12} {delay:>13}", class.wrong_trims)?;
    Ok(())
}

/// A column's name in eight characters.
fn short(word: &str) -> &str {
    match word {
        "ARRAY_SHIFT" => "ARRAY",
        "BASELINE_DRIFT" => "DRIFT",
        "GAUGE_OPEN" => "OPEN",
        "GAUGE_SHORT" => "SHORT",
        "GAUGE_SATURATED" => "SATUR.",
        "EROSION" => "EROS.",
        whole => whole,
    }
}

fn json(report: &Report) -> Value {
    json!({
        "seed": report.seed,
        "right": report.right(),
        "wrong_trims": report.wrong_trims(),
        "columns": Report::columns(),
        "classes": report.classes.iter().map(class_json).collect::<Vec<_>>(),
        "wrong": report.outcomes.iter().filter(|one| !one.is_right()).map(outcome_json).collect::<Vec<_>>(),
    })
}

fn class_json(class: &ClassReport) -> Value {
    json!({
        "class": class.truth.word(),
        "cases": class.cases,
        "called": class.called,
        "right": class.right,
        "with_bystanders": class.with_bystanders,
        "wrong_trims": class.wrong_trims,
        "delay_contacts_median": class.delay_contacts.map(|(median, _)| median),
        "delay_contacts_p95": class.delay_contacts.map(|(_, most)| most),
    })
}

fn outcome_json(outcome: &Outcome) -> Value {
    json!({
        "class": outcome.truth.word(),
        "called": outcome.called.word(),
        "bystander": outcome.bystander.map(|called| called.word()),
        "delay_contacts": outcome.delay_contacts,
    })
}
