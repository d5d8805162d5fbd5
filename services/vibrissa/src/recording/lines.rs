//! Reads a recording of any size, line by line.

use std::io::{self, BufRead, Read};

use vibrissa_edge::recording::{LineError, Recorded};

/// Size limit of a line, in bytes: the largest packet of a broker with every byte escaped.
pub const LINE_MAX_BYTES: usize = 16 * 1024 * 1024;

/// Reader of a recording; keeps one line in memory.
pub struct Lines<R> {
    reader: R,
    line: Vec<u8>,
    number: u64,
    bytes: u64,
}

impl<R: BufRead> Lines<R> {
    /// Reads from the start.
    pub fn new(reader: R) -> Self {
        Self { reader, line: Vec::new(), number: 0, bytes: 0 }
    }

    /// Number of the last line read, from 1.
    #[must_use]
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Number of bytes read.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The next line that is not empty, or its error; `None` at the end.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn next_line(&mut self) -> io::Result<Option<Result<Recorded, LineError>>> {
        loop {
            self.line.clear();
            let most = LINE_MAX_BYTES as u64 + 1;
            let read = (&mut self.reader).take(most).read_until(b'\n', &mut self.line)?;
            if read == 0 {
                return Ok(None);
            }
            self.bytes += read as u64;
            self.number += 1;
            if self.line.len() > LINE_MAX_BYTES && self.line.last() != Some(&b'\n') {
                self.skip_line()?;
                return Ok(Some(Err(LineError::TooLong(LINE_MAX_BYTES))));
            }
            if !self.line.trim_ascii().is_empty() {
                return Ok(Some(Recorded::read(self.line.trim_ascii())));
            }
        }
    }

    fn skip_line(&mut self) -> io::Result<()> {
        loop {
            let buffer = self.reader.fill_buf()?;
            let (skipped, is_over) = match buffer.iter().position(|&byte| byte == b'\n') {
                Some(at) => (at + 1, true),
                None => (buffer.len(), buffer.is_empty()),
            };
            self.reader.consume(skipped);
            self.bytes += skipped as u64;
            if is_over {
                return Ok(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_numbered_as_editors_do_and_a_long_one_is_passed_over() {
        let good = b"{\"received_us\":1,\"topic\":\"t\",\"payload\":{}}";
        let mut text = b"\nnonsense\r\n".to_vec();
        text.extend(vec![b'x'; LINE_MAX_BYTES + 100]);
        text.extend(b"\n");
        text.extend(good);
        let mut lines = Lines::new(&text[..]);
        assert!(matches!(lines.next_line().unwrap(), Some(Err(LineError::Malformed(_)))));
        assert_eq!(lines.number(), 2);
        assert_eq!(lines.next_line().unwrap(), Some(Err(LineError::TooLong(LINE_MAX_BYTES))));
        assert_eq!(lines.number(), 3);
        assert!(matches!(lines.next_line().unwrap(), Some(Ok(_))), "the last line needs no line end");
        assert_eq!(lines.number(), 4);
        assert_eq!(lines.next_line().unwrap(), None);
        assert_eq!(lines.bytes(), text.len() as u64);
    }
}
