//! `vibrissa-lab evaluate detection`: detection delays beside an oracle's, as a table, as JSON, and as a figure.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde_json::{Value, json};
use vibrissa_evaluation::detection::{Delay, Evaluation, Healthy, Plan, contacts_in_words, evaluate, whiskers};

use crate::figures;
use vibrissa::cli::progress::Progress;
use vibrissa::cli::stop;

/// Share of outliers in the evaluation with outliers.
const OUTLIERS: f64 = 0.02;

/// Arguments of `vibrissa-lab evaluate detection`.
#[derive(Debug, Args)]
pub struct DetectionArgs {
    /// Seed: equal seeds give equal results, on any number of processors.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Cuts of each size at each time.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    cuts: u32,
    /// Healthy whiskers, each observed for 20,000 contacts.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    healthy: u32,
    /// Nominal mean number of contacts between false alarms (ARL0).
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(100..=100_000_000))]
    contacts_between_false_alarms: u32,
    /// Give two contacts in a hundred ten times the noise.
    #[arg(long)]
    outliers: bool,
    /// Print everything as JSON instead of a table.
    #[arg(long)]
    json: bool,
    /// Draw the delays as an SVG file into this folder.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

/// Runs the cuts, prints the table, and draws the figure on request.
///
/// # Errors
/// The output or a file cannot be written.
pub fn run(args: &DetectionArgs, out: &mut dyn Write) -> Result<()> {
    let plan = Plan {
        seed: args.seed,
        cuts: args.cuts,
        healthy_whiskers: args.healthy,
        contacts_between_false_alarms: f64::from(args.contacts_between_false_alarms),
        outliers: if args.outliers { OUTLIERS } else { 0.0 },
        ..Plan::default()
    };
    let progress = Progress::start(whiskers(&plan), "whiskers")?;
    let found = evaluate(&plan, &|| progress.step());
    drop(progress);
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&json(&plan, &found))?)?;
    } else {
        print(&plan, &found, out)?;
    }
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder).with_context(|| format!("creating the folder {}", folder.display()))?;
        let path = stop::whole(|| figures::detection::draw(&found, folder))?;
        if !args.json {
            writeln!(out, "drawn: {}", path.display())?;
        }
    }
    Ok(())
}

fn print(plan: &Plan, found: &Evaluation, out: &mut dyn Write) -> Result<()> {
    writeln!(
        out,
        "\
Contacts from a cut to the alarm: {}{}.
Whiskers differ from the model by up to {:.0} % in each parameter; offset and noise are learned as in the service.

oracle   a CUSUM that knows the size of the cut, the whisker's own curve and its noise, at the same mean number of
         contacts between false alarms; on the same contacts{}
Lorden   log(ARL0) / KL, the bound to first order for ARL0 to infinity
trim     contacts until the trim is reported: confirmed, distinguished from erosion and array shift, length certain
called   share of the cuts that were reported as a trim
interval share of the 95 % intervals of the length that contain the true length
",
        contacts_in_words(),
        if plan.outliers > 0.0 { ", 2 in 100 with ten times that" } else { "" },
        100.0 * plan.calibration_error,
        if plan.outliers > 0.0 { " without the outliers" } else { "" },
    )?;
    writeln!(
        out,
        "{:>8} {:>8} {:>16} {:>8} {:>7} {:>8} {:>8} {:>8} {:>9} {:>10}",
        "cut at", "cut (mm)", "alarm", "oracle", "ratio", "Lorden", "trim", "called", "interval", "off (mm)"
    )?;
    for delay in &found.delays {
        print_row(delay, out)?;
    }
    let Healthy { contacts, alarms, called, mean_square } = found.healthy;
    writeln!(
        out,
        "
mean contacts between false alarms  {:.0}, stated {:.0} ({alarms} alarms in {contacts} contacts of healthy whiskers)
false reports of a change           {called}
mean squared innovation             {mean_square:.4} (normal, cut at 9: 0.995)
seed {}, {} cuts each",
        found.healthy.between_false_alarms(),
        plan.contacts_between_false_alarms,
        plan.seed,
        plan.cuts
    )?;
    Ok(())
}

fn print_row(delay: &Delay, out: &mut dyn Write) -> Result<()> {
    let alarm = format!("{:.1} +- {:.1}", delay.alarm, delay.alarm_error);
    writeln!(
        out,
        "{:>8} {:>8} {alarm:>16} {:>8.1} {:>7.2} {:>8.1} {:>8.1} {:>6.1} % {:>7.1} % {:>10.2}",
        delay.change_at,
        delay.size_mm,
        delay.oracle,
        delay.ratio(),
        delay.lorden,
        delay.called,
        100.0 * delay.called_share,
        100.0 * delay.covered,
        delay.length_error_mm
    )?;
    Ok(())
}

fn json(plan: &Plan, found: &Evaluation) -> Value {
    let delays = found.delays.iter().map(|delay| {
        json!({
            "change_at_contact": delay.change_at,
            "cut_mm": delay.size_mm,
            "cuts": delay.cuts,
            "alarm_contacts": delay.alarm,
            "alarm_contacts_standard_error": delay.alarm_error,
            "oracle_contacts": delay.oracle,
            "ratio_to_oracle": delay.ratio(),
            "lorden_contacts": delay.lorden,
            "trim_contacts": delay.called,
            "called_trim_ratio": delay.called_share,
            "interval_coverage_ratio": delay.covered,
            "length_error_mm": delay.length_error_mm,
        })
    });
    json!({
        "seed": plan.seed,
        "contacts_between_false_alarms_stated": plan.contacts_between_false_alarms,
        "contacts_between_false_alarms_measured": found.healthy.between_false_alarms(),
        "healthy_contacts": found.healthy.contacts,
        "false_alarms": found.healthy.alarms,
        "called_wrongly": found.healthy.called,
        "mean_squared_innovation": found.healthy.mean_square,
        "outlier_ratio": plan.outliers,
        "calibration_error_ratio": plan.calibration_error,
        "delays": delays.collect::<Vec<_>>(),
    })
}
