//! The settings of the policy. Its numbers are declared once, in [`policy_numbers!`](crate::policy_numbers).

use crate::mechanics::Objective;

/// Whether case 2 is used. The paper measured an error of 36.2 % for it, against 20.4 % for case 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LongerForShorter {
    /// Case 2 is never used.
    Never,
    /// Only for a whisker that case 1 cannot serve.
    #[default]
    LastResort,
    /// Treated like case 1: only the predicted error counts.
    Allowed,
}

/// Who starts a compensation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// The supervisor: each decision takes effect at once.
    #[default]
    Automatic,
    /// An operator: a decision is a proposal, and no setpoint is sent before its approval. An approved compensation
    /// is refined without another approval. A better assignment does not end it; only a broken precondition does.
    Advise,
}

/// Declares the numbers of the policy, and passes the declaration in brackets to another macro, followed by the
/// other macro's own tokens: `policy_numbers!(other more)` is `other!([declaration] more)`.
///
/// The name of a number is its field in [`PolicyParams`](crate::policy::PolicyParams), its key under `policy.` in the
/// configuration, its field in JSON, and its column in the table `policies`. All of these, the checks of its range,
/// the OpenAPI document and the form of the console derive from this declaration. By hand remain: the code that uses
/// the number, the column (a migration for each database, with a default for the versions of before), and the format
/// version of a stored batch, which contains a policy's numbers in the order of this list: a new one goes to its end.
///
/// `key` names the number among the configuration's keys; `min` and `max` are included in the range; `unit` is "ratio"
/// for what people read in percent; `title` is its label for people; `doc` explains it, with the unit, in one
/// sentence.
#[macro_export]
macro_rules! policy_numbers {
    ($callback:ident $($more:tt)*) => {
        $callback! {
            [
                predicted_error_max {
                    key: PolicyPredictedErrorMax,
                    default: 0.5, min: 0.0, max: 10.0, unit: "ratio",
                    title: "Maximum predicted error",
                    doc: "Maximum mean predicted error of a compensation, as a ratio.",
                }
                own_role_cost {
                    key: PolicyOwnRoleCost,
                    default: 0.25, min: 0.0, max: 10.0, unit: "mean error",
                    title: "Penalty for using a neighbour",
                    doc: "Cost of a neighbour that gives up its own role, in units of mean error: the trimmed whisker \
                          itself is preferred unless a neighbour is better by more.",
                }
                change_margin {
                    key: PolicyChangeMargin,
                    default: 0.1, min: 0.0, max: 10.0, unit: "mean error",
                    title: "Change only if better by",
                    doc: "Minimum gain for changing an active assignment, in units of mean error, for each whisker \
                          that changes.",
                }
            ]
            $($more)*
        }
    };
}

/// A number of the policy, as [`policy_numbers!`](crate::policy_numbers) declares it.
#[derive(Debug, Clone, Copy)]
pub struct PolicyNumber {
    /// Name in the configuration, in JSON and in the database.
    pub name: &'static str,
    /// Lowest allowed value.
    pub min: f64,
    /// Highest allowed value.
    pub max: f64,
    /// The value in a policy.
    pub of: fn(&PolicyParams) -> f64,
    /// The place of the value in a policy.
    pub of_mut: fn(&mut PolicyParams) -> &mut f64,
}

macro_rules! params {
    ([$($name:ident {
        key: $key:tt, default: $default:tt, min: $min:tt, max: $max:tt, unit: $unit:tt, title: $title:tt, doc: $doc:tt,
    })+]) => {
        /// Parameters of the policy.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct PolicyParams {
            /// Who starts a compensation. Open proposals stay proposals when this becomes automatic.
            pub mode: Mode,
            /// Quantity that the setpoint solver matches. [`Objective::Shape`] is for robots that apply gains; the others
            /// then get the paper's, [`Objective::Tip`].
            pub objective: Objective,
            /// When a longer whisker may compensate for a shorter one.
            pub longer_for_shorter: LongerForShorter,
            $(#[doc = $doc] pub $name: f64,)+
        }

        impl Default for PolicyParams {
            fn default() -> Self {
                Self {
                    mode: Mode::default(),
                    objective: Objective::Shape,
                    longer_for_shorter: LongerForShorter::default(),
                    $($name: $default,)+
                }
            }
        }

        impl PolicyParams {
            /// The objective for a robot, by whether it multiplies its readings by a gain.
            #[must_use]
            pub fn objective_for(&self, applies_gain: bool) -> Objective {
                match self.objective {
                    Objective::Shape if !applies_gain => Objective::Tip,
                    objective => objective,
                }
            }

            /// The numbers of a policy, in the order of their declaration.
            pub const NUMBERS: &[PolicyNumber] = &[$(PolicyNumber {
                name: stringify!($name),
                min: $min,
                max: $max,
                of: |policy| policy.$name,
                of_mut: |policy| &mut policy.$name,
            }),+];
        }
    };
}
crate::policy_numbers!(params);
