//! The digest of known vulnerabilities, and the script that checks the lock files against it.

use std::path::Path;
use std::process::Command;

use serde_json::json;

use crate::project;

/// Exit status and output of the script.
fn checked(arguments: &[&str], files: &[&Path]) -> (i32, String) {
    let mut script = Command::new(project().join("tests/advisories"));
    let ended = script.args(arguments).args(files).output().unwrap();
    let output = String::from_utf8([ended.stdout, ended.stderr].concat()).unwrap();
    (ended.status.code().unwrap(), output)
}

#[test]
fn regress_no_version_in_a_lock_file_has_a_known_vulnerability() {
    let (status, output) = checked(&[], &[]);
    assert_eq!(status, 0, "{output}");
    let folder = tempfile::tempdir().unwrap();
    let lock = folder.path().join("Cargo.lock");
    let package = "[[package]]\nname = \"quick-xml\"\nversion = \"0.39.4\"\nsource = \"registry\"\n";
    std::fs::write(&lock, package).unwrap();
    let (status, output) = checked(&[], &[&lock]);
    assert!(status == 1 && output.contains("quick-xml 0.39.4 is vulnerable (RUSTSEC-2026-0194)"), "{output}");
    let rules = folder.path().join("deny.toml");
    std::fs::write(&rules, "[advisories]\nignore = [\"RUSTSEC-2026-0194\", \"RUSTSEC-2026-0195\"]\n").unwrap();
    assert_eq!(checked(&[], &[&lock]).0, 0, "the rules beside it ignore both");
    std::fs::remove_file(&rules).unwrap();
    std::fs::write(&lock, package.replace("0.39.4", "0.41.0")).unwrap();
    assert_eq!(checked(&[], &[&lock]).0, 0, "{output}");
}

#[test]
fn a_version_is_safe_if_one_of_the_ranges_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let (digest, lock) = (folder.path().join("digest.json"), folder.path().join("Cargo.lock"));
    let digest_flag = digest.to_str().unwrap();
    let is_safe = |version: &str, ranges: &str| {
        let ranges: Vec<&str> = ranges.split('|').filter(|range| !range.is_empty()).collect();
        let advisory = json!({ "id": "A-1", "package": "a", "patched": ranges, "unaffected": [] });
        let text = json!({ "date": "2026-01-01", "packages": ["a"], "advisories": [advisory] }).to_string();
        std::fs::write(&digest, text).unwrap();
        let package = format!("[[package]]\nname = \"a\"\nversion = \"{version}\"\nsource = \"registry\"\n");
        std::fs::write(&lock, package).unwrap();
        let (status, output) = checked(&["--today", "2026-02-01", "--digest", digest_flag], &[&lock]);
        assert!(status == 0 || output.contains("A-1"), "{output}");
        status == 0
    };
    for (version, ranges, expected) in [
        ("1.2.3", ">= 1.2.3", true),
        ("1.2.2", ">= 1.2.3", false),
        ("1.10.0", "> 1.9", true),
        ("1.2.3-rc.1", ">= 1.2.3", false),
        ("1.2.3-rc.10", "> 1.2.3-rc.9", true),
        ("0.9.5", ">= 0.9.4, < 0.10|>= 0.10.2", true),
        ("0.10.1", ">= 0.9.4, < 0.10|>= 0.10.2", false),
        ("0.3.9", "^0.3.4", true),
        ("0.4.0", "^0.3.4", false),
        ("1.9.0", "^1.2", true),
        ("2.0.0", "1.2", false),
        ("0.0.3", "^0.0.3", true),
        ("1.2.9", "~1.2.3", true),
        ("1.3.0", "~1.2.3", false),
        ("1.2.3+build", "= 1.2.3", true),
        ("1.2.4", "= 1.2.3", false),
        ("1.0.0", "", false),
    ] {
        assert_eq!(is_safe(version, ranges), expected, "{version} in {ranges:?}");
    }
}

#[test]
fn the_script_says_when_the_digest_is_old_or_does_not_cover_a_crate() {
    let folder = tempfile::tempdir().unwrap();
    let (digest, lock) = (folder.path().join("digest.json"), folder.path().join("Cargo.lock"));
    std::fs::write(&digest, json!({ "date": "2026-01-01", "packages": ["a"], "advisories": [] }).to_string()).unwrap();
    std::fs::write(&lock, "[[package]]\nname = \"b\"\nversion = \"1.0.0\"\nsource = \"registry\"\n").unwrap();
    let on = |day: &str, more: &[&str]| {
        checked(&[&["--digest", digest.to_str().unwrap(), "--today", day][..], more].concat(), &[&lock])
    };
    let (status, output) = on("2026-03-02", &[]);
    assert!(status == 0 && output.contains("does not cover b") && !output.contains("days old"), "{output}");
    let (status, output) = on("2026-03-03", &[]);
    assert!(status == 0 && output.contains("61 days old (2026-01-01)"), "{output}");
    assert_eq!(on("2026-03-03", &["--strict"]).0, 1);
}
