//! How soon a trim is known, at a stated mean number of contacts between false alarms.
//!
//! Everything is learned as in the service: a robot is born, its whisker learns offset and noise in its cold
//! start, and the core gets nothing but messages' contents. Beside it runs the [`oracle`] on the same contacts.

pub mod oracle;
pub mod plant;
mod supervised;

use rayon::prelude::*;
use vibrissa_core::units::ContactRatio;

use vibrissa_edge::words::Z95;

use oracle::Oracle;
use plant::{DEFLECTIONS_MM, NOISE, Plant, RATIOS, WHOLE_MM};
use supervised::{Said, Supervised};

/// What is evaluated.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Where all randomness starts.
    pub seed: u64,
    /// Cuts of each size.
    pub cuts: u32,
    /// Whiskers that are watched while nothing happens to them.
    pub healthy_whiskers: u32,
    /// How many contacts each of them is watched, after its cold start.
    pub healthy_contacts: u32,
    /// Stated mean number of contacts between false alarms.
    pub contacts_between_false_alarms: f64,
    /// How far each parameter of a whisker's calibration may be off, relative.
    pub calibration_error: f64,
    /// Share of contacts with ten times the noise.
    pub outliers: f64,
    /// What is cut off, mm.
    pub sizes_mm: Vec<f64>,
    /// The contacts at which the cuts happen.
    pub changes_at: Vec<u32>,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
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

/// Delays for one size of cut at one moment.
#[derive(Debug, Clone)]
pub struct Delay {
    /// What was cut off, mm.
    pub size_mm: f64,
    /// Contacts before the cut.
    pub change_at: u32,
    /// Cuts that count: those without a false alarm under way at the change.
    pub cuts: u32,
    /// Mean number of contacts from the cut to the alarm.
    pub alarm: f64,
    /// Its standard error.
    pub alarm_error: f64,
    /// Mean number of contacts to the trim being called: confirmed, told from erosion, its length certain.
    pub called: f64,
    /// Share of the cuts that were called a trim within the time allowed.
    pub called_share: f64,
    /// The oracle's mean delay on the same contacts.
    pub oracle: f64,
    /// log(ARL0) / KL: Lorden's bound, to first order.
    pub lorden: f64,
    /// Share of the called trims whose 95 % interval of the length holds the truth.
    pub covered: f64,
    /// Mean of |length - truth| of the called trims, mm.
    pub length_error_mm: f64,
}

impl Delay {
    /// Alarm delay against the oracle's.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.alarm / self.oracle
    }
}

/// What healthy whiskers showed.
#[derive(Debug, Clone, Copy)]
pub struct Healthy {
    /// Contacts that were watched.
    pub contacts: u64,
    /// False alarms.
    pub alarms: u64,
    /// Trims, erosions and the like that were called.
    pub called: u64,
    /// Mean of the squared standardised innovations, outliers cut at 9 (a consistent filter: 0.995).
    pub mean_square: f64,
}

impl Healthy {
    /// Mean number of contacts between false alarms; with no alarm, the contacts watched.
    #[must_use]
    pub fn between_false_alarms(&self) -> f64 {
        self.contacts as f64 / self.alarms.max(1) as f64
    }
}

/// The whole answer.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// By moment and size.
    pub delays: Vec<Delay>,
    /// Healthy whiskers.
    pub healthy: Healthy,
}

/// Runs a plan on all cores; the same plan gives the same answer. `done` is called after each whisker.
#[must_use]
pub fn evaluate(plan: &Plan, done: &(dyn Fn() + Sync)) -> Evaluation {
    let cells: Vec<(u32, f64)> =
        plan.changes_at.iter().flat_map(|&at| plan.sizes_mm.iter().map(move |&size_mm| (at, size_mm))).collect();
    let delays = cells.iter().map(|&(at, size_mm)| delays(plan, at, size_mm, done)).collect();
    Evaluation { delays, healthy: healthy(plan, done) }
}

/// How many whiskers a plan has.
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
            let mut plant = Plant::new(seed(plan, 0, number), plan.calibration_error, plan.outliers);
            let mut supervised = Supervised::new(plan.contacts_between_false_alarms);
            let mut seen = nothing;
            while seen.contacts < u64::from(plan.healthy_contacts) {
                let said = supervised.feel(&plant.touch());
                seen.contacts += u64::from(supervised.is_watching());
                seen.alarms += u64::from(said.alarm);
                seen.called += u64::from(said.called);
                if said.called {
                    supervised = Supervised::new(plan.contacts_between_false_alarms);
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

/// One cut: contacts to the alarm, to the call, and of the oracle.
struct Cut {
    alarm: u32,
    called: Option<(u32, Said)>,
    oracle: u32,
    /// What remained, mm.
    length_mm: f64,
}

fn delays(plan: &Plan, change_at: u32, size_mm: f64, done: &(dyn Fn() + Sync)) -> Delay {
    let length_mm = WHOLE_MM - size_mm;
    // The typical whisker's shifts: the oracle's threshold depends on them alone.
    let typical = Plant::new(0, 0.0, 0.0);
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
            let plant = Plant::new(seed(plan, purpose, number), plan.calibration_error, plan.outliers);
            let cut = cut(plan, plant, (change_at, size_mm), threshold, patience);
            done();
            cut
        })
        .collect();
    let cuts: Vec<Cut> = cuts.into_iter().flatten().collect();
    summary(size_mm, change_at, &cuts, plan.contacts_between_false_alarms.ln() / information)
}

/// None if a false alarm was under way at the change.
fn cut(plan: &Plan, mut plant: Plant, (at, size_mm): (u32, f64), threshold: f64, patience: u32) -> Option<Cut> {
    let length_mm = plant.whole_mm - size_mm;
    let mut supervised = Supervised::new(plan.contacts_between_false_alarms);
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
    // Trims: contacts to the call, |length - truth|, its standard deviation.
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

/// A seed of its own for each purpose and whisker.
fn seed(plan: &Plan, purpose: u64, number: u32) -> u64 {
    let mut seed = plan.seed;
    for part in [purpose, u64::from(number)] {
        seed = (seed ^ part).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    }
    seed
}

/// Deflections and ratios that the plan's text names.
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
