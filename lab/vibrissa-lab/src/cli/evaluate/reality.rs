//! `vibrissa-lab evaluate reality`: detection, false reports and compensation on whiskers with nuisances, as a table, as
//! JSON, and as a figure.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde_json::{Value, json};
use vibrissa_evaluation::reality::{Figures, Found, Nuisance, Plan, Row, Share, Spread, StatedPlace, evaluate};

use crate::figures;
use vibrissa::cli::progress::Progress;
use vibrissa::cli::stop;
use vibrissa::cli::words::one_of;

/// Arguments of `vibrissa-lab evaluate reality`.
#[derive(Debug, Args)]
pub struct RealityArgs {
    /// Seed: equal seeds give equal figures, on any number of processors.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Contacts of healthy whiskers in each row.
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..=10_000_000_000))]
    contacts: u64,
    /// Robots in each row on which something is cut or wears off; each takes the next of seven sizes, 1 to 16 mm.
    #[arg(long, default_value_t = 70, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    cuts: u32,
    /// Rows, each at all its strengths (`mix,ar1`) or at one (`temperature:2`); all rows if not given.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = rows_of)]
    rows: Vec<Rows>,
    /// Place that the robots know of their contacts; `RATIO_TESTS` and `DISTANCE_TESTS` are with touch tests.
    #[arg(long, default_value = "RATIO", value_parser = one_of(StatedPlace::ALL.to_vec(), StatedPlace::word))]
    place: StatedPlace,
    /// Let the robots multiply their readings: air for the shape, one gain for the level.
    #[arg(long)]
    gains: bool,
    /// Print everything as JSON instead of a table.
    #[arg(long)]
    json: bool,
    /// Draw the figures as an SVG file into this folder.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

/// Rows of one name.
#[derive(Debug, Clone)]
struct Rows(Vec<Row>);

fn rows_of(text: &str) -> Result<Rows, String> {
    let (name, strength) = text.split_once(':').map_or((text, None), |(name, strength)| (name, Some(strength)));
    let named = |one: &Nuisance| one.word().eq_ignore_ascii_case(name);
    let nuisance = Nuisance::ALL.into_iter().find(named).ok_or_else(|| {
        let names: Vec<&str> = Nuisance::ALL.iter().map(|one| one.word()).collect();
        format!("the rows are {}", names.join(", "))
    })?;
    let Some(strength) = strength else { return Ok(Rows(Row::of(&[nuisance]))) };
    let strength: f64 = strength.parse().map_err(|_| "a strength is a number".to_owned())?;
    if (0.01..=10.0).contains(&strength) {
        Ok(Rows(vec![Row { nuisance, strength }]))
    } else {
        Err("a strength is 0.01 to 10".to_owned())
    }
}

/// Runs the rows, prints the table, and draws the figure on request.
///
/// # Errors
/// The output or a file cannot be written.
pub fn run(args: &RealityArgs, out: &mut dyn Write) -> Result<()> {
    let named: Vec<Row> = args.rows.iter().flat_map(|rows| rows.0.iter().copied()).collect();
    let rows = if named.is_empty() { Row::of(&Nuisance::ALL) } else { named };
    let plan = Plan {
        seed: args.seed,
        rows,
        place: args.place,
        applies_gain: args.gains,
        contacts: args.contacts,
        incidents: args.cuts,
    };
    let progress = Progress::start(plan.trials(), "robots")?;
    let found = evaluate(&plan, &|| progress.step());
    drop(progress);
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&json(&plan, &found))?)?;
    } else {
        print(&plan, &found, out)?;
    }
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder).with_context(|| format!("creating the folder {}", folder.display()))?;
        let path = stop::whole(|| figures::reality::draw(&found, folder))?;
        if !args.json {
            writeln!(out, "drawn: {}", path.display())?;
        }
    }
    Ok(())
}

fn print(plan: &Plan, found: &[Figures], out: &mut dyn Write) -> Result<()> {
    writeln!(
        out,
        "\
Robots with six whiskers; {}; place of a contact: {}.
Each row has one nuisance at a multiple of the strength of real whiskers.

found, >=2mm   cuts reported as a trim (wear: also as erosion); those of 2 mm or more in %
alarm ...      contacts from the cut to the suspicion, to the report, to the setpoint: median and 90 %
wrong          reports of erosion or loss of sensitivity of cut whiskers, or of the same cut once more
susp. ...      false suspicions, trims, and other conditions or faults in a million contacts of healthy whiskers
length error   at the report, mm: median and standard deviation; how often the 95 % interval contains the truth, in %: at
               the report, and 300 and 2,000 contacts after the change, or after its end, reported or not
compensation   mean of eq. 35 in %: true, measured, predicted; how often a 95 % interval contains the truth, in %
read, lost     error of a reading with the published gain, in %: 300 contacts after the first setpoint, and at the end;
               compensations that ended without cause
",
        if plan.applies_gain { "they multiply their readings" } else { "air alone" },
        plan.place.word()
    )?;
    writeln!(
        out,
        "{:<15}{:>7} {:>5}{:>9}{:>10}{:>10}{:>6} |{:>7}{:>7}{:>7} |{:>12}{:>12} |{:>6}{:>6}{:>5}{:>6}{:>5}{:>9}{:>5}",
        "row",
        "found",
        ">=2mm",
        "alarm",
        "call",
        "setpoint",
        "wrong",
        "susp.",
        "trims",
        "cond.",
        "length error",
        "cov.",
        "true",
        "meas.",
        "cov.",
        "pred.",
        "cov.",
        "read",
        "lost"
    )?;
    for figures in found {
        print_row(figures, out)?;
    }
    writeln!(
        out,
        "\n{} healthy contacts and {} robots with cuts in each row, seed {}",
        plan.contacts, plan.incidents, plan.seed
    )?;
    for figures in found.iter().filter(|one| one.healthy.leaks.chambers > 0) {
        let leaks = figures.healthy.leaks;
        let within = leaks.in_time;
        let (found, all, raised) = (leaks.found, leaks.chambers, leaks.raised);
        writeln!(out, "{}: {found} of {all} leaks reported, {within} within 60 s, {raised} times", name(figures))?;
    }
    Ok(())
}

fn name(figures: &Figures) -> String {
    format!("{} {}", figures.row.nuisance.word(), figures.row.strength)
}

fn print_row(one: &Figures, out: &mut dyn Write) -> Result<()> {
    let spread =
        |spread: Option<Spread>| spread.map_or("-".to_owned(), |one| format!("{:.0} {:.0}", one.median, one.most));
    let share = |share: Share| share.ratio().map_or("-".to_owned(), |ratio| format!("{:.0}", 100.0 * ratio));
    let per_cent = |ratio: Option<f64>| ratio.map_or("-".to_owned(), |ratio| format!("{:.1}", 100.0 * ratio));
    let rate = |count: u64| match one.healthy.per_million(count) {
        0.0 => "0".to_owned(),
        rate => format!("{rate:.1}"),
    };
    let (found, [soon, late]) = (one.found(), one.length_after_covered());
    let length = one.length_error_mm().map_or("-".to_owned(), |(median, sd)| format!("{median:+.2} {sd:.2}"));
    writeln!(
        out,
        "{:<15}{:>7} {:>5}{:>9}{:>10}{:>10}{:>6} |{:>7}{:>7}{:>7} |{length:>12}{:>12} |{:>6}{:>6}{:>5}{:>6}{:>5}{:>9}{:>5}",
        name(one),
        format!("{}/{}", found.count, found.of),
        share(one.found_from_2_mm()),
        spread(one.alarm()),
        spread(one.call()),
        spread(one.setpoint()),
        one.wrong(),
        rate(one.healthy.suspicions),
        rate(one.healthy.trims),
        rate(one.healthy.conditions()),
        format!("{} {} {}", share(one.length_covered()), share(soon), share(late)),
        per_cent(one.error_true()),
        per_cent(one.error_measured()),
        share(one.measured_covered()),
        per_cent(one.error_predicted()),
        share(one.predicted_covered()),
        format!("{} {}", per_cent(one.soon_reading_error()), per_cent(one.reading_error())),
        one.lost(),
    )?;
    Ok(())
}

fn json(plan: &Plan, found: &[Figures]) -> Value {
    json!({
        "seed": plan.seed,
        "place": plan.place.word(),
        "applies_gain": plan.applies_gain,
        "healthy_contacts_a_row": plan.contacts,
        "robots_with_cuts_a_row": plan.incidents,
        "rows": found.iter().map(row_json).collect::<Vec<_>>(),
    })
}

fn row_json(one: &Figures) -> Value {
    let spread =
        |spread: Option<Spread>| json!({ "median": spread.map(|one| one.median), "p90": spread.map(|one| one.most) });
    let share = |share: Share| json!({ "count": share.count, "of": share.of });
    let (healthy, [soon, late]) = (one.healthy, one.length_after_covered());
    json!({
        "row": one.row.nuisance.word(),
        "strength": one.row.strength,
        "place": one.place.word(),
        "found": share(one.found()),
        "found_from_2_mm": share(one.found_from_2_mm()),
        "alarm_contacts": spread(one.alarm()),
        "call_contacts": spread(one.call()),
        "setpoint_contacts": spread(one.setpoint()),
        "wrong_reports": one.wrong(),
        "healthy_contacts": healthy.contacts,
        "false_suspicions": healthy.suspicions,
        "false_suspicions_per_million": healthy.per_million(healthy.suspicions),
        "false_trims": healthy.trims,
        "false_trims_per_million": healthy.per_million(healthy.trims),
        "false_conditions": healthy.conditions(),
        "false_conditions_per_million": healthy.per_million(healthy.conditions()),
        "false_conditions_by_kind": {
            "ERODING": healthy.eroding, "SENSITIVITY_LOSS": healthy.losses, "FAULT": healthy.faults,
        },
        "array_shifts": healthy.shifts,
        "baseline_drifts": healthy.drifts,
        "leaks": { "chambers": healthy.leaks.chambers, "found": healthy.leaks.found,
            "found_within_60_s": healthy.leaks.in_time, "raised": healthy.leaks.raised },
        "length_error_mm": { "median": one.length_error_mm().map(|(median, _)| median),
            "sd": one.length_error_mm().map(|(_, sd)| sd) },
        "length_covered": share(one.length_covered()),
        "length_covered_after_300_contacts": share(soon),
        "length_covered_after_2000_contacts": share(late),
        "length_covered_at_end": share(one.length_end_covered()),
        "served": share(one.served()),
        "error_true": one.error_true(),
        "error_measured": one.error_measured(),
        "error_measured_covered": share(one.measured_covered()),
        "error_predicted": one.error_predicted(),
        "error_predicted_covered": share(one.predicted_covered()),
        "reading_error_after_300_contacts": one.soon_reading_error(),
        "error_measured_covered_after_300_contacts": share(one.soon_measured_covered()),
        "reading_error": one.reading_error(),
        "compensations_lost": one.lost(),
        "cuts": one.found.iter().map(cut_json).collect::<Vec<_>>(),
    })
}

fn cut_json(cut: &Found) -> Value {
    json!({
        "cut_mm": cut.size_mm,
        "alarm_contacts": cut.alarm,
        "call_contacts": cut.call,
        "setpoint_contacts": cut.setpoint,
        "length_error_mm": cut.length.map(|(error, _)| error),
        "length_sd_mm": cut.length.map(|(_, sd)| sd),
        "length_error_after_300_contacts_mm": cut.length_after[0].map(|(error, _)| error),
        "length_sd_after_300_contacts_mm": cut.length_after[0].map(|(_, sd)| sd),
        "length_error_after_2000_contacts_mm": cut.length_after[1].map(|(error, _)| error),
        "length_sd_after_2000_contacts_mm": cut.length_after[1].map(|(_, sd)| sd),
        "length_error_at_end_mm": cut.length_end.0,
        "length_sd_at_end_mm": cut.length_end.1,
        "error_true": cut.compensated.map(|one| one.truth),
        "error_measured": cut.compensated.and_then(|one| one.measured.map(|(mean, _)| mean)),
        "error_measured_sd": cut.compensated.and_then(|one| one.measured.map(|(_, sd)| sd)),
        "error_predicted": cut.compensated.map(|one| one.predicted.0),
        "error_predicted_interval": cut.compensated.map(|one| one.predicted.1),
        "error_true_as_decided": cut.compensated.map(|one| one.predicted.2),
        "reading_error_after_300_contacts": cut.soon.and_then(|one| one.reading),
        "error_true_after_300_contacts": cut.soon.map(|one| one.truth),
        "error_measured_after_300_contacts": cut.soon.and_then(|one| one.measured.map(|(mean, _)| mean)),
        "error_measured_sd_after_300_contacts": cut.soon.and_then(|one| one.measured.map(|(_, sd)| sd)),
        "reading_error": cut.compensated.and_then(|one| one.reading),
        "compensations_lost": cut.lost,
        "wrong_reports": cut.wrong,
        "reading_error_while_wearing": cut.worn_reading,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows of a few thousand contacts, so that the test takes a second.
    #[test]
    fn table_json_and_figure_tell_the_same_and_each_column_is_in_the_json() {
        let folder = std::env::temp_dir().join(format!("vibrissa-reality-{}", std::process::id()));
        let output_of = |json: bool, svg: Option<PathBuf>| {
            let rows = vec![rows_of("ideal").unwrap(), rows_of("ar1:2").unwrap()];
            let mut out = Vec::new();
            run(
                &RealityArgs {
                    seed: 5,
                    contacts: 3000,
                    cuts: 4,
                    rows,
                    place: StatedPlace::Ratio,
                    gains: true,
                    json,
                    svg,
                },
                &mut out,
            )
            .unwrap();
            String::from_utf8(out).unwrap()
        };
        let table = output_of(false, Some(folder.clone()));
        assert!(table.lines().all(|line| line.chars().count() <= 160), "{table}");
        let whole: Value = serde_json::from_str(&output_of(true, None)).unwrap();
        let rows = whole["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 2);
        for row in rows {
            let name = format!("{} {} ", row["row"].as_str().unwrap(), row["strength"].as_f64().unwrap());
            let line = table.lines().find(|line| line.starts_with(&name)).unwrap();
            let found = format!("{}/{}", row["found"]["count"], row["found"]["of"]);
            assert!(line.contains(&found), "{found} in {line}");
            for column in [
                "found",
                "found_from_2_mm",
                "alarm_contacts",
                "call_contacts",
                "setpoint_contacts",
                "wrong_reports",
                "false_suspicions_per_million",
                "false_trims_per_million",
                "false_conditions_per_million",
                "length_error_mm",
                "length_covered",
                "length_covered_after_300_contacts",
                "length_covered_after_2000_contacts",
                "error_true",
                "error_measured",
                "error_measured_covered",
                "error_predicted",
                "error_predicted_covered",
                "reading_error",
                "reading_error_after_300_contacts",
                "compensations_lost",
            ] {
                assert!(row.get(column).is_some(), "{column}");
            }
            assert_eq!(row["cuts"].as_array().unwrap().len(), 4);
        }
        let svg = std::fs::read_to_string(folder.join("reality.svg")).unwrap();
        assert!(svg.ends_with("</svg>\n") && svg.contains("ar1 2"));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn rows_are_named_with_or_without_a_strength() {
        assert_eq!(rows_of("temperature").unwrap().0.len(), 3);
        assert_eq!(rows_of("temperature:2").unwrap().0[0].strength, 2.0);
        assert!(rows_of("weather").unwrap_err().contains("temperature"));
        assert!(rows_of("mix:0").is_err() && rows_of("mix:x").is_err());
    }
}
