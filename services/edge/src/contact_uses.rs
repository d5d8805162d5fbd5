//! Remedies for contacts that are not used, and for segmenters that find none.

use vibrissa_core::robot::effect::ContactUse;
use vibrissa_protocol::Segmenter;

/// Advice for people about a contact that was not used; `None` if it was used.
#[must_use]
pub const fn remedy(used: ContactUse) -> Option<&'static str> {
    Some(match used {
        ContactUse::Learning | ContactUse::Used => return None,
        ContactUse::Unsettled => {
            "Nothing to do while a pressure changes. If it lasts, check the regulator, and that at_setpoint is sent."
        }
        ContactUse::Late => {
            "Nothing to do after an interruption. If it lasts, check the robot's clock and its way to the broker."
        }
        ContactUse::TooWeak => {
            "Touch with more deflection. If it lasts, check the gain of the gauge's amplifier, and that the strain is in m/m \
             and not in microstrain or volts."
        }
        ContactUse::NegativeStrain => {
            "Exchange the two signal wires of the gauge, or change the sign of its gain in the driver. A touch must give a \
             positive strain."
        }
        ContactUse::Saturated => {
            "Touch with less deflection, or amplify the gauge less: beyond the end of its range the strain is too small for \
             the deflection."
        }
        ContactUse::OnChamber => {
            "Touch nearer the tip: the model holds beyond the chamber. If the touch was nearer the tip, check the zero of the \
             place and its unit, mm."
        }
        ContactUse::NoPlace => {
            "Send contact_ratio or distance_mm with each contact, or let the robot offer touch tests."
        }
        ContactUse::BeyondTip => {
            "Check the zero and the unit of distance_mm. If they are right, check the whisker's length in the factsheet."
        }
        ContactUse::GaugeFault => "Mend the gauge or its wires. The whisker's alarm names the fault.",
        ContactUse::Implausible => {
            "Check the units (deflection in mm, strain in m/m, pressure in MPa), the calibration of the whisker, and that the \
             gauge belongs to this whisker."
        }
    })
}

/// Advice for people about a segmenter; `None` if it finds contacts.
#[must_use]
pub const fn segmenter_remedy(segmenter: Segmenter) -> Option<&'static str> {
    Some(match segmenter {
        Segmenter::Ready => return None,
        Segmenter::Learning => {
            "Leave the whisker alone for a second, then touch and release it some times. If it lasts, send at least 10 \
             samples of strain a second, and deflection_mm with them."
        }
        Segmenter::Lost => {
            "Release the whisker, then touch it again. If it lasts, send deflection_mm with the samples."
        }
        Segmenter::Clipped => {
            "Touch with less deflection, or amplify the gauge less: the last strain was a lower bound."
        }
        Segmenter::Noisy => "Check the wires and the supply of the converter: only strong touches are found.",
        Segmenter::Inverted => {
            "Exchange the two signal wires of the gauge, or set the sign of the segmenter in the agent's file."
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Words;

    #[test]
    fn every_segmenter_that_does_not_find_contacts_has_a_remedy() {
        for segmenter in Segmenter::all() {
            assert_eq!(segmenter_remedy(segmenter).is_none(), segmenter == Segmenter::Ready, "{segmenter}");
        }
    }

    #[test]
    fn every_contact_that_is_not_used_has_a_remedy() {
        for used in ContactUse::all() {
            let is_used = matches!(used, ContactUse::Learning | ContactUse::Used);
            assert_eq!(remedy(used).is_none(), is_used, "{used:?}");
            assert!(used.label().is_some(), "{used:?}");
        }
    }
}
