//! Files of a crate that import each other in a circle, other than a module and those within it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::structure::{CRATES, code, folder, rust_files};

/// A module as its path within the crate.
type Module = Vec<String>;
type Imports = BTreeMap<Module, BTreeSet<Module>>;

/// The paths of a tree of imports: `a::{b, c::{d, e}}` has `a::b`, `a::c::d` and `a::c::e`.
fn leaves(tree: &str) -> Vec<String> {
    let Some((before, list)) = tree.split_once('{') else { return vec![tree.trim().to_owned()] };
    let list = list.rsplit_once('}').map_or(list, |(list, _)| list);
    let (mut depth, mut parts) = (0_u32, vec![String::new()]);
    for one in list.chars() {
        match one {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        parts.last_mut().unwrap().push(one);
    }
    let parts = parts.iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(|part| leaves(part)).map(|leaf| format!("{}{leaf}", before.trim())).collect()
}

/// All paths in a file that begin in its crate.
fn paths(code: &str) -> Vec<String> {
    let mut paths = Vec::new();
    for statement in code.split(';') {
        if let Some((_, tree)) = statement.rsplit_once("use ") {
            paths.extend(leaves(tree));
        }
        for begin in ["crate::", "super::"] {
            for after in statement.split(begin).skip(1) {
                let is_of_path = |one: char| one.is_alphanumeric() || one == '_' || one == ':';
                let rest: String = after.chars().take_while(|one| is_of_path(*one)).collect();
                paths.push(format!("{begin}{rest}"));
            }
        }
    }
    paths
}

/// The module that a path within `of` names, as far as there is a file for it.
fn target(path: &str, of: &Module, all: &BTreeSet<Module>) -> Option<Module> {
    let mut rest: Vec<&str> = path.split("::").map(str::trim).filter(|one| !one.is_empty()).collect();
    let mut full = match *rest.first()? {
        "crate" => Vec::new(),
        "super" => of.split_last()?.1.to_vec(),
        "self" => of.clone(),
        _ => return None,
    };
    rest.remove(0);
    while rest.first() == Some(&"super") {
        full.pop();
        rest.remove(0);
    }
    full.extend(rest.into_iter().map(str::to_owned));
    while !full.is_empty() && !all.contains(&full) {
        full.pop();
    }
    (!full.is_empty()).then_some(full)
}

fn imports(root: &Path) -> Imports {
    let module = |path: &Path| -> Module {
        let mut parts: Vec<String> = path
            .strip_prefix(root)
            .unwrap()
            .with_extension("")
            .iter()
            .map(|one| one.to_str().unwrap().into())
            .collect();
        if parts.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
            parts.pop();
        }
        parts
    };
    let files: BTreeMap<Module, String> = rust_files(root)
        .into_iter()
        .map(|path| (module(&path), code(&path)))
        .filter(|(module, _)| !module.iter().any(|part| part == "tests" || part == "disabled"))
        .collect();
    let all: BTreeSet<Module> = files.keys().cloned().collect();
    let is_within = |one: &Module, other: &Module| one.starts_with(other) || other.starts_with(one);
    files
        .iter()
        .map(|(of, code)| {
            let targets = paths(code).into_iter().filter_map(|path| target(&path, of, &all));
            (of.clone(), targets.filter(|target| !is_within(target, of)).collect())
        })
        .collect()
}

/// The modules that reach themselves.
fn in_circles(imports: &Imports) -> Vec<String> {
    let reaches_itself = |module: &&Module| {
        let (mut seen, mut waiting) = (BTreeSet::new(), vec![*module]);
        while let Some(one) = waiting.pop() {
            waiting.extend(imports[one].iter().filter(|next| seen.insert(*next)));
        }
        seen.contains(module)
    };
    imports.keys().filter(reaches_itself).map(|module| module.join("/")).collect()
}

#[test]
fn trees_of_imports_are_divided() {
    assert_eq!(leaves("a::{b, c::{d, e}, f}"), ["a::b", "a::c::d", "a::c::e", "a::f"]);
    let circle = |of: &str| Imports::from([(vec![of.to_owned()], BTreeSet::from([vec!["b".to_owned()]]))]);
    let mut imports = circle("a");
    imports.insert(vec!["b".to_owned()], BTreeSet::new());
    assert!(in_circles(&imports).is_empty());
    imports.insert(vec!["b".to_owned()], BTreeSet::from([vec!["a".to_owned()]]));
    assert_eq!(in_circles(&imports), ["a", "b"]);
}

#[test]
fn no_files_of_a_crate_import_each_other_in_a_circle() {
    for (name, _) in CRATES {
        assert_eq!(in_circles(&imports(&folder(name).join("src"))), [""; 0], "{name}");
    }
}

/// The modules directly below a module, with the imports of all their files.
fn below(imports: &Imports, parent: &[&str]) -> Imports {
    let place = parent.len();
    let child =
        |module: &Module| (module.len() > place && module[..place] == *parent).then(|| vec![module[place].clone()]);
    let mut children = Imports::new();
    for (module, targets) in imports {
        let Some(of) = child(module) else { continue };
        let others: BTreeSet<Module> = targets.iter().filter_map(child).filter(|target| *target != of).collect();
        children.entry(of).or_default().extend(others);
    }
    children
}

/// A folder is understood after those that it imports, without going back.
#[test]
fn no_modules_of_the_store_or_of_the_engine_depend_on_each_other() {
    for (name, parent) in [("store", &[][..]), ("supervisor", &["engine"])] {
        let modules = below(&imports(&folder(name).join("src")), parent);
        assert!(modules.len() > 15, "{modules:?}");
        assert_eq!(in_circles(&modules), [""; 0], "{name}");
    }
}
