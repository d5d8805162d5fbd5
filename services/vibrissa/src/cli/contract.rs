//! `vibrissa contract`: the MQTT contract as AsyncAPI and JSON Schema documents.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, Subcommand};
use serde_json::{Map, Value, from_str, to_string_pretty};

/// Arguments of `vibrissa contract`.
#[derive(Debug, Args)]
#[command(arg_required_else_help = true, args_conflicts_with_subcommands = true)]
pub struct ContractArgs {
    /// Write asyncapi.yaml, and a JSON Schema for each message in schemas/, into this folder.
    #[arg(long, value_name = "DIR")]
    write: Option<PathBuf>,
    #[command(subcommand)]
    print: Option<Print>,
}

#[derive(Debug, Subcommand)]
enum Print {
    /// Print the AsyncAPI 3.0 document as YAML.
    Asyncapi,
    /// Print the JSON Schemas (draft 2020-12) of all messages as one JSON object, by message name.
    Schemas,
}

/// The AsyncAPI document.
const ASYNCAPI: &str = include_str!("../../../../docs/asyncapi.yaml");

/// Defines `SCHEMAS`: the name of each message with its JSON Schema.
macro_rules! schemas {
    ($($name:literal)+) => {
        const SCHEMAS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../../docs/schemas/", $name, ".json")))),+];
    };
}

schemas!("connection" "factsheet" "contacts" "status" "receipt" "setpoint" "setpoint_state" "request" "test_state" "estimate" "maintenance" "supervisor_state" "supervisor_request");

/// JSON Schema of a message by its name, the last segment of its topic; `None` for an unknown one.
#[must_use]
pub(super) fn schema_of(message: &str) -> Option<&'static str> {
    SCHEMAS.iter().find(|(name, _)| *name == message).map(|(_, schema)| *schema)
}

/// Prints or writes the documents.
///
/// # Errors
/// A file cannot be written.
pub fn run(args: &ContractArgs, out: &mut dyn Write) -> Result<()> {
    match args.print {
        Some(Print::Asyncapi) => write!(out, "{ASYNCAPI}")?,
        Some(Print::Schemas) => {
            let schema = |&(name, text): &(&str, &str)| Ok((name.to_owned(), from_str(text)?));
            let schemas = SCHEMAS.iter().map(schema).collect::<Result<Map<String, Value>>>()?;
            writeln!(out, "{}", to_string_pretty(&schemas)?)?;
        }
        None => {}
    }
    let Some(folder) = &args.write else { return Ok(()) };
    let schemas = folder.join("schemas");
    fs::create_dir_all(&schemas).with_context(|| format!("creating a folder in {}", folder.display()))?;
    let asyncapi = (folder.join("asyncapi.yaml"), ASYNCAPI);
    let files = SCHEMAS.iter().map(|(name, text)| (schemas.join(format!("{name}.json")), *text));
    for (path, text) in std::iter::once(asyncapi).chain(files) {
        fs::write(&path, text).with_context(|| format!("writing {}", path.display()))?;
        writeln!(out, "written: {}", path.display())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::document::Channel;

    use super::*;

    #[test]
    fn every_message_has_its_schema() {
        let names: Vec<&str> = Channel::ALL.into_iter().map(Channel::name).collect();
        assert_eq!(SCHEMAS.iter().map(|(name, _)| *name).collect::<Vec<_>>(), names);
    }
}
