//! Fast reader of `contacts` messages in the form that nearly all robots write, in one pass.
//!
//! Any other form (a place other than a ratio, fields in another order, unknown or missing fields, escapes in a name,
//! any error) is left to the
//! full reader, which alone refuses messages. So this reader accepts no message that the full reader refuses, and
//! its values are equal to the last bit; a test compares the two.

use crate::{BootId, Contact, Contacts, Name};

/// Most digits that are sure to fit 64 bits.
const DIGITS_MAX: usize = 18;

/// Reads a message; its contacts replace the contents of `list`. `None` if the message has another form.
pub(super) fn contacts(text: &str, list: &mut Vec<Contact>) -> Option<Contacts> {
    list.clear();
    let mut reader = Reader { text, at: 0 };
    let boot_id = BootId::new(reader.field(b'{', "\"boot_id\"")?.string()?).ok()?;
    let seq = reader.field(b',', "\"seq\"")?.integer()?;
    reader.field(b',', "\"contacts\"")?.list(list)?;
    reader.take(b'}')?;
    reader.next().is_none().then(|| Contacts { boot_id, seq, contacts: std::mem::take(list), missed: Vec::new() })
}

/// A position in a text.
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
            ratio: Some(self.field(b',', "\"ratio\"")?.number()?),
            ratio_sd: None,
            distance_mm: None,
            distance_sd_mm: None,
            tip: false,
            deflection_mm: self.field(b',', "\"deflection_mm\"")?.number()?,
            strain: self.field(b',', "\"strain\"")?.number()?,
            saturated: false,
            pressure_mpa: self.field(b',', "\"pressure_mpa\"")?.number()?,
            temperature_c: self.field(b',', "\"temperature_c\"")?.number()?,
            angle_deg: None,
            angle_sd_deg: None,
            test_id: None,
        };
        self.take(b'}')?;
        Some(contact)
    }

    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    /// The next byte other than white space, without consuming it.
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

    /// Moves to the value of a field, given its quoted name. Inlined, so that the comparison takes one or two
    /// instructions.
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

    /// Reads a quoted text without escapes.
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

    /// Consumes digits and returns their number.
    #[inline]
    fn digits(&mut self) -> usize {
        let start = self.at;
        while self.peek().is_some_and(|byte| byte.is_ascii_digit()) {
            self.at += 1;
        }
        self.at - start
    }

    /// Consumes the digits before a decimal point; `None` for no digits, or for a leading zero before others
    /// (invalid in JSON).
    #[inline]
    fn whole(&mut self) -> Option<usize> {
        let first = self.peek();
        let count = self.digits();
        (count == 1 || count > 1 && first != Some(b'0')).then_some(count)
    }

    /// Reads an integer from 0, without decimals or exponent.
    fn integer(&mut self) -> Option<u64> {
        let start = self.at;
        if self.whole()? > DIGITS_MAX || matches!(self.peek(), Some(b'.' | b'e' | b'E')) {
            return None;
        }
        let digits = self.text.as_bytes().get(start..self.at)?;
        Some(digits.iter().fold(0, |value, digit| 10 * value + u64::from(digit - b'0')))
    }

    /// Reads a JSON number; the standard library rounds it to the nearest `f64`.
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
