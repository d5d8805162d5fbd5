//! The robots' own record of a run, and its comparison with the database: nothing lost, nothing twice, nothing stale.

pub mod ledger;
pub mod obedience;
