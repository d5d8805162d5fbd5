//! Places of contacts as a robot knows them: the ratio to the present length, which few robots can know, or less.

use serde::Deserialize;
use vibrissa_protocol::{Contact, PlaceKind};

/// Place that a robot states with each contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Places {
    /// Contact distance / present length, as a robot with a camera knows it.
    #[default]
    Ratio,
    /// Contact distance / factory length, which the robot wrongly calls the contact ratio.
    FactoryRatio,
    /// Contact distance / length of the supervisor's newest estimate. Until the first estimate, and for contacts beyond that
    /// length, the distance.
    EstimatedRatio,
    /// Distance from the base.
    Distance,
    /// Each contact is at the tip.
    Tip,
    /// Each contact is at the tip, and its distance from the base is measured.
    TipDistance,
    /// None.
    Unknown,
}

impl Places {
    /// True contact ratio of a touch, from a random number between the least contact ratio and 1: objects stand at random
    /// ratios of the present length, at random distances, or at the tip. `None` if the object is beyond the tip.
    pub(crate) fn ratio(self, drawn: f64, length_mm: f64, whole_length_mm: f64) -> Option<f64> {
        let ratio = match self {
            Self::Ratio | Self::Unknown => drawn,
            Self::FactoryRatio | Self::EstimatedRatio | Self::Distance => drawn * whole_length_mm / length_mm,
            Self::Tip | Self::TipDistance => 1.0,
        };
        (ratio <= 1.0).then_some(ratio)
    }

    /// Kind of the place, as the factsheet states it.
    pub(crate) fn kind(self) -> PlaceKind {
        match self {
            Self::Ratio | Self::FactoryRatio | Self::EstimatedRatio => PlaceKind::Ratio,
            Self::Distance => PlaceKind::Distance,
            Self::Tip | Self::TipDistance => PlaceKind::Tip,
            Self::Unknown => PlaceKind::Unknown,
        }
    }

    /// States the place of a touch in its contact. `estimated_mm` is the length of the supervisor's newest estimate.
    pub(crate) fn state(self, contact: &mut Contact, touch: &Touch, estimated_mm: Option<f64>) {
        let distance_mm = (touch.ratio + touch.ratio_error) * touch.length_mm;
        let ratio = |ratio: f64| Some(rounded(ratio).clamp(0.01, 1.0));
        let sd_mm = (touch.ratio_sd * touch.whole_length_mm).max(0.01);
        let distance = || (Some(rounded(distance_mm).max(0.1)), Some(rounded(sd_mm)));
        match self {
            Self::Ratio => contact.ratio = ratio(touch.ratio + touch.ratio_error),
            Self::FactoryRatio => contact.ratio = ratio(distance_mm / touch.whole_length_mm),
            Self::EstimatedRatio => match estimated_mm.filter(|&length_mm| distance_mm <= length_mm) {
                Some(length_mm) => contact.ratio = ratio(distance_mm / length_mm),
                None => (contact.distance_mm, contact.distance_sd_mm) = distance(),
            },
            Self::Distance => (contact.distance_mm, contact.distance_sd_mm) = distance(),
            Self::Tip => contact.tip = true,
            Self::TipDistance => {
                contact.tip = true;
                (contact.distance_mm, contact.distance_sd_mm) = distance();
            }
            Self::Unknown => {}
        }
    }
}

/// Where a whisker was touched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touch {
    /// True contact ratio.
    pub(crate) ratio: f64,
    /// Error of the measured ratio, and its standard deviation.
    pub(crate) ratio_error: f64,
    pub(crate) ratio_sd: f64,
    /// Present length, mm.
    pub(crate) length_mm: f64,
    /// Length at installation, mm.
    pub(crate) whole_length_mm: f64,
}

fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
