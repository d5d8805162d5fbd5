//! The AsyncAPI 3.0 document. It describes the robot: the robot sends, the supervisor receives.

use std::collections::BTreeMap;

use schemars::Schema;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::schemas::{component_name, components, parsed};
use super::{BEYOND_SCHEMAS, CONTRACT_VERSION, Channel};
use crate::{Name, PAYLOAD_MAX_BYTES, RobotTopic};

/// Version of the MQTT bindings.
const BINDING_VERSION: &str = "0.2.0";

/// The whole document, in reading order.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    asyncapi: &'static str,
    info: Value,
    default_content_type: &'static str,
    servers: Value,
    channels: BTreeMap<&'static str, Value>,
    operations: BTreeMap<String, Value>,
    components: Components,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Components {
    messages: BTreeMap<&'static str, Value>,
    parameters: Value,
    security_schemes: Value,
    schemas: BTreeMap<String, Schema>,
}

impl Document {
    pub(super) fn new() -> Self {
        let of_each = |make: fn(Channel) -> Value| Channel::ALL.iter().map(|&one| (one.name(), make(one))).collect();
        Self {
            asyncapi: "3.0.0",
            info: info(),
            default_content_type: "application/json",
            servers: servers(),
            channels: of_each(channel),
            operations: Channel::ALL.iter().map(|&one| operation(one)).collect(),
            components: Components {
                messages: of_each(message),
                parameters: parameters(),
                security_schemes: json!({
                    "password": {
                        "type": "userPassword",
                        "description": "If the broker has users: a robot's user is FLEET/ROBOT. It may publish below \
                                        its own level only, and subscribe there and to supervisor/request.",
                    }
                }),
                schemas: components(),
            },
        }
    }
}

fn info() -> Value {
    let beyond: Vec<String> = BEYOND_SCHEMAS.iter().map(|one| format!("- {one}")).collect();
    let description = format!(
        "MQTT 5 messages of a robot with soft whiskers. **This document describes the robot**: where it \
         says `send`, the robot publishes and the supervisor subscribes; where it says `receive`, the supervisor \
         publishes and the robot subscribes.\n\n\
         Every message carries `boot_id`, new at each start of its sender, and `seq`, from 0 per boot and topic and \
         without gaps: both identify it, and a duplicate changes nothing. Fields that a receiver does \
         not know are ignored; a message with a missing or wrong field is refused. Contacts, missed touches and the entries \
         of a status are judged one by one: a wrong one is refused alone, counted, and never recorded, also if its message \
         gets a receipt. A payload has at most {PAYLOAD_MAX_BYTES} bytes.\n\n\
         A message that matches its schema is still refused for:\n\n{}\n\n\
         Rules for a robot's behaviour over time, such as sending messages again without a receipt, are stated with \
         the messages concerned.\n\n\
         Level `{}` of a fleet belongs to the supervisor. Every few seconds it publishes a probe there for each topic \
         that robots send, such as `whisker/v1/lab/supervisor/contacts`, and expects to receive it through its own \
         subscriptions. The broker must let the supervisor publish there, and no robot. Robots read `{}/request` there.\n\n\
         **Retained messages are a convenience.** A broker may forget all of them, or refuse to retain any (MQTT 5, Retain \
         Available = 0; then clients publish without the retain flag). Requests for births replace them.",
        beyond.join("\n"),
        Name::RESERVED,
        Name::RESERVED
    );
    json!({
        "title": "Soft whiskers: the robot",
        "version": CONTRACT_VERSION,
        "description": description,
        "license": { "name": "MIT OR Apache-2.0" },
    })
}

fn servers() -> Value {
    let server = |protocol: &str, port: &str, summary: &str, security: bool| {
        let mut server = json!({
            "host": "{host}",
            "protocol": protocol,
            "protocolVersion": "5.0",
            "summary": summary,
            "variables": { "host": {
                "description": format!("Name or address of the broker, and its port, usually {port}."),
                "default": format!("localhost:{port}"),
            } },
            "bindings": { "mqtt": {
                "cleanSession": true,
                "lastWill": {
                    "topic": Channel::Robot(RobotTopic::Connection).address(),
                    "qos": Channel::Robot(RobotTopic::Connection).qos(),
                    "retain": Channel::Robot(RobotTopic::Connection).is_retained(),
                    "message": super::examples::CONNECTION_WILL,
                },
                "bindingVersion": BINDING_VERSION,
            } },
        });
        if security {
            server["security"] = json!([{ "$ref": "#/components/securitySchemes/password" }]);
        }
        server
    };
    json!({
        "plain": server("mqtt", "1883", "Without TLS, such as the supervisor's own broker.", false),
        "tls": server("secure-mqtt", "8883", "A broker with TLS and users.", true),
    })
}

fn parameters() -> Value {
    json!({
        "fleet": {
            "description": format!("The robot's fleet: {}.", Name::pattern()),
            "examples": ["lab"],
            "x-pattern": Name::pattern(),
        },
        "robot": {
            "description": format!("The robot: {}; {} is reserved.", Name::pattern(), Name::RESERVED),
            "examples": ["crawler-1"],
            "x-pattern": Name::robot_pattern(),
        },
    })
}

fn channel(channel: Channel) -> Value {
    let address = channel.address();
    let used = ["fleet", "robot"].into_iter().filter(|name| address.contains(&format!("{{{name}}}")));
    let parameters: Map<String, Value> =
        used.map(|name| (name.to_owned(), json!({ "$ref": format!("#/components/parameters/{name}") }))).collect();
    json!({
        "address": address,
        "description": channel.purpose(),
        "parameters": parameters,
        "messages": { channel.name(): { "$ref": format!("#/components/messages/{}", channel.name()) } },
    })
}

fn operation(channel: Channel) -> (String, Value) {
    let name = channel.name();
    let (action, summary) = if channel.is_from_robot() {
        ("send", "The robot publishes; the supervisor subscribes, with + in place of the robot.")
    } else {
        ("receive", "The supervisor publishes; the robot subscribes.")
    };
    let mut mqtt = json!({
        "qos": channel.qos(), "retain": channel.is_retained(), "bindingVersion": BINDING_VERSION,
    });
    let mut operation = json!({
        "action": action,
        "channel": { "$ref": format!("#/channels/{name}") },
        "summary": summary,
        "messages": [{ "$ref": format!("#/channels/{name}/messages/{name}") }],
    });
    if channel == Channel::Robot(RobotTopic::Setpoint) {
        // The expiry is that of the setpoint itself, which the supervisor chooses.
        mqtt["messageExpiryInterval"] = json!({ "type": "integer", "minimum": 1 });
        operation["reply"] = json!({ "channel": { "$ref": "#/channels/setpoint_state" } });
    }
    operation["bindings"] = json!({ "mqtt": mqtt });
    (format!("{action}_{name}"), operation)
}

fn message(channel: Channel) -> Value {
    let example = |(name, text): &(&str, &str)| json!({ "name": name, "payload": parsed(text) });
    let mut message = json!({
        "name": channel.name(),
        "title": component_name(channel),
        "summary": channel.purpose(),
        "payload": { "$ref": format!("#/components/schemas/{}", component_name(channel)) },
        "examples": channel.examples().iter().map(example).collect::<Vec<_>>(),
    });
    if matches!(channel, Channel::Robot(RobotTopic::Setpoint | RobotTopic::SetpointState)) {
        message["correlationId"] = json!({
            "description": "The command and its result.",
            "location": "$message.payload#/command_id",
        });
    }
    message
}
