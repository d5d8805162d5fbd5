//! The robots' own record of a run, and its comparison with the database: nothing lost, nothing twice, nothing stale.

pub use vibrissa_simulation::oracle::{ledger, obedience};

pub mod recorded;
pub mod robots;
pub mod verdicts;
