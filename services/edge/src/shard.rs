//! Shards: the parts of a fleet that different supervisors can own.
//!
//! A robot's shard follows from the names of its fleet and itself, by the hash of Apache Kafka's default partitioner over the
//! key `fleet/robot`. So a Kafka topic that has as many partitions as the fleet has shards, and this key, has one shard in
//! each partition.

use std::fmt;

use vibrissa_protocol::Name;

/// Largest number of shards of a fleet.
pub const SHARDS_MAX: u32 = 1024;

/// One shard of a fleet, together with the number of all its shards: after a change of this number it is another one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FleetShard {
    fleet: Name,
    number: u32,
    count: u32,
}

impl FleetShard {
    /// The only shard of a fleet that is not divided.
    #[must_use]
    pub fn whole(fleet: Name) -> Self {
        Self { fleet, number: 0, count: 1 }
    }

    /// Shard `number` of `count`; `None` if the number is too high, or the count is not between 1 and [`SHARDS_MAX`].
    #[must_use]
    pub fn new(fleet: Name, number: u32, count: u32) -> Option<Self> {
        (number < count && count <= SHARDS_MAX).then_some(Self { fleet, number, count })
    }

    /// All shards of a fleet with so many.
    pub fn all(fleet: &Name, count: u32) -> impl Iterator<Item = Self> + '_ {
        (0..count).filter_map(move |number| Self::new(fleet.clone(), number, count))
    }

    /// Name of the fleet.
    #[must_use]
    pub fn fleet(&self) -> &Name {
        &self.fleet
    }

    /// Number of the shard, from 0.
    #[must_use]
    pub fn number(&self) -> u32 {
        self.number
    }

    /// Number of all shards of the fleet.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Whether this is the whole fleet.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.count == 1
    }

    /// Whether this shard does the work of the whole fleet that only one owner may do: actions without a robot, and the
    /// supervisor's state.
    #[must_use]
    pub fn is_first(&self) -> bool {
        self.number == 0
    }

    /// Whether a robot of this fleet belongs to this shard.
    #[must_use]
    pub fn has(&self, robot: &str) -> bool {
        self.is_whole() || robot_hash(self.fleet.as_str(), robot) % self.count == self.number
    }
}

impl fmt::Display for FleetShard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.is_whole() {
            true => f.write_str(self.fleet.as_str()),
            false => write!(f, "{}/{}", self.fleet, self.number),
        }
    }
}

/// Hash of a robot, 0 to 2^31 - 1; its shard is the remainder of a division by the number of shards.
#[must_use]
pub fn robot_hash(fleet: &str, robot: &str) -> u32 {
    let key = [fleet.as_bytes(), b"/", robot.as_bytes()].concat();
    murmur2::murmur2(&key, murmur2::KAFKA_SEED) & 0x7FFF_FFFF
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hashes of Kafka's own test (`UtilsTest.testMurmur2`), as unsigned numbers.
    #[test]
    fn golden_the_hash_is_that_of_kafka() {
        for (key, hash) in [("21", -973_932_308), ("foobar", -790_332_482), ("a-little-bit-long-string", -985_981_536)]
        {
            assert_eq!(murmur2::murmur2(key.as_bytes(), murmur2::KAFKA_SEED) as i32, hash, "{key}");
        }
    }

    #[test]
    fn each_robot_belongs_to_one_shard_and_shards_are_of_similar_size() {
        let fleet = Name::new("lab").unwrap();
        for count in [1, 2, 3, 4, 16, 64] {
            let mut sizes = vec![0; count as usize];
            for robot in 0..6400 {
                let robot = format!("crawler-{robot}");
                let owners: Vec<u32> =
                    FleetShard::all(&fleet, count).filter(|one| one.has(&robot)).map(|one| one.number()).collect();
                assert_eq!(owners.len(), 1, "{robot}");
                sizes[owners[0] as usize] += 1;
            }
            let expected = 6400.0 / f64::from(count);
            let apart =
                sizes.iter().map(|&size| (f64::from(size) - expected).abs() / expected.sqrt()).fold(0.0, f64::max);
            assert!(apart < 4.5, "{count} shards: {sizes:?}");
        }
    }

    #[test]
    fn a_shard_is_named_after_its_fleet_and_numbered_if_there_are_several() {
        let fleet = Name::new("lab").unwrap();
        assert_eq!(FleetShard::whole(fleet.clone()).to_string(), "lab");
        assert_eq!(FleetShard::new(fleet.clone(), 3, 4).unwrap().to_string(), "lab/3");
        assert_eq!(FleetShard::new(fleet.clone(), 4, 4), None);
        assert_eq!(FleetShard::new(fleet, 0, SHARDS_MAX + 1), None);
    }
}
