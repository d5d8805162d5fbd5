//! Words of the state of robots and whiskers.

use vibrissa_core::robot::effect::{AlarmKind, Condition, ContactUse, Fault};
use vibrissa_core::robot::event::{ArrayKind, GaugeState, Link};
use vibrissa_protocol::Segmenter;

use super::{Severity, Word, Words};
use crate::presence::Presence;

words! {
    Condition {
        Learning => "LEARNING" "learning" (Info),
        Healthy => "HEALTHY" "healthy" (Good),
        Suspected => "SUSPECTED" "suspected" (Warn),
        Trimmed => "TRIMMED" "trimmed" (Bad),
        Eroding => "ERODING" "eroding" (Warn),
        SensitivityLoss => "SENSITIVITY_LOSS" "less sensitive" (Warn),
    }
    Fault {
        Stale => "STALE" "silent" (Warn),
        Gauge(GaugeState::Open) => "GAUGE_OPEN" "gauge open" (Bad),
        Gauge(GaugeState::Short) => "GAUGE_SHORT" "gauge shorted" (Bad),
        Gauge(GaugeState::Saturated) => "GAUGE_SATURATED" "gauge saturated" (Bad),
        Gauge(GaugeState::Ok) => "GAUGE" "gauge faulty" (Bad),
        Leak => "LEAK" "leaking" (Bad),
        Regulator => "REGULATOR" "regulator faulty" (Bad),
        SupplyLow => "SUPPLY_LOW" "air supply low" (Bad),
    }
    Segmenter {
        Learning => "LEARNING" "contacts not found yet" (Info),
        Lost => "LOST" "rest is not known" (Warn),
        Clipped => "CLIPPED" "last touch too strong" (Info),
        Noisy => "NOISY" "noisy strain" (Warn),
        Inverted => "INVERTED" "gauge reversed" (Bad),
        Ready => "READY" "contacts found" (Good),
    }
    ContactUse {
        Learning => "LEARNING" "used to learn the whisker" (Info),
        Used => "USED" "used" (Good),
        Unsettled => "UNSETTLED" "the pressure was on its way" (Info),
        Late => "LATE" "it came after a later change was found" (Info),
        TooWeak => "TOO_WEAK" "the strain was too small" (Warn),
        NegativeStrain => "NEGATIVE_STRAIN" "the strain was negative" (Bad),
        Saturated => "SATURATED" "the strain was at the end of the gauge's range" (Warn),
        OnChamber => "ON_CHAMBER" "the touch was on the chamber" (Warn),
        NoPlace => "NO_PLACE" "the place was not known" (Warn),
        BeyondTip => "BEYOND_TIP" "the place was beyond the tip" (Warn),
        GaugeFault => "GAUGE_FAULT" "the gauge was faulty" (Bad),
        Implausible => "IMPLAUSIBLE" "no length explains the strain" (Bad),
    }
    AlarmKind {
        Uncompensated => "UNCOMPENSATED" "trimmed, not compensated",
        SetpointFailed => "SETPOINT_FAILED" "setpoints have failed",
        SensitivityLoss => "SENSITIVITY_LOSS" "sensitivity loss not explained by a cut",
        Eroding => "ERODING" "eroding",
        ArrayShift => "ARRAY_SHIFT" "shift shared by the whole array",
        BaselineDrift => "BASELINE_DRIFT" "baseline drift of the gauge",
        Proposed => "PROPOSED" "a compensation waits for approval",
        ReachLost => "REACH_LOST" "no contacts near the tip any more",
        Vented => "VENTED" "vented by the robot itself, and not filled again",
        CablesExchanged => "CABLES_EXCHANGED" "the cables of two whiskers seem to be exchanged",
        WhiskerReplaced => "WHISKER_REPLACED" "another whisker seems to be in this place",
        GaugeReversed => "GAUGE_REVERSED" "the gauge seems to have the wrong polarity",
        ModelMisfit => "MODEL_MISFIT" "the calibration does not fit this whisker any more",
        RobotSilent => "ROBOT_SILENT" "the robot is silent or not connected",
        ReceiptsUnheard => "RECEIPTS_UNHEARD" "the robot does not hear its receipts",
        DuplicateRobot => "DUPLICATE_ROBOT" "two robots use this name";
        Fault(Fault)
    }
    ArrayKind {
        Type1 => "TYPE_1" "whiskers that compensate for one another",
        Type2 => "TYPE_2" "single whiskers, each for itself",
    }
    Link {
        Online => "ONLINE",
        Offline => "OFFLINE",
        Broken => "CONNECTION_BROKEN",
    }
    Presence {
        Online => "ONLINE" "online" (Good),
        Silent => "SILENT" "connected, but silent" (Bad),
        Offline => "OFFLINE" "offline" (Off),
        Broken => "CONNECTION_BROKEN" "connection broken" (Bad),
    }
}
