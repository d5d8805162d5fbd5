//! Whether a robot is there, for people: its connection, and whether anything is heard of it.

use vibrissa_core::robot::event::Link;

/// Presence of a robot. A connection alone says little: the broker keeps it open while the robot's program hangs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// Connected, and heard.
    Online,
    /// Connected, but nothing is heard of its whiskers.
    Silent,
    /// It has announced that it leaves.
    Offline,
    /// Its connection has broken.
    Broken,
}

impl Presence {
    /// The presence of a robot with this connection.
    #[must_use]
    pub fn of(link: Link, is_silent: bool) -> Self {
        match link {
            Link::Online if is_silent => Self::Silent,
            Link::Online => Self::Online,
            Link::Offline => Self::Offline,
            Link::Broken => Self::Broken,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Word as _;

    #[test]
    fn regress_a_silent_robot_is_not_online() {
        assert_eq!(Presence::of(Link::Online, true).word(), "SILENT");
        for link in [Link::Online, Link::Offline, Link::Broken] {
            assert_eq!(Presence::of(link, false).word(), link.word(), "the words of the contract");
        }
        assert_eq!(Presence::of(Link::Offline, true), Presence::Offline);
    }
}
