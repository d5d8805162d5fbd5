//! The direction of imports: between crates, between modules of a crate, and around heavy libraries.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};

use crate::project;

/// Crates from the lowest to the highest, with their folders: a crate depends only on those before it.
pub(crate) const CRATES: [(&str, &str); 15] = [
    ("core", "services/core"),
    ("regulator", "robot/regulator"),
    ("segmenter", "robot/segmenter"),
    ("host", "services/host"),
    ("program", "services/program"),
    ("protocol", "services/protocol"),
    ("edge", "services/edge"),
    ("robot", "robot/agent"),
    ("store", "services/store"),
    ("supervisor", "services/supervisor"),
    ("vibrissa", "services/vibrissa"),
    ("simulator", "lab/simulator"),
    ("simulation", "lab/simulation"),
    ("evaluation", "lab/evaluation"),
    ("lab", "lab/vibrissa-lab"),
];
/// Crates that must not reach a library, and those libraries: directly, or by way of another crate.
const KEPT_OUT: [(&str, &[&str]); 6] = [
    ("vibrissa-core", &["tokio", "sqlx", "axum", "rumqttc-next"]),
    ("vibrissa-core-tests", &["sqlx", "axum", "vibrissa-store", "vibrissa-supervisor"]),
    ("vibrissa-robot", &["sqlx", "axum", "vibrissa-core", "vibrissa-store", "vibrissa-supervisor"]),
    ("vibrissa-store", &["axum", "rumqttc-next"]),
    ("vibrissa-supervisor", &["plotters", "clap", "indicatif"]),
    ("vibrissa", &["vibrissa-lab", "vibrissa-simulator", "vibrissa-evaluation", "vibrissa-robot", "plotters", "rayon"]),
];

pub(crate) fn rust_files(folder: &Path) -> Vec<PathBuf> {
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
pub(crate) fn code(path: &Path) -> String {
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

/// The folder of a crate.
pub(crate) fn folder(name: &str) -> PathBuf {
    let (_, folder) = CRATES.iter().find(|(crate_name, _)| *crate_name == name).unwrap();
    project().join(folder)
}

/// Each module of a crate with the modules of the same crate that it imports.
fn modules_of(name: &str) -> BTreeMap<String, BTreeSet<String>> {
    let root = folder(name).join("src");
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

fn no_circle(name: &str) {
    let mut modules = modules_of(name);
    // Modules that import nothing that is left are removed until none is left; those of a circle stay.
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
    assert!(modules.is_empty(), "{name}: modules in a circle of imports, or above one: {modules:#?}");
}

#[test]
fn no_module_of_the_supervisor_imports_one_that_depends_on_it() {
    let modules = modules_of("supervisor");
    assert!(modules["engine"].contains("inbox") && modules.len() > 15, "{modules:?}");
    no_circle("supervisor");
}

#[test]
fn no_module_of_the_program_imports_one_that_depends_on_it() {
    assert!(modules_of("vibrissa")["cli"].contains("config"));
    no_circle("vibrissa");
}

#[test]
fn crates_depend_on_lower_crates_only() {
    for (place, (name, folder)) in CRATES.iter().enumerate() {
        let manifest = read_to_string(project().join(folder).join("Cargo.toml")).unwrap();
        let dependencies = manifest.split("[dependencies]").nth(1).unwrap_or_default().split("\n[").next().unwrap();
        for (at, (other, _)) in CRATES.iter().enumerate() {
            let package = if *other == "vibrissa" { "vibrissa".to_owned() } else { format!("vibrissa-{other}") };
            let is_used = dependencies.lines().any(|line| line.starts_with(&format!("{package}.")));
            assert!(!is_used || at < place, "{name} must not depend on {other}");
        }
    }
    let houses = ["services", "lab"].map(|house| read_dir(project().join(house)).unwrap());
    let crates =
        houses.into_iter().flatten().filter(|entry| entry.as_ref().unwrap().path().join("Cargo.toml").exists());
    let listed = CRATES.iter().filter(|(_, folder)| !folder.starts_with("robot/"));
    assert_eq!(crates.count(), listed.count(), "each crate must have a place in the order");
}

/// Names and versions of the packages in a Cargo.lock.
fn locked(path: &str) -> BTreeSet<(String, String)> {
    let lock: toml::Table = read_to_string(project().join(path)).unwrap().parse().unwrap();
    let word = |package: &toml::Value, key: &str| package[key].as_str().unwrap().to_owned();
    let packages = lock["package"].as_array().unwrap().iter();
    packages.map(|package| (word(package, "name"), word(package, "version"))).collect()
}

/// The agent speaks with the broker and reads its messages through the same code, whichever workspace builds it.
#[test]
fn the_programs_of_robots_have_the_versions_of_the_service() {
    let (service, robot) = (locked("Cargo.lock"), locked("robot/Cargo.lock"));
    let names: BTreeSet<&str> = service.iter().map(|(name, _)| name.as_str()).collect();
    let shared: Vec<_> = robot.iter().filter(|(name, _)| names.contains(name.as_str())).collect();
    assert!(shared.len() > 100, "{}", shared.len());
    let different: Vec<_> = shared.into_iter().filter(|&package| !service.contains(package)).collect();
    assert!(different.is_empty(), "copy Cargo.lock to robot, and build there: {different:?}");
    let requirements = |path: &str| -> toml::Table {
        let manifest: toml::Table = read_to_string(project().join(path)).unwrap().parse().unwrap();
        let dependencies = manifest["workspace"]["dependencies"].as_table().unwrap();
        dependencies
            .iter()
            .filter(|(_, of)| of.get("path").is_none())
            .map(|(name, of)| (name.clone(), of.clone()))
            .collect()
    };
    let (service, robot) = (requirements("Cargo.toml"), requirements("robot/Cargo.toml"));
    for (name, asked) in robot.iter().filter(|(name, _)| service.contains_key(*name)) {
        assert_eq!(asked, &service[name], "{name} in Cargo.toml and robot/Cargo.toml");
    }
}

/// The packages of Cargo.lock with the packages that each depends on, development dependencies included.
fn packages() -> BTreeMap<String, Vec<String>> {
    let lock = read_to_string(project().join("Cargo.lock")).unwrap();
    let quoted = |text: &str| text.split('"').nth(1).unwrap_or_default().split(' ').next().unwrap().to_owned();
    let mut packages: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in lock.split("[[package]]").skip(1) {
        let name = package.lines().find(|line| line.starts_with("name = ")).map(quoted).unwrap();
        let dependencies = package.split("dependencies = [").nth(1).unwrap_or_default();
        packages.entry(name).or_default().extend(dependencies.lines().map(quoted).filter(|name| !name.is_empty()));
    }
    packages
}

#[test]
fn crates_do_not_reach_the_libraries_that_are_kept_out_of_them() {
    let packages = packages();
    for (name, kept_out) in KEPT_OUT {
        let mut reached = BTreeSet::from([name.to_owned()]);
        let mut to_visit = vec![name.to_owned()];
        while let Some(next) = to_visit.pop() {
            for other in packages.get(&next).unwrap_or_else(|| panic!("no package {next}")) {
                if reached.insert(other.clone()) {
                    to_visit.push(other.clone());
                }
            }
        }
        for library in kept_out {
            assert!(packages.contains_key(*library), "no package {library}");
            assert!(!reached.contains(*library), "{name} depends on {library}");
        }
    }
}

#[test]
fn only_the_store_and_the_tests_depend_on_sqlx() {
    let packages = packages();
    let users = packages.iter().filter(|(_, dependencies)| dependencies.iter().any(|one| one == "sqlx"));
    let users: Vec<&str> = users.map(|(name, _)| name.as_str()).collect();
    assert_eq!(users, ["vibrissa-store", "vibrissa-tests"]);
}

/// `cargo test --doc` would run it, but takes three minutes of CPU time without a test.
#[test]
fn no_comment_has_code_that_nobody_runs() {
    let folders = CRATES.iter().map(|(_, folder)| project().join(folder)).chain([project().join("tests")]);
    for path in folders.flat_map(|folder| rust_files(&folder)) {
        let text = read_to_string(&path).unwrap();
        let fences = text.lines().filter_map(|line| {
            let comment = line.trim_start();
            comment.strip_prefix("//!").or_else(|| comment.strip_prefix("///"))?.trim_start().strip_prefix("```")
        });
        for language in fences.step_by(2) {
            assert!(["text", "toml"].contains(&language), "{}: ```{language}", path.display());
        }
    }
}
