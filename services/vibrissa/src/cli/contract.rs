//! `vibrissa contract`: the MQTT contract as AsyncAPI and JSON Schema documents.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, Subcommand};
use serde_json::{Map, to_string_pretty, to_value};
use vibrissa_protocol::document::{self, Channel};

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

/// Prints or writes the documents.
///
/// # Errors
/// A file cannot be written.
pub fn run(args: &ContractArgs, out: &mut dyn Write) -> Result<()> {
    match args.print {
        Some(Print::Asyncapi) => write!(out, "{}", document::asyncapi())?,
        Some(Print::Schemas) => {
            let schema = |channel: Channel| Ok((channel.name().to_owned(), to_value(document::json_schema(channel))?));
            let schemas = Channel::ALL.into_iter().map(schema).collect::<Result<Map<_, _>>>()?;
            writeln!(out, "{}", to_string_pretty(&schemas)?)?;
        }
        None => {}
    }
    let Some(folder) = &args.write else { return Ok(()) };
    fs::create_dir_all(folder.join("schemas")).with_context(|| format!("creating a folder in {}", folder.display()))?;
    for file in document::files() {
        let path = folder.join(file.path);
        fs::write(&path, file.text).with_context(|| format!("writing {}", path.display()))?;
        writeln!(out, "written: {}", path.display())?;
    }
    Ok(())
}
