//! True value of a compensation on the whiskers themselves.

use vibrissa_core::mechanics::{ByRatio, CONTACT_RATIOS, ErrorProfile};

use super::whisker::{NOMINAL_MPA, Whisker};

/// True responses at the time of the cut, against which a compensation is measured.
///
/// A whisker's own lasting change of gain counts, because its readings show it. Temperature and scale of the whole
/// robot do not, because they change the target's reading in the same way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reference {
    before: ByRatio,
    target: ByRatio,
}

impl Reference {
    /// The target while whole, and the compensator at nominal pressure.
    #[must_use]
    pub(super) fn new(whole_target: ByRatio, compensator: &Whisker) -> Self {
        Self { before: per_mm(compensator, compensator.length_mm, NOMINAL_MPA), target: whole_target }
    }

    /// Eq. 35, mean over the contact ratios, at a pressure of the compensator, with a factor on its readings.
    #[must_use]
    pub(super) fn error(&self, compensator: &Whisker, pressure_mpa: f64, reading_gain: f64) -> f64 {
        let after = per_mm(compensator, compensator.length_mm, pressure_mpa).map(|one| Some(reading_gain * one?));
        ErrorProfile::new(&after, &self.before, &self.target).mean
    }

    /// Mean error of a reading with the published gain, as a share of the target's.
    #[must_use]
    pub(super) fn reading_error(
        &self,
        compensator: &Whisker,
        pressure_mpa: f64,
        gain: &[f64; CONTACT_RATIOS.len()],
    ) -> f64 {
        let after = per_mm(compensator, compensator.length_mm, pressure_mpa);
        let each = (0..CONTACT_RATIOS.len()).filter_map(|k| Some((after[k]? * gain[k] / self.target[k]? - 1.0).abs()));
        let (sum, count) = each.fold((0.0, 0_u32), |(sum, count), error| (sum + error, count + 1));
        sum / f64::from(count.max(1))
    }
}

/// The present response of a whisker as if it were whole and at nominal pressure, by contact ratio, per mm.
#[must_use]
pub(super) fn whole(whisker: &Whisker) -> ByRatio {
    per_mm(whisker, whisker.whole_mm, NOMINAL_MPA)
}

/// Mean rise of log sensitivity by a cut of this many mm.
#[must_use]
pub(super) fn rise_by_cut(whisker: &Whisker, size_mm: f64) -> f64 {
    let before = per_mm(whisker, whisker.length_mm, NOMINAL_MPA);
    let after = per_mm(whisker, whisker.length_mm - size_mm, NOMINAL_MPA);
    let rises: Vec<f64> =
        before.iter().zip(after).filter_map(|(before, after)| Some((after? / (*before)?).ln())).collect();
    rises.iter().sum::<f64>() / rises.len().max(1) as f64
}

fn per_mm(whisker: &Whisker, length_mm: f64, pressure_mpa: f64) -> ByRatio {
    let logs = whisker.log_sensitivities(length_mm, pressure_mpa);
    logs.map(|log| Some((log? + whisker.log_gain()).exp()))
}
