//! Units as types, checked once where a value enters.
//!
//! In formulas, the name of a raw `f64` ends with its unit (`deflection_mm`).

use borsh::{BorshDeserialize, BorshSerialize};

/// A value outside the range of its unit; the message names the quantity, the value and the range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{quantity} is {value}, but must be {range}")]
pub struct OutOfUnitRange {
    /// Name of the quantity, with its unit, for people.
    pub quantity: &'static str,
    /// The rejected value.
    pub value: f64,
    /// The permitted range.
    pub range: &'static str,
}

/// Defines a unit: a checked `f64` that is finite and in a closed range.
macro_rules! unit {
    ($(#[$doc:meta])* $name:ident, $getter:ident, $quantity:literal, $range:literal, $check:expr) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, BorshSerialize, BorshDeserialize)]
        pub struct $name(f64);

        impl $name {
            /// Checks the range.
            ///
            /// # Errors
            /// The value is not finite or not in the range stated by the type's documentation.
            pub fn new(value: f64) -> Result<Self, OutOfUnitRange> {
                let check: fn(f64) -> bool = $check;
                if value.is_finite() && check(value) {
                    Ok(Self(value))
                } else {
                    Err(OutOfUnitRange { quantity: $quantity, value, range: $range })
                }
            }

            /// Wraps a value known to be in range: for constants and results of the mechanics.
            ///
            /// # Panics
            /// In debug builds, if the value is out of range.
            #[must_use]
            pub fn known(value: f64) -> Self {
                debug_assert!(Self::new(value).is_ok(), concat!($quantity, " out of range: {}"), value);
                Self(value)
            }

            /// The number in the unit of the type.
            #[must_use]
            pub fn $getter(self) -> f64 {
                self.0
            }
        }
    };
}

unit!(
    /// A length or a deflection in millimetres, 0 to 1000.
    Millimetre, mm, "length in mm", "between 0 and 1000", |v| (0.0..=1000.0).contains(&v)
);
unit!(
    /// A gauge pressure of the air chamber in megapascal, 0 to 1.
    ///
    /// The paper examined 0 to 0.2 MPa; [`Megapascal::EXAMINED_MAX`] is the limit for setpoints.
    Megapascal, mpa, "pressure in MPa", "between 0 and 1", |v| (0.0..=1.0).contains(&v)
);
unit!(
    /// A mean strain over the gauge grid, dimensionless (m/m), -1 to 1.
    Strain, ratio, "strain in m/m", "between -1 and 1", |v| (-1.0..=1.0).contains(&v)
);
unit!(
    /// The paper's contact ratio a: contact distance / present length, above 0 and at most 1.
    ContactRatio, a, "contact ratio", "above 0 and at most 1", |v| v > 0.0 && v <= 1.0
);

impl Megapascal {
    /// Highest pressure that the paper examined, and the limit of all setpoints: 0.2 MPa.
    pub const EXAMINED_MAX: Self = Self(0.2);
    /// No gauge pressure.
    pub const ZERO: Self = Self(0.0);
}

impl ContactRatio {
    /// Contact at the tip, a = 1.
    pub const TIP: Self = Self(1.0);
}

/// A point in time or a span, in microseconds; points count from 1970 UTC.
///
/// There are two clocks, the supervisor's and each robot's; a variable's name says which (`now`, `robot_time`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, BorshSerialize, BorshDeserialize)]
pub struct Micros(pub u64);

impl Micros {
    /// Converts seconds; negative values and NaN become zero.
    #[must_use]
    pub fn from_s(seconds: f64) -> Self {
        Self((seconds.max(0.0) * 1e6) as u64)
    }

    /// Converts to seconds.
    #[must_use]
    pub fn as_s(self) -> f64 {
        self.0 as f64 / 1e6
    }

    /// The time `span` later, saturating.
    #[must_use]
    pub fn after(self, span: Self) -> Self {
        Self(self.0.saturating_add(span.0))
    }

    /// Time since `earlier`; zero if `earlier` is later.
    #[must_use]
    pub fn since(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }
}
