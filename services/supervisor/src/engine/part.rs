//! Division of a fleet's robots among the workers of the engine.

use borsh::{BorshDeserialize, BorshSerialize};
use vibrissa_protocol::Name;

/// The robots of one of the engine's workers; the number of workers differs between machines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub(crate) struct Part {
    pub(crate) number: u16,
    pub(crate) of: u16,
}

impl Part {
    pub(crate) fn has(self, robot: &Name) -> bool {
        index_of(robot, usize::from(self.of)) == usize::from(self.number)
    }
}

/// The worker of a robot. Depends only on its name and the number of workers.
pub(crate) fn index_of(name: &Name, workers: usize) -> usize {
    // FNV-1a, so that the result is the same in every build.
    let hash = name
        .as_str()
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    // The low bits depend on the last letter, the high ones hardly do.
    let mixed = (hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 33;
    (mixed % workers.max(1) as u64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_spread_over_all_workers_and_stay_where_they_are() {
        let mut counts = [0; 4];
        for number in 0..1000 {
            let name = Name::robot(&format!("robot-{number:04}")).unwrap();
            let worker = index_of(&name, counts.len());
            assert_eq!(worker, index_of(&name, counts.len()));
            counts[worker] += 1;
        }
        assert!(counts.iter().all(|&count| count > 200), "{counts:?}");
    }
}
