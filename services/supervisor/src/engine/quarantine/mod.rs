//! Robots whose rows the database rejects: the message to blame is found and left out.

pub(super) mod conviction;
pub(super) mod suspects;
