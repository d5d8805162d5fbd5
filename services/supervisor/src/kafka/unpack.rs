//! Unpacks what a batch of the log has packed, up to a limit: a batch of a kilobyte may unpack to a gigabyte.

use std::io::Read;

use bytes::Bytes;
use flate2::read::MultiGzDecoder;
use lz4_flex::frame::FrameDecoder as Lz4Decoder;
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder as ZstdDecoder};

use super::defect::{Codec, Defect};

/// Begin of the form of snappy that Java's library writes: magic bytes, version, and the oldest version that reads it.
const JAVA_SNAPPY: [u8; 16] = [0x82, b'S', b'N', b'A', b'P', b'P', b'Y', 0, 0, 0, 0, 1, 0, 0, 0, 1];

impl Codec {
    /// Unpacks at most `most` bytes.
    pub(super) fn unpack(self, packed: &[u8], most: usize) -> Result<Bytes, Defect> {
        let unpacked = match self {
            Self::Gzip => self.read(MultiGzDecoder::new(packed), most),
            Self::Lz4 => self.read(Lz4Decoder::new(packed), most),
            Self::Snappy => match packed.strip_prefix(&JAVA_SNAPPY) {
                Some(chunks) => self.chunks(chunks, most),
                None => self.chunk(packed, most),
            },
            Self::Zstd => self.frames(packed, most),
        };
        unpacked.map(Into::into)
    }

    fn read(self, unpacked: impl Read, most: usize) -> Result<Vec<u8>, Defect> {
        let mut bytes = Vec::new();
        // One byte more tells a longer one from one that just fits.
        unpacked.take(most as u64 + 1).read_to_end(&mut bytes).map_err(|_| Defect::Packed(self))?;
        if bytes.len() > most { Err(Defect::TooLong(self)) } else { Ok(bytes) }
    }

    /// A block of snappy, which states its length at its begin.
    fn chunk(self, packed: &[u8], most: usize) -> Result<Vec<u8>, Defect> {
        let length = snap::raw::decompress_len(packed).map_err(|_| Defect::Packed(self))?;
        if length > most {
            return Err(Defect::TooLong(self));
        }
        snap::raw::Decoder::new().decompress_vec(packed).map_err(|_| Defect::Packed(self))
    }

    /// Blocks of snappy, each after its length.
    fn chunks(self, mut packed: &[u8], most: usize) -> Result<Vec<u8>, Defect> {
        let mut bytes = Vec::new();
        while !packed.is_empty() {
            let (length, rest) = packed.split_first_chunk().ok_or(Defect::Packed(self))?;
            let (chunk, rest) =
                rest.split_at_checked(u32::from_be_bytes(*length) as usize).ok_or(Defect::Packed(self))?;
            bytes.append(&mut self.chunk(chunk, most - bytes.len())?);
            packed = rest;
        }
        Ok(bytes)
    }

    /// Frames of zstd. A frame is unpacked block by block, each of at most 128 KiB: its window may be longer than the
    /// limit although its content is short.
    fn frames(self, mut packed: &[u8], most: usize) -> Result<Vec<u8>, Defect> {
        let mut bytes = Vec::new();
        while !packed.is_empty() {
            let mut frame = ZstdDecoder::new();
            frame.init(&mut packed).map_err(|_| Defect::Packed(self))?;
            let room = most - bytes.len();
            let is_whole = frame.decode_blocks(&mut packed, BlockDecodingStrategy::UptoBytes(room + 1));
            if !is_whole.map_err(|_| Defect::Packed(self))? {
                return Err(Defect::TooLong(self));
            }
            bytes.append(&mut frame.collect().unwrap_or_default());
            if bytes.len() > most {
                return Err(Defect::TooLong(self));
            }
        }
        Ok(bytes)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;
    use lz4_flex::frame::FrameEncoder;
    use proptest::prelude::*;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    pub(in super::super) const CODECS: [Codec; 4] = [Codec::Gzip, Codec::Snappy, Codec::Lz4, Codec::Zstd];

    pub(in super::super) fn pack(codec: Codec, bytes: &[u8]) -> Vec<u8> {
        match codec {
            Codec::Gzip => {
                let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(bytes).unwrap();
                encoder.finish().unwrap()
            }
            Codec::Snappy => snap::raw::Encoder::new().compress_vec(bytes).unwrap(),
            Codec::Lz4 => {
                let mut encoder = FrameEncoder::new(Vec::new());
                encoder.write_all(bytes).unwrap();
                encoder.finish().unwrap()
            }
            Codec::Zstd => compress_to_vec(bytes, CompressionLevel::Fastest),
        }
    }

    /// Snappy as Java's library writes it.
    fn java(bytes: &[u8]) -> Vec<u8> {
        let mut packed = JAVA_SNAPPY.to_vec();
        for chunk in bytes.chunks(1000) {
            let chunk = pack(Codec::Snappy, chunk);
            packed.extend((chunk.len() as u32).to_be_bytes());
            packed.extend(chunk);
        }
        packed
    }

    #[test]
    fn what_is_longer_than_the_limit_is_not_unpacked() {
        const MOST: usize = 1 << 20;
        for codec in CODECS {
            for length in [0, 1, MOST] {
                assert_eq!(codec.unpack(&pack(codec, &vec![0; length]), MOST), Ok(vec![0; length].into()), "{codec}");
            }
            for length in [MOST + 1, 64 * MOST] {
                assert_eq!(codec.unpack(&pack(codec, &vec![0; length]), MOST), Err(Defect::TooLong(codec)), "{codec}");
            }
        }
        assert_eq!(Codec::Snappy.unpack(&java(&vec![0; MOST]), MOST), Ok(vec![0; MOST].into()));
        assert_eq!(Codec::Snappy.unpack(&java(&vec![0; MOST + 1]), MOST), Err(Defect::TooLong(Codec::Snappy)));
    }

    /// A block of zstd states 128 KiB of one byte in four bytes: 32,000 times the packed length.
    #[test]
    fn the_longest_ratio_of_zstd_ends_at_the_limit() {
        let mut packed = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x88];
        for _ in 0..100_000 {
            packed.extend([0x02, 0x00, 0x10, 0x00]);
        }
        assert_eq!(Codec::Zstd.unpack(&packed, 1 << 20), Err(Defect::TooLong(Codec::Zstd)));
    }

    proptest! {
        #[test]
        fn property_each_codec_gives_back_what_was_packed(bytes: Vec<u8>, copies in 1_usize..200) {
            let bytes = bytes.repeat(copies);
            for codec in CODECS {
                prop_assert_eq!(codec.unpack(&pack(codec, &bytes), bytes.len()), Ok(bytes.clone().into()));
            }
            prop_assert_eq!(Codec::Snappy.unpack(&java(&bytes), bytes.len()), Ok(bytes.into()));
        }

        #[test]
        fn property_damaged_bytes_end_with_an_error_or_within_the_limit(
            bytes in prop::collection::vec(0_u8..4, 1..3000), damages: Vec<(prop::sample::Index, u8)>
        ) {
            for codec in CODECS {
                let mut packed = pack(codec, &bytes);
                for (at, byte) in &damages {
                    *at.get_mut(&mut packed) = *byte;
                }
                if let Ok(unpacked) = codec.unpack(&packed, 4096) {
                    prop_assert!(unpacked.len() <= 4096);
                }
            }
        }
    }
}
