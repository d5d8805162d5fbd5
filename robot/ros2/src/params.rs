//! Parameters of ROS: `-p name:=value`, and files of parameters.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

/// The key below which a node's parameters are in a file.
const PARAMETERS: &str = "ros__parameters";
/// Size limit of a file, bytes.
const FILE_MAX: u64 = 1 << 20;

/// A value for a parameter of some nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    /// Absolute name of the node, in which `*` stands for one part and `**` for any number of them.
    pub node: String,
    /// Name of the parameter; parts of a nested one are separated by dots.
    pub name: String,
    /// Its value.
    pub value: Value,
}

/// Where parameters come from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// The command line.
    Value(Override),
    /// A file.
    File(PathBuf),
}

fn yaml(text: &str) -> Result<Value, String> {
    let read = serde_saphyr::from_str(text).map_err(|problem| problem.to_string());
    // The library's text goes on with a picture of the place.
    read.map_err(|problem| problem.lines().next().unwrap_or_default().to_owned())
}

impl Override {
    /// Reads `[node:]name:=value`; the value is YAML.
    ///
    /// # Errors
    /// The text has another form; the error is a text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = |why: &str| format!("the parameter {text:?} {why}");
        let (name, value) = text.split_once(":=").ok_or_else(|| wrong("has no `:=` between name and value"))?;
        let (node, name) = name.split_once(':').map_or(("/**".to_owned(), name), |(node, name)| {
            (if node.starts_with('/') { node.to_owned() } else { format!("/**/{node}") }, name)
        });
        if name.is_empty() || value.trim().is_empty() {
            return Err(wrong("needs a name and a value"));
        }
        let value = yaml(value).map_err(|problem| wrong(&format!("has no value: {problem}")))?;
        Ok(Self { node, name: name.to_owned(), value })
    }
}

/// Reads a file of parameters.
fn read_file(path: &Path) -> Result<Vec<Override>, String> {
    let wrong = |problem: String| format!("--params-file {}: {problem}", path.display());
    let length = std::fs::metadata(path).map_err(|problem| wrong(problem.to_string()))?.len();
    if length > FILE_MAX {
        return Err(wrong(format!("has {length} bytes; at most {FILE_MAX} are read")));
    }
    let text = std::fs::read_to_string(path).map_err(|problem| wrong(problem.to_string()))?;
    overrides(&text).map_err(wrong)
}

/// The parameters in the text of a file.
///
/// # Errors
/// It is no YAML, or has another form.
pub fn overrides(text: &str) -> Result<Vec<Override>, String> {
    let Value::Object(nodes) = yaml(text)? else { return Err("has no node with ros__parameters".to_owned()) };
    let mut found = Vec::new();
    walk("", &nodes, &mut found)?;
    Ok(found)
}

fn walk(node: &str, keys: &Map<String, Value>, found: &mut Vec<Override>) -> Result<(), String> {
    for (key, value) in keys {
        let is_parameters = key == PARAMETERS && !node.is_empty();
        if is_parameters && value.is_null() {
            continue;
        }
        let Some(below) = value.as_object().filter(|_| is_parameters || key != PARAMETERS) else {
            return Err(format!("{node}/{key}: parameters are below the name of a node and {PARAMETERS}"));
        };
        if is_parameters {
            flatten(node, "", below, found);
        } else {
            walk(&format!("{node}/{}", key.trim_matches('/')), below, found)?;
        }
    }
    Ok(())
}

fn flatten(node: &str, prefix: &str, parameters: &Map<String, Value>, found: &mut Vec<Override>) {
    for (key, value) in parameters {
        let name = format!("{prefix}{key}");
        match value.as_object() {
            Some(below) => flatten(node, &format!("{name}."), below, found),
            None => found.push(Override { node: node.to_owned(), name, value: value.clone() }),
        }
    }
}

/// Whether a pattern of nodes fits the parts of a name.
fn fits(pattern: &[&str], parts: &[&str]) -> bool {
    match (pattern, parts) {
        ([], []) => true,
        (["**", rest @ ..], _) => (0..=parts.len()).any(|skipped| fits(rest, &parts[skipped..])),
        ([token, rest @ ..], [part, parts @ ..]) => (*token == "*" || token == part) && fits(rest, parts),
        _ => false,
    }
}

/// The parameters of a node: the last value of each name.
///
/// # Errors
/// A file cannot be read.
pub fn of_node(sources: &[Source], full_name: &str) -> Result<BTreeMap<String, Value>, String> {
    let parts = |name: &str| name.split('/').skip(1).map(str::to_owned).collect::<Vec<_>>();
    let own = parts(full_name);
    let own: Vec<&str> = own.iter().map(String::as_str).collect();
    let mut values = BTreeMap::new();
    for source in sources {
        let given = match source {
            Source::Value(given) => vec![given.clone()],
            Source::File(path) => read_file(path)?,
        };
        for Override { node, name, value } in given {
            let pattern = parts(&node);
            let pattern: Vec<&str> = pattern.iter().map(String::as_str).collect();
            if fits(&pattern, &own) {
                values.insert(name, value);
            }
        }
    }
    Ok(values)
}
