//! The contract as documents for other people's tools: AsyncAPI 3.0, and a JSON Schema for each message.
//!
//! Both come from the types and constants that [`mod@crate::decode`] checks with, so they say what it enforces.
//! What no schema can say is in [`BEYOND_SCHEMAS`]. `vibrissa contract --write docs` writes them; a test keeps
//! the files in `docs` equal to this.

mod asyncapi;
mod channel;
pub mod examples;
mod schemas;

pub use channel::Channel;
pub use schemas::json_schema;

/// Version of the contract and of its documents: the first number is the one in the topics.
pub const CONTRACT_VERSION: &str = "1.0.0";

/// What receivers refuse although a message's schema allows it.
pub const BEYOND_SCHEMAS: &[&str] = &[
    "a payload that is too long, or not JSON in UTF-8",
    "a number that is written with decimals or an exponent where an integer is due (`1.0` for `1`)",
    "a field twice in one object",
    "a day that its month does not have, and the leap second after the year 9999, in `timestamp` and `issued`",
    "in a factsheet: the same array or whisker twice, a neighbour that is the whisker itself or that its array does \
     not have, `pressure_mpa` above `pressure_max_mpa`",
    "in a receipt: a `held` range whose last `seq` is below its first",
    "in a setpoint: contact ratios of `gain` that do not rise",
];

/// A document and where it belongs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Below the folder of documents, such as `schemas/contacts.json`.
    pub path: String,
    /// All of it.
    pub text: String,
}

/// Every document of the contract.
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
/// Never: it is made of texts, numbers and lists of them.
#[must_use]
pub fn asyncapi() -> String {
    let yaml = serde_saphyr::to_string(&asyncapi::Document::new()).expect("a document of texts and numbers");
    format!("# Written by `vibrissa contract --write docs`.\n{yaml}")
}

#[cfg(test)]
mod tests;
