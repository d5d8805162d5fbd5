//! A payload that is being read, with the position for errors.

use std::convert::Infallible;

use cbor4ii::core::dec::{Decode, Read, Reference};
use cbor4ii::core::types::F16;

/// Bytes of a payload from the present position on.
#[derive(Clone, Copy)]
pub(super) struct Input<'a> {
    payload: &'a [u8],
    at: usize,
}

impl<'a> Read<'a> for Input<'a> {
    type Error = Infallible;

    #[inline]
    fn fill<'short>(&'short mut self, _: usize) -> Result<Reference<'a, 'short>, Infallible> {
        Ok(Reference::Long(self.payload.get(self.at..).unwrap_or_default()))
    }

    #[inline]
    fn advance(&mut self, count: usize) {
        self.at += count;
    }
}

impl<'a> Input<'a> {
    pub(super) fn new(payload: &'a [u8]) -> Self {
        Self { payload, at: 0 }
    }

    /// Number of bytes already read.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// The next byte, without consuming it.
    #[inline]
    pub(super) fn peek(&self) -> Option<u8> {
        self.payload.get(self.at).copied()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.at >= self.payload.len()
    }

    /// Moves behind these bytes, if they are the next ones.
    #[inline(always)]
    pub(super) fn after(&mut self, bytes: &'static [u8]) -> Option<&mut Self> {
        self.payload.get(self.at..)?.starts_with(bytes).then(|| self.at += bytes.len())?;
        Some(self)
    }

    /// Reads a value of a type; `None` if the next value has another type or is incomplete.
    #[inline]
    pub(super) fn value<T: Decode<'a>>(&mut self) -> Option<T> {
        T::decode(self).ok()
    }

    #[inline]
    pub(super) fn text(&mut self) -> Option<&'a str> {
        self.value()
    }

    /// The bytes of a text of known length that may not be UTF-8.
    pub(super) fn text_bytes(&mut self) -> Option<&'a [u8]> {
        let rest = self.payload.get(self.at + 1..)?;
        let (length, rest) = match self.peek()? {
            first @ 0x60..=0x77 => (usize::from(first - 0x60), rest),
            0x78 => rest.split_first().map(|(length, rest)| (usize::from(*length), rest))?,
            0x79 => rest.split_first_chunk().map(|(length, rest)| (u16::from_be_bytes(*length).into(), rest))?,
            _ => return None,
        };
        let bytes = rest.get(..length)?;
        self.at = self.payload.len() - (rest.len() - length);
        Some(bytes)
    }

    #[inline]
    pub(super) fn integer(&mut self) -> Option<u64> {
        self.value()
    }

    pub(super) fn truth(&mut self) -> Option<bool> {
        self.value()
    }

    /// Reads a finite number, which may be an integer of up to 64 bits.
    #[inline]
    pub(super) fn number(&mut self) -> Option<f64> {
        let number = match self.peek()? {
            0xfb => {
                let bits = self.payload.get(self.at + 1..)?.first_chunk()?;
                self.at += 9;
                f64::from_be_bytes(*bits)
            }
            0xfa => f64::from(self.value::<f32>()?),
            0xf9 => of_half(self.value::<F16>()?.0),
            0x00..=0x1b => self.integer()? as f64,
            0x20..=0x3b => self.value::<i64>()? as f64,
            _ => return None,
        };
        number.is_finite().then_some(number)
    }
}

/// Value of a number of 16 bits (RFC 8949, appendix D).
pub(super) fn of_half(bits: u16) -> f64 {
    let (exponent, mantissa) = (i32::from((bits >> 10) & 0x1f), f64::from(bits & 0x3ff));
    let magnitude = match exponent {
        0 => mantissa * 2_f64.powi(-24),
        31 if mantissa == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (mantissa + 1024.0) * 2_f64.powi(exponent - 25),
    };
    if bits & 0x8000 == 0 { magnitude } else { -magnitude }
}
