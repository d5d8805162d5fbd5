//! Groups of bench readings with the mean and the spread of their residuals.

use vibrissa_core::mechanics::{BenchReading, Gauge, Kind, Model, student_t};

use crate::cli::bench_table::Reading;

/// A mean error below this does not count as a misfit, as a ratio.
const MISFIT_MIN: f64 = 0.05;
/// Share of the largest reading of a kind below which a reading counts less.
const FLOOR_SHARE: f64 = 0.05;
/// Numbers this close belong to one group: relative, and absolute in MPa, ratio, or mm.
const CLOSE: (f64, f64) = (0.02, 0.0005);

/// A reading with the model's number for it.
#[derive(Clone, Copy)]
pub(crate) struct Compared {
    pub(crate) reading: BenchReading,
    pub(crate) modelled: f64,
    /// Place as a share of the length, or in mm if the length is not known.
    pub(crate) place: Option<f64>,
    /// Length of the whisker, if it is known, mm.
    pub(crate) length_mm: Option<f64>,
}

/// The readings that a comparison uses, and whether their places are ratios.
pub(crate) struct Comparison {
    pub(crate) all: Vec<Compared>,
    pub(crate) by_ratio: bool,
}

impl Comparison {
    pub(crate) fn new(table: &[Reading], model: &Model) -> Self {
        let gauge = gauge(table);
        let by_ratio = table.iter().all(|one| one.reading.contact().is_none() || one.length.is_some());
        let compared = |one: &Reading| {
            one.reading.kind().filter(|kind| *kind != Kind::Zero)?;
            let elongation_mm = model.elongation(one.reading.pressure).mm();
            let place = one.reading.contact().map(|contact| {
                let distance_mm = contact.distance_mm(elongation_mm);
                let length_mm = one.length.map(|length| length.mm() + elongation_mm);
                length_mm.filter(|_| by_ratio).map_or(distance_mm, |length_mm| distance_mm / length_mm)
            });
            let (modelled, length_mm) = (one.reading.modelled(model, gauge), one.length.map(|length| length.mm()));
            Some(Compared { reading: one.reading, modelled, place, length_mm })
        };
        Self { all: table.iter().filter_map(compared).collect(), by_ratio }
    }

    pub(crate) fn of_kind(&self, kind: Kind) -> Vec<Compared> {
        self.all.iter().filter(|one| one.reading.kind() == Some(kind)).copied().collect()
    }

    /// Name of a place.
    pub(crate) fn place(&self, place: f64) -> String {
        if self.by_ratio { format!("ratio {}", rounded(place, 100.0)) } else { format!("{} mm", rounded(place, 10.0)) }
    }
}

/// Without the digits beyond a scale.
pub(crate) fn rounded(value: f64, scale: f64) -> f64 {
    (value * scale).round() / scale
}

/// The gauge with the offset that the file shows at zero pressure.
fn gauge(table: &[Reading]) -> Gauge {
    let zeros: Vec<f64> =
        table.iter().filter(|one| one.reading.kind() == Some(Kind::Zero)).map(|one| one.reading.value).collect();
    let offset = if zeros.len() > 1 { zeros.iter().sum::<f64>() / zeros.len() as f64 } else { 0.0 };
    Gauge { offset, ..Gauge::TRUE }
}

/// Readings whose keys lie close together, with the mean key, in the order of the keys.
pub(crate) fn clusters(readings: &[Compared], key: impl Fn(&Compared) -> Option<f64>) -> Vec<(f64, Vec<Compared>)> {
    let mut keyed: Vec<(f64, Compared)> = readings.iter().filter_map(|one| Some((key(one)?, *one))).collect();
    keyed.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let (relative, absolute) = CLOSE;
    let groups = keyed.chunk_by(|(a, _), (b, _)| b - a <= relative * a.abs() + absolute);
    groups
        .map(|group| {
            let mean = group.iter().map(|(key, _)| key).sum::<f64>() / group.len() as f64;
            (mean, group.iter().map(|(_, one)| *one).collect())
        })
        .collect()
}

/// Mean and spread of a group's relative residuals, `measured / computed - 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Errors {
    pub(crate) readings: usize,
    pub(crate) mean: f64,
    /// Half of the 95 % interval of one residual about the mean; `None` for a single reading.
    pub(crate) half_of_one: Option<f64>,
    /// Half of the 95 % interval of the mean.
    half_of_mean: Option<f64>,
}

impl Errors {
    /// Small readings count less, because a part of each error does not shrink with the reading.
    pub(crate) fn new(group: &[Compared]) -> Self {
        let floor = FLOOR_SHARE * group.iter().map(|one| one.modelled.abs()).fold(0.0, f64::max);
        let weighed: Vec<(f64, f64)> = group
            .iter()
            .filter(|one| one.modelled != 0.0)
            .map(|one| {
                let squared = one.modelled.powi(2);
                (squared / (squared + floor.powi(2)), one.reading.value / one.modelled - 1.0)
            })
            .collect();
        let weights: f64 = weighed.iter().map(|(weight, _)| weight).sum();
        let mean = weighed.iter().map(|(weight, off)| weight * off).sum::<f64>() / weights.max(f64::MIN_POSITIVE);
        let count = weighed.len() as f64;
        let squares: f64 = weighed.iter().map(|(weight, off)| weight * (off - mean).powi(2)).sum();
        let half = (count > 1.0).then(|| student_t(count - 1.0) * (squares / weights * count / (count - 1.0)).sqrt());
        Self {
            readings: weighed.len(),
            mean,
            half_of_one: half.map(|half| half * (1.0 + 1.0 / count).sqrt()),
            half_of_mean: half.map(|half| half / count.sqrt()),
        }
    }

    /// Whether the mean is off by more than its own scatter explains, and by more than 5 %.
    pub(crate) fn is_misfit(&self) -> bool {
        self.readings > 0 && self.mean.abs() > MISFIT_MIN && self.mean.abs() > self.half_of_mean.unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_core::mechanics::Quantity;
    use vibrissa_core::units::Megapascal;

    use super::*;

    fn compared(pressure_mpa: f64, value: f64, modelled: f64) -> Compared {
        let pressure = Megapascal::new(pressure_mpa).unwrap();
        let reading = BenchReading { pressure, pressure_sd_mpa: 0.0, quantity: Quantity::AxialStrain, value, sd: None };
        Compared { reading, modelled, place: None, length_mm: None }
    }

    #[test]
    fn pressures_that_a_regulator_scatters_are_one_group() {
        let at = |pressure_mpa: f64| compared(pressure_mpa, 1.0, 1.0);
        let readings: Vec<_> = [0.0998, 0.002, 0.1004, 0.005, 0.2001, 0.1, 0.1999].map(at).into();
        let found: Vec<_> = clusters(&readings, |one| Some(one.reading.pressure.mpa()))
            .into_iter()
            .map(|(mean, group)| (rounded(mean, 1000.0), group.len()))
            .collect();
        assert_eq!(found, [(0.002, 1), (0.005, 1), (0.1, 3), (0.2, 2)]);
    }

    #[test]
    fn a_group_is_a_misfit_beyond_its_own_scatter_only() {
        let errors =
            |values: &[f64]| Errors::new(&values.iter().map(|value| compared(0.1, *value, 1.0)).collect::<Vec<_>>());
        let clear = errors(&[1.22, 1.24, 1.23]);
        assert!(clear.is_misfit() && (clear.mean - 0.23).abs() < 1e-9, "{clear:?}");
        assert!(!errors(&[1.5, 0.7, 1.1]).is_misfit());
        assert!(!errors(&[1.04, 1.041, 1.039]).is_misfit());
        assert!(errors(&[0.8]).is_misfit() && errors(&[0.8]).half_of_one.is_none());
        // A large reading counts, and one of a thousandth of it hardly.
        let mixed = Errors::new(&[compared(0.1, 1.0, 1.0), compared(0.1, 0.003, 0.001)]);
        assert!(mixed.mean.abs() < 0.001, "{mixed:?}");
    }
}
