//! Remedies for contacts that are not used.

use vibrissa_core::robot::effect::ContactUse;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Words;

    #[test]
    fn every_contact_that_is_not_used_has_a_remedy() {
        for used in ContactUse::all() {
            let is_used = matches!(used, ContactUse::Learning | ContactUse::Used);
            assert_eq!(remedy(used).is_none(), is_used, "{used:?}");
            assert!(used.label().is_some(), "{used:?}");
        }
    }
}
