//! `vibrissa-lab evaluate compensation`: the paper's Fig. 9 and 10 on simulated plants, as a table and as figures.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde_json::{Value, json};
use vibrissa_core::mechanics::CONTACT_RATIOS;
use vibrissa_edge::words::Word;
use vibrissa_evaluation::compensation::reading::{self, Reading, ReadingSummary, SHORT_MM, Setting};
use vibrissa_evaluation::compensation::weakened::{self, Loss, Readout, STIFFENED_TO, WORN_TO_MM};
use vibrissa_evaluation::compensation::{
    CASES, CONTACTS_AFTER, Case, Outcome, PLANT_ERROR, START_MPA, Served, Summary, WHOLE_CONTACTS, evaluate, summary,
    trials,
};

use crate::figures;
use vibrissa::cli::progress::Progress;
use vibrissa::cli::stop;

/// Arguments of `vibrissa-lab evaluate compensation`.
#[derive(Debug, Args)]
pub struct CompensationArgs {
    /// Seed: equal seeds give equal numbers, on any number of processors.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of plants; each gets 15 compensations.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    plants: u16,
    /// Draw figures like the paper's Fig. 9 and 10 as SVG files into this folder.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
    /// Print everything as JSON instead of a table.
    #[arg(long)]
    json: bool,
}

/// Mean error that the paper measured on real whiskers, as a ratio.
fn paper(case: Case) -> Option<f64> {
    match case {
        Case::Shorter => Some(0.203_85),
        Case::Itself => None,
        Case::Longer => Some(0.361_8),
    }
}

fn name(case: Case) -> &'static str {
    match case {
        Case::Shorter => "case 1: 65-69 mm for 70 mm",
        Case::Itself => "self: 70 mm trimmed to 65-69",
        Case::Longer => "case 2: 66-70 mm for 65 mm",
    }
}

/// Runs the trials, prints the summary, and draws the figures on request.
///
/// # Errors
/// The output or a file cannot be written.
pub fn run(args: &CompensationArgs, out: &mut dyn Write) -> Result<()> {
    let trials = trials(args.seed, usize::from(args.plants));
    let read = reading::trials(args.seed, usize::from(args.plants));
    let weakened_count = 2 * u64::from(args.plants);
    let progress = Progress::start((trials.len() + read.len()) as u64 + weakened_count, "compensations")?;
    let outcomes = evaluate(&trials, &|| progress.step());
    let readings = reading::evaluate(&read, &|| progress.step());
    let readouts = weakened::evaluate(args.seed, usize::from(args.plants), &|| progress.step());
    drop(progress);
    let summaries: Vec<Summary> = CASES.into_iter().filter_map(|case| summary(case, &outcomes)).collect();
    if args.json {
        let trials: Vec<Value> = outcomes.iter().map(trial_json).collect();
        let whole = json!({ "seed": args.seed, "plants": args.plants,
            "cases": summaries.iter().map(summary_json).collect::<Vec<_>>(), "trials": trials,
            "with_reading_gain": rows(&readings).iter().map(|(name, one)| reading_json(name, one)).collect::<Vec<_>>(),
            "losses": losses(&readouts).iter().map(|(name, one)| readout_json(name, one)).collect::<Vec<_>>() });
        writeln!(out, "{}", serde_json::to_string_pretty(&whole)?)?;
    } else {
        print(args, &summaries, out)?;
        print_readings(&rows(&readings), out)?;
        print_losses(&losses(&readouts), out)?;
    }
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder).with_context(|| format!("creating the folder {}", folder.display()))?;
        for path in stop::whole(|| figures::evaluation::draw(folder, &outcomes))? {
            // Standard output is for the table or the JSON.
            eprintln!("drawn: {}", path.display());
        }
    }
    Ok(())
}

/// Rows of the table of readings: the cases, their nearest length, and short whiskers.
fn rows(readings: &[Option<Reading>]) -> Vec<(String, ReadingSummary)> {
    let mut rows = Vec::new();
    for case in CASES {
        rows.push((name(case).to_owned(), reading::summary(reading::of(case, readings))));
    }
    let nearest = reading::of(Case::Shorter, readings).filter(|one| one.trial.length_mm == 65.0);
    rows.push(("  65 mm for 70 mm alone".to_owned(), reading::summary(nearest)));
    for length_mm in SHORT_MM {
        let short = reading::summary(reading::of_length(length_mm, readings));
        rows.push((format!("self: 70 mm trimmed to {length_mm}"), short));
    }
    for setting in Setting::OTHERS {
        let name = match setting {
            Setting::Usual => "self",
            Setting::NoAir => "self, no air: gain alone",
            Setting::Distance => "self, DISTANCE with tests",
            Setting::Tip => "self, TIP",
            Setting::Unknown => "self, UNKNOWN with tests",
        };
        rows.push((name.to_owned(), reading::summary(reading::of_setting(setting, readings))));
    }
    rows.into_iter().filter_map(|(name, summary)| Some((name, summary?))).collect()
}

fn print_readings(rows: &[(String, ReadingSummary)], out: &mut dyn Write) -> Result<()> {
    writeln!(
        out,
        "
Robots that multiply their readings (applies_gain): air for the shape, one gain for the level. Errors of the reading
with the setpoint of the decision, after contacts at the setpoint (\"noise\": that the noise of so many contacts leaves on a
plant that is known but for its level), and at the end; \"least\": that any gain has at the held pressure; \"moved\": air
moved; \"predicted\", \"measured\": the 95 % intervals that hold the truth. Without a place (UNKNOWN) only the contacts of
touch tests count. The noise of 800 contacts is 0.1 % of a reading, 3 % of the difference that a cut of 1 mm makes.

{:<30} {:>6} {:>7} {:>6} {:>7} {:>6} {:>6} {:>6} {:>10} {:>10} {:>9} {:>7}",
        "mean error (%)", "open", "300", "noise", "800", "noise", "end", "least", "moved kPa", "predicted", "measured", "served"
    )?;
    for (name, one) in rows {
        writeln!(
            out,
            "{name:<30} {:>6.2} {:>7.2} {:>6.2} {:>7.2} {:>6.2} {:>6.2} {:>6.2} {:>10.1} {:>10} {:>9} {:>7}",
            100.0 * one.open,
            100.0 * one.looks[0],
            100.0 * one.noise_limits[0],
            100.0 * one.looks[1],
            100.0 * one.noise_limits[1],
            100.0 * one.end,
            100.0 * one.best_gain,
            1000.0 * one.moved_mpa,
            format!("{:.1} %", 100.0 * one.predicted_coverage),
            one.measured_coverage.map_or_else(|| "-".to_owned(), |share| format!("{:.1} %", 100.0 * share)),
            one.served
        )?;
    }
    Ok(())
}

/// Mean of each loss over its plants.
fn losses(readouts: &[(Loss, Readout)]) -> Vec<(String, Readout)> {
    let named =
        [(Loss::Stiffened, format!("stiffened to {STIFFENED_TO}")), (Loss::Worn, format!("worn to {WORN_TO_MM} mm"))];
    let mean = |of: Loss| {
        let all: Vec<&Readout> = readouts.iter().filter(|(loss, _)| *loss == of).map(|(_, one)| one).collect();
        let mean = |of: &dyn Fn(&Readout) -> f64| all.iter().map(|one| of(one)).sum::<f64>() / all.len().max(1) as f64;
        Readout {
            unserved: mean(&|one| one.unserved),
            early: mean(&|one| one.early),
            end: mean(&|one| one.end),
            setpoints: all.iter().map(|one| one.setpoints).max().unwrap_or_default(),
        }
    };
    named.into_iter().map(|(loss, name)| (name, mean(loss))).collect()
}

fn print_losses(rows: &[(String, Readout)], out: &mut dyn Write) -> Result<()> {
    writeln!(
        out,
        "
Whiskers of 70 mm that lose sensitivity in place, or wear off: relative error of the reading, mean over the contact ratios.

{:<30} {:>9} {:>14} {:>8} {:>20}",
        "mean error of reading (%)", "unserved", "800 contacts", "end", "setpoints, at most"
    )?;
    for (name, one) in rows {
        writeln!(
            out,
            "{name:<30} {:>9.2} {:>14.2} {:>8.2} {:>20}",
            100.0 * one.unserved,
            100.0 * one.early,
            100.0 * one.end,
            one.setpoints
        )?;
    }
    Ok(())
}

fn readout_json(name: &str, one: &Readout) -> Value {
    json!({
        "name": name, "unserved_error": one.unserved, "error_after_800_contacts": one.early, "error_at_end": one.end,
        "setpoints_max": one.setpoints,
    })
}

fn reading_json(name: &str, one: &ReadingSummary) -> Value {
    json!({
        "name": name.trim(), "served": one.served, "open_error": one.open, "error_after_300_contacts": one.looks[0],
        "error_after_800_contacts": one.looks[1], "error_at_end": one.end, "least_error_of_any_gain": one.best_gain,
        "noise_limit_after_300_contacts": one.noise_limits[0], "noise_limit_after_800_contacts": one.noise_limits[1],
        "moved_mpa": one.moved_mpa, "predicted_interval_coverage": one.predicted_coverage,
        "measured_interval_coverage": one.measured_coverage,
    })
}

fn print(args: &CompensationArgs, summaries: &[Summary], out: &mut dyn Write) -> Result<()> {
    let per_cent = 100.0 * PLANT_ERROR;
    writeln!(
        out,
        "\
Compensations on {} simulated plants (seed {}): k2's c, a and b and the elongation each off by up to
{per_cent} %, every second plant of the other formulation. Each whisker has {WHOLE_CONTACTS} contacts while whole and
{CONTACTS_AFTER} from the cut on, with noise and a dithering regulator; the supervisor's core has no other
input. All start at {START_MPA} MPa. Errors are the true ones, without noise: eq. 35, mean over the contact ratios
0.45 to 1 and over compensators and plants. (Strain is linear in the deflection: 0 to 6 mm cancel.)
",
        args.plants, args.seed
    )?;
    writeln!(
        out,
        "{:<30} {:>7} {:>6} {:>6} {:>7} {:>10} {:>7} {:>11}",
        "mean error (%)", "paper", "Tip", "Mean", "closed", "with gain", "best", "closed/best"
    )?;
    for one in summaries {
        let paper = paper(one.case).map_or("-".to_owned(), |error| format!("{:.2}", 100.0 * error));
        writeln!(
            out,
            "{:<30} {paper:>7} {:>6.2} {:>6.2} {:>7.2} {:>10.2} {:>7.2} {:>11.3}",
            name(one.case),
            100.0 * one.tip,
            100.0 * one.mean,
            100.0 * one.closed,
            100.0 * one.with_gain,
            100.0 * one.best,
            one.closed / one.best
        )?;
    }
    writeln!(
        out,
        "\n{:<30} {:>9} {:>16} {:>12} {:>9} {:>14} {:>16}",
        "", "predicted", "95 % interval", "width of it", "setpoints", "contacts", "served"
    )?;
    writeln!(
        out,
        "{:<30} {:>9} {:>16} {:>12} {:>9} {:>14} {:>16}",
        "", "(%)", "holds the true", "(% points)", "mean/most", "to last gain", "(not)"
    )?;
    for one in summaries {
        writeln!(
            out,
            "{:<30} {:>9.2} {:>16} {:>12.1} {:>9} {:>14} {:>16}",
            name(one.case),
            100.0 * one.predicted,
            format!("in {:.1} %", 100.0 * one.coverage),
            100.0 * one.width,
            format!("{:.1}/{}", one.setpoints.0, one.setpoints.1),
            one.gain_contacts,
            format!("{} ({})", one.served, one.unserved)
        )?;
    }
    writeln!(
        out,
        "
paper      measured on real whiskers, at eq. 34's pressure; its whiskers are not among these plants
Tip, Mean  open loop: eq. 34 at the tip (what the supervisor does first), and the model's least mean error
closed     after refinement from measured contacts; with gain: the published gain on the compensator's strain
best       the best single pressure on the plant, by brute force: no pressure does better
served     the others were not detected as trimmed, or eq. 34 had no root at the allowed pressures"
    )?;
    Ok(())
}

fn summary_json(one: &Summary) -> Value {
    json!({
        "case": name(one.case), "served": one.served, "not_served": one.unserved, "paper": paper(one.case),
        "tip": one.tip, "mean": one.mean, "closed": one.closed, "with_gain": one.with_gain, "best": one.best,
        "predicted": one.predicted, "interval_coverage": one.coverage, "interval_width": one.width,
        "setpoints_mean": one.setpoints.0, "setpoints_max": one.setpoints.1, "contacts_to_last_gain": one.gain_contacts,
    })
}

fn trial_json(outcome: &Outcome) -> Value {
    let trial = outcome.trial();
    let mut whole = json!({
        "case": name(trial.case), "compensator_mm": trial.length_mm, "target_mm": trial.case.target_mm(),
        "plant": trial.plant, "c": trial.rubber.c, "a": trial.rubber.a, "b": trial.rubber.b,
        "elongation": trial.rubber.elongation, "formulation": format!("{:?}", trial.rubber.formulation),
    });
    if let (Outcome::Served(served), Some(fields)) = (outcome, whole.as_object_mut()) {
        fields.insert("served".to_owned(), served_json(served));
    }
    whole
}

fn served_json(one: &Served) -> Value {
    let reached = |(mpa, error): &(f64, vibrissa_core::mechanics::ErrorProfile)| json!({ "pressure_mpa": mpa, "error": error.mean, "error_by_ratio": error.by_ratio });
    let looks = one.looks.iter().map(|look| {
        json!({ "contacts": look.contacts, "outcome": look.outcome.word(),
            "pressure_from_mpa": look.pressure_from.mpa(), "pressure_best_mpa": look.pressure_best.map(|best| best.mpa()),
            "error": look.error, "error_sd": look.error_sd, "gain_published": look.gain_published })
    });
    json!({
        "predicted_error": one.chosen.predicted_error, "predicted_error_interval": one.chosen.predicted_error_interval,
        "tip": reached(&one.tip), "mean": reached(&one.mean), "closed": reached(&one.closed), "best": reached(&one.best),
        "with_gain": { "error": one.with_gain.mean, "error_by_ratio": one.with_gain.by_ratio, "gain": one.gain },
        "contact_ratios": CONTACT_RATIOS, "setpoints": one.setpoints, "looks": looks.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A single plant, so that the test takes a second.
    #[test]
    fn table_json_and_figures_tell_the_same_whatever_the_number_of_threads() {
        let folder = std::env::temp_dir().join(format!("vibrissa-evaluate-{}", std::process::id()));
        let output_of = |threads: usize, json: bool, svg: Option<PathBuf>| {
            let args = CompensationArgs { seed: 3, plants: 1, svg, json };
            let mut out = Vec::new();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&args, &mut out)).unwrap();
            String::from_utf8(out).unwrap()
        };
        let table = output_of(1, false, Some(folder.clone()));
        assert_eq!(table, output_of(3, false, None));
        let whole: Value = serde_json::from_str(&output_of(2, true, None)).unwrap();
        assert_eq!(whole["trials"].as_array().unwrap().len(), 15);
        for case in whole["cases"].as_array().unwrap() {
            let closed = format!("{:.2}", 100.0 * case["closed"].as_f64().unwrap());
            let line = table.lines().find(|line| line.starts_with(case["case"].as_str().unwrap())).unwrap();
            assert!(line.contains(&closed), "{closed} in {line}");
        }
        let drawn: Vec<String> = std::fs::read_dir(&folder)
            .unwrap()
            .map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap())
            .collect();
        assert_eq!(drawn.len(), 4);
        assert!(drawn.iter().all(|svg| svg.ends_with("</svg>\n")));
        assert!(drawn.iter().any(|svg| svg.contains("after with gain")));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
