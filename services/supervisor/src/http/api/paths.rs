//! Path parameters of fleets, robots, arrays and whiskers.

use serde::Deserialize;
use utoipa::IntoParams;
use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::WhiskerIndex;
use vibrissa_protocol::Name;

use crate::http::problem::{Kind, Problem};
use vibrissa_store::list::{Filter, Selection, Value};
use vibrissa_store::lists::robots::{ARRAYS, ArraySummary, ROBOTS, RobotSummary};
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};
use vibrissa_store::{Store, StoreError};

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

/// Learned state of a whisker's robot, as of the last checkpoint.
#[derive(Debug)]
pub struct Learned {
    /// State of the robot.
    pub robot: Robot,
    /// Number of the robot in the database.
    pub robot_id: i64,
    /// Index of the whisker in `robot`.
    pub index: WhiskerIndex,
}

impl WhiskerPath {
    /// Learned state of the whisker's robot.
    ///
    /// # Errors
    /// The whisker is unknown, or its state cannot be read.
    pub async fn learned(&self, store: &Store) -> Result<Learned, Problem> {
        let stored = store.robot_state(self.fleet.as_str(), self.robot.as_str()).await?;
        let Some(stored) = stored else { return Err(self.unknown(store).await) };
        let robot = stored.robot().map_err(|problem| Problem::new(Kind::Internal, problem.to_string()))?;
        let Some(index) = robot.find(self.array.as_str(), self.whisker) else { return Err(self.unknown(store).await) };
        Ok(Learned { robot, robot_id: stored.robot_id, index })
    }

    /// Filters that select this whisker from a list.
    #[must_use]
    pub fn filters(&self) -> Vec<Filter> {
        let mut filters = self.on_array().filters();
        filters.push(Filter::Is("whisker", Value::Whole(self.whisker.into())));
        filters
    }
}

/// Most whiskers that a problem names.
const NAMED_MAX: u32 = 32;

impl RobotPath {
    /// The problem of an unknown robot: says whether its fleet is known.
    pub async fn unknown(&self, store: &Store) -> Problem {
        match store.has_fleet(self.fleet.as_str()).await {
            Ok(true) => Problem::unknown(format!("the fleet {} has no robot {}", self.fleet, self.robot)),
            Ok(false) => Problem::unknown(format!("there is no fleet {}", self.fleet)),
            Err(problem) => problem.into(),
        }
    }
}

impl ArrayPath {
    /// Path of its robot.
    #[must_use]
    pub fn on_robot(&self) -> RobotPath {
        RobotPath { fleet: self.fleet.clone(), robot: self.robot.clone() }
    }

    /// The problem of an unknown array: says which part of the path is unknown.
    pub async fn unknown(&self, store: &Store) -> Problem {
        let robot = self.on_robot();
        match store.first::<RobotSummary>(&ROBOTS, robot.filters()).await {
            Ok(Some(_)) => Problem::unknown(format!(
                "the robot {} of the fleet {} has no array {}",
                self.robot, self.fleet, self.array
            )),
            Ok(None) => robot.unknown(store).await,
            Err(problem) => problem.into(),
        }
    }
}

impl WhiskerPath {
    /// The problem of an unknown whisker: says which part of the path is unknown, and which whiskers the array has.
    pub async fn unknown(&self, store: &Store) -> Problem {
        let array = self.on_array();
        match self.others(store).await {
            Ok(Some(numbers)) => Problem::unknown(format!(
                "the array {} of the robot {} has no whisker {}; it has {numbers}",
                self.array, self.robot, self.whisker
            )),
            Ok(None) => array.unknown(store).await,
            Err(problem) => problem.into(),
        }
    }

    /// Numbers of the whiskers on its array; `None` if the array is unknown.
    async fn others(&self, store: &Store) -> Result<Option<String>, StoreError> {
        let array = self.on_array();
        if store.first::<ArraySummary>(&ARRAYS, array.filters()).await?.is_none() {
            return Ok(None);
        }
        let selection = Selection { filters: array.filters(), ..Selection::all(&WHISKERS, NAMED_MAX) };
        let page = store.list::<Whisker>(&WHISKERS, &selection).await?;
        let mut numbers: Vec<String> = page.rows.iter().map(|row| row.whisker.to_string()).collect();
        numbers.extend(page.next.map(|_| "more".to_owned()));
        Ok(Some(numbers.join(", ")))
    }

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
        match store.whisker_id(whisker).await? {
            Some(whisker_id) => Ok(whisker_id),
            None => Err(self.unknown(store).await),
        }
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
