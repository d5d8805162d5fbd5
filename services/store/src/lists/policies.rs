//! The policies that operators have set.

use serde::Serialize;
use utoipa::ToSchema;
use vibrissa_core::policy::PolicyParams;
use vibrissa_core::policy_numbers;
use vibrissa_edge::words::Word as _;

use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

macro_rules! policy {
    ([$($name:ident {
        key: $key:tt, default: $default:tt, min: $min:tt, max: $max:tt, unit: $unit:tt, title: $title:tt, doc: $doc:tt,
    })+]) => {
        from_row! {
            /// A policy: the rules by which a fleet's compensations are decided.
            #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
            #[schema(as = Policy)]
            pub struct PolicyRow {
                /// Name of the fleet.
                pub fleet: String,
                /// Version of the fleet's policy, from 1; 0 is the policy of the configuration.
                pub version: i64,
                /// `AUTOMATIC`: compensations start without approval; `ADVISE`: each waits for an operator's approval.
                pub mode: String,
                /// Quantity that a setpoint is solved for: `TIP` (equal sensitivity at the tip) or `MEAN` (least mean
                /// error).
                pub objective: String,
                /// Whether a longer whisker may compensate for a shorter one: `NEVER`, `LAST_RESORT` or `ALLOWED`.
                pub longer_for_shorter: String,
                $(#[doc = $doc] pub $name: f64,)+
                /// Time at which this version was set; null for the policy of the configuration.
                pub changed_at: Option<Time>,
                /// Person or token that set this version; null for the policy of the configuration.
                pub changed_by: Option<String>,
                /// Reason that the person gave; null if none was given.
                pub reason: Option<String>,
            }
        }

        impl PolicyRow {
            /// The policy of the configuration, which is in force until an operator sets another one.
            #[must_use]
            pub fn configured(fleet: String, policy: &PolicyParams) -> Self {
                Self {
                    fleet,
                    version: 0,
                    mode: policy.mode.word().to_owned(),
                    objective: policy.objective.word().to_owned(),
                    longer_for_shorter: policy.longer_for_shorter.word().to_owned(),
                    $($name: policy.$name,)+
                    changed_at: None,
                    changed_by: None,
                    reason: None,
                }
            }
        }

        const SELECT: &str = concat!(
            "SELECT fleet, version, mode, objective, longer_for_shorter, ",
            $(stringify!($name), ", ",)+
            "changed_us AS changed_at, changed_by, reason FROM policies"
        );
    };
}
policy_numbers!(policy);

sorts! {
    /// Sort keys of a fleet's policies.
    pub enum PolicySort {
        /// By version, which is the order in which they came into force.
        Version = "version" Whole Down,
    }
}

/// The policies that operators have set, in all versions.
pub static POLICIES: List =
    List { what: "list the policies", select: SELECT, details: "", keys: &[], sorts: PolicySort::SORTS, id: "version" };
