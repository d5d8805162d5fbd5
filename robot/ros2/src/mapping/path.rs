//! Places of values in messages, such as `position[slide]` or `wrench.force.z`.

use std::fmt;

use super::definitions::{Kind, Layout};
use super::value::Value;

/// Names by which elements of a list of messages are found.
const NAMES: [&str; 2] = ["name", "key"];

#[derive(Debug, Clone, PartialEq)]
enum Step {
    Field(usize),
    Index(usize),
    /// The element of a list of messages whose field at this place has this text.
    Keyed(usize, String),
    /// The number of the list in the first field whose place is that of this text in the list of the second field.
    Named {
        list: usize,
        names: usize,
        text: String,
    },
}

/// A place in messages of a layout.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    text: String,
    steps: Vec<Step>,
    is_list: bool,
}

impl fmt::Display for Path {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.text)
    }
}

/// Splits `a.b[c]` into names of fields, each with the texts in the brackets after it.
fn split(text: &str) -> Result<Vec<(&str, Vec<&str>)>, String> {
    let wrong = || format!("the field {text:.64} is no place: write it as data[0], wrench.force.z or position[slide]");
    let mut parts = Vec::new();
    let mut rest = text;
    loop {
        let end = rest.find(['.', '[']).unwrap_or(rest.len());
        let (name, mut after) = rest.split_at(end);
        if name.is_empty() {
            return Err(wrong());
        }
        let mut indexes = Vec::new();
        while let Some(inner) = after.strip_prefix('[') {
            let (index, next) = inner.split_once(']').ok_or_else(wrong)?;
            if index.is_empty() {
                return Err(wrong());
            }
            indexes.push(index);
            after = next;
        }
        parts.push((name, indexes));
        if after.is_empty() {
            return Ok(parts);
        }
        rest = after.strip_prefix('.').ok_or_else(wrong)?;
    }
}

fn names_of(layout: &Layout) -> String {
    layout.fields.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ")
}

/// The list of texts `name` beside a list of numbers.
fn names_beside(layout: &Layout) -> Option<usize> {
    layout.field(NAMES[0]).filter(|(_, kind)| kind.element() == Some(&Kind::Text)).map(|(at, _)| at)
}

impl Path {
    /// Finds a place in a layout.
    ///
    /// # Errors
    /// The layout has no such place, or no numbers there.
    pub fn find(text: &str, layout: &Layout) -> Result<Self, String> {
        let (mut steps, mut within) = (Vec::new(), layout);
        let parts = split(text)?;
        let last = parts.len() - 1;
        for (part, (name, indexes)) in parts.into_iter().enumerate() {
            let found = within.field(name);
            let Some((at, mut kind)) = found else {
                return Err(format!("{} has no field {name:.64}; it has {}", within.name, names_of(within)));
            };
            steps.push(Step::Field(at));
            for index in indexes {
                let Some(element) = kind.element() else {
                    return Err(format!("{name} of {} is no list, so it has no [{index:.64}]", within.name));
                };
                let step = match (index.parse::<usize>(), element, names_beside(within)) {
                    (Ok(index), ..) => Step::Index(index),
                    (Err(_), Kind::Message(inner), _) => {
                        let keys = NAMES.iter().filter_map(|name| inner.field(name));
                        let key = keys.into_iter().find(|(_, kind)| **kind == Kind::Text);
                        let key =
                            key.ok_or_else(|| format!("{} has no name: use a number in [{index:.64}]", inner.name));
                        Step::Keyed(key?.0, index.to_owned())
                    }
                    (Err(_), element, Some(names)) if element.is_number() => {
                        steps.pop();
                        Step::Named { list: at, names, text: index.to_owned() }
                    }
                    (Err(_), ..) => {
                        return Err(format!("{name} of {} has no names: use a number in [{index:.64}]", within.name));
                    }
                };
                if let (Step::Index(index), Kind::Array(_, length)) = (&step, kind)
                    && index >= length
                {
                    return Err(format!("{name} of {} has {length} elements, so it has no [{index}]", within.name));
                }
                steps.push(step);
                kind = element;
            }
            match kind {
                Kind::Message(inner) if part < last => within = inner,
                Kind::Message(inner) => {
                    return Err(format!("{text} is {} and no number; it has {}", inner.name, names_of(inner)));
                }
                _ if part < last => return Err(format!("{name} of {} has no fields", within.name)),
                Kind::List(element) | Kind::Array(element, _) if element.is_number() => {
                    return Ok(Self { text: text.to_owned(), steps, is_list: true });
                }
                Kind::List(_) | Kind::Array(..) => {
                    return Err(format!("{text} is a list of messages or texts: name one of them in []"));
                }
                Kind::Bool
                | Kind::Signed(_)
                | Kind::Unsigned(_)
                | Kind::Float32
                | Kind::Float64
                // Diagnostics have numbers as texts.
                | Kind::Text => {}
            }
        }
        Ok(Self { text: text.to_owned(), steps, is_list: false })
    }

    /// Whether it names an element of a list: messages of other publishers of the topic may have none of this name.
    #[must_use]
    pub fn is_named(&self) -> bool {
        self.steps.iter().any(|step| matches!(step, Step::Keyed(..) | Step::Named { .. }))
    }

    /// Whether it leads to a list of numbers.
    #[must_use]
    pub fn is_list(&self) -> bool {
        self.is_list
    }

    /// The numbers there in a message; `None` if no element has the name.
    ///
    /// # Errors
    /// The message is too short, or has no number there.
    pub fn numbers(&self, message: &Value) -> Result<Option<Vec<f64>>, String> {
        let missing = |what: String| format!("{}: {what}", self.text);
        let mut at = message;
        for step in &self.steps {
            at = match (step, at) {
                (Step::Field(field), Value::Parts(parts)) => {
                    parts.get(*field).ok_or_else(|| missing("the message is too short".to_owned()))?
                }
                (Step::Index(index), Value::Parts(parts)) => {
                    parts.get(*index).ok_or_else(|| missing(format!("the list has {} elements", parts.len())))?
                }
                (Step::Index(index), Value::Numbers(numbers)) => {
                    let number = numbers.get(*index).copied();
                    return number
                        .map(|number| Some(vec![number]))
                        .ok_or_else(|| missing(format!("the list has {} elements", numbers.len())));
                }
                (Step::Keyed(key, text), Value::Parts(parts)) => {
                    let is_it = |part: &&Value| match part {
                        Value::Parts(fields) => matches!(fields.get(*key), Some(Value::Text(name)) if name == text),
                        Value::Number(_) | Value::Text(_) | Value::Numbers(_) => false,
                    };
                    let Some(found) = parts.iter().find(is_it) else { return Ok(None) };
                    found
                }
                (Step::Named { list, names, text }, Value::Parts(parts)) => {
                    let (Some(Value::Numbers(numbers)), Some(Value::Parts(names))) =
                        (parts.get(*list), parts.get(*names))
                    else {
                        return Err(missing("the message is too short".to_owned()));
                    };
                    let found = names.iter().position(|name| matches!(name, Value::Text(name) if name == text));
                    let Some(found) = found else { return Ok(None) };
                    let number = numbers.get(found).copied();
                    return number.map(|number| Some(vec![number])).ok_or_else(|| {
                        missing(format!("{text:.64} is element {found}, and the list has {}", numbers.len()))
                    });
                }
                _ => return Err(missing("the message has another form".to_owned())),
            };
        }
        match at {
            Value::Number(number) => Ok(Some(vec![*number])),
            Value::Numbers(numbers) => Ok(Some(numbers.clone())),
            Value::Text(text) => match text.trim().parse() {
                Ok(number) => Ok(Some(vec![number])),
                Err(_) => Err(missing(format!("{text:.64} is no number"))),
            },
            Value::Parts(_) => Err(missing("the message has another form".to_owned())),
        }
    }
}
