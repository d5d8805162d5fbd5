//! Short hashes of one robot's newest `contacts` messages. They show whether a repeated message number has the same content.

use std::hash::{BuildHasher, Hasher};

use vibrissa_protocol::Contacts;

/// Messages that are remembered: those that a robot may send again within some seconds of a burst.
const REMEMBERED: usize = 256;
/// Stands for the content of a message that was refused and is only accounted for.
pub(super) const REFUSED: u32 = 1;
/// Spreads the numbers of boots over 32 bits (Knuth).
const SPREAD: u32 = 0x9e37_79b1;

/// The newest messages of one robot, each at the place that its number has; with room once there is one.
#[derive(Debug, Default)]
pub(super) struct Fingerprints(Option<Box<[Fingerprint; REMEMBERED]>>);

/// One message. The content of a place that was never used is 0, which stands for none.
#[derive(Debug, Clone, Copy, Default)]
struct Fingerprint {
    /// Boot and the rest of the number.
    name: u32,
    content: u32,
}

/// A fingerprint of a message's content, above [`REFUSED`]. `hashers` has secret keys, so that nobody can make two contents alike.
pub(super) fn of_content(hashers: &impl BuildHasher, told: &Contacts) -> u32 {
    let mut hasher = hashers.build_hasher();
    for contact in &told.contacts {
        hasher.write(contact.array.as_str().as_bytes());
        hasher.write_u64(u64::from(contact.whisker));
        hasher.write_u64(contact.t_us);
        for number in
            [contact.ratio, contact.deflection_mm, contact.strain, contact.pressure_mpa, contact.temperature_c]
        {
            hasher.write_u64(number.to_bits());
        }
    }
    (hasher.finish() as u32).max(2)
}

impl Fingerprints {
    /// A message was taken.
    pub(super) fn remember(&mut self, boot: i64, seq: u64, content: u32) {
        let places = self.0.get_or_insert_with(|| Box::new([Fingerprint::default(); REMEMBERED]));
        places[place(seq)] = Fingerprint { name: name(boot, seq), content };
    }

    /// Whether the message of that number said something else; not if it is not remembered.
    pub(super) fn contradict(&self, boot: i64, seq: u64, content: u32) -> bool {
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
            ratio: 0.85,
            deflection_mm: 2.4,
            strain,
            pressure_mpa: 0.1,
            temperature_c: 24.0,
        };
        Contacts { boot_id: BootId::new("b").unwrap(), seq: 0, contacts: vec![contact; 3] }
    }

    #[test]
    fn another_content_under_a_number_is_noticed_as_long_as_the_number_is_remembered() {
        let hashers = RandomState::new();
        let [one, same, other] = [0.01, 0.01, 0.010_000_1].map(|strain| of_content(&hashers, &message(strain)));
        assert_eq!(one, same);
        let mut known = Fingerprints::default();
        assert!(!known.contradict(1, 7, other), "never seen");
        known.remember(1, 7, one);
        assert_eq!([known.contradict(1, 7, same), known.contradict(1, 7, other)], [false, true]);
        // Another boot, and another number at the same place.
        assert_eq!([known.contradict(2, 7, other), known.contradict(1, 7 + 256, other)], [false, false]);
        known.remember(1, 7 + 256, other);
        assert!(!known.contradict(1, 7, other), "forgotten");
    }
}
