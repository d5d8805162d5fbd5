//! Cuts a stream of bytes into lines of bounded length.

/// Longest line, in bytes, without its end.
pub const LINE_MAX_BYTES: usize = 64 * 1024;

/// One line of a driver, without its end; `None` in place of one that was too long.
pub type Line = Option<Vec<u8>>;

/// Bytes of a line whose end has not come yet.
#[derive(Debug, Default)]
pub struct Lines {
    begun: Vec<u8>,
    /// The line was too long: its rest is thrown away.
    is_too_long: bool,
}

impl Lines {
    /// Takes bytes, and returns the lines that they complete. Empty lines are left out.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Line> {
        let mut lines = Vec::new();
        let mut rest = bytes;
        while let Some(end) = rest.iter().position(|&byte| byte == b'\n') {
            self.add(&rest[..end]);
            rest = &rest[end + 1..];
            if std::mem::take(&mut self.is_too_long) {
                lines.push(None);
                continue;
            }
            let mut line = std::mem::take(&mut self.begun);
            if line.last() == Some(&b'\r') {
                line.pop();
            }
            if !line.is_empty() {
                lines.push(Some(line));
            }
        }
        self.add(rest);
        lines
    }

    fn add(&mut self, bytes: &[u8]) {
        if self.is_too_long || self.begun.len() + bytes.len() > LINE_MAX_BYTES + 1 {
            self.is_too_long = true;
            self.begun = Vec::new();
        } else {
            self.begun.extend_from_slice(bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(lines: Vec<Line>) -> Vec<Option<String>> {
        lines.into_iter().map(|line| line.map(|line| String::from_utf8(line).unwrap())).collect()
    }

    #[test]
    fn lines_are_cut_at_line_feeds_wherever_the_stream_is_divided() {
        let bytes = b"one\r\n\n\r\ntwo\nthr";
        for at in 0..bytes.len() {
            let mut lines = Lines::default();
            let mut all = lines.push(&bytes[..at]);
            all.extend(lines.push(&bytes[at..]));
            assert_eq!(texts(all), [Some("one".to_owned()), Some("two".to_owned())], "{at}");
            assert_eq!(texts(lines.push(b"ee\n")), [Some("three".to_owned())]);
        }
    }

    #[test]
    fn a_line_that_is_too_long_takes_no_memory_and_the_next_one_is_read() {
        let mut lines = Lines::default();
        for _ in 0..1000 {
            assert!(lines.push(&[b'x'; 1000]).is_empty());
            assert!(lines.begun.capacity() <= 2 * LINE_MAX_BYTES);
        }
        assert_eq!(texts(lines.push(b"\nnext\n")), [None, Some("next".to_owned())]);
    }
}
