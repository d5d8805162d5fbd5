//! The partition of a robot in a topic of Apache Kafka: that of Kafka's default partitioner for the key `fleet/robot`.

/// Hash of a robot, 0 to 2^31 - 1; its partition is the remainder of a division by the number of partitions.
#[must_use]
pub fn robot_hash(fleet: &str, robot: &str) -> u32 {
    let key = [fleet.as_bytes(), b"/", robot.as_bytes()].concat();
    murmur2::murmur2(&key, murmur2::KAFKA_SEED) & 0x7FFF_FFFF
}

#[cfg(test)]
mod tests {
    /// Hashes of Kafka's own test (`UtilsTest.testMurmur2`), as unsigned numbers.
    #[test]
    fn golden_the_hash_is_that_of_kafka() {
        for (key, hash) in [("21", -973_932_308), ("foobar", -790_332_482), ("a-little-bit-long-string", -985_981_536)]
        {
            assert_eq!(murmur2::murmur2(key.as_bytes(), murmur2::KAFKA_SEED) as i32, hash, "{key}");
        }
    }
}
