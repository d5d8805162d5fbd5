//! Causes for which the supervisor requests the births and factsheets of all robots of a fleet.
//!
//! Robots announce themselves at each of their connections. A supervisor that connects later would know them only from
//! retained messages, which a broker may have forgotten.

/// Cause of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BirthCause {
    /// This supervisor has connected to the broker: after a takeover, or after a lost connection.
    Connected,
    /// A birth or factsheet was shed because the inbox was full.
    Shed,
    /// The allow list has changed: births that were refused may be acceptable now.
    Allowed,
    /// A robot of the database was not heard since the takeover.
    Unheard,
    /// A robot sends messages, and its birth was not received.
    Unannounced,
}

impl BirthCause {
    /// All causes, in the order of the variants.
    pub const ALL: [Self; 5] = [Self::Connected, Self::Shed, Self::Allowed, Self::Unheard, Self::Unannounced];

    /// Word of the cause in metrics.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Connected => "CONNECTED",
            Self::Shed => "SHED",
            Self::Allowed => "ALLOWED",
            Self::Unheard => "UNHEARD",
            Self::Unannounced => "UNANNOUNCED",
        }
    }
}
