//! Checks of the dashboards: linter rules, Grafana's requirements, and queries on data of a real fleet.

mod expand;
mod lint;
mod live;
mod promql;
mod shape;
mod stage;

use std::path::PathBuf;
use std::sync::LazyLock;

use serde_json::Value;

/// Folder of the dashboards.
fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("dashboards")
}

/// A dashboard and its file name.
struct Dashboard {
    file: String,
    json: Value,
}

/// All dashboards, by file name.
static ALL: LazyLock<Vec<Dashboard>> = LazyLock::new(|| {
    let files = std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|ending| ending == "json")).collect();
    files.sort();
    let read = |path: PathBuf| Dashboard {
        file: path.file_name().unwrap().to_str().unwrap().to_owned(),
        json: serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap(),
    };
    files.into_iter().map(read).collect()
});

impl Dashboard {
    fn title(&self) -> &str {
        self.json["title"].as_str().unwrap()
    }

    fn uid(&self) -> &str {
        self.json["uid"].as_str().unwrap()
    }

    /// Panels of the dashboard, without headings of rows.
    fn panels(&self) -> impl Iterator<Item = &Value> {
        list(&self.json["panels"]).filter(|panel| panel["type"] != "row")
    }

    fn variables(&self) -> impl Iterator<Item = &Value> {
        list(&self.json["templating"]["list"])
    }

    fn variable(&self, name: &str) -> Option<&Value> {
        self.variables().find(|variable| variable["name"] == name)
    }

    /// Whether several fleets can be chosen.
    fn takes_fleets(&self) -> bool {
        self.variable("fleet").is_some_and(|fleet| fleet["multi"] == true)
    }

    /// All queries in PromQL, each with its panel.
    fn promql(&self) -> impl Iterator<Item = (&Value, &Value)> {
        self.panels().flat_map(targets).filter(|(_, target)| target.get("expr").is_some())
    }
}

/// Queries of a panel.
fn targets(panel: &Value) -> impl Iterator<Item = (&Value, &Value)> {
    list(&panel["targets"]).map(move |target| (panel, target))
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}
