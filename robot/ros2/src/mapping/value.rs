//! Messages of any type, read by their layout.

use std::fmt;
use std::sync::Arc;

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, SeqAccess, Visitor};

use super::definitions::{Kind, Layout};

/// Most elements of a list: a greater one is a picture or a cloud of points.
const ELEMENTS_MAX: usize = 65_536;

/// A part of a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number, true (1) or false (0).
    Number(f64),
    /// A text.
    Text(String),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// The fields of a message, or another list.
    Parts(Vec<Value>),
}

/// Reads a message with this layout.
#[derive(Debug, Clone)]
pub struct MessageSeed(pub Arc<Layout>);

impl<'de> DeserializeSeed<'de> for MessageSeed {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        fields(&self.0, deserializer)
    }
}

fn fields<'de, D: Deserializer<'de>>(layout: &Layout, deserializer: D) -> Result<Value, D::Error> {
    deserializer.deserialize_tuple(layout.fields.len(), Fields(layout))
}

#[derive(Clone, Copy)]
struct OfKind<'k>(&'k Kind);

impl<'de> DeserializeSeed<'de> for OfKind<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        match self.0 {
            Kind::Bool => deserializer.deserialize_bool(One),
            Kind::Signed(8) => deserializer.deserialize_i8(One),
            Kind::Signed(16) => deserializer.deserialize_i16(One),
            Kind::Signed(32) => deserializer.deserialize_i32(One),
            Kind::Signed(_) => deserializer.deserialize_i64(One),
            Kind::Unsigned(8) => deserializer.deserialize_u8(One),
            Kind::Unsigned(16) => deserializer.deserialize_u16(One),
            Kind::Unsigned(32) => deserializer.deserialize_u32(One),
            Kind::Unsigned(_) => deserializer.deserialize_u64(One),
            Kind::Float32 => deserializer.deserialize_f32(One),
            Kind::Float64 => deserializer.deserialize_f64(One),
            Kind::Text => deserializer.deserialize_string(One),
            Kind::Message(layout) => fields(layout, deserializer),
            Kind::List(element) => deserializer.deserialize_seq(Elements(element)),
            Kind::Array(element, length) => deserializer.deserialize_tuple(*length, Elements(element)),
        }
    }
}

struct One;

impl Visitor<'_> for One {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a number or a text")
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Number(f64::from(u8::from(value))))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Value, E> {
        Ok(Value::Number(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Value, E> {
        Ok(Value::Number(value as f64))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        Ok(Value::Number(value))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Value, E> {
        Ok(Value::Text(value.to_owned()))
    }
}

struct Fields<'k>(&'k Layout);

impl<'de> Visitor<'de> for Fields<'_> {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "the fields of {}", self.0.name)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Value, A::Error> {
        let mut values = Vec::with_capacity(self.0.fields.len());
        for (at, (_, kind)) in self.0.fields.iter().enumerate() {
            let value = parts.next_element_seed(OfKind(kind))?;
            values.push(value.ok_or_else(|| A::Error::invalid_length(at, &self))?);
        }
        Ok(Value::Parts(values))
    }
}

struct Elements<'k>(&'k Kind);

impl<'de> Visitor<'de> for Elements<'_> {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Value, A::Error> {
        let (mut numbers, mut parts) = (Vec::new(), Vec::new());
        while let Some(value) = elements.next_element_seed(OfKind(self.0))? {
            match value {
                Value::Number(number) => numbers.push(number),
                other @ (Value::Text(_) | Value::Numbers(_) | Value::Parts(_)) => parts.push(other),
            }
            if numbers.len() + parts.len() > ELEMENTS_MAX {
                return Err(A::Error::custom(format!("a list has more than {ELEMENTS_MAX} elements")));
            }
        }
        Ok(if self.0.is_number() { Value::Numbers(numbers) } else { Value::Parts(parts) })
    }
}
