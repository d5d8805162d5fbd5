//! Lines to send, and fields of received ones, in fixed memory.

use core::fmt;

/// Lines that have waited for so long without a byte taken are old: nobody listens. µs.
const OLD_US: u64 = 500_000;

/// Bytes that wait to be sent.
pub struct Lines<const N: usize> {
    bytes: [u8; N],
    length: usize,
    /// Bytes were sent since the last look, and the time of the last look at which that was so. µs.
    has_moved: bool,
    moved_us: u64,
}

impl<const N: usize> Default for Lines<N> {
    fn default() -> Self {
        Lines { bytes: [0; N], length: 0, has_moved: false, moved_us: 0 }
    }
}

impl<const N: usize> Lines<N> {
    /// Adds a line; false, and nothing is added, if there is no room.
    pub(crate) fn add(&mut self, write: impl FnOnce(&mut Self) -> fmt::Result) -> bool {
        let before = self.length;
        let whole = write(self).and_then(|()| fmt::Write::write_str(self, "\n")).is_ok();
        if !whole {
            self.length = before;
        }
        whole
    }

    /// Bytes that wait.
    pub fn waiting(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    /// So many of the first bytes were sent.
    pub fn sent(&mut self, count: usize) {
        let count = count.min(self.length);
        self.has_moved |= count > 0;
        self.bytes.copy_within(count..self.length, 0);
        self.length -= count;
    }

    /// Forgets lines that nobody has taken, so that one who comes later hears no old ones; whether there were any. The first of
    /// them may have been sent in part.
    pub(crate) fn forget_old(&mut self, now_us: u64) -> bool {
        let is_old = !self.has_moved && self.length > 0 && now_us.saturating_sub(self.moved_us) >= OLD_US;
        if self.has_moved || self.length == 0 || is_old {
            self.has_moved = false;
            self.moved_us = now_us;
        }
        if is_old {
            self.length = 0;
        }
        is_old
    }
}

impl<const N: usize> fmt::Write for Lines<N> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let end = self.length + text.len();
        self.bytes.get_mut(self.length..end).ok_or(fmt::Error)?.copy_from_slice(text.as_bytes());
        self.length = end;
        Ok(())
    }
}

/// Text after a field's name and colon in a flat JSON object.
pub(crate) fn field<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    let mut rest = line;
    while let Some(at) = rest.find('"') {
        rest = &rest[at + 1..];
        let value = rest.strip_prefix(name).and_then(|after| after.strip_prefix('"'));
        if let Some(value) = value.and_then(|after| after.trim_start().strip_prefix(':')) {
            return Some(value.trim_start());
        }
    }
    None
}

/// Whether a value is this text.
pub(crate) fn is_text(value: &str, text: &str) -> bool {
    value.strip_prefix('"').and_then(|rest| rest.strip_prefix(text)).is_some_and(|rest| rest.starts_with('"'))
}

/// The number at the beginning of a value.
pub(crate) fn number(value: &str) -> Option<f32> {
    let end = value.find(|c: char| !matches!(c, '0'..='9' | '+' | '-' | '.' | 'e' | 'E')).unwrap_or(value.len());
    value[..end].parse().ok()
}
