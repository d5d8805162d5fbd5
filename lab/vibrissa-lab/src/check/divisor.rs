//! The length by which a robot divides distances, from touches at one place. Pure.

use vibrissa_protocol::Contact;

use super::report::Judgement;

/// Largest relative deviation of a touch from the median of touches at one place, which two thirds of them keep.
const AT_PLACE: f64 = 0.08;
/// Largest relative deviation of such medians at the same place. Two lengths of the test differ by more than twice as much.
const SAME: f64 = 0.1;

/// Touches of a whisker at one place: the median of its places.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) enum Touches {
    /// None came.
    #[default]
    None,
    /// Most had a contact ratio.
    Ratio(f64),
    /// Most had a distance from the base, in mm.
    Distance(f64),
    /// They were at different places.
    Scattered,
    /// Most had another place, or none.
    Other,
}

impl Touches {
    pub(super) fn of(contacts: &[Contact]) -> Self {
        if contacts.is_empty() {
            return Self::None;
        }
        let most = |values: Vec<f64>| Some(values).filter(|values| 2 * values.len() > contacts.len()).map(median);
        let ratios = contacts.iter().filter_map(|one| one.ratio).collect();
        let distances = contacts.iter().filter(|one| one.ratio.is_none() && !one.tip).filter_map(|one| one.distance_mm);
        let place = |medians: Option<f64>, place: fn(f64) -> Self| medians.map_or(Self::Scattered, place);
        let ratio = most(ratios).map(|one| place(one, Self::Ratio));
        ratio.or_else(|| most(distances.collect()).map(|one| place(one, Self::Distance))).unwrap_or(Self::Other)
    }

    fn text(self) -> String {
        match self {
            Self::None => "no touch".to_owned(),
            Self::Ratio(ratio) => format!("contact ratio {ratio:.3}"),
            Self::Distance(mm) => format!("distance {mm:.1} mm"),
            Self::Scattered => "touches at different places".to_owned(),
            Self::Other => "neither ratio nor distance".to_owned(),
        }
    }
}

/// The median of values, if most are near it.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let median = values.get(values.len() / 2).copied()?;
    let near = values.iter().filter(|&&value| (value / median - 1.0).abs() <= AT_PLACE).count();
    (3 * near >= 2 * values.len()).then_some(median)
}

/// Touches before the first estimate of the check.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum First {
    /// The robot had no estimate in this boot.
    WithoutEstimate(Touches),
    /// It may have had one of the last supervisor.
    Unknown(Touches),
}

impl Default for First {
    fn default() -> Self {
        Self::Unknown(Touches::None)
    }
}

/// Touches after estimates.
#[derive(Debug, Default)]
pub(super) struct Divisor {
    pub(super) first: First,
    /// The two lengths that the robot was told, in mm.
    pub(super) lengths_mm: (f64, f64),
    /// Touches after the first one, after the second one, and after the first one again in an older estimate.
    pub(super) one: Touches,
    pub(super) two: Touches,
    pub(super) stale: Touches,
    /// The time in which nobody touched the whisker, as text.
    pub(super) limit: Option<String>,
}

fn is_same(one: f64, other: f64) -> bool {
    (one / other - 1.0).abs() <= SAME
}

impl Divisor {
    /// Whether contact ratio × length is the same with both lengths.
    pub(super) fn follows(&self) -> bool {
        let (Touches::Ratio(one), Touches::Ratio(two)) = (self.one, self.two) else { return false };
        is_same(one * self.lengths_mm.0, two * self.lengths_mm.1)
    }

    fn before(&self) -> Touches {
        match self.first {
            First::WithoutEstimate(touches) | First::Unknown(touches) => touches,
        }
    }

    /// Whether the robot knows its lengths without estimates, so that the rules do not concern it.
    fn knows_lengths(&self) -> bool {
        let (Touches::Ratio(one), Touches::Ratio(two)) = (self.one, self.two) else { return false };
        is_same(one, two) && matches!(self.before(), Touches::Ratio(before) if is_same(before, two))
    }

    fn text(&self) -> String {
        let (one_mm, two_mm) = self.lengths_mm;
        let before = match self.first {
            First::WithoutEstimate(touches) => format!("{} before the first estimate", touches.text()),
            First::Unknown(touches) => format!("{} before", touches.text()),
        };
        format!("{before}, {} with {one_mm:.1} mm, {} with {two_mm:.1} mm", self.one.text(), self.two.text())
    }

    /// The rule about the length.
    pub(super) fn length(&self) -> Judgement {
        if let Some(limit) = &self.limit {
            return Judgement::Skip(format!("the whisker was not touched within {limit}"));
        }
        if self.one == Touches::None || self.two == Touches::None {
            return Judgement::Skip(format!("the whisker was not touched long enough: {}", self.text()));
        }
        if [self.before(), self.one, self.two].contains(&Touches::Scattered) {
            return Judgement::Skip(format!("the whisker was not touched at one place: {}", self.text()));
        }
        if self.knows_lengths() {
            return Judgement::Exempt(
                "its contact ratio does not depend on the estimate: it knows its lengths by itself. A robot that always \
                 divides by the factsheet's length would look the same, and break the rule"
                    .to_owned(),
            );
        }
        let text = self.text();
        if !self.follows() {
            return Judgement::Fail(format!("ratio × length does not stay the same: {text}"));
        }
        if matches!(self.first, First::WithoutEstimate(Touches::Ratio(_))) {
            return Judgement::Fail(format!("it divides by estimates, and sends ratios before the first one: {text}"));
        }
        Judgement::Pass(format!("ratio × length stays the same: {text}"))
    }

    /// The rule about the order.
    pub(super) fn order(&self) -> Judgement {
        match self.length() {
            skipped @ Judgement::Skip(_) => return skipped,
            exempt @ Judgement::Exempt(_) => return exempt,
            Judgement::Pass(_) | Judgement::Fail(_) => {}
        }
        let (Touches::Ratio(two), true) = (self.two, self.follows()) else {
            return Judgement::Skip(
                "the robot does not follow estimates, so that it cannot be told which one it uses".into(),
            );
        };
        let finding = format!("{} before estimates that are not newer, {} after", self.two.text(), self.stale.text());
        match self.stale {
            Touches::None => Judgement::Skip("the whisker was not touched long enough".into()),
            Touches::Scattered => Judgement::Skip("the whisker was not touched at one place".into()),
            Touches::Ratio(ratio) if is_same(ratio, two) => Judgement::Pass(finding),
            Touches::Ratio(_) | Touches::Distance(_) | Touches::Other => Judgement::Fail(finding),
        }
    }
}

#[cfg(test)]
mod tests {
    use Touches::{Distance, Ratio};

    use super::*;

    /// Touches at 42 mm of a whisker of 70 mm, which is told to be 70 and then 87.5 mm long.
    fn divisor(first: First, one: Touches, two: Touches, stale: Touches) -> Divisor {
        Divisor { first, lengths_mm: (70.0, 87.5), one, two, stale, limit: None }
    }

    fn contact(ratio: Option<f64>, distance_mm: Option<f64>) -> Contact {
        Contact {
            array: vibrissa_protocol::Name::new("left").unwrap(),
            whisker: 0,
            t_us: 0,
            ratio,
            ratio_sd: None,
            distance_mm,
            distance_sd_mm: None,
            tip: false,
            deflection_mm: 1.0,
            strain: 0.01,
            saturated: false,
            pressure_mpa: 0.1,
            temperature_c: 24.0,
            angle_deg: None,
            angle_sd_deg: None,
            test_id: None,
        }
    }

    #[test]
    fn touches_have_the_median_place_of_most_of_them() {
        let ratios = |ratios: &[f64]| ratios.iter().map(|&ratio| contact(Some(ratio), None)).collect::<Vec<_>>();
        assert_eq!(Touches::of(&ratios(&[0.6, 0.61, 0.95, 0.59, 0.6, 0.62])), Ratio(0.61));
        assert_eq!(Touches::of(&ratios(&[0.5, 0.6, 0.7, 0.8, 0.9, 1.0])), Touches::Scattered);
        let mut mixed = ratios(&[0.6]);
        mixed.extend([41.0, 42.0, 43.0].map(|mm| contact(None, Some(mm))));
        assert_eq!(Touches::of(&mixed), Distance(42.0));
        assert_eq!(Touches::of(&[contact(None, None)]), Touches::Other);
        assert_eq!(Touches::of(&[]), Touches::None);
        let scattered = divisor(First::Unknown(Ratio(0.6)), Ratio(0.6), Touches::Scattered, Touches::None);
        assert!(matches!((scattered.length(), scattered.order()), (Judgement::Skip(_), Judgement::Skip(_))));
    }

    #[test]
    fn a_robot_that_follows_passes() {
        for first in [First::WithoutEstimate(Distance(42.0)), First::Unknown(Ratio(0.6))] {
            let divisor = divisor(first, Ratio(0.61), Ratio(0.48), Ratio(0.47));
            assert!(matches!((divisor.length(), divisor.order()), (Judgement::Pass(_), Judgement::Pass(_))));
        }
    }

    #[test]
    fn a_robot_that_sends_ratios_before_the_first_estimate_or_keeps_a_length_fails() {
        let early = divisor(First::WithoutEstimate(Ratio(0.6)), Ratio(0.6), Ratio(0.48), Ratio(0.48));
        assert!(matches!((early.length(), early.order()), (Judgement::Fail(_), Judgement::Pass(_))));
        for (one, two) in [(Ratio(0.6), Ratio(0.6)), (Distance(42.0), Distance(42.0))] {
            let kept = divisor(First::WithoutEstimate(Distance(42.0)), one, two, Touches::None);
            assert!(matches!((kept.length(), kept.order()), (Judgement::Fail(_), Judgement::Skip(_))));
        }
    }

    #[test]
    fn a_robot_that_takes_older_estimates_fails_in_their_order() {
        for stale in [Ratio(0.6), Distance(42.0)] {
            let older = divisor(First::WithoutEstimate(Distance(42.0)), Ratio(0.6), Ratio(0.48), stale);
            assert!(matches!((older.length(), older.order()), (Judgement::Pass(_), Judgement::Fail(_))));
        }
    }

    #[test]
    fn a_robot_that_knows_its_lengths_is_exempt_and_one_that_is_not_touched_is_not_judged() {
        for first in [First::WithoutEstimate(Ratio(0.6)), First::Unknown(Ratio(0.61))] {
            let knows = divisor(first, Ratio(0.6), Ratio(0.59), Touches::None);
            assert!(matches!((knows.length(), knows.order()), (Judgement::Exempt(_), Judgement::Exempt(_))));
        }
        let alone = divisor(First::WithoutEstimate(Distance(42.0)), Touches::None, Touches::None, Touches::None);
        assert!(matches!((alone.length(), alone.order()), (Judgement::Skip(_), Judgement::Skip(_))));
    }
}
