//! Messages of serde, from JSON, TOML or CBOR, for people who do not know Rust: the value that was given, and the values that
//! are allowed.

/// Rewords a message of serde. The field's name stands beside it. A message of another form is kept.
#[must_use]
pub fn json(message: &str) -> String {
    let message = without_position(message);
    if let Some(text) = syntax(message).or_else(|| number(message)) {
        return text.to_owned();
    }
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

/// A message about a whole text that is not JSON, with its line and column.
#[must_use]
pub fn not_json(message: &str) -> String {
    let text = without_position(message);
    format!("{}{}", data(text), &message[text.len()..])
}

/// The values of a type of Rust in plain English, such as `a whole number` for `i64`.
#[must_use]
pub fn required(type_name: &str) -> String {
    plain(type_name)
}

/// The words of `serde_json` about a text that is not JSON.
fn syntax(message: &str) -> Option<&'static str> {
    Some(match message {
        "EOF while parsing a list" => "the JSON ends within a list: send all of it, up to the ]",
        "EOF while parsing an object" => "the JSON ends within an object: send all of it, up to the }",
        "EOF while parsing a string" => "the JSON ends within a text: send all of it, up to the closing quote",
        "EOF while parsing a value" => "the JSON ends where a value is required: send all of it",
        "expected `:`" => "a colon is missing after the name of a field",
        "expected `,` or `]`" => "a comma or a ] is missing in a list",
        "expected `,` or `}`" => "a comma or a } is missing in an object",
        "expected ident" => "only the words true, false and null need no quotes",
        "expected value" => {
            "a value is required: a number, a text in double quotes, true, false, null, a list or an object"
        }
        "expected `\"`" => "a double quote is missing",
        "invalid escape" => "a text has an unknown escape after a backslash: write \\\\ for a backslash",
        "invalid number" => "a number is not written as in JSON, such as 0.5 or -1e3",
        "number out of range" => "a number is too large",
        "invalid unicode code point" => "a text is not in UTF-8",
        "control character (\\u0000-\\u001F) found while parsing a string" => {
            "a text has a line end, a tab or another control character: write it as an escape, such as \\n"
        }
        "key must be a string" => "the name of a field must be in double quotes",
        "invalid value: expected key to be a number in quotes" => {
            "the name of a field must be a number in double quotes"
        }
        "float key must be finite" => "the name of a field must be a finite number",
        "lone leading surrogate in hex escape" => "a text has one half of a character after \\u: write both halves",
        "trailing comma" => "a comma stands before a closing bracket: remove it",
        "trailing characters" => "other text follows the JSON: send one value only",
        "unexpected end of hex escape" => "an escape \\u in a text needs four digits",
        "recursion limit exceeded" => "too many lists and objects are within one another",
        _ => return None,
    })
}

/// The words of Rust's standard library about a text that is no number.
fn number(message: &str) -> Option<&'static str> {
    Some(match message {
        "invalid digit found in string" | "cannot parse integer from empty string" => "a whole number is required",
        "number too large to fit in target type" => "the number is too large",
        "number too small to fit in target type" => "the number is too small",
        "invalid float literal" | "cannot parse float from empty string" => "a number is required",
        "provided string was not `true` or `false`" => "true or false is required",
        _ => return None,
    })
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

    fn plain_text(text: &str) -> String {
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
            assert_eq!(plain_text(text), expected, "{text}");
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

    #[test]
    fn regress_texts_that_are_not_json_lose_the_words_of_the_library() {
        let deep = "[".repeat(200);
        for text in [
            "",
            "[",
            "[1",
            "{",
            "{\"a\"",
            "{\"a\":",
            "{\"a\" 1}",
            "{\"a\":1 \"b\"}",
            "[1 2]",
            "[1,]",
            "{\"a\":1,}",
            "{a:1}",
            "tru",
            "NaN",
            "\"a",
            "\"\\q\"",
            "\"\\u12\"",
            "\"\\ud800\"",
            "\"a\nb\"",
            "1e999",
            "01",
            "-",
            "{} x",
            deep.as_str(),
        ] {
            let raw = serde_json::from_str::<serde_json::Value>(text).unwrap_err().to_string();
            let (shown, position) = (not_json(&raw), raw.find(" at line ").map_or("", |at| &raw[at..]));
            let word = raw.strip_suffix(position).unwrap();
            assert!(!shown.contains(word) && !position.is_empty() && shown.ends_with(position), "{text}: {shown}");
            assert!(!json(&raw).contains(" at line "), "{text}");
        }
    }

    #[test]
    fn regress_texts_that_are_no_numbers_lose_the_words_of_the_library() {
        let whole = |text: &str| text.parse::<u8>().unwrap_err().to_string();
        let signed = "-200".parse::<i8>().unwrap_err().to_string();
        let float = |text: &str| text.parse::<f64>().unwrap_err().to_string();
        let truth = "x".parse::<bool>().unwrap_err().to_string();
        for raw in [whole("x"), whole(""), whole("300"), signed, float("x"), float(""), truth] {
            let shown = json(&raw);
            assert!(shown != raw && !shown.contains("string") && !shown.contains("type"), "{raw}: {shown}");
        }
        assert_eq!(required("i64"), "a whole number");
    }
}
