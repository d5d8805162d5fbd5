//! The build profiles: `release` for a first look, `dist` for the images and for measurements.

use std::collections::BTreeSet;
use std::fs::read_to_string;

use toml::{Table, Value};

use crate::project;

/// A profile of the workspace's manifest.
fn profile(name: &str) -> Table {
    let manifest: Table = read_to_string(project().join("Cargo.toml")).unwrap().parse().unwrap();
    manifest["profile"][name].as_table().unwrap().clone()
}

/// Packages of a profile whose level is or is not 3.
fn packages(profile: &Table, is_three: bool) -> BTreeSet<&str> {
    let has_level = |level: &Value| (level["opt-level"].as_integer() == Some(3)) == is_three;
    let packages = profile["package"].as_table().unwrap();
    packages.iter().filter(|(_, level)| has_level(level)).map(|(name, _)| name.as_str()).collect()
}

#[test]
fn the_images_profile_optimises_every_package_fully() {
    let (release, dist) = (profile("release"), profile("dist"));
    assert_eq!(dist["inherits"].as_str(), Some("release"));
    assert_eq!(dist["opt-level"].as_integer(), Some(3));
    // The levels by package are inherited from release, and would win over the profile's own.
    assert_eq!(packages(&dist, true), packages(&release, false));
    assert_eq!(packages(&dist, false), BTreeSet::new());
    assert_eq!(profile("bench")["inherits"].as_str(), Some("dist"));
}
