//! Prints the configuration in effect with the origin of each value, as a configuration file; and an example file.

use std::fmt::Write;

use toml::Value;

use super::database::masked;
use super::keys::{Key, ValueKind};
use super::layers::{Layers, Sources};
use super::reader::MASK;

/// The configuration in effect, in TOML. Secrets are masked; a comment on each line names the origin.
///
/// `rust_log` is the value of the variable `RUST_LOG`, which overrides the key `log`.
#[must_use]
pub fn effective(sources: &Sources, rust_log: Option<&str>) -> String {
    let layers = Layers::new(sources);
    let is_external = layers.find(Key::MqttUrl).1.is_explicit();
    document(|text, key| {
        let (value, origin) = layers.find(key);
        let name = key.section().1;
        let line = match (value, key.kind()) {
            (None, _) => format!("# {name} is not set"),
            // Commented out, so that a file made from this output does not use the mask as password.
            (Some(_), ValueKind::Secret) => format!("# {name} = \"{MASK}\"  # {origin}"),
            // With mqtt.url, an explicit port would be refused.
            (Some(_), _) if key == Key::MqttPort && !origin.is_explicit() && is_external => {
                format!("# {name} has no effect with mqtt.url")
            }
            (Some(value), kind) => format!("{name} = {}  # {origin}", toml_value(value, kind)),
        };
        // A file name may contain line breaks.
        let line: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let _ = writeln!(text, "{line}");
        if let (Key::Log, Some(rust_log)) = (key, rust_log) {
            let _ = writeln!(text, "# RUST_LOG overrides it: {}", rust_log.escape_debug());
        }
    })
}

/// An example file with every key, its description and its default, all commented out.
#[must_use]
pub fn example() -> String {
    let head = "# Every key of vibrissa with its default. `vibrissa config` shows the values in effect and their origins.\n\
                #\n\
                # An environment variable overrides the file, and a flag overrides both: mqtt.ca_file is also\n\
                # VIBRISSA_MQTT_CA_FILE and --mqtt-ca-file. File names are relative to the working directory.\n\
                # Passwords are refused on the command line.\n\n";
    let keys = document(|text, key| {
        let name = key.section().1;
        let _ = match key.default() {
            Some(default) => writeln!(text, "# {}.\n#{name} = {default}", key.help()),
            None => writeln!(text, "# {}. Not set.\n#{name} = \"\"", key.help()),
        };
    });
    format!("{head}{keys}")
}

/// Writes every key under its section.
fn document(write: impl Fn(&mut String, Key)) -> String {
    let mut text = String::new();
    let mut open = None;
    for &key in Key::ALL {
        let section = key.section().0;
        if let Some(name) = section.filter(|_| section != open) {
            let _ = writeln!(text, "\n[{name}]");
            open = section;
        }
        write(&mut text, key);
    }
    text
}

fn toml_value(value: &Value, kind: ValueKind) -> String {
    // JSON's escapes are valid in TOML, except for one character.
    let quoted = |text: &str| serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007F");
    match value {
        Value::String(text) if kind == ValueKind::DatabaseUrl => quoted(&masked(text)),
        Value::String(text) => quoted(text),
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(|item| toml_value(item, kind)).collect();
            format!("[{}]", items.join(", "))
        }
        Value::Float(number) => format!("{number:?}"),
        Value::Integer(number) => number.to_string(),
        Value::Boolean(truth) => truth.to_string(),
        // A valid configuration has no such value.
        Value::Datetime(_) | Value::Table(_) => "\"\"".to_owned(),
    }
}
