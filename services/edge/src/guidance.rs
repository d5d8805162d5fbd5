//! Guidance for people about each kind of alarm: how urgent it is, what to do now, likely causes, and its runbook.
//!
//! They are declared here only. The API, the console, the order of the alarms page and the alert rules follow; tests in
//! `tests/integration/deploy/guidance.rs` compare the hand-written rules and pages.

use vibrissa_core::robot::effect::{AlarmKind, Fault};
use vibrissa_core::robot::event::GaugeState;

use crate::words::Word;

/// Path of the runbooks on a supervisor.
pub const RUNBOOKS: &str = "/runbooks";

/// How soon somebody must act, in the words of VDA 5050's `errorLevel`.
///
/// VDA 5050's level `FATAL`, which stops the vehicle, has no use here: the supervisor is not the safety function and
/// stops no robot. As severities of Prometheus' alerts the levels are `info`, `warning` and `page`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Plan for it: readings are still right, or corrected.
    Warning,
    /// Look within the working day: readings are wrong or missing.
    Urgent,
    /// Act now: a pressure is not the intended one.
    Critical,
}

impl Level {
    /// Severity of a Prometheus alert about alarms of this level.
    #[must_use]
    pub const fn prometheus(self) -> &'static str {
        match self {
            Self::Warning => "info",
            Self::Urgent => "warning",
            Self::Critical => "page",
        }
    }
}

/// Guidance about a kind of alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Guidance {
    /// How soon somebody must act.
    pub level: Level,
    /// Advice for people at once, in one or two sentences.
    pub hint: &'static str,
    /// Likely causes, the most likely first.
    pub causes: &'static [&'static str],
    /// File of the runbook in `docs/runbooks`.
    pub runbook: &'static str,
}

/// All kinds of alarms, the most urgent first: by level, then by the cost of waiting.
pub const BY_URGENCY: [AlarmKind; 24] = [
    AlarmKind::SetpointFailed,
    AlarmKind::Vented,
    AlarmKind::Uncompensated,
    AlarmKind::DuplicateRobot,
    AlarmKind::RobotSilent,
    AlarmKind::ReceiptsUnheard,
    AlarmKind::Fault(Fault::Leak),
    AlarmKind::Fault(Fault::Regulator),
    AlarmKind::Fault(Fault::SupplyLow),
    AlarmKind::Fault(Fault::Gauge(GaugeState::Open)),
    AlarmKind::Fault(Fault::Gauge(GaugeState::Short)),
    AlarmKind::Fault(Fault::Gauge(GaugeState::Saturated)),
    AlarmKind::Fault(Fault::Gauge(GaugeState::Ok)),
    AlarmKind::Fault(Fault::Stale),
    AlarmKind::CablesExchanged,
    AlarmKind::WhiskerReplaced,
    AlarmKind::GaugeReversed,
    AlarmKind::ModelMisfit,
    AlarmKind::Proposed,
    AlarmKind::ReachLost,
    AlarmKind::SensitivityLoss,
    AlarmKind::Eroding,
    AlarmKind::BaselineDrift,
    AlarmKind::ArrayShift,
];

/// Place of a kind in the order of urgency: greater is more urgent, from 1 on.
#[must_use]
pub fn urgency(kind: AlarmKind) -> usize {
    BY_URGENCY.iter().position(|one| *one == kind).map_or(0, |at| BY_URGENCY.len() - at)
}

/// The guidance about alarms of a word; `None` for a word that names no kind of alarm.
#[must_use]
pub fn of_word(word: &str) -> Option<Guidance> {
    BY_URGENCY.into_iter().find(|kind| kind.word() == word).map(of)
}

/// The guidance about a kind of alarm.
#[must_use]
pub fn of(kind: AlarmKind) -> Guidance {
    match kind {
        AlarmKind::SetpointFailed => Guidance {
            level: Level::Critical,
            hint: "Compare the whisker's pressure with its setpoint, and remove the cause. The supervisor tries again by \
                   itself after unanswered and postponed setpoints, but not after a refusal: then press Try again.",
            causes: &[
                "the robot rejected the setpoint: out of range, not ready, or its clock is wrong",
                "the regulator or the air supply cannot reach the pressure",
                "the robot did not answer in time",
            ],
            runbook: "VibrissaSetpointFailed.md",
        },
        AlarmKind::Vented => Guidance {
            level: Level::Critical,
            hint: "Look at the robot. If its chambers may be filled again, release the whisker, or all that the filters show if \
                   they name this kind; or set its pressure by hand.",
            causes: &[
                "the robot has missed the supervisor for too long, and an operator holds the whisker",
                "the regulator was faulty when the supervisor came back",
                "somebody has vented it at the robot",
            ],
            runbook: "VibrissaSetpointFailed.md",
        },
        AlarmKind::Uncompensated => Guidance {
            level: Level::Urgent,
            hint: "Do not rely on this whisker's readings. Read why each candidate was refused, then replace the whisker \
                   and mark it as replaced.",
            causes: &[
                "the cut is too large for any pressure from 0 to the limit",
                "the policy's limit of the predicted error refuses the compensation",
                "the neighbours are faulty, held, silent or still being learned",
            ],
            runbook: "VibrissaWhiskerUncompensated.md",
        },
        AlarmKind::DuplicateRobot => Guidance {
            level: Level::Urgent,
            hint: "Two robots connect under this name in turn. Switch one off, give it a name and a broker account of its \
                   own, delete its copied outbox, and start both anew. Until then nothing is learned and no setpoint is sent.",
            causes: &[
                "the second robot runs from a copy of the first one's disk or configuration",
                "a replaced computer was started again beside its successor",
                "a simulator or a test uses the name of a real robot",
            ],
            runbook: "VibrissaRobotDuplicate.md",
        },
        AlarmKind::RobotSilent => Guidance {
            level: Level::Urgent,
            hint: "Check the robot's power and network, then its connection to the broker. Nothing is known about its \
                   whiskers until it is heard again.",
            causes: &[
                "the robot is switched off or restarting",
                "its network or the path to the broker is interrupted",
                "its program has stopped sending status and contacts",
            ],
            runbook: "VibrissaRobotSilent.md",
        },
        AlarmKind::ReceiptsUnheard => Guidance {
            level: Level::Urgent,
            hint: "Let the robot's user read its topic receipt in the broker's access list. Its contacts are recorded, but it \
                   sends them again until its memory is full, and then loses new ones.",
            causes: &[
                "the broker does not let the robot's user read whisker/v1/FLEET/ROBOT/receipt",
                "the broker refuses the supervisor's publications on this topic",
                "the robot's program does not subscribe to the topic, or cannot read receipts",
            ],
            runbook: "VibrissaReceiptsUnheard.md",
        },
        AlarmKind::CablesExchanged => Guidance {
            level: Level::Urgent,
            hint: "Compare the cables of the two whiskers with this alarm. Put them right, or relearn the baseline of both if \
                   they stay so. Until then no setpoint is sent for them.",
            causes: &[
                "the cables of two gauges were exchanged during maintenance",
                "the robot's program names two channels the wrong way round",
                "one whisker was cut and another has lost sensitivity at the same time",
            ],
            runbook: "VibrissaModelMisfit.md",
        },
        AlarmKind::WhiskerReplaced => Guidance {
            level: Level::Urgent,
            hint: "If the whisker is a new one, mark it as replaced. If it is still the cut one, inspect its gauge and relearn \
                   its baseline. Until then no setpoint is sent for it.",
            causes: &[
                "somebody has put a new whisker in, and has not said so",
                "the gauge of the cut whisker has come loose by chance as much as the cut was large",
            ],
            runbook: "VibrissaModelMisfit.md",
        },
        AlarmKind::GaugeReversed => Guidance {
            level: Level::Urgent,
            hint: "Exchange the two wires of the gauge, or the sign in the robot's program. The contacts are not used until \
                   then.",
            causes: &[
                "the gauge's wires were exchanged",
                "the sign of the strain has changed in the robot's program",
                "the whisker is mounted the wrong way round",
            ],
            runbook: "VibrissaModelMisfit.md",
        },
        AlarmKind::ModelMisfit => Guidance {
            level: Level::Urgent,
            hint: "Look at the whisker, and request a touch test if the robot offers one. Mark it as replaced if it is another \
                   one, or else relearn its baseline.",
            causes: &[
                "the whisker was cut or has lost sensitivity, which its noise hides",
                "the factsheet names the wrong model or length",
                "another whisker is in its place",
                "the robot's readings of deflection or contact ratio are wrong",
            ],
            runbook: "VibrissaModelMisfit.md",
        },
        AlarmKind::Fault(fault) => of_fault(fault),
        AlarmKind::Proposed => Guidance {
            level: Level::Urgent,
            hint: "Approve or refuse the proposed compensation. Nothing is sent before, and the whisker's readings are \
                   wrong meanwhile.",
            causes: &["a whisker was cut and the policy is in mode ADVISE", "nobody has answered the proposal yet"],
            runbook: "VibrissaApprovalWaiting.md",
        },
        AlarmKind::ReachLost => Guidance {
            level: Level::Warning,
            hint: "Request a touch test or look at the whisker: it may be cut although no reading shows it.",
            causes: &[
                "the whisker is cut, and the robot divides distances by an old length",
                "the robot no longer touches anything with the whisker's tip",
            ],
            runbook: "VibrissaWhiskerWearing.md",
        },
        AlarmKind::SensitivityLoss => Guidance {
            level: Level::Warning,
            hint: "Inspect the whisker and its gauge. If the whisker is whole, relearn its baseline.",
            causes: &[
                "the gauge has come loose from the chamber",
                "the silicone has softened or torn",
                "the contact ratios that the robot reports are wrong",
            ],
            runbook: "VibrissaWhiskerWearing.md",
        },
        AlarmKind::Eroding => Guidance {
            level: Level::Warning,
            hint: "Plan the replacement: the whisker's page states how many contacts are left.",
            causes: &["normal wear", "a rough or hot surface", "a pressure or path that lets the tip scrape"],
            runbook: "VibrissaWhiskerWearing.md",
        },
        AlarmKind::BaselineDrift => Guidance {
            level: Level::Warning,
            hint: "Inspect the gauge. Relearn the baseline if the whisker is sound, or replace the whisker.",
            causes: &["the gauge's adhesive creeps", "moisture in the gauge or its wiring", "the amplifier drifts"],
            runbook: "VibrissaReadingsShifted.md",
        },
        AlarmKind::ArrayShift => Guidance {
            level: Level::Warning,
            hint: "The readings of all whiskers moved together: has the camera moved? Check also the robot's deflection \
                   scale and the temperature. The shift is taken out of the readings, so cuts are still detected.",
            causes: &[
                "the camera that tells the contact ratios has moved",
                "the temperature of the silicone has changed",
                "the robot's scale of the deflection has changed, such as after a calibration",
            ],
            runbook: "VibrissaReadingsShifted.md",
        },
    }
}

fn of_fault(fault: Fault) -> Guidance {
    let (hint, causes): (_, &'static [&'static str]) = match fault {
        Fault::Stale => {
            return Guidance {
                level: Level::Urgent,
                hint: "Check this whisker's wiring and its entry in the robot's factsheet: the robot's other whiskers \
                       are heard.",
                causes: &[
                    "the robot has stopped reporting this whisker",
                    "its cable or amplifier has failed",
                    "the factsheet names a whisker that is not on the robot",
                ],
                runbook: "WhiskerUnheard.md",
            };
        }
        Fault::Leak => (
            "Look for the leak at the chamber, tube and fitting. Do not rely on the whisker until its pressure holds.",
            &["the chamber is torn or cut", "a tube or fitting is loose", "the regulator's valve does not close"],
        ),
        Fault::Regulator => (
            "Check the regulator of this whisker's chamber: it reports a fault, and its pressure is not known to be held.",
            &["the regulator or its valve is broken", "its supply voltage or bus has failed"],
        ),
        Fault::SupplyLow => (
            "Restore the robot's air supply. Whiskers keep their present pressure and cannot be raised until then.",
            &["the compressor or pump is off", "a tank or bottle is empty", "a leak elsewhere drains the supply"],
        ),
        Fault::Gauge(GaugeState::Open) => (
            "Check the gauge's cable and solder joints. The whisker's readings are not used.",
            &["a wire is broken", "the gauge is torn"],
        ),
        Fault::Gauge(GaugeState::Short) => (
            "Check the gauge's cable for crushed insulation and moisture. The whisker's readings are not used.",
            &["the insulation is damaged", "moisture in the connector"],
        ),
        Fault::Gauge(GaugeState::Saturated) => (
            "Check whether the whisker is bent or blocked, then the amplifier's range. The whisker's readings are not used.",
            &["the whisker is bent beyond the gauge's range", "the amplifier's gain or offset is wrong"],
        ),
        Fault::Gauge(GaugeState::Ok) => (
            "Check the gauge and its amplifier. The whisker's readings are not used.",
            &["the gauge has come loose", "the amplifier is faulty"],
        ),
    };
    Guidance { level: Level::Urgent, hint, causes, runbook: "VibrissaWhiskerFault.md" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Words;

    #[test]
    fn the_order_has_each_kind_once_and_follows_the_levels() {
        let mut kinds: Vec<&str> = BY_URGENCY.iter().map(|kind| kind.word()).collect();
        let mut all: Vec<&str> = AlarmKind::all().into_iter().map(Word::word).collect();
        kinds.sort_unstable();
        all.sort_unstable();
        assert_eq!(kinds, all);
        assert!(BY_URGENCY.windows(2).all(|two| of(two[0]).level >= of(two[1]).level));
        assert!(urgency(AlarmKind::Uncompensated) > urgency(AlarmKind::Fault(Fault::Leak)));
        assert!(urgency(AlarmKind::Fault(Fault::Stale)) > urgency(AlarmKind::Eroding));
    }

    #[test]
    fn each_kind_says_what_to_do_and_why_it_may_have_happened() {
        for kind in BY_URGENCY {
            let Guidance { hint, causes, .. } = of(kind);
            assert!(hint.ends_with('.') && !hint.contains("  "), "{}: {hint}", kind.word());
            assert!(causes.len() >= 2 && causes.iter().all(|cause| !cause.ends_with('.')), "{}", kind.word());
        }
    }
}
