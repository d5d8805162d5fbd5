//! Supervision of a gauge by its contacts and the robot's status.
//!
//! A gauge without current drives its amplifier to the end of the scale: the same strain every time, far above what
//! the contact should give, or below zero. A shorted one reads next to nothing. A saturated one reads one strain
//! wherever the contact should give more: its ceiling. None of them can come from a cut, which multiplies every
//! strain by the same factor.
//!
//! A ceiling that only strong contacts reach is found like one that all of them reach: no two contacts of a gauge in
//! order read the same strain to six digits, and a strain above it shows that it is no ceiling. Contacts at a
//! suspected ceiling, and all while the gauge is out of order, say nothing about the length.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::estimation::Innovation;
use crate::estimation::filter::Observation;
use crate::robot::event::GaugeState;

/// Strains that differ by less than this part of themselves are the same.
const SAME: f64 = 1e-6;
/// A strain this much above a level shows that the level is no ceiling.
const ABOVE: f64 = 1.001;
/// Deflections that differ by this, or contact ratios by `OTHER_RATIO`, are different contacts.
const OTHER_DEFLECTION: f64 = 0.1;
const OTHER_RATIO: f64 = 0.05;
/// Less than this part of what a contact should give is next to nothing.
const DEAD: f64 = 0.1;
/// A strain below zero by no more than this is next to nothing, too; below that is the other end of the scale.
const NEXT_TO_NOTHING: f64 = 0.01;
/// More than this many times what a contact should give, again and again the same: the end of the scale.
const END_OF_SCALE: f64 = 1.5;
/// A strain this many standard deviations below the prediction may be a ceiling.
const SHORT_OF: f64 = -1.0;
/// Strains above a ceiling that show that it is gone.
const STRAINS_ABOVE: u8 = 2;

/// The state of one gauge's supervision.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct GaugeWatch {
    /// State reported by the robot.
    pub reported: GaugeState,
    /// State shown by the contacts.
    pub observed: GaugeState,
    /// Contacts in a row with next to no strain.
    dead: u8,
    /// Contacts in a row that a gauge in order may give.
    plausible: u8,
    level: Option<Level>,
}

/// A strain that comes again.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
struct Level {
    strain: f32,
    deflection_mm: f32,
    ratio: f32,
    /// How often it came again from another contact, ...
    repeats: u8,
    /// ... and how often of these it was far above what the contact should give.
    far_above: u8,
    /// Strains above it since it is called a ceiling.
    above: u8,
}

crate::optional_parts::optional_fields!(GaugeWatch: reported, observed;
    dead: *dead > 0,
    plausible: *plausible > 0,
    level: level.is_some(),
);

/// Class of one contact's strain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum StrainClass {
    /// Next to no strain.
    Dead,
    /// At the level, from another contact.
    Repeated,
    /// Above the level: it is no ceiling.
    Above,
    /// As a gauge in order reads.
    Plain,
    /// The same contact once more, or too weak to tell.
    Unclear,
}

impl GaugeWatch {
    /// Takes one contact in; true if its strain is not to be used. `contacts` bad ones make a fault, twice as many
    /// good ones end it. `is_negative` if the contact should give a plain strain, and gives one below zero.
    pub(in crate::robot) fn watch(
        &mut self,
        contact: &Observation,
        seen: Option<&Innovation>,
        is_negative: bool,
        contacts: u8,
    ) -> bool {
        let expected = seen.map(|seen| seen.predicted_sensitivity_per_mm * contact.deflection_mm);
        let reading = self.reading(contact, expected, is_negative);
        match reading {
            StrainClass::Dead => (self.dead, self.plausible) = (self.dead.saturating_add(1), 0),
            StrainClass::Repeated => (self.dead, self.plausible) = (0, 0),
            StrainClass::Above | StrainClass::Plain => {
                (self.dead, self.plausible) = (0, self.plausible.saturating_add(1))
            }
            StrainClass::Unclear => {}
        }
        let far_above = expected.is_some_and(|expected| contact.strain > END_OF_SCALE * expected)
            || contact.strain < -NEXT_TO_NOTHING;
        self.follow_level(reading, far_above);
        let may_be_ceiling = far_above || seen.is_some_and(|seen| seen.alone.standardised < SHORT_OF);
        if may_be_ceiling && reading != StrainClass::Dead && self.level.is_none_or(|level| level.repeats == 0) {
            self.level = Some(Level::new(contact));
        }
        self.conclude(contacts);
        !matches!(reading, StrainClass::Above | StrainClass::Plain) || self.state() != GaugeState::Ok
    }

    fn reading(&self, contact: &Observation, expected: Option<f64>, is_negative: bool) -> StrainClass {
        let strain = contact.strain;
        if let Some(level) = &self.level {
            let at = f64::from(level.strain);
            if (strain - at).abs() <= SAME * at.abs() {
                return if level.is_another(contact) { StrainClass::Repeated } else { StrainClass::Unclear };
            }
            if strain > 0.0 && strain > ABOVE * at {
                return StrainClass::Above;
            }
        }
        match expected {
            Some(expected) if strain.abs() < DEAD * expected => StrainClass::Dead,
            Some(_) => StrainClass::Plain,
            None if strain > 0.0 => StrainClass::Unclear,
            None if strain >= -NEXT_TO_NOTHING && !is_negative => StrainClass::Dead,
            None => StrainClass::Plain,
        }
    }

    /// Counts how often the level came again; a strain above it ends it, unless a fault rests on it.
    fn follow_level(&mut self, reading: StrainClass, far_above: bool) {
        let Some(level) = &mut self.level else { return };
        match reading {
            StrainClass::Repeated => {
                level.repeats = level.repeats.saturating_add(1);
                level.far_above = level.far_above.saturating_add(u8::from(far_above));
            }
            StrainClass::Above if self.observed == GaugeState::Ok => self.level = None,
            StrainClass::Above => level.above = level.above.saturating_add(1),
            StrainClass::Dead | StrainClass::Plain | StrainClass::Unclear => {}
        }
    }

    fn conclude(&mut self, contacts: u8) {
        let level = self.level.filter(|level| level.repeats >= contacts.saturating_sub(1));
        let recovered = self.plausible >= contacts.saturating_mul(2);
        self.observed = match (self.observed, level) {
            (_, _) if self.dead >= contacts => GaugeState::Short,
            (GaugeState::Ok | GaugeState::Short, Some(level)) if level.far_above == level.repeats => GaugeState::Open,
            (GaugeState::Ok | GaugeState::Short, Some(_)) => GaugeState::Saturated,
            (GaugeState::Short | GaugeState::Open, _) if recovered => self.recover(),
            (GaugeState::Saturated, Some(level)) if level.above >= STRAINS_ABOVE => self.recover(),
            (as_before, _) => as_before,
        };
    }

    fn recover(&mut self) -> GaugeState {
        self.level = None;
        GaugeState::Ok
    }

    /// The state reported by the robot, or else the one shown by the contacts.
    pub(in crate::robot) fn state(&self) -> GaugeState {
        if self.reported == GaugeState::Ok { self.observed } else { self.reported }
    }
}

impl Level {
    fn new(contact: &Observation) -> Self {
        Self {
            strain: contact.strain as f32,
            deflection_mm: contact.deflection_mm as f32,
            ratio: contact.place.ratio.a() as f32,
            repeats: 0,
            far_above: 0,
            above: 0,
        }
    }

    fn is_another(&self, contact: &Observation) -> bool {
        (contact.deflection_mm / f64::from(self.deflection_mm) - 1.0).abs() > OTHER_DEFLECTION
            || (contact.place.ratio.a() - f64::from(self.ratio)).abs() > OTHER_RATIO
    }
}
