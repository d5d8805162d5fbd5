//! Values of whiskers in topics that exist already: a file names topic, type and field of each.

mod definitions;
mod file;
mod path;
mod value;

use std::collections::BTreeMap;
use std::sync::Arc;

use ros2_client::builtin_interfaces::Time;

pub use definitions::{Definitions, Layout};
pub use path::Path;
pub use value::{MessageSeed, Value};

/// A number of a message, in the unit of the quantity: `scale` times the field, plus `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// Field of the message.
    pub path: Path,
    /// Factor on the field.
    pub scale: f64,
    /// Added after the factor, in the unit of the quantity.
    pub offset: f64,
}

impl Number {
    /// The values in a message, in the unit of the quantity; `None` if the message has no element of this name.
    ///
    /// # Errors
    /// The message has no such field, or no finite number there.
    pub fn of(&self, message: &Value) -> Result<Option<Vec<f64>>, String> {
        let Some(values) = self.path.numbers(message)? else { return Ok(None) };
        match values.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(format!("{}: is {value}", self.path)),
            None => Ok(Some(values.into_iter().map(|value| self.scale * value + self.offset).collect())),
        }
    }

    /// The number of the field for a value.
    #[must_use]
    pub fn inverse(&self, value: f64) -> f64 {
        (value - self.offset) / self.scale
    }
}

/// Meaning of a number for a whisker.
#[derive(Debug, Clone, PartialEq)]
pub enum Quantity {
    /// Strain, m/m.
    Strain {
        /// The second gauge.
        second: Option<Number>,
        /// Time between the numbers of a list, us.
        every_us: Option<u32>,
    },
    /// Way of the whisker's base, m.
    Deflection,
    /// Distance of the contact from the base, m.
    Distance,
    /// Contact ratio.
    Ratio,
    /// Pressure of the chamber, Pa.
    Pressure,
    /// Level of the regulator's diagnostics: below 2 it works.
    Regulator,
}

/// A number of a whisker in the messages of a topic.
#[derive(Debug, Clone, PartialEq)]
pub struct Use {
    /// Array and number of the whisker.
    pub place: (String, u16),
    /// Its index in the agent's `hello`.
    pub index: Option<usize>,
    /// Meaning of the number.
    pub quantity: Quantity,
    /// Its place and unit.
    pub number: Number,
}

/// A topic that is read.
#[derive(Debug, Clone, PartialEq)]
pub struct MappedTopic {
    /// Name, before rules of ROS.
    pub topic: String,
    /// Type, such as `std_msgs/msg/Float64`.
    pub kind: String,
    /// Fields of its messages.
    pub layout: Arc<Layout>,
    /// Places of seconds and nanoseconds of `header.stamp`, if the messages have it.
    pub stamp: Option<[Path; 2]>,
    /// Its numbers, each of a whisker.
    pub uses: Vec<Use>,
    /// A number that is not 0 while the robot moves.
    pub driving: Option<Number>,
    /// A number that is not 0 while the robot is in a task.
    pub task: Option<Number>,
}

/// Types of messages that take setpoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SetpointType {
    /// `std_msgs/msg/Float64`.
    Float64,
    /// `std_msgs/msg/Float32`.
    Float32,
    /// `sensor_msgs/msg/FluidPressure`.
    FluidPressure,
}

impl SetpointType {
    /// Package and name.
    #[must_use]
    pub fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::Float64 => ("std_msgs", "Float64"),
            Self::Float32 => ("std_msgs", "Float32"),
            Self::FluidPressure => ("sensor_msgs", "FluidPressure"),
        }
    }
}

/// A topic that takes the setpoints of a whisker.
#[derive(Debug, Clone, PartialEq)]
pub struct MappedSetpoint {
    /// Array and number of the whisker.
    pub place: (String, u16),
    /// Its index in the agent's `hello`.
    pub index: Option<usize>,
    /// Name, before rules of ROS.
    pub topic: String,
    /// Type of the messages.
    pub written: SetpointType,
    /// Unit of the number.
    pub number: Number,
}

/// A pressure that nothing measures.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// Array and number of the whisker.
    pub place: (String, u16),
    /// Its index in the agent's `hello`.
    pub index: Option<usize>,
    /// Pressure, Pa.
    pub pa: f64,
}

/// A mapping file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mapping {
    /// Topics that are read.
    pub topics: Vec<MappedTopic>,
    /// Topics that take setpoints.
    pub setpoints: Vec<MappedSetpoint>,
    /// Pressures that nothing measures.
    pub constants: Vec<Constant>,
}

impl MappedTopic {
    /// Package and name of the type.
    #[must_use]
    pub fn package_and_name(&self) -> Option<(&str, &str)> {
        definitions::package_and_name(&self.kind)
    }

    /// Its numbers with names, which not every message of the topic has.
    pub fn named(&self) -> impl Iterator<Item = &Path> {
        let second = self
            .uses
            .iter()
            .filter_map(|one| if let Quantity::Strain { second, .. } = &one.quantity { second.as_ref() } else { None });
        let numbers = self.uses.iter().map(|one| &one.number).chain(second).chain(&self.driving).chain(&self.task);
        numbers.map(|number| &number.path).filter(|path| path.is_named())
    }

    /// The stamp of a message; `None` if its type has none.
    #[must_use]
    pub fn stamp_of(&self, message: &Value) -> Option<Time> {
        let [sec, nanosec] = self.stamp.as_ref()?.each_ref().map(|path| path.numbers(message).ok()??.first().copied());
        Some(Time::new(sec? as i32, nanosec? as u32))
    }

    fn stamp_in(layout: &Layout) -> Option<[Path; 2]> {
        let path = |text: &str| Path::find(text, layout).ok();
        Some([path("header.stamp.sec")?, path("header.stamp.nanosec")?])
    }
}

impl Mapping {
    /// Finds the whiskers of the robot.
    ///
    /// # Errors
    /// The mapping names a whisker that the robot does not have.
    pub fn bind(&mut self, index: &BTreeMap<(String, u16), usize>) -> Result<(), String> {
        let find = |place: &(String, u16)| match index.get(place) {
            Some(index) => Ok(Some(*index)),
            None => {
                let robot: Vec<String> = index.keys().map(|(array, whisker)| format!("{array}/{whisker}")).collect();
                let robot = robot.join(", ");
                Err(format!("the mapping names {}/{}, but agent.toml has {robot}", place.0, place.1))
            }
        };
        for one in self.topics.iter_mut().flat_map(|topic| &mut topic.uses) {
            one.index = find(&one.place)?;
        }
        for one in &mut self.setpoints {
            one.index = find(&one.place)?;
        }
        for one in &mut self.constants {
            one.index = find(&one.place)?;
        }
        Ok(())
    }

    /// The topic that takes the setpoints of a whisker.
    #[must_use]
    pub fn setpoint_of(&self, index: usize) -> Option<&MappedSetpoint> {
        self.setpoints.iter().find(|setpoint| setpoint.index == Some(index))
    }
}
