//! Unguessable identifiers: client ids and probes.
//!
//! A broker ends a connection when another client connects with its client id. So nobody else may know an id: it has
//! 128 random bits, and only its prefix is ever published or logged.

use vibrissa_host::random;
use vibrissa_protocol::Name;

/// 128 random bits in hexadecimal.
///
/// # Panics
/// The system has no random numbers; hash tables could not be created either.
pub(super) fn random_hex() -> String {
    random::hex()
}

/// Prefix of all client ids of a fleet's connections with this role. It is not secret.
pub(super) fn id_prefix(fleet: &Name, role: &str) -> String {
    format!("vibrissa-{fleet}-{role}-")
}

/// A new client id, which must never be logged or published.
pub(super) fn client_id(fleet: &Name, role: &str) -> String {
    format!("{}{}", id_prefix(fleet, role), random_hex())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_client_id_says_whose_it_is_and_has_128_bits_that_are_new_each_time() {
        let fleet = Name::new("lab").unwrap();
        let ids: BTreeSet<String> = (0..1_000).map(|_| client_id(&fleet, "in")).collect();
        assert_eq!(ids.len(), 1_000);
        for id in ids {
            let random = id.strip_prefix("vibrissa-lab-in-").unwrap();
            assert!(random.len() == 32 && random.bytes().all(|byte| byte.is_ascii_hexdigit()), "{id}");
        }
    }
}
