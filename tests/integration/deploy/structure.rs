//! Checks the direction of imports between crates and between modules of the supervisor, and that only one module uses
//! SQL.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};

use crate::project;

/// Crates from the lowest to the highest; a crate depends only on earlier ones.
const CRATES: [&str; 6] = ["core", "protocol", "edge", "simulator", "evaluation", "supervisor"];
/// The only module of the supervisor that uses sqlx.
const WITH_SQL: &str = "store";

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}

/// The code without comments and without unit tests, which may import anything.
fn code(path: &Path) -> String {
    let is_test = path.file_stem().is_some_and(|stem| stem == "tests");
    let text = if is_test { String::new() } else { read_to_string(path).unwrap() };
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Modules imported by `crate::a`, `crate::{a, b::c}` and `crate::a::{b, c}`.
fn imported(code: &str) -> BTreeSet<String> {
    let word =
        |text: &str| -> String { text.trim().chars().take_while(|one| one.is_alphanumeric() || *one == '_').collect() };
    let mut modules = BTreeSet::new();
    for after in code.split("crate::").skip(1) {
        match after.strip_prefix('{') {
            Some(list) => {
                let list = list.split('}').next().unwrap_or_default();
                modules.extend(list.split(',').map(word));
            }
            None => {
                modules.insert(word(after));
            }
        }
    }
    modules
}

/// Each module of the supervisor with the modules that it imports.
fn supervisor_modules() -> BTreeMap<String, BTreeSet<String>> {
    let root = project().join("services/supervisor/src");
    let mut modules: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for path in rust_files(&root) {
        let top = path.strip_prefix(&root).unwrap().iter().next().unwrap();
        let module = Path::new(top).file_stem().unwrap().to_str().unwrap();
        if !["lib", "main"].contains(&module) {
            modules.entry(module.to_owned()).or_default().extend(imported(&code(&path)));
        }
    }
    let names: BTreeSet<String> = modules.keys().cloned().collect();
    for (name, imports) in &mut modules {
        imports.retain(|one| names.contains(one) && one != name);
    }
    modules
}

#[test]
fn no_module_of_the_supervisor_imports_one_that_depends_on_it() {
    let mut modules = supervisor_modules();
    assert!(modules["engine"].contains("store") && modules.len() > 20, "{modules:?}");
    // Repeatedly removes modules whose imports are all removed; modules of a cycle remain.
    loop {
        let free: Vec<String> =
            modules.iter().filter(|(_, imports)| imports.is_empty()).map(|(name, _)| name.clone()).collect();
        if free.is_empty() {
            break;
        }
        for name in free {
            modules.remove(&name);
            for imports in modules.values_mut() {
                imports.remove(&name);
            }
        }
    }
    assert!(modules.is_empty(), "modules in a cycle of imports, or above one: {modules:#?}");
}

#[test]
fn crates_depend_on_lower_crates_only() {
    for (place, name) in CRATES.iter().enumerate() {
        let manifest = read_to_string(project().join("services").join(name).join("Cargo.toml")).unwrap();
        let dependencies = manifest.split("[dependencies]").nth(1).unwrap().split("\n[").next().unwrap();
        for (at, other) in CRATES.iter().enumerate() {
            let is_used = dependencies.lines().any(|line| line.starts_with(&format!("vibrissa-{other}.")));
            assert!(!is_used || at < place, "vibrissa-{name} must not depend on vibrissa-{other}");
        }
    }
    let folders = read_dir(project().join("services")).unwrap().count();
    assert_eq!(folders, CRATES.len(), "each crate must have a place in the order");
}

#[test]
fn only_the_store_knows_sql() {
    let root = project().join("services");
    let store = root.join("supervisor/src").join(WITH_SQL);
    let mut with_sql = 0;
    for path in rust_files(&root) {
        let is_used = code(&path).contains("sqlx::");
        assert!(!is_used || path.starts_with(&store), "{} uses sqlx", path.display());
        with_sql += usize::from(is_used);
    }
    assert!(with_sql > 10, "{with_sql}");
}
