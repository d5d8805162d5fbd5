//! JSON as a tree that can be changed into invalid JSON.

use serde_json::Value;

/// A node. Entries of lists and objects can be any text, and names can repeat.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    /// Text written without changes.
    Leaf(String),
    List(Vec<Node>),
    Object(Vec<(String, Node)>),
}

impl Node {
    pub(crate) fn new(value: &Value) -> Self {
        match value {
            Value::Array(items) => Self::List(items.iter().map(Self::new).collect()),
            Value::Object(fields) => {
                Self::Object(fields.iter().map(|(name, value)| (name.clone(), Self::new(value))).collect())
            }
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => Self::Leaf(value.to_string()),
        }
    }

    pub(crate) fn write(&self, text: &mut String) {
        match self {
            Self::Leaf(leaf) => text.push_str(leaf),
            Self::List(items) => {
                text.push('[');
                for (index, item) in items.iter().enumerate() {
                    text.push_str(if index == 0 { "" } else { "," });
                    item.write(text);
                }
                text.push(']');
            }
            Self::Object(fields) => {
                text.push('{');
                for (index, (name, value)) in fields.iter().enumerate() {
                    text.push_str(if index == 0 { "" } else { "," });
                    text.push_str(&Value::from(name.as_str()).to_string());
                    text.push(':');
                    value.write(text);
                }
                text.push('}');
            }
        }
    }

    /// Number of nodes, including this one.
    fn count(&self) -> usize {
        1 + match self {
            Self::Leaf(_) => 0,
            Self::List(items) => items.iter().map(Self::count).sum(),
            Self::Object(fields) => fields.iter().map(|(_, value)| value.count()).sum(),
        }
    }

    /// Picks one of the nodes that satisfy `holds`; `place` from 0 to 1 selects which one.
    pub(crate) fn pick(&mut self, place: f64, holds: fn(&Node) -> bool) -> Option<&mut Node> {
        let mut matching = Vec::with_capacity(self.count());
        self.each(&mut |index, node| {
            if holds(node) {
                matching.push(index);
            }
        });
        let chosen = *matching.get(at(place, matching.len())?)?;
        self.nth(&mut { chosen })
    }

    fn each(&self, see: &mut impl FnMut(usize, &Node)) {
        let mut queue = vec![self];
        let mut index = 0;
        while let Some(node) = queue.pop() {
            see(index, node);
            index += 1;
            match node {
                Self::Leaf(_) => {}
                Self::List(items) => queue.extend(items.iter().rev()),
                Self::Object(fields) => queue.extend(fields.iter().rev().map(|(_, value)| value)),
            }
        }
    }

    /// The node that [`Node::each`] visits at this index.
    fn nth(&mut self, index: &mut usize) -> Option<&mut Node> {
        if *index == 0 {
            return Some(self);
        }
        *index -= 1;
        match self {
            Self::Leaf(_) => None,
            Self::List(items) => items.iter_mut().find_map(|item| item.nth(index)),
            Self::Object(fields) => fields.iter_mut().find_map(|(_, value)| value.nth(index)),
        }
    }
}

/// Index for a place from 0 to 1. None if the length is 0.
pub(crate) fn at(place: f64, length: usize) -> Option<usize> {
    (length > 0).then(|| ((place * length as f64) as usize).min(length - 1))
}
