//! Path parameters of fleets, robots, arrays and whiskers.

use serde::Deserialize;
use utoipa::IntoParams;
use vibrissa_protocol::Name;

use crate::http::problem::Problem;
use vibrissa_store::Store;
use vibrissa_store::list::{Filter, Value};

/// Defines path parameters, the filters for lists that have columns of the same names, and their display text.
macro_rules! paths {
    ($($(#[$meta:meta])* pub struct $name:ident ($what:literal) { $($(#[$field_meta:meta])* $field:ident = $column:literal,)+ })+) => {
        $($(#[$meta])*
        #[derive(Debug, Clone, Deserialize, IntoParams)]
        #[into_params(parameter_in = Path)]
        pub struct $name {
            $($(#[$field_meta])*
            #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
            pub $field: Name,)+
        }

        impl $name {
            /// Filters that select this object from a list.
            #[must_use]
            pub fn filters(&self) -> Vec<Filter> {
                vec![$(Filter::Is($column, Value::Text(self.$field.to_string())),)+]
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str($what)?;
                [$(&self.$field),+].into_iter().try_for_each(|part| write!(f, " {part}"))
            }
        })+
    };
}

paths! {
    /// Path parameters of a fleet.
    pub struct FleetPath ("fleet") {
        /// Name of the fleet.
        fleet = "fleet",
    }
    /// Path parameters of a robot.
    pub struct RobotPath ("robot") {
        /// Name of the fleet.
        fleet = "fleet",
        /// Name of the robot.
        robot = "robot",
    }
    /// Path parameters of an array.
    pub struct ArrayPath ("array") {
        /// Name of the fleet.
        fleet = "fleet",
        /// Name of the robot.
        robot = "robot",
        /// Name of the array.
        array = "\"array\"",
    }
}

/// Path parameters of a whisker.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct WhiskerPath {
    /// Name of the fleet.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub fleet: Name,
    /// Name of the robot.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Name,
    /// Name of the array.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub array: Name,
    /// Number of the whisker in its array.
    #[param(maximum = 65535)]
    pub whisker: u16,
}

impl WhiskerPath {
    /// Filters that select this whisker from a list.
    #[must_use]
    pub fn filters(&self) -> Vec<Filter> {
        let mut filters = self.on_array().filters();
        filters.push(Filter::Is("whisker", Value::Whole(self.whisker.into())));
        filters
    }
}

impl WhiskerPath {
    /// Path of its array.
    #[must_use]
    pub fn on_array(&self) -> ArrayPath {
        ArrayPath { fleet: self.fleet.clone(), robot: self.robot.clone(), array: self.array.clone() }
    }

    /// Its number in the database, also if it is no longer on the robot.
    ///
    /// # Errors
    /// The whisker is unknown, or the database cannot be read.
    pub async fn whisker_id(&self, store: &Store) -> Result<i64, Problem> {
        let whisker = (self.fleet.as_str(), self.robot.as_str(), self.array.as_str(), self.whisker);
        store.whisker_id(whisker).await?.ok_or_else(|| Problem::not_found(self))
    }
}

impl std::fmt::Display for WhiskerPath {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "whisker {} {} {} {}", self.fleet, self.robot, self.array, self.whisker)
    }
}

/// Path parameters of a compensation.
#[derive(Debug, Clone, Copy, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct CompensationPath {
    /// Number of the compensation.
    #[param(minimum = 0, maximum = 9007199254740991_i64)]
    pub compensation_id: i64,
}
