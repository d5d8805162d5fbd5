//! Robots whose rows the database rejects: the message to blame is found and left out.

pub(crate) mod suspect;
pub(crate) mod suspects;
