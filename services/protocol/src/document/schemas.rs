//! Schemas of the messages: JSON Schema 2020-12 for the separate files, and draft 7 inside the AsyncAPI document,
//! whose schemas are a superset of that draft.

use std::collections::BTreeMap;

use schemars::generate::SchemaSettings;
use schemars::transform::{ReplacePrefixItems, Transform};
use schemars::{Schema, SchemaGenerator};
use serde_json::Value;

use super::Channel;
use crate::messages::{
    Connection, Contacts, Estimate, Factsheet, Maintenance, Receipt, Request, Setpoint, SetpointState, Status,
    TestState,
};
use crate::{RobotTopic, SupervisorRequest, SupervisorState, schema};

/// The JSON Schema 2020-12 of a channel's message, with examples.
#[must_use]
pub fn json_schema(channel: Channel) -> Schema {
    let generator = SchemaSettings::draft2020_12().with_transform(schema::without_number_formats).into_generator();
    let mut schema = root(channel, generator);
    let examples: Vec<Value> = channel.examples().iter().map(|(_, text)| parsed(text)).collect();
    schema.insert("examples".to_owned(), Value::Array(examples));
    schema
}

/// Parses an example.
pub(super) fn parsed(text: &str) -> Value {
    serde_json::from_str(text).expect("a test decodes every example")
}

fn root(channel: Channel, generator: SchemaGenerator) -> Schema {
    match channel {
        Channel::Robot(RobotTopic::Connection) => generator.into_root_schema_for::<Connection>(),
        Channel::Robot(RobotTopic::Factsheet) => generator.into_root_schema_for::<Factsheet>(),
        Channel::Robot(RobotTopic::Contacts) => generator.into_root_schema_for::<Contacts>(),
        Channel::Robot(RobotTopic::Status) => generator.into_root_schema_for::<Status>(),
        Channel::Robot(RobotTopic::Receipt) => generator.into_root_schema_for::<Receipt>(),
        Channel::Robot(RobotTopic::Setpoint) => generator.into_root_schema_for::<Setpoint>(),
        Channel::Robot(RobotTopic::SetpointState) => generator.into_root_schema_for::<SetpointState>(),
        Channel::Robot(RobotTopic::Request) => generator.into_root_schema_for::<Request>(),
        Channel::Robot(RobotTopic::TestState) => generator.into_root_schema_for::<TestState>(),
        Channel::Robot(RobotTopic::Estimate) => generator.into_root_schema_for::<Estimate>(),
        Channel::Robot(RobotTopic::Maintenance) => generator.into_root_schema_for::<Maintenance>(),
        Channel::SupervisorState => generator.into_root_schema_for::<SupervisorState>(),
        Channel::SupervisorRequest => generator.into_root_schema_for::<SupervisorRequest>(),
    }
}

/// Name of the component that describes a channel's payload.
pub(super) fn component_name(channel: Channel) -> String {
    title(&root(channel, SchemaGenerator::default()))
}

fn title(schema: &Schema) -> String {
    schema.get("title").and_then(Value::as_str).expect("a root schema has its type's name").to_owned()
}

/// All components by name: messages and their parts.
pub(super) fn components() -> BTreeMap<String, Schema> {
    let settings = || {
        SchemaSettings::draft07().with(|settings| {
            settings.definitions_path = "/components/schemas".into();
            settings.meta_schema = None;
        })
    };
    let mut all = BTreeMap::new();
    for channel in Channel::ALL {
        let mut schema = root(channel, settings().with_transform(schema::without_number_formats).into_generator());
        let parts = schema.remove("components").and_then(|mut found| found.get_mut("schemas").map(Value::take));
        if let Some(Value::Object(parts)) = parts {
            for (name, part) in parts {
                let mut part = Schema::try_from(part).expect("a part of a schema is a schema");
                // The generator transforms only what it finds in the usual places.
                ReplacePrefixItems::default().transform(&mut part);
                schema::without_number_formats(&mut part);
                all.insert(name, part);
            }
        }
        all.insert(title(&schema), schema);
    }
    all
}
