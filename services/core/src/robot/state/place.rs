//! The contact ratio of a contact, from the place that the robot states.

use crate::estimation::LengthEstimate;
use crate::robot::effect::ContactUse;
use crate::robot::event::{ContactPlace, Distance};
use crate::units::ContactRatio;

/// A distance may be beyond the estimated length by this many standard deviations of both.
const BEYOND_SD: f64 = 4.0;

/// A contact at a known place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::robot) struct Placed {
    /// Contact ratio with respect to the present length, or to its estimate.
    pub ratio: ContactRatio,
    /// Its standard deviation; the configured one if it is `None`.
    pub ratio_sd: Option<f64>,
    /// Whether the sensitivity at this place depends on the length.
    pub informs_length: bool,
    /// Measured distance of the tip.
    pub tip: Option<Distance>,
}

impl Placed {
    /// The place of a contact on a whisker of this length.
    ///
    /// # Errors
    /// The use of a contact that cannot be placed.
    pub(in crate::robot) fn on(length: &LengthEstimate, place: ContactPlace) -> Result<Self, ContactUse> {
        let placed = |ratio, ratio_sd, informs_length, tip| Self { ratio, ratio_sd, informs_length, tip };
        match place {
            ContactPlace::Ratio { ratio, sd } => Ok(placed(ratio, sd, true, None)),
            ContactPlace::Tip(distance) => Ok(placed(ContactRatio::TIP, Some(0.0), true, distance)),
            ContactPlace::Distance(distance) => {
                let length_mm = length.length.mm();
                let ratio = distance.at.mm() / length_mm;
                let sd = distance.sd_mm / length_mm;
                if ratio - 1.0 > BEYOND_SD * sd.hypot(length.sd_mm / length_mm) {
                    return Err(ContactUse::BeyondTip);
                }
                let ratio = ContactRatio::new(ratio.min(1.0)).map_err(|_| ContactUse::OnChamber)?;
                Ok(placed(ratio, Some(sd), false, None))
            }
            ContactPlace::Unknown => Err(ContactUse::NoPlace),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Millimetre;

    fn on(place: ContactPlace) -> Result<Placed, ContactUse> {
        let length = LengthEstimate { length: Millimetre::known(60.0), sd_mm: 0.3 };
        Placed::on(&length, place)
    }

    fn at(mm: f64, sd_mm: f64) -> Distance {
        Distance { at: Millimetre::known(mm), sd_mm }
    }

    #[test]
    fn a_distance_is_divided_by_the_estimated_length_and_tells_nothing_of_it() {
        let placed = on(ContactPlace::Distance(at(45.0, 0.6))).unwrap();
        assert_eq!((placed.ratio.a(), placed.ratio_sd, placed.informs_length), (0.75, Some(0.01), false));
        // 1 mm beyond the tip is within the errors; 4 mm is not.
        assert_eq!(on(ContactPlace::Distance(at(61.0, 0.6))).unwrap().ratio, ContactRatio::TIP);
        assert_eq!(on(ContactPlace::Distance(at(64.0, 0.6))), Err(ContactUse::BeyondTip));
    }

    #[test]
    fn a_contact_at_the_tip_has_an_exact_ratio() {
        let placed = on(ContactPlace::Tip(Some(at(55.0, 0.5)))).unwrap();
        assert_eq!((placed.ratio, placed.ratio_sd, placed.informs_length), (ContactRatio::TIP, Some(0.0), true));
        assert_eq!(placed.tip, Some(at(55.0, 0.5)));
        assert_eq!(on(ContactPlace::Unknown), Err(ContactUse::NoPlace));
    }
}
