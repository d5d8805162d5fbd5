//! Text files that people write with editors, spreadsheets and shells.

use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Byte order mark that programs for Windows write at the beginning of a text in UTF-8.
const UTF_8: &[u8] = &[0xef, 0xbb, 0xbf];
const UTF_16_LITTLE: [u8; 2] = [0xff, 0xfe];
const UTF_16_BIG: [u8; 2] = [0xfe, 0xff];

/// Bytes that are not text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("line {line} is not text in UTF-8{}: save the file as UTF-8", if *has_nul { UTF_16_HINT } else { "" })]
pub struct NotText {
    /// Line of the first wrong byte, from 1; always 1 after a byte order mark of UTF-16.
    pub line: usize,
    /// Whether there are bytes of 0, as in UTF-16 without a byte order mark.
    pub has_nul: bool,
}

const UTF_16_HINT: &str = ", it seems to be in UTF-16 without a byte order mark";

/// The text of a file in UTF-8, or in UTF-16 with a byte order mark, without that mark.
///
/// # Errors
/// The bytes are not text.
pub fn text_of(bytes: &[u8]) -> std::result::Result<String, NotText> {
    let utf_16 = |rest: &[u8], unit: fn([u8; 2]) -> u16| {
        let (units, odd) = rest.as_chunks::<2>();
        let units: Vec<u16> = units.iter().map(|&bytes| unit(bytes)).collect();
        let read = String::from_utf16(&units).ok().filter(|_| odd.is_empty());
        read.ok_or(NotText { line: 1, has_nul: false })
    };
    if let Some(rest) = bytes.strip_prefix(&UTF_16_LITTLE) {
        return utf_16(rest, u16::from_le_bytes);
    }
    if let Some(rest) = bytes.strip_prefix(&UTF_16_BIG) {
        return utf_16(rest, u16::from_be_bytes);
    }
    let bytes = bytes.strip_prefix(UTF_8).unwrap_or(bytes);
    let nul = bytes.iter().position(|byte| *byte == 0);
    let wrong = std::str::from_utf8(bytes).err().map(|problem| problem.valid_up_to());
    match (std::str::from_utf8(bytes), nul.into_iter().chain(wrong).min()) {
        (Ok(text), None) => Ok(text.to_owned()),
        (_, wrong) => {
            let before = bytes.get(..wrong.unwrap_or_default()).unwrap_or_default();
            Err(NotText { line: 1 + line_ends(before), has_nul: nul.is_some() })
        }
    }
}

/// Number of line ends. CR LF is one.
fn line_ends(bytes: &[u8]) -> usize {
    let both = bytes.windows(2).filter(|pair| pair == b"\r\n").count();
    bytes.iter().filter(|byte| matches!(byte, b'\r' | b'\n')).count() - both
}

/// The content of a PEM file without a byte order mark, in UTF-8 if it was UTF-16; other bytes are as they were.
#[must_use]
pub fn pem_of(bytes: Vec<u8>) -> Vec<u8> {
    let has_mark = [UTF_8, &UTF_16_LITTLE, &UTF_16_BIG].iter().any(|mark| bytes.starts_with(mark));
    if !has_mark {
        return bytes;
    }
    text_of(&bytes).map_or(bytes, String::into_bytes)
}

/// Reads the text of a file of at most `bytes_max` bytes.
///
/// # Errors
/// The file cannot be read, is longer, or is not text.
pub fn read_text(path: &Path, bytes_max: u64) -> Result<String> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(bytes_max + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > bytes_max {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("it is longer than {bytes_max} bytes")));
    }
    text_of(&bytes).map_err(|problem| Error::new(ErrorKind::InvalidData, problem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_a_byte_order_mark_is_no_part_of_the_text() {
        let utf_16 = |unit: fn(u16) -> [u8; 2]| "\u{feff}dé🐭\r\n".encode_utf16().flat_map(unit).collect::<Vec<u8>>();
        let files = ["dé🐭\r\n".into(), "\u{feff}dé🐭\r\n".into(), utf_16(u16::to_le_bytes), utf_16(u16::to_be_bytes)];
        for file in files {
            assert_eq!(text_of(&file), Ok("dé🐭\r\n".to_owned()), "{file:x?}");
        }
        let pem = b"-----BEGIN CERTIFICATE-----".to_vec();
        assert_eq!(pem_of([UTF_8, &pem].concat()), pem);
        assert_eq!(pem_of(pem.clone()), pem);
        assert_eq!(text_of(b""), Ok(String::new()));
        assert_eq!(text_of(b"\xff\xfea"), Err(NotText { line: 1, has_nul: false }));
    }

    #[test]
    fn regress_a_wrong_byte_is_told_with_its_line_whatever_ends_the_lines() {
        for (bytes, line) in [
            (b"a\nb\xe9\n".as_slice(), 2),
            (b"a\r\nb\xe9\r\n", 2),
            (b"a\rb\r\rc\xe9\r", 4),
            (b"a\r\n\xe9", 2),
            (b"a\n\r\xe9", 3),
        ] {
            assert_eq!(text_of(bytes), Err(NotText { line, has_nul: false }), "{bytes:x?}");
        }
    }

    #[test]
    fn regress_utf_16_without_a_mark_is_named() {
        for text in ["pressure_mpa,strain\r\n", "é,b\r\n"] {
            for unit in [u16::to_le_bytes, u16::to_be_bytes] {
                let problem = text_of(&text.encode_utf16().flat_map(unit).collect::<Vec<u8>>()).unwrap_err();
                assert!(
                    problem.to_string().contains("line 1") && problem.to_string().contains("UTF-16"),
                    "{text}: {problem}"
                );
            }
        }
        assert!(!text_of(b"\xe9").unwrap_err().to_string().contains("UTF-16"));
    }
}
