//! Checks `deploy/sbom.cdx.json` against `Cargo.lock` as far as possible without all packages; `tests/sbom` compares
//! the whole file.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::project;

/// The values of `key = "value"` in a text, in order.
fn values<'a>(text: &'a str, key: &str) -> Vec<&'a str> {
    let prefix = format!("{key} = \"");
    text.lines().filter_map(|line| line.strip_prefix(&prefix)?.strip_suffix('"')).collect()
}

#[test]
fn the_sbom_has_the_versions_of_the_lock_file_and_every_direct_dependency() {
    let sbom: Value =
        serde_json::from_str(&std::fs::read_to_string(project().join("deploy/sbom.cdx.json")).unwrap()).unwrap();
    let lock = std::fs::read_to_string(project().join("Cargo.lock")).unwrap();
    let packages: Vec<&str> = lock.split("[[package]]\n").skip(1).collect();
    let locked: BTreeSet<(&str, &str)> =
        packages.iter().map(|package| (values(package, "name")[0], values(package, "version")[0])).collect();
    let components = sbom["components"].as_array().unwrap();
    let from_crates = components.iter().filter(|one| one["purl"].as_str().unwrap().starts_with("pkg:cargo/"));
    let listed: BTreeSet<(&str, &str)> =
        from_crates.map(|one| (one["name"].as_str().unwrap(), one["version"].as_str().unwrap())).collect();
    let renew = "run tests/sbom --write";
    assert!(listed.is_subset(&locked), "{renew}: {:?}", listed.difference(&locked).collect::<Vec<_>>());

    let program = packages.iter().find(|package| values(package, "name") == ["vibrissa"]).unwrap();
    let (_, dependencies) = program.split_once("dependencies = [\n").unwrap();
    for line in dependencies.lines().take_while(|line| *line != "]") {
        let name = line.trim_matches([' ', '"', ',']).split(' ').next().unwrap();
        assert!(listed.iter().any(|(listed, _)| *listed == name), "{renew}: {name} is missing");
    }
}

#[test]
fn the_sbom_lists_the_vendored_files_as_they_are_with_their_licences() {
    let read = |path: &str| std::fs::read(project().join(path)).unwrap_or_else(|problem| panic!("{path}: {problem}"));
    let sbom: Value = serde_json::from_slice(&read("deploy/sbom.cdx.json")).unwrap();
    let vendored: Vec<Value> = serde_json::from_slice(&read("deploy/vendored.json")).unwrap();
    for component in &vendored {
        assert!(sbom["components"].as_array().unwrap().contains(component), "run tests/sbom --write: {component}");
        let path = component["properties"][0]["value"].as_str().unwrap();
        let hash = ring::digest::digest(&ring::digest::SHA256, &read(path));
        let hash: String = hash.as_ref().iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(
            component["hashes"][0]["content"],
            hash.as_str(),
            "{path} was changed, or deploy/vendored.json is old"
        );
        let text = String::from_utf8(read(path)).unwrap();
        assert!(text.contains(&format!("v{}", component["version"].as_str().unwrap())), "{path}: another version");
        assert_eq!(
            component["licenses"][0]["expression"], "MIT",
            "check the licence, and state it in docs/security.md"
        );
        let licence = String::from_utf8(read(&path.replace(".esm.js", ".LICENSE.txt"))).unwrap();
        assert!(licence.starts_with("The MIT License"), "{path}: the licence belongs beside it");
    }
    assert_eq!(vendored.len(), 1);
}

#[test]
fn the_sbom_says_nothing_of_a_machine_or_a_time() {
    let text = std::fs::read_to_string(project().join("deploy/sbom.cdx.json")).unwrap();
    let sbom: Value = serde_json::from_str(&text).unwrap();
    assert!(sbom.get("serialNumber").is_none() && sbom["metadata"].get("timestamp").is_none());
    for path in text.split("file://").skip(1).map(|rest| rest.split('"').next().unwrap()) {
        assert!(path.starts_with("/vibrissa/services/") || path.starts_with('.'), "file://{path}");
    }
}
