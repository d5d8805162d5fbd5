//! Robots whose rows the database refuses: finding the message to blame, and leaving it out.

pub(super) mod conviction;
pub(super) mod suspects;
