//! `contacts` as nearly every robot writes them, read in one pass: a burst is made of nothing else.
//!
//! What is not written plainly (fields in another order than the contract's, one that is unknown or missing, an escape in
//! a name, anything wrong) is left to the full reader, which alone refuses. So this one takes nothing that the other
//! does not take, and what it takes is the same to the last bit: a test holds them against each other.

use crate::{BootId, Contact, Contacts, Name};

/// More digits than this could be too much for 64 bits.
const DIGITS_MAX: usize = 18;

/// Reads a message; its contacts go into `list`, in place of what was there. None if it is not written plainly.
pub(super) fn contacts(text: &str, list: &mut Vec<Contact>) -> Option<Contacts> {
    list.clear();
    let mut reader = Reader { text, at: 0 };
    let boot_id = BootId::new(reader.field(b'{', "\"boot_id\"")?.string()?).ok()?;
    let seq = reader.field(b',', "\"seq\"")?.integer()?;
    reader.field(b',', "\"contacts\"")?.list(list)?;
    reader.take(b'}')?;
    reader.next().is_none().then(|| Contacts { boot_id, seq, contacts: std::mem::take(list) })
}

/// A place in a text.
struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Reader<'a> {
    fn list(&mut self, list: &mut Vec<Contact>) -> Option<()> {
        self.take(b'[')?;
        if self.next()? == b']' {
            return self.take(b']');
        }
        loop {
            list.push(self.contact()?);
            match self.next()? {
                b',' => self.at += 1,
                _ => return self.take(b']'),
            }
        }
    }

    fn contact(&mut self) -> Option<Contact> {
        let contact = Contact {
            array: Name::new(self.field(b'{', "\"array\"")?.string()?).ok()?,
            whisker: u16::try_from(self.field(b',', "\"whisker\"")?.integer()?).ok()?,
            t_us: self.field(b',', "\"t_us\"")?.integer()?,
            ratio: self.field(b',', "\"ratio\"")?.number()?,
            deflection_mm: self.field(b',', "\"deflection_mm\"")?.number()?,
            strain: self.field(b',', "\"strain\"")?.number()?,
            pressure_mpa: self.field(b',', "\"pressure_mpa\"")?.number()?,
            temperature_c: self.field(b',', "\"temperature_c\"")?.number()?,
        };
        self.take(b'}')?;
        Some(contact)
    }

    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    /// The next byte that is no white space, not taken yet.
    #[inline]
    fn next(&mut self) -> Option<u8> {
        loop {
            match self.peek()? {
                b' ' | b'\n' | b'\r' | b'\t' => self.at += 1,
                byte => return Some(byte),
            }
        }
    }

    #[inline]
    fn take(&mut self, byte: u8) -> Option<()> {
        if self.next()? != byte {
            return None;
        }
        self.at += 1;
        Some(())
    }

    /// Goes to the value of the field of that name, which is in its quotes already. Inlined, so that comparing is one
    /// instruction or two.
    #[inline(always)]
    fn field(&mut self, before: u8, quoted: &'static str) -> Option<&mut Self> {
        self.take(before)?;
        self.next()?;
        if !self.text.as_bytes().get(self.at..)?.starts_with(quoted.as_bytes()) {
            return None;
        }
        self.at += quoted.len();
        self.take(b':')?;
        self.next()?;
        Some(self)
    }

    /// A text in quotes without escapes.
    #[inline]
    fn string(&mut self) -> Option<&'a str> {
        self.take(b'"')?;
        let start = self.at;
        let rest = self.text.as_bytes().get(start..)?;
        let length = rest.iter().position(|&byte| byte == b'"' || byte == b'\\' || byte < b' ')?;
        self.at = start + length;
        self.take(b'"')?;
        self.text.get(start..start + length)
    }

    /// How many digits come next; they are taken.
    #[inline]
    fn digits(&mut self) -> usize {
        let start = self.at;
        while self.peek().is_some_and(|byte| byte.is_ascii_digit()) {
            self.at += 1;
        }
        self.at - start
    }

    /// The digits before a decimal point: none, or more than one after a zero, are no number in JSON.
    #[inline]
    fn whole(&mut self) -> Option<usize> {
        let first = self.peek();
        let count = self.digits();
        (count == 1 || count > 1 && first != Some(b'0')).then_some(count)
    }

    /// An integer from 0, without decimals or exponent.
    fn integer(&mut self) -> Option<u64> {
        let start = self.at;
        if self.whole()? > DIGITS_MAX || matches!(self.peek(), Some(b'.' | b'e' | b'E')) {
            return None;
        }
        let digits = self.text.as_bytes().get(start..self.at)?;
        Some(digits.iter().fold(0, |value, digit| 10 * value + u64::from(digit - b'0')))
    }

    /// A number as JSON writes it. The standard library gives the nearest one there is.
    fn number(&mut self) -> Option<f64> {
        let start = self.at;
        self.at += usize::from(self.peek() == Some(b'-'));
        self.whole()?;
        if self.peek() == Some(b'.') {
            self.at += 1;
            (self.digits() > 0).then_some(())?;
        }
        if let Some(b'e' | b'E') = self.peek() {
            self.at += 1;
            self.at += usize::from(matches!(self.peek(), Some(b'+' | b'-')));
            (self.digits() > 0).then_some(())?;
        }
        let value: f64 = self.text.get(start..self.at)?.parse().ok()?;
        value.is_finite().then_some(value)
    }
}

#[cfg(test)]
mod tests;
