//! Why a batch of the log cannot be read, and the limits of its size in memory.

use std::fmt;

/// Most bytes that the packed batches of one answer take unpacked.
pub(super) const UNPACKED_MAX: usize = UNPACKED_MIB * 1024 * 1024;
const UNPACKED_MIB: usize = 16;
/// Most records of an answer. A record takes some 200 bytes beside its content, and as few as seven in the batch.
pub(super) const RECORDS_MAX: usize = 100_000;

/// How a batch is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Codec {
    /// DEFLATE with the frame of gzip.
    Gzip,
    /// Snappy, in blocks or as one.
    Snappy,
    /// The frames of LZ4.
    Lz4,
    /// The frames of Zstandard.
    Zstd,
}

impl Codec {
    /// The codec of a batch by its number there; `None` for a number without a codec. With number 0 nothing is packed.
    pub(super) fn of(number: i16) -> Option<Self> {
        [Self::Gzip, Self::Snappy, Self::Lz4, Self::Zstd].get(usize::try_from(number).ok()?.checked_sub(1)?).copied()
    }
}

impl fmt::Display for Codec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gzip => "gzip",
            Self::Snappy => "snappy",
            Self::Lz4 => "lz4",
            Self::Zstd => "zstd",
        })
    }
}

/// Why a batch cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Defect {
    /// The bytes differ from those that were written.
    #[error("a batch is damaged: its checksum differs; look at the disks of the brokers")]
    Checksum,
    /// A number in it is impossible.
    #[error("a batch is damaged: its {0} cannot be right; look at the program that writes to the topic")]
    Malformed(&'static str),
    /// It was written before 2017.
    #[error("a batch has the format of Kafka before 0.11: let the bridge write the present one")]
    Old,
    /// No codec has this number.
    #[error("a batch is packed with an unknown codec, number {0}: set compression.type to gzip, snappy, lz4 or zstd")]
    UnknownCodec(i16),
    /// The codec refuses the bytes.
    #[error("a batch cannot be unpacked by {0}: look at the program that writes to the topic")]
    Packed(Codec),
    /// It is longer than the limit.
    #[error("a batch unpacks by {0} to more than {UNPACKED_MIB} MiB: let the bridge write smaller batches")]
    TooLong(Codec),
    /// It has more records than the limit.
    #[error("a batch has more than {RECORDS_MAX} records: let the bridge write smaller batches")]
    TooMany,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_codec_has_a_number() {
        let all = [Codec::Gzip, Codec::Snappy, Codec::Lz4, Codec::Zstd];
        assert_eq!([1, 2, 3, 4].map(Codec::of), all.map(Some));
        assert_eq!([-1, 0, 5, 7].map(Codec::of), [None; 4]);
    }
}
