//! A recorded message as a line of JSON: the format of `vibrissa record`, and of black boxes.
//!
//! `{"received_us":1795248000123456,"topic":"whisker/v1/f/r/contacts","payload":{...}}`. A payload that is a JSON
//! object is `payload` itself, byte for byte except for its line ends. Any other text is `payload` as a JSON string. A
//! payload that is not UTF-8 is in `payload_base64` instead.

use std::borrow::Cow;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{INTEGER_LIMIT, plain};

/// A message as it was received.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recorded {
    /// Time of reception by the recorder's clock.
    pub received: Micros,
    /// MQTT topic of the message.
    pub topic: String,
    /// Payload of the message.
    pub payload: Vec<u8>,
}

/// Reason why a line is not a recorded message.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LineError {
    /// Not an object with these fields.
    #[error("not a recorded message: {0}")]
    Malformed(String),
    /// Neither `payload` nor `payload_base64`, or both.
    #[error("a recorded message has either payload or payload_base64")]
    NotOnePayload,
    /// `payload` is neither an object nor a text.
    #[error("payload must be an object, or a text if the payload is not a JSON object")]
    BadPayload,
    /// `payload_base64` is not valid base64.
    #[error("payload_base64 is not base64: {0}")]
    BadBase64(String),
    /// The time is too large to be plausible.
    #[error("received_us must be below 2^53")]
    BadTime,
    /// The line is longer than any recorded message.
    #[error("longer than {0} bytes")]
    TooLong(usize),
}

#[derive(Deserialize)]
struct Fields<'a> {
    received_us: u64,
    #[serde(borrow)]
    topic: Cow<'a, str>,
    #[serde(borrow)]
    payload: Option<&'a RawValue>,
    #[serde(borrow)]
    payload_base64: Option<Cow<'a, str>>,
}

impl Recorded {
    /// Reads a line.
    ///
    /// # Errors
    /// The reason why the line is not a recorded message.
    pub fn read(line: &[u8]) -> Result<Self, LineError> {
        let fields: Fields<'_> = serde_json::from_slice(line).map_err(|problem| malformed(&problem))?;
        if fields.received_us >= INTEGER_LIMIT {
            return Err(LineError::BadTime);
        }
        let payload = match (fields.payload, fields.payload_base64) {
            (Some(raw), None) => match raw.get().as_bytes().first() {
                Some(b'{') => raw.get().as_bytes().to_vec(),
                Some(b'"') => {
                    let text: String = serde_json::from_str(raw.get()).map_err(|problem| malformed(&problem))?;
                    text.into_bytes()
                }
                _ => return Err(LineError::BadPayload),
            },
            (None, Some(text)) => {
                STANDARD.decode(text.as_bytes()).map_err(|problem| LineError::BadBase64(problem.to_string()))?
            }
            (Some(_), Some(_)) | (None, None) => return Err(LineError::NotOnePayload),
        };
        Ok(Self { received: Micros(fields.received_us), topic: fields.topic.into_owned(), payload })
    }

    /// Appends the message as a line, with a line end.
    pub fn write(&self, out: &mut Vec<u8>) {
        let quoted = |text: &str| serde_json::Value::from(text).to_string();
        let head = format!("{{\"received_us\":{},\"topic\":{},", self.received.0, quoted(&self.topic));
        out.extend_from_slice(head.as_bytes());
        match std::str::from_utf8(&self.payload) {
            Ok(text) if is_object(text) => {
                out.extend_from_slice(b"\"payload\":");
                // Outside of texts, JSON treats a line end as a space.
                let flat = text.trim().bytes().map(|byte| if matches!(byte, b'\n' | b'\r') { b' ' } else { byte });
                out.extend(flat);
            }
            Ok(text) => out.extend_from_slice(format!("\"payload\":{}", quoted(text)).as_bytes()),
            Err(_) => {
                out.extend_from_slice(format!("\"payload_base64\":\"{}\"", STANDARD.encode(&self.payload)).as_bytes());
            }
        }
        out.extend_from_slice(b"}\n");
    }
}

fn is_object(text: &str) -> bool {
    text.trim_start().starts_with('{') && serde_json::from_str::<IgnoredAny>(text).is_ok()
}

/// Removes the parser's line number, which counts from the start of this line.
fn malformed(problem: &serde_json::Error) -> LineError {
    let place = problem.column();
    LineError::Malformed(format!("{} at column {place}", plain::data(&problem.to_string())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recorded(payload: &[u8]) -> Recorded {
        Recorded { received: Micros(17), topic: "whisker/v1/f/r/contacts".to_owned(), payload: payload.to_vec() }
    }

    fn line(recorded: &Recorded) -> String {
        let mut line = Vec::new();
        recorded.write(&mut line);
        String::from_utf8(line).unwrap()
    }

    #[test]
    fn any_payload_comes_back_byte_for_byte() {
        let payloads: [&[u8]; 10] = [
            br#"{"a":1.10,"a":2,"b":[1e999]}"#,
            b"{}",
            b"",
            b"hello",
            b"\"quoted\"",
            b"[1,2]",
            b"{\"cut off\":",
            b"{} and more",
            b"line\nends\r\n",
            &[0xff, 0x00, b'{'],
        ];
        for payload in payloads {
            let one = recorded(payload);
            let line = line(&one);
            assert_eq!(line.matches('\n').count(), 1, "{line}");
            assert_eq!(Recorded::read(line.trim_end().as_bytes()), Ok(one), "{line}");
        }
    }

    #[test]
    fn an_object_is_there_as_itself_with_its_line_ends_as_spaces() {
        let written = line(&recorded(b" {\"a\":\n 1}\r\n"));
        assert_eq!(written, "{\"received_us\":17,\"topic\":\"whisker/v1/f/r/contacts\",\"payload\":{\"a\":  1}}\n");
        assert!(line(&recorded(&[0xff])).contains("\"payload_base64\":\"/w==\""));
    }

    #[test]
    fn a_bad_line_says_what_is_wrong() {
        let problem = |text: &str| Recorded::read(text.as_bytes()).unwrap_err().to_string();
        assert!(problem("nonsense").starts_with("not a recorded message: only the words true, false and null"));
        assert!(problem(r#"{"topic":"t","payload":{}}"#).contains("missing field `received_us`: add it"));
        assert!(problem(r#"{"received_us":1,"topic":"t"}"#).contains("either payload or payload_base64"));
        assert!(problem(r#"{"received_us":1,"topic":"t","payload":{},"payload_base64":""}"#).contains("either"));
        assert!(problem(r#"{"received_us":1,"topic":"t","payload":7}"#).contains("must be an object"));
        assert!(problem(r#"{"received_us":1,"topic":"t","payload_base64":"%"}"#).contains("not base64"));
        assert!(problem(r#"{"received_us":9007199254740992,"topic":"t","payload":{}}"#).contains("2^53"));
        assert!(problem(r#"{"received_us":-1,"topic":"t","payload":{}}"#).contains("-1 was given"));
    }
}
