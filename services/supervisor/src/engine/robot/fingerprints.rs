//! Short hashes of one robot's newest `contacts` messages. They show whether a repeated `seq` has the same content.

use std::hash::{BuildHasher, Hasher};

use vibrissa_protocol::Contacts;

/// Number of messages remembered: those that a robot may send again within some seconds of a burst.
const REMEMBERED: usize = 256;
/// Fingerprint of a message that was refused and only receipted.
pub(crate) const REFUSED: u32 = 1;
/// Multiplier that spreads boot numbers over 32 bits (Knuth).
const SPREAD: u32 = 0x9e37_79b1;

/// Fingerprints of one robot's newest messages, at the index `seq` mod 256. Allocated with the first message.
#[derive(Debug, Default)]
pub(crate) struct Fingerprints(Option<Box<[Fingerprint; REMEMBERED]>>);

/// Fingerprint of one message. Content 0 marks an unused entry.
#[derive(Debug, Clone, Copy, Default)]
struct Fingerprint {
    /// Combines the boot number and the high part of `seq`.
    name: u32,
    content: u32,
}

/// Fingerprint of a message's content, above [`REFUSED`]. `hashers` has secret keys, so that nobody can construct two
/// contents with the same fingerprint.
pub(crate) fn of_content(hashers: &impl BuildHasher, message: &Contacts) -> u32 {
    let mut hasher = hashers.build_hasher();
    for contact in &message.contacts {
        hasher.write(contact.array.as_str().as_bytes());
        hasher.write_u64(u64::from(contact.whisker));
        hasher.write_u64(contact.t_us);
        // No place is a number of -1 or less.
        let place = [contact.ratio, contact.ratio_sd, contact.distance_mm, contact.distance_sd_mm];
        let share = contact.share_in_gauge_plane();
        let reading = [contact.deflection_mm, contact.strain, contact.pressure_mpa, contact.temperature_c];
        for number in place.map(|one| one.unwrap_or(-1.0)).into_iter().chain(reading).chain([share]) {
            hasher.write_u64(number.to_bits());
        }
        hasher.write_u8(contact.tip.into());
    }
    for missed in &message.missed {
        hasher.write(missed.array.as_str().as_bytes());
        hasher.write_u64(u64::from(missed.whisker));
        hasher.write_u64(missed.t_us);
        hasher.write_u64(missed.distance_mm.to_bits());
    }
    (hasher.finish() as u32).max(2)
}

impl Fingerprints {
    /// Remembers the fingerprint of an accepted message.
    pub(crate) fn remember(&mut self, boot: i64, seq: u64, content: u32) {
        let places = self.0.get_or_insert_with(|| Box::new([Fingerprint::default(); REMEMBERED]));
        places[place(seq)] = Fingerprint { name: name(boot, seq), content };
    }

    /// Whether a remembered message of this `seq` had other content. False if the message is not remembered.
    pub(crate) fn contradict(&self, boot: i64, seq: u64, content: u32) -> bool {
        self.0.as_ref().is_some_and(|places| {
            let known = places[place(seq)];
            known.content != 0 && known.name == name(boot, seq) && known.content != content
        })
    }
}

fn place(seq: u64) -> usize {
    (seq % REMEMBERED as u64) as usize
}

fn name(boot: i64, seq: u64) -> u32 {
    (boot as u32).wrapping_mul(SPREAD) ^ (seq / REMEMBERED as u64) as u32
}

#[cfg(test)]
mod tests {
    use std::hash::RandomState;

    use vibrissa_protocol::{BootId, Contact, Name};

    use super::*;

    fn message(strain: f64) -> Contacts {
        let contact = Contact {
            array: Name::new("left").unwrap(),
            whisker: 0,
            t_us: 1_000_000,
            ratio: Some(0.85),
            ratio_sd: None,
            distance_mm: None,
            distance_sd_mm: None,
            tip: false,
            deflection_mm: 2.4,
            strain,
            saturated: false,
            pressure_mpa: 0.1,
            temperature_c: 24.0,
            angle_deg: None,
            angle_sd_deg: None,
            test_id: None,
        };
        Contacts { boot_id: BootId::new("b").unwrap(), seq: 0, contacts: vec![contact; 3], missed: Vec::new() }
    }

    #[test]
    fn another_content_under_a_number_is_noticed_as_long_as_the_number_is_remembered() {
        let hashers = RandomState::new();
        let [one, same, other] = [0.01, 0.01, 0.010_000_1].map(|strain| of_content(&hashers, &message(strain)));
        assert_eq!(one, same);
        let mut known = Fingerprints::default();
        assert!(!known.contradict(1, 7, other), "an unknown message contradicts nothing");
        known.remember(1, 7, one);
        assert_eq!([known.contradict(1, 7, same), known.contradict(1, 7, other)], [false, true]);
        // Another boot, and another `seq` with the same index.
        assert_eq!([known.contradict(2, 7, other), known.contradict(1, 7 + 256, other)], [false, false]);
        known.remember(1, 7 + 256, other);
        assert!(!known.contradict(1, 7, other), "the entry was overwritten");
    }
}
