//! Delay until a trim is detected, at a given mean number of contacts between false alarms.
//!
//! The core learns everything as in service: a robot connects, its whisker learns offset and noise in its cold
//! start, and the core gets only the content of messages. The [`oracle`] runs on the same contacts.

pub mod oracle;
pub mod plant;
mod supervised;

use rayon::prelude::*;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::units::ContactRatio;

use vibrissa_edge::interval::Z95;

use oracle::Oracle;
use plant::{DEFLECTIONS_MM, NOISE, Plant, RATIOS, WHOLE_MM};
use supervised::{Said, Supervised};

/// Parameters of the evaluation.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Model of the whiskers, from which the true ones deviate.
    pub model: Model,
    /// Seed of all randomness.
    pub seed: u64,
    /// Number of cuts of each size.
    pub cuts: u32,
    /// Number of whiskers without any change.
    pub healthy_whiskers: u32,
    /// Number of contacts of each of them after the cold start.
    pub healthy_contacts: u32,
    /// Configured mean number of contacts between false alarms.
    pub contacts_between_false_alarms: f64,
    /// Largest relative deviation of each parameter of a whisker's calibration.
    pub calibration_error: f64,
    /// Share of contacts with ten times the noise.
    pub outliers: f64,
    /// Lengths that are cut off, mm.
    pub sizes_mm: Vec<f64>,
    /// Numbers of contacts before the cuts.
    pub changes_at: Vec<u32>,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            model: Model::nguyen_2021(Formulation::Published),
            seed: 1,
            cuts: 1000,
            healthy_whiskers: 1000,
            healthy_contacts: 20_000,
            contacts_between_false_alarms: 1e5,
            calibration_error: 0.1,
            outliers: 0.0,
            sizes_mm: vec![0.25, 0.5, 1.0, 2.0, 5.0, 10.0],
            changes_at: vec![300, 2000],
        }
    }
}

/// Delays for one size of cut at one time.
#[derive(Debug, Clone)]
pub struct Delay {
    /// Length that was cut off, mm.
    pub size_mm: f64,
    /// Contacts before the cut.
    pub change_at: u32,
    /// Number of cuts that count: those without a false alarm in progress at the cut.
    pub cuts: u32,
    /// Mean number of contacts from the cut to the alarm.
    pub alarm: f64,
    /// Standard error of `alarm`.
    pub alarm_error: f64,
    /// Mean number of contacts from the cut to the trim verdict: confirmed, told from erosion, its length certain.
    pub called: f64,
    /// Share of the cuts with a trim verdict within the time limit.
    pub called_share: f64,
    /// Mean delay of the oracle on the same contacts.
    pub oracle: f64,
    /// log(ARL0) / KL: first-order approximation of Lorden's bound.
    pub lorden: f64,
    /// Share of the trim verdicts whose 95 % interval of the length contains the truth.
    pub covered: f64,
    /// Mean of |length - truth| over the trim verdicts, mm.
    pub length_error_mm: f64,
}

impl Delay {
    /// Ratio of the mean alarm delay to the oracle's.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.alarm / self.oracle
    }
}

/// Results of the whiskers without any change.
#[derive(Debug, Clone, Copy)]
pub struct Healthy {
    /// Number of contacts after the cold start.
    pub contacts: u64,
    /// Number of false alarms.
    pub alarms: u64,
    /// Number of false verdicts: trims, erosions and losses of sensitivity.
    pub called: u64,
    /// Mean of the squared standardised innovations, each limited to 9 (0.995 for a consistent filter).
    pub mean_square: f64,
}

impl Healthy {
    /// Mean number of contacts between false alarms; without an alarm, the number of contacts.
    #[must_use]
    pub fn between_false_alarms(&self) -> f64 {
        self.contacts as f64 / self.alarms.max(1) as f64
    }
}

/// Result of the evaluation.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Delays by time and size.
    pub delays: Vec<Delay>,
    /// Results of the healthy whiskers.
    pub healthy: Healthy,
}

/// Runs a plan on all processors; the same plan gives the same result. `done` is called after each whisker.
#[must_use]
pub fn evaluate(plan: &Plan, done: &(dyn Fn() + Sync)) -> Evaluation {
    let cells: Vec<(u32, f64)> =
        plan.changes_at.iter().flat_map(|&at| plan.sizes_mm.iter().map(move |&size_mm| (at, size_mm))).collect();
    let delays = cells.iter().map(|&(at, size_mm)| delays(plan, at, size_mm, done)).collect();
    Evaluation { delays, healthy: healthy(plan, done) }
}

/// Number of whiskers of a plan.
#[must_use]
pub fn whiskers(plan: &Plan) -> u64 {
    let cells = plan.changes_at.len() as u64 * plan.sizes_mm.len() as u64;
    u64::from(plan.cuts) * cells + u64::from(plan.healthy_whiskers)
}

fn healthy(plan: &Plan, done: &(dyn Fn() + Sync)) -> Healthy {
    let nothing = Healthy { contacts: 0, alarms: 0, called: 0, mean_square: 0.0 };
    let each: Vec<Healthy> = (0..plan.healthy_whiskers)
        .into_par_iter()
        .map(|number| {
            let mut plant = Plant::new(&plan.model, seed(plan, 0, number), plan.calibration_error, plan.outliers);
            let mut supervised = Supervised::new(plan);
            let mut seen = nothing;
            while seen.contacts < u64::from(plan.healthy_contacts) {
                let said = supervised.feel(&plant.touch());
                seen.contacts += u64::from(supervised.is_watching());
                seen.alarms += u64::from(said.alarm);
                seen.called += u64::from(said.called);
                if said.called {
                    supervised = Supervised::new(plan);
                }
                seen.mean_square += said.square;
            }
            done();
            seen
        })
        .collect();
    let sum = each.iter().fold(nothing, |sum, one| Healthy {
        contacts: sum.contacts + one.contacts,
        alarms: sum.alarms + one.alarms,
        called: sum.called + one.called,
        mean_square: sum.mean_square + one.mean_square,
    });
    Healthy { mean_square: sum.mean_square / sum.contacts as f64, ..sum }
}

/// Result of one cut: contacts to the alarm, to the verdict, and to the oracle's alarm.
struct Cut {
    alarm: u32,
    called: Option<(u32, Said)>,
    oracle: u32,
    /// Remaining length, mm.
    length_mm: f64,
}

fn delays(plan: &Plan, change_at: u32, size_mm: f64, done: &(dyn Fn() + Sync)) -> Delay {
    let length_mm = WHOLE_MM - size_mm;
    // Shifts of a typical whisker, on which the oracle's threshold depends.
    let typical = Plant::new(&plan.model, 0, 0.0, 0.0);
    let shifts: Vec<f64> = (0..12)
        .map(|k| ContactRatio::known(RATIOS.0 + (RATIOS.1 - RATIOS.0) * (f64::from(k) + 0.5) / 12.0))
        .map(|ratio| typical.log_shift(ratio, length_mm) / NOISE)
        .collect();
    let information = shifts.iter().map(|shift| 0.5 * shift * shift).sum::<f64>() / shifts.len() as f64;
    let threshold = oracle::threshold(&shifts, plan.contacts_between_false_alarms);
    let patience = 3000 + (100.0 / information) as u32;
    let purpose = u64::from(change_at) * 1000 + (size_mm * 4.0) as u64;
    let cuts: Vec<Option<Cut>> = (0..plan.cuts)
        .into_par_iter()
        .map(|number| {
            let plant = Plant::new(&plan.model, seed(plan, purpose, number), plan.calibration_error, plan.outliers);
            let cut = cut(plan, plant, (change_at, size_mm), threshold, patience);
            done();
            cut
        })
        .collect();
    let cuts: Vec<Cut> = cuts.into_iter().flatten().collect();
    summary(size_mm, change_at, &cuts, plan.contacts_between_false_alarms.ln() / information)
}

/// `None` if a false alarm was in progress at the cut.
fn cut(plan: &Plan, mut plant: Plant, (at, size_mm): (u32, f64), threshold: f64, patience: u32) -> Option<Cut> {
    let length_mm = plant.whole_mm - size_mm;
    let mut supervised = Supervised::new(plan);
    let mut oracle = Oracle::default();
    for _ in 0..at {
        let touch = plant.touch();
        supervised.feel(&touch);
        let shift = plant.log_shift(touch.ratio, length_mm) / NOISE;
        if oracle.update(touch.log_deviation / NOISE, shift, threshold) {
            oracle = Oracle::default();
        }
    }
    if !supervised.is_calm() {
        return None;
    }
    plant.length_mm = length_mm;
    let mut found = Cut { alarm: 0, called: None, oracle: 0, length_mm };
    for contact in 1..=patience {
        let touch = plant.touch();
        let said = supervised.feel(&touch);
        let shift = plant.log_shift(touch.ratio, length_mm) / NOISE;
        if oracle.update(touch.log_deviation / NOISE, shift, threshold) && found.oracle == 0 {
            found.oracle = contact;
        }
        if said.alarm && found.alarm == 0 {
            found.alarm = contact;
        }
        if said.called && found.called.is_none() {
            found.called = Some((contact, said));
        }
        if found.oracle > 0 && found.called.is_some() {
            break;
        }
    }
    found.alarm = if found.alarm == 0 { patience } else { found.alarm };
    found.oracle = if found.oracle == 0 { patience } else { found.oracle };
    Some(found)
}

fn summary(size_mm: f64, change_at: u32, cuts: &[Cut], lorden: f64) -> Delay {
    let count = cuts.len().max(1) as f64;
    let mean = |of: &dyn Fn(&Cut) -> f64| cuts.iter().map(of).sum::<f64>() / count;
    let alarm = mean(&|cut| f64::from(cut.alarm));
    let variance = mean(&|cut| (f64::from(cut.alarm) - alarm).powi(2));
    // Trims: contacts to the verdict, |length - truth|, its standard deviation.
    let trims: Vec<(f64, f64, f64)> = cuts
        .iter()
        .filter_map(|cut| {
            let (contact, said) = cut.called.as_ref()?;
            let (length_mm, sd_mm) = said.trim?;
            Some((f64::from(*contact), (length_mm - cut.length_mm).abs(), sd_mm))
        })
        .collect();
    let called = trims.len().max(1) as f64;
    Delay {
        size_mm,
        change_at,
        cuts: cuts.len() as u32,
        alarm,
        alarm_error: (variance / count).sqrt(),
        called: trims.iter().map(|(contacts, _, _)| contacts).sum::<f64>() / called,
        called_share: trims.len() as f64 / count,
        oracle: mean(&|cut| f64::from(cut.oracle)),
        lorden,
        covered: trims.iter().filter(|(_, off_mm, sd_mm)| *off_mm <= Z95 * sd_mm).count() as f64 / called,
        length_error_mm: trims.iter().map(|(_, off_mm, _)| off_mm).sum::<f64>() / called,
    }
}

/// A separate seed for each purpose and whisker.
fn seed(plan: &Plan, purpose: u64, number: u32) -> u64 {
    let mut seed = plan.seed;
    for part in [purpose, u64::from(number)] {
        seed = (seed ^ part).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    }
    seed
}

/// The contacts' parameters as text.
#[must_use]
pub fn contacts_in_words() -> String {
    format!(
        "contact ratios {} to {}, deflections {} to {} mm, noise {} %",
        RATIOS.0,
        RATIOS.1,
        DEFLECTIONS_MM.0,
        DEFLECTIONS_MM.1,
        100.0 * NOISE
    )
}
