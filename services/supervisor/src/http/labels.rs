//! Labels of robots in requests.

use serde::{Deserialize, Serialize};
use utoipa::openapi::schema::{ObjectBuilder, SchemaType, Type};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};
use vibrissa_edge::labels::{self, LabelConditions, LabelKey, LabelValue};

/// Conditions on the labels of a robot: `key=value`, or `key` for any value; up to 8, separated by commas.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct LabelFilter(pub LabelConditions);

/// Key of a label.
#[derive(Debug, Clone, Deserialize)]
#[serde(transparent)]
pub struct LabelKeyText(pub LabelKey);

/// Value of a label.
#[derive(Debug, Clone, Deserialize)]
#[serde(transparent)]
pub struct LabelValueText(pub LabelValue);

/// A text with a pattern, which the description of the field explains.
pub(super) fn text(pattern: String, description: &str, example: &str) -> RefOr<Schema> {
    let text = ObjectBuilder::new().schema_type(SchemaType::Type(Type::String)).pattern(Some(pattern));
    text.description(Some(description)).examples([example]).into()
}

fn without_ends(pattern: &str) -> &str {
    pattern.trim_start_matches('^').trim_end_matches('$')
}

macro_rules! texts {
    ($($name:ident($pattern:expr, $description:literal, $example:literal))+) => {
        $(impl PartialSchema for $name {
            fn schema() -> RefOr<Schema> {
                text($pattern, $description, $example)
            }
        }

        impl ToSchema for $name {})+
    };
}

texts! {
    LabelKeyText(labels::KEY_PATTERN.to_owned(), "Key of a label.", "hall")
    LabelValueText(labels::VALUE_PATTERN.to_owned(), "Value of a label.", "2")
    LabelFilter(
        conditions(),
        "Conditions on the labels of the robot, separated by commas, all of which must hold: `key=value`, or `key` for any value.",
        "hall=2,line"
    )
}

fn conditions() -> String {
    let (key, value) = (without_ends(labels::KEY_PATTERN), without_ends(labels::VALUE_PATTERN));
    format!("^{key}(={value})?(,{key}(={value})?){{0,{}}}$", labels::CONDITIONS_MAX - 1)
}
