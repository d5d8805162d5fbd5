//! Messages of serde, from JSON, TOML or CBOR, for people who do not know Rust: the value that was given, and the values that
//! are allowed.

/// Rewords a message of serde. The field's name stands beside it. A message of another form is kept.
#[must_use]
pub fn json(message: &str) -> String {
    let message = without_position(message);
    let (problem, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    let quoted = problem.split('`').nth(1).unwrap_or_default();
    if problem.starts_with("unknown field") {
        return format!("there is no field {quoted}{}", allowed(expected, "; the fields are"));
    }
    if problem.starts_with("unknown variant") {
        return format!("{quoted} is not allowed{}", allowed(expected, "; allowed are"));
    }
    if problem.starts_with("missing field") {
        return "this field is required".to_owned();
    }
    if problem.starts_with("duplicate field") {
        return "this field is given more than once".to_owned();
    }
    match problem.strip_prefix("invalid type: ").or_else(|| problem.strip_prefix("invalid value: ")) {
        Some(given) if !expected.is_empty() => {
            format!("{} was given, {} is required", plain(given), plain(expected))
        }
        Some(_) | None => message.to_owned(),
    }
}

/// Rewords a message of serde that stands alone: it names the field, in back quotes.
#[must_use]
pub fn data(message: &str) -> String {
    let text = without_position(message);
    let (problem, expected) = text.split_once(", expected ").unwrap_or((text, ""));
    if problem.starts_with("missing field") {
        return format!("{problem}: add it");
    }
    if problem.starts_with("duplicate field") {
        return format!("{problem}: keep one of them");
    }
    if problem.starts_with("unknown field") {
        return format!("{problem}{}", allowed(expected, "; the fields are"));
    }
    if problem.starts_with("unknown variant") {
        return format!("{}{}", json(text), &message[text.len()..]);
    }
    json(message)
}

/// A message about a place in a file, such as one in TOML: the line, and the message, but not the line's content, which may
/// be a secret.
#[must_use]
pub fn in_file(text: &str, place: Option<std::ops::Range<usize>>, message: &str) -> String {
    let before = place.and_then(|place| text.get(..place.start)).unwrap_or_default();
    format!("line {}: {}", before.matches('\n').count() + 1, data(message))
}

/// The message without the position in the body, which says nothing beside the field's name.
fn without_position(message: &str) -> &str {
    message.rfind(" at line ").map_or(message, |at| &message[..at])
}

/// The names in back quotes, after `lead`; empty without names.
fn allowed(expected: &str, lead: &str) -> String {
    let names: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
    if names.is_empty() { String::new() } else { format!("{lead} {}", names.join(", ")) }
}

/// Serde's and Rust's names of types in plain English.
fn plain(named: &str) -> String {
    let whole = ["i8", "i16", "i32", "i64"];
    match named {
        "u8" => "a whole number from 0 to 255".to_owned(),
        "u16" => "a whole number from 0 to 65535".to_owned(),
        "u32" | "u64" | "usize" => "a whole number from 0 on".to_owned(),
        "f64" | "f32" => "a number".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" => "a text".to_owned(),
        "null" | "unit value" => "null".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" | "map" => "an object".to_owned(),
        "sequence" => "a list".to_owned(),
        _ if whole.contains(&named) => "a whole number".to_owned(),
        _ if named.starts_with("struct ") => "an object".to_owned(),
        _ => {
            let prefixes = ["string ", "integer ", "floating point ", "boolean "];
            let value = prefixes.iter().find_map(|prefix| named.strip_prefix(prefix));
            value.unwrap_or(named).replace('`', "")
        }
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize)]
    enum Mode {
        #[serde(rename = "ADVISE")]
        Advise,
        #[serde(rename = "AUTOMATIC")]
        Automatic,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only its errors are read")]
    struct Asked {
        mode: Mode,
        pressure_mpa: f64,
        whisker: u16,
        #[serde(default)]
        names: Vec<String>,
    }

    fn told(text: &str) -> String {
        json(&serde_json::from_str::<Asked>(text).unwrap_err().to_string())
    }

    #[test]
    fn messages_name_the_given_and_the_allowed_values_without_words_of_rust() {
        for (text, expected) in [
            (r#"{"mode":"AUTO","pressure_mpa":0.1,"whisker":1}"#, "AUTO is not allowed; allowed are ADVISE, AUTOMATIC"),
            (
                r#"{"mode":"ADVISE","pressure":0.1}"#,
                "there is no field pressure; the fields are mode, pressure_mpa, whisker, names",
            ),
            (r#"{"mode":"ADVISE","pressure_mpa":0.1}"#, "this field is required"),
            (r#"{"mode":"ADVISE","mode":"ADVISE"}"#, "this field is given more than once"),
            (r#"{"mode":"ADVISE","pressure_mpa":"high"}"#, "\"high\" was given, a number is required"),
            (r#"{"mode":"ADVISE","whisker":-1}"#, "-1 was given, a whole number from 0 to 65535 is required"),
            (r#"{"mode":"ADVISE","whisker":true}"#, "true was given, a whole number from 0 to 65535 is required"),
            (r#"{"mode":"ADVISE","names":{}}"#, "an object was given, a list is required"),
            (r#"{"mode":"ADVISE","names":[null]}"#, "null was given, a text is required"),
            (r#"7"#, "7 was given, an object is required"),
        ] {
            assert_eq!(told(text), expected, "{text}");
        }
        assert_eq!(json("the pressure must be at most 0.2 MPa"), "the pressure must be at most 0.2 MPa");
        assert_eq!(in_file("a = 1\nb = x", Some(6..7), "invalid key"), "line 2: invalid key");
        assert_eq!(data("missing field `c`"), "missing field `c`: add it");
        assert_eq!(data("unknown field `d`, expected `c` or `a`"), "unknown field `d`; the fields are c, a");
        assert_eq!(
            data("invalid type: string \"x\", expected u64"),
            "\"x\" was given, a whole number from 0 on is required"
        );
        assert_eq!(
            data("invalid type: integer `1`, expected a string at line 1 column 2"),
            "1 was given, a text is required"
        );
        let _ = (Mode::Advise, Mode::Automatic);
    }
}
