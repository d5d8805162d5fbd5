//! Full names of robots and whiskers in logs, spelled as the paths of REST and the console spell them.

use std::fmt;

/// Name of a robot in the whole installation, such as `hall/crawler-83`, or of one of its whiskers, such as
/// `hall/crawler-83/right/1`: the number is that of the factsheet, counted within the array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FullName<'a> {
    fleet: &'a str,
    robot: &'a str,
    whisker: Option<(&'a str, u16)>,
}

impl<'a> FullName<'a> {
    /// Name of a robot.
    #[must_use]
    pub fn robot(fleet: &'a str, robot: &'a str) -> Self {
        Self { fleet, robot, whisker: None }
    }

    /// Name of a whisker of this robot.
    #[must_use]
    pub fn whisker(self, array: &'a str, number: u16) -> Self {
        Self { whisker: Some((array, number)), ..self }
    }
}

impl fmt::Display for FullName<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.fleet, self.robot)?;
        self.whisker.map_or(Ok(()), |(array, number)| write!(f, "/{array}/{number}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_begins_with_the_fleet_and_ends_with_the_number_in_the_array() {
        let robot = FullName::robot("hall", "crawler-83");
        assert_eq!(robot.to_string(), "hall/crawler-83");
        assert_eq!(robot.whisker("right", 1).to_string(), "hall/crawler-83/right/1");
    }
}
