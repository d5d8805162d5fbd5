//! The size of the default build, which everyone waits for who tries the program.

use std::collections::BTreeSet;
use std::process::Command;

use crate::project;

/// Most packages of the program `vibrissa` with its default features, those of the workspace included.
const PACKAGES_MAX: usize = 280;

#[test]
fn the_default_build_has_few_packages() {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(["tree", "--locked", "--offline", "-e", "normal,build", "-p", "vibrissa", "--prefix", "none"]);
    let ended = command.current_dir(project()).output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let tree = String::from_utf8(ended.stdout).unwrap();
    let packages: BTreeSet<&str> = tree.lines().map(|line| line.trim_end_matches(" (*)")).collect();
    assert!(packages.len() > 100, "{tree}");
    assert!(packages.len() <= PACKAGES_MAX, "{} packages, at most {PACKAGES_MAX} are allowed", packages.len());
}
