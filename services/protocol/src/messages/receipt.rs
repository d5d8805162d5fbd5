use serde::{Deserialize, Serialize};

use super::Checked;
use crate::{BootId, HELD_MAX, Refusal, check};

/// `receipt`: which contacts messages of one boot of a robot are committed in the supervisor's database.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Receipt {
    /// Boot id of the supervisor.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Boot id of the robot whose `contacts` messages are receipted.
    pub robot_boot_id: BootId,
    /// All contacts messages of that boot with a `seq` below this one are committed.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub next: u64,
    /// Committed messages beyond a gap: first and last `seq` of each range, both inclusive, with last not below
    /// first.
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::held"))]
    #[serde(deserialize_with = "crate::shape::pairs_of_wholes")]
    pub held: Vec<(u64, u64)>,
}

impl Receipt {
    /// Whether the contacts message with this `seq` is committed.
    #[must_use]
    pub fn covers(&self, seq: u64) -> bool {
        seq < self.next || self.held.iter().any(|&(first, last)| (first..=last).contains(&seq))
    }
}

impl Checked for Receipt {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::integer("next", self.next)?;
        check::count("held", self.held.len(), HELD_MAX)?;
        check::each("held", &self.held, |&(first, last)| {
            check::integer("", first)?;
            check::integer("", last)?;
            // A reversed range would silently cover nothing.
            if first <= last {
                return Ok(());
            }
            Err(Refusal::OutOfRange {
                path: String::new(),
                value: last as f64,
                allowed: "[first, last] with last not below first",
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covers_what_lies_below_next_and_what_is_held() {
        let boot = BootId::new("b").unwrap();
        let receipt = Receipt { boot_id: boot.clone(), seq: 0, robot_boot_id: boot, next: 5, held: vec![(6, 8)] };
        let covered: Vec<u64> = (0..11).filter(|&seq| receipt.covers(seq)).collect();
        assert_eq!(covered, [0, 1, 2, 3, 4, 6, 7, 8]);
    }
}
