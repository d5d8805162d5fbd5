//! The row of a policy that an operator has set.

use vibrissa_core::policy::PolicyParams;
use vibrissa_core::policy_numbers;
use vibrissa_edge::words::Word as _;

use crate::row::row;

/// Who set a policy, when and why.
#[derive(Debug, Clone)]
pub struct PolicyChanged {
    /// Name of the fleet.
    pub fleet: String,
    /// Version of the fleet's policy, from 1.
    pub version: i64,
    /// Time at which it was set, µs since 1970 UTC by the supervisor's clock.
    pub changed_us: i64,
    /// Person or token that set it.
    pub changed_by: String,
    /// Reason that the person gave.
    pub reason: Option<String>,
    /// Number of the action that set it.
    pub action_id: i64,
}

macro_rules! policy {
    ([$($name:ident {
        key: $key:tt, default: $default:tt, min: $min:tt, max: $max:tt, unit: $unit:tt, title: $title:tt, doc: $doc:tt,
    })+]) => {
        row! {
            /// A policy that an operator has set; docs/schema.md documents the columns.
            pub struct PolicyRow {
                /// Name of the fleet.
                pub fleet: String,
                /// Version of the fleet's policy, from 1.
                pub version: i64,
                /// `AUTOMATIC`: compensations start without approval; `ADVISE`: each waits for approval.
                pub mode: &'static str,
                /// Quantity that a setpoint is solved for: `TIP` or `MEAN`.
                pub objective: &'static str,
                /// Whether a longer whisker may compensate for a shorter one: `NEVER`, `LAST_RESORT` or `ALLOWED`.
                pub longer_for_shorter: &'static str,
                $(#[doc = $doc] pub $name: f64,)+
                /// Time at which it was set, µs since 1970 UTC by the supervisor's clock.
                pub changed_us: i64,
                /// Person or token that set it.
                pub changed_by: String,
                /// Reason that the person gave.
                pub reason: Option<String>,
                /// Number of the action that set it.
                pub action_id: i64,
            }
        }

        impl PolicyRow {
            /// The row of a policy that was set.
            #[must_use]
            pub fn new(policy: &PolicyParams, changed: PolicyChanged) -> Self {
                Self {
                    fleet: changed.fleet,
                    version: changed.version,
                    mode: policy.mode.word(),
                    objective: policy.objective.word(),
                    longer_for_shorter: policy.longer_for_shorter.word(),
                    $($name: policy.$name,)+
                    changed_us: changed.changed_us,
                    changed_by: changed.changed_by,
                    reason: changed.reason,
                    action_id: changed.action_id,
                }
            }
        }
    };
}
policy_numbers!(policy);
