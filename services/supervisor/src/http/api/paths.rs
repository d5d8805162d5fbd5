//! Where things are: the parts of paths.

use serde::Deserialize;
use utoipa::IntoParams;
use vibrissa_protocol::Name;

use crate::http::problem::Problem;
use vibrissa_store::Store;
use vibrissa_store::list::{Filter, Value};

/// Spells out a path's parts, their filters on a list that has columns of their names, and how they are told.
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
            /// What picks it out of a list.
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
    /// A fleet.
    pub struct FleetPath ("fleet") {
        /// Fleet.
        fleet = "fleet",
    }
    /// A robot.
    pub struct RobotPath ("robot") {
        /// Fleet.
        fleet = "fleet",
        /// Robot.
        robot = "robot",
    }
    /// An array.
    pub struct ArrayPath ("array") {
        /// Fleet.
        fleet = "fleet",
        /// Robot.
        robot = "robot",
        /// Array.
        array = "\"array\"",
    }
}

/// A whisker.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct WhiskerPath {
    /// Fleet.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub fleet: Name,
    /// Robot.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Name,
    /// Array.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub array: Name,
    /// Number in the array.
    #[param(maximum = 65535)]
    pub whisker: u16,
}

impl WhiskerPath {
    /// What picks it out of a list.
    #[must_use]
    pub fn filters(&self) -> Vec<Filter> {
        let mut filters = self.on_array().filters();
        filters.push(Filter::Is("whisker", Value::Whole(self.whisker.into())));
        filters
    }
}

impl WhiskerPath {
    /// Its array.
    #[must_use]
    pub fn on_array(&self) -> ArrayPath {
        ArrayPath { fleet: self.fleet.clone(), robot: self.robot.clone(), array: self.array.clone() }
    }

    /// Its number in the database, on a robot now or once.
    ///
    /// # Errors
    /// It was never heard of, or the database cannot be read.
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

/// A compensation.
#[derive(Debug, Clone, Copy, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct CompensationPath {
    /// Its number.
    #[param(minimum = 0, maximum = 9007199254740991_i64)]
    pub compensation_id: i64,
}
