//! Mutations that make an invalid input from a valid one.

use proptest::prelude::*;

use crate::INPUT_MAX_BYTES;
use crate::json::{Node, at};

/// Texts that commonly confuse parsers.
pub(crate) const TOKENS: &[&str] = &[
    "null",
    "true",
    "[]",
    "{}",
    "\"\"",
    "\"\\u0000\"",
    "\"\\ud800\"",
    "\"ä😀\"",
    "-0",
    "-1",
    "0.1e-320",
    "5e-324",
    "1e308",
    "1e309",
    "-1e999",
    "9007199254740991",
    "9007199254740992",
    "18446744073709551615",
    "18446744073709551616",
    "99999999999999999999999999999999999999",
    "NaN",
    "nan",
    "-inf",
    "Infinity",
    "0x10",
    "1_000",
    "01",
    "1.",
    ".5",
    "+1",
    "0.30000000000000004",
    "123456789.12345678901234567890",
    "2.2250738585072011e-308",
    "\"2026-11-21T08:00:00Z\"",
    "\"9999-12-31T23:59:60Z\"",
    "\"9999-12-31T23:59:59.999999999Z\"",
    "\"2026-02-29T00:00:00Z\"",
    "1979-05-27",
    "07:32:00",
    "'x'",
    "\"\"\"x\"\"\"",
    "\"*\"",
    "\"supervisor\"",
    "\"mqtt://u:p@h\"",
    "\"postgres://u:***@[::1]:5/d?password=x\"",
    "\"sqlite:\"",
    "\"[{=}]=trace,,\"",
    "\"a[b{c=d}]=warn\"",
    "\"::1\"",
    "\"[::1]:99999\"",
];

/// One mutation. Places are from 0 to 1, so that they shrink towards the start.
#[derive(Debug, Clone)]
pub(crate) enum Mutation {
    /// Replaces a value with a token.
    Replace(f64, usize),
    /// Removes a field or entry.
    Remove(f64, f64),
    /// Repeats a field or entry this many times.
    Repeat(f64, f64, usize),
    /// Renames a field.
    Rename(f64, f64, String),
    /// Wraps a value in this many lists.
    Nest(f64, usize),
    /// Replaces a value with a text of this length.
    Lengthen(f64, usize),
    /// Flips a bit.
    Flip(f64, u8),
    /// Removes the rest.
    Truncate(f64),
    /// Inserts a part of another input, or any bytes.
    Insert(f64, Vec<u8>),
    /// Repeats a part this many times.
    Echo(f64, f64, usize),
}

/// A few mutations, mostly small ones.
pub(crate) fn mutations() -> impl Strategy<Value = Vec<Mutation>> {
    let place = || 0.0..1.0;
    let one = prop_oneof![
        6 => (place(), 0..TOKENS.len()).prop_map(|(at, token)| Mutation::Replace(at, token)),
        2 => (place(), place()).prop_map(|(at, entry)| Mutation::Remove(at, entry)),
        2 => (place(), place(), prop_oneof![3 => 1..3_usize, 1 => 1..3000_usize])
            .prop_map(|(at, entry, times)| Mutation::Repeat(at, entry, times)),
        2 => (place(), place(), "[a-z_]{0,12}|\\PC{0,4}").prop_map(|(at, entry, name)| Mutation::Rename(at, entry, name)),
        1 => (place(), prop_oneof![1..4_usize, 100..200_usize, 1000..100_000_usize])
            .prop_map(|(at, depth)| Mutation::Nest(at, depth)),
        1 => (place(), prop_oneof![60..70_usize, 1..INPUT_MAX_BYTES])
            .prop_map(|(at, length)| Mutation::Lengthen(at, length)),
        3 => (place(), 0..8_u8).prop_map(|(at, bit)| Mutation::Flip(at, bit)),
        1 => place().prop_map(Mutation::Truncate),
        2 => (place(), inserted()).prop_map(|(at, bytes)| Mutation::Insert(at, bytes)),
        1 => (place(), place(), prop_oneof![3 => 1..4_usize, 1 => 1..100_000_usize])
            .prop_map(|(from, to, times)| Mutation::Echo(from, to, times)),
    ];
    prop::collection::vec(one, 0..6)
}

fn inserted() -> impl Strategy<Value = Vec<u8>> {
    let broken_utf8: &[&[u8]] =
        &[b"\xff", b"\xc0\x80", b"\xed\xa0\x80", b"\xf4\x90\x80\x80", b"\xe2\x82", b"\xef\xbb\xbf"];
    prop_oneof![
        prop::sample::select(broken_utf8).prop_map(<[u8]>::to_vec),
        (0..TOKENS.len()).prop_map(|token| TOKENS[token].as_bytes().to_vec()),
        prop::sample::select(&b"{}[]\",:=\n\0#'\\"[..]).prop_map(|byte| vec![byte]),
        prop::collection::vec(any::<u8>(), 0..20),
    ]
}

/// Arbitrary bytes, mostly short.
pub(crate) fn anything() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        4 => prop::collection::vec(any::<u8>(), 0..200),
        4 => "\\PC{0,200}".prop_map(String::into_bytes),
        // Long inputs repeat one piece: drawing each byte would take longer than the test itself.
        1 => (prop::collection::vec(any::<u8>(), 1..20), 1..60_000_usize).prop_map(|(piece, times)| piece.repeat(times)),
    ]
    .prop_map(bounded)
}

/// A message after all of these mutations.
pub(crate) fn bent_message(good: &serde_json::Value, mutations: &[Mutation]) -> Vec<u8> {
    let mut tree = Node::new(good);
    for mutation in mutations {
        bend_tree(&mut tree, mutation);
    }
    let mut text = String::new();
    tree.write(&mut text);
    mutations.iter().fold(bounded(text.into_bytes()), |bytes, mutation| bounded(bend_bytes(bytes, mutation)))
}

fn bend_tree(tree: &mut Node, mutation: &Mutation) {
    let is_leaf: fn(&Node) -> bool = |node| matches!(node, Node::Leaf(_));
    let is_filled: fn(&Node) -> bool = |node| match node {
        Node::Leaf(_) => false,
        Node::List(items) => !items.is_empty(),
        Node::Object(fields) => !fields.is_empty(),
    };
    let leaf = |text: String| move |node: &mut Node| *node = Node::Leaf(text);
    match mutation {
        Mutation::Replace(place, token) => {
            tree.pick(*place, |_| true).map(leaf(TOKENS[*token].to_owned()));
        }
        Mutation::Nest(place, depth) => {
            tree.pick(*place, |_| true).map(leaf(format!("{}1{}", "[".repeat(*depth), "]".repeat(*depth))));
        }
        Mutation::Lengthen(place, length) => {
            tree.pick(*place, is_leaf).map(leaf(format!("\"{}\"", "x".repeat(*length))));
        }
        Mutation::Remove(place, entry) => match tree.pick(*place, is_filled) {
            Some(Node::List(items)) => drop(at(*entry, items.len()).map(|index| items.remove(index))),
            Some(Node::Object(fields)) => drop(at(*entry, fields.len()).map(|index| fields.remove(index))),
            Some(Node::Leaf(_)) | None => {}
        },
        Mutation::Repeat(place, entry, times) => match tree.pick(*place, is_filled) {
            Some(Node::List(items)) => repeat(items, *entry, *times),
            Some(Node::Object(fields)) => repeat(fields, *entry, *times),
            Some(Node::Leaf(_)) | None => {}
        },
        Mutation::Rename(place, entry, name) => {
            if let Some(Node::Object(fields)) = tree.pick(*place, |node| matches!(node, Node::Object(_)))
                && let Some(index) = at(*entry, fields.len())
            {
                fields[index].0.clone_from(name);
            }
        }
        Mutation::Flip(..) | Mutation::Truncate(..) | Mutation::Insert(..) | Mutation::Echo(..) => {}
    }
}

fn repeat<T: Clone>(entries: &mut Vec<T>, entry: f64, times: usize) {
    if let Some(index) = at(entry, entries.len()) {
        let copies = vec![entries[index].clone(); times];
        entries.splice(index..index, copies);
    }
}

/// Lines of `name = value` after all of these mutations.
pub(crate) fn bent_lines(good: &str, mutations: &[Mutation]) -> Vec<u8> {
    let mut lines: Vec<String> = good.lines().map(str::to_owned).collect();
    for mutation in mutations {
        bend_lines(&mut lines, mutation);
    }
    let text = lines.join("\n").into_bytes();
    mutations.iter().fold(bounded(text), |bytes, mutation| bounded(bend_bytes(bytes, mutation)))
}

fn bend_lines(lines: &mut Vec<String>, mutation: &Mutation) {
    let count = lines.len();
    let set = |lines: &mut Vec<String>, place: f64, value: &str| {
        if let Some(index) = at(place, count) {
            let name = lines[index].split('=').next().unwrap_or_default().trim().to_owned();
            lines[index] = format!("{name} = {value}");
        }
    };
    match mutation {
        Mutation::Replace(place, token) => set(lines, *place, TOKENS[*token]),
        Mutation::Nest(place, depth) => {
            set(lines, *place, &format!("{}1{}", "[".repeat(*depth), "]".repeat(*depth)));
        }
        Mutation::Lengthen(place, length) => set(lines, *place, &format!("\"{}\"", "x".repeat(*length))),
        Mutation::Remove(place, _) => drop(at(*place, count).map(|index| lines.remove(index))),
        Mutation::Repeat(place, _, times) => repeat(lines, *place, *times),
        Mutation::Rename(place, _, name) => {
            if let Some(index) = at(*place, count) {
                let value = lines[index].split_once('=').map_or("1", |(_, value)| value).to_owned();
                lines[index] = format!("{name} ={value}");
            }
        }
        Mutation::Flip(..) | Mutation::Truncate(..) | Mutation::Insert(..) | Mutation::Echo(..) => {}
    }
}

fn bend_bytes(mut bytes: Vec<u8>, mutation: &Mutation) -> Vec<u8> {
    let count = bytes.len();
    match mutation {
        Mutation::Flip(place, bit) => {
            if let Some(index) = at(*place, count) {
                bytes[index] ^= 1 << bit;
            }
        }
        Mutation::Truncate(place) => bytes.truncate(at(*place, count).unwrap_or_default()),
        Mutation::Insert(place, inserted) => {
            let index = at(*place, count).unwrap_or_default();
            bytes.splice(index..index, inserted.iter().copied());
        }
        Mutation::Echo(from, to, times) => {
            if let (Some(from), Some(to)) = (at(from.min(*to), count), at(to.max(*from), count)) {
                let piece = &bytes[from..to];
                let times = (*times).min(INPUT_MAX_BYTES / piece.len().max(1));
                let echo = piece.repeat(times);
                bytes.splice(from..from, echo);
            }
        }
        Mutation::Replace(..)
        | Mutation::Remove(..)
        | Mutation::Repeat(..)
        | Mutation::Rename(..)
        | Mutation::Nest(..)
        | Mutation::Lengthen(..) => {}
    }
    bytes
}

fn bounded(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.truncate(INPUT_MAX_BYTES);
    bytes
}
