//! The contract as documents: AsyncAPI 3.0, and a JSON Schema for each message.
//!
//! Both are generated from the types and constants that [`mod@crate::decode`] uses, so they state what it enforces.
//! [`BEYOND_SCHEMAS`] lists the rules that a schema cannot express.
//!
//! A test compares the files in `docs` with the code, and writes them if the variable `VIBRISSA_WRITE_DOCS` is set. The
//! program contains those files (`vibrissa contract`), so that only tests need the feature `documents`, which generates
//! them.

#[cfg(feature = "documents")]
mod asyncapi;
mod channel;
pub mod examples;
#[cfg(feature = "documents")]
mod schemas;

pub use channel::Channel;
#[cfg(feature = "documents")]
pub use schemas::json_schema;

/// Version of the contract and of its documents; the topics contain its major number.
pub const CONTRACT_VERSION: &str = "1.0.0";

/// Messages that receivers refuse although they match the schema.
pub const BEYOND_SCHEMAS: &[&str] = &[
    "a payload that is too long or is not JSON in UTF-8",
    "a field twice in one object",
    "a day that does not exist in its month, or the leap second after the year 9999, in `timestamp` and `issued`",
    "in a factsheet: the same array or whisker twice, a neighbour that is the whisker itself or does not exist in \
     its array, `pressure_mpa` above `pressure_max_mpa`",
    "in a receipt: a `held` range whose last `seq` is below its first",
    "in a setpoint or an estimate: contact ratios of `gain` that do not rise",
    "in an estimate: the same whisker twice, `length_mm` outside `length_low_mm` to `length_high_mm`",
];

/// A document with its path.
#[cfg(feature = "documents")]
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Path below the folder of documents, such as `schemas/contacts.json`.
    pub path: String,
    /// Full text of the document.
    pub text: String,
}

/// All documents of the contract.
#[cfg(feature = "documents")]
#[must_use]
pub fn files() -> Vec<File> {
    let asyncapi = File { path: "asyncapi.yaml".to_owned(), text: asyncapi() };
    let schema = |channel: &Channel| {
        let text = serde_json::to_string_pretty(&json_schema(*channel)).expect("a schema is JSON");
        File { path: format!("schemas/{}.json", channel.name()), text: text + "\n" }
    };
    std::iter::once(asyncapi).chain(Channel::ALL.iter().map(schema)).collect()
}

/// The AsyncAPI 3.0 document, in YAML.
///
/// # Panics
/// Never: it consists of texts, numbers and lists of them.
#[cfg(feature = "documents")]
#[must_use]
pub fn asyncapi() -> String {
    let yaml = serde_saphyr::to_string(&asyncapi::Document::new()).expect("a document of texts and numbers");
    format!("# Generated from the types of vibrissa-protocol; docs/README.md says how.\n{yaml}")
}

#[cfg(test)]
#[cfg(feature = "documents")]
mod tests;
