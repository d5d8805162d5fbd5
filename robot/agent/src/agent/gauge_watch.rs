//! Faults of a gauge's wiring and amplifier, seen in its strains: a reversed polarity, and an end of the scale.
//!
//! **Polarity.** A touch stretches the gauge, or moves its strain the way that `segmenter.sign` states. If the last contacts
//! go the other way, all but a few, its wires are swapped, and the supervisor can use none of them.
//!
//! **End of the scale.** Where the amplifier or the converter ends, samples have one and the same value, the highest or
//! lowest of all, while the deflection goes on. Such a strain is too small for its deflection, as that of a cut
//! whisker.

/// Contacts that decide about the polarity.
const CONTACTS: u32 = 20;
/// Of these so many must go the other way.
const OTHERS: u32 = 19;
/// Way during which an unchanged strain is the end of the scale, in mm: a converter of 10 bits sees a hundredth of it.
const WAY_MM: f64 = 0.2;
/// Samples of it: of a fast slide the last sample before a slip-off and the first one after it may be the same.
const SAMPLES: u32 = 3;
/// Least difference of that strain from rest: there a strain does not change either, in m/m.
const LEAST: f64 = 5e-4;
/// Contacts below the end of the scale after which it counts no more.
const CLEAN: u8 = 10;

/// Something that a person must correct at the gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Finding {
    /// Touches go the other way.
    Reversed,
    /// Strains end at this value.
    Clipped(f64),
}

/// Samples with one value.
#[derive(Debug, Clone, Copy)]
struct Run {
    strain: f64,
    /// Deflection at its begin.
    from_mm: f64,
    samples: u32,
}

impl Run {
    /// Whether the deflection has gone on meanwhile.
    fn has_gone_on(&self, deflection_mm: f64) -> bool {
        self.samples >= SAMPLES && (deflection_mm - self.from_mm).abs() >= WAY_MM
    }
}

/// The strains of one gauge.
#[derive(Debug, Default)]
pub(super) struct GaugeWatch {
    /// The last contacts, a bit for each that goes the other way, and their number.
    others: u32,
    contacts: u32,
    is_reversed: bool,
    before: Option<f64>,
    lowest: f64,
    highest: f64,
    run: Option<Run>,
    /// The end of the scale.
    end: Option<f64>,
    /// A sample since the last contact was there.
    at_end: bool,
    /// Contacts in sequence that were not.
    clean: u8,
}

impl GaugeWatch {
    /// Takes the strain of a contact that is sent: positive if it goes the right way.
    pub(super) fn contact(&mut self, strain: f64) -> Option<Finding> {
        self.others = self.others << 1 | u32::from(strain < 0.0);
        self.contacts = (self.contacts + 1).min(CONTACTS);
        let others = (self.others & ((1 << CONTACTS) - 1)).count_ones();
        let was_reversed = self.is_reversed;
        self.is_reversed = self.contacts == CONTACTS && others >= OTHERS;
        (self.is_reversed && !was_reversed).then_some(Finding::Reversed)
    }

    /// Takes a sample, and the strain to which contacts are relative. Until that is known, no end of the scale is.
    pub(super) fn sample(&mut self, strain: f64, deflection_mm: Option<f64>, rest: Option<f64>) -> Option<Finding> {
        if !strain.is_finite() {
            return None;
        }
        let before = self.before.replace(strain);
        let Some(before) = before else {
            (self.lowest, self.highest) = (strain, strain);
            return None;
        };
        // A single wrong sample of a cheap converter is no extreme.
        let (lower, higher) = (before.max(strain), before.min(strain));
        let is_beyond = lower < self.lowest || higher > self.highest;
        (self.lowest, self.highest) = (self.lowest.min(lower), self.highest.max(higher));
        let rest = rest?;
        if is_beyond && self.end.is_some_and(|end| (strain > rest) == (end > rest)) {
            // The scale goes on.
            self.end = None;
        }
        self.at_end |= self.end == Some(strain);
        let deflection_mm = deflection_mm?;
        match &mut self.run {
            Some(run) if run.strain == strain => {
                run.samples = run.samples.saturating_add(1);
                let is_extreme = strain == self.lowest || strain == self.highest;
                let is_end = is_extreme && (strain - rest).abs() >= LEAST && run.has_gone_on(deflection_mm);
                if !is_end || self.end == Some(strain) {
                    return None;
                }
                (self.end, self.at_end, self.clean) = (Some(strain), true, 0);
                Some(Finding::Clipped(strain))
            }
            Some(_) | None => {
                self.run = Some(Run { strain, from_mm: deflection_mm, samples: 1 });
                None
            }
        }
    }

    /// A contact has ended; whether its strain was at the end of the scale.
    pub(super) fn ended(&mut self) -> bool {
        if std::mem::take(&mut self.at_end) {
            self.clean = 0;
            return true;
        }
        self.clean = self.clean.saturating_add(1);
        if self.clean >= CLEAN {
            self.end = None;
        }
        false
    }

    /// Whether the scale is known to end at this strain.
    pub(super) fn is_end(&self, strain: f64) -> bool {
        self.end == Some(strain)
    }

    /// Whether the strains end below the deflections of the whisker.
    pub(super) fn is_clipped(&self) -> bool {
        self.end.is_some()
    }

    /// Whether touches go the other way.
    pub(super) fn is_reversed(&self) -> bool {
        self.is_reversed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of touches up to this deflection, 0.02 mm apart, with the grain of a converter of 10 bits.
    fn touches(watch: &mut GaugeWatch, most_mm: f64, end: f64, count: usize) -> Vec<Finding> {
        let mut found = Vec::new();
        let steps = (most_mm / 0.02) as usize;
        for _ in 0..count {
            // A way through the air, a touch, and the way back.
            for step in (0..50 + steps).chain((0..50 + steps).rev()) {
                let way_mm = step as f64 * 0.02;
                let strain = ((way_mm - 1.0).max(0.0) * 0.0046 / 1e-5).round() * 1e-5;
                found.extend(watch.sample(strain.min(end), Some(way_mm), Some(0.0)));
            }
            watch.ended();
        }
        found
    }

    #[test]
    fn the_end_of_a_scale_is_found_by_the_motion() {
        let mut watch = GaugeWatch::default();
        assert_eq!(touches(&mut watch, 1.0, 0.005, 5), [], "below the end of the scale");
        assert_eq!(touches(&mut watch, 3.0, 0.005, 1), [Finding::Clipped(0.005)]);
        assert!(watch.is_clipped());
        assert_eq!(touches(&mut watch, 3.0, 0.005, 3), [], "it is told once");
        touches(&mut watch, 1.0, 0.005, 10);
        assert!(!watch.is_clipped(), "softer touches are all right");
    }

    #[test]
    fn a_slip_off_between_two_equal_samples_of_a_fast_slide_is_no_end() {
        let mut watch = GaugeWatch::default();
        for (way_mm, strain) in [(1.0, 0.0), (1.2, 0.0), (2.0, 0.0092), (2.2, 0.0101), (2.4, 0.0101), (2.6, 0.0)] {
            assert_eq!(watch.sample(strain, Some(way_mm), Some(0.0)), None);
        }
    }

    #[test]
    fn a_strain_beyond_it_shows_that_the_scale_goes_on() {
        let mut watch = GaugeWatch::default();
        touches(&mut watch, 3.0, 0.005, 1);
        watch.sample(0.006, Some(2.0), Some(0.0));
        assert!(watch.is_clipped(), "one sample may be wrong");
        watch.sample(0.006, Some(2.0), Some(0.0));
        assert!(!watch.is_clipped());
    }

    #[test]
    fn a_polarity_is_reversed_if_nearly_all_touches_go_the_other_way() {
        let mut watch = GaugeWatch::default();
        // A whisker that is swept to both sides.
        assert!((0..100).all(|at| watch.contact(if at % 2 == 0 { -0.01 } else { 0.01 }).is_none()));
        let found: Vec<_> = (0..40).filter_map(|_| watch.contact(-0.01)).collect();
        assert_eq!(found, [Finding::Reversed]);
        assert!(watch.is_reversed());
        watch.contact(0.01);
        watch.contact(0.01);
        assert!(!watch.is_reversed());
    }
}
