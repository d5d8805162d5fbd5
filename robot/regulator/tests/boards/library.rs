//! The library as the Arduino IDE needs it.

use std::collections::BTreeMap;

use crate::{arduino, compiled_example};

#[test]
fn the_library_has_what_the_arduino_ide_asks_for() {
    let folder = arduino().join("vibrissa");
    let text = std::fs::read_to_string(folder.join("library.properties")).expect("library.properties");
    let properties: BTreeMap<&str, &str> = text.lines().filter_map(|line| line.split_once('=')).collect();
    for name in ["name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url", "architectures"]
    {
        assert!(properties.get(name).is_some_and(|value| !value.is_empty()), "{name}");
    }
    let header = std::fs::read_to_string(folder.join("src").join(properties["includes"])).expect("the header");
    let version = format!("#define VIBRISSA_VERSION \"{}\"", properties["version"]);
    assert!(header.contains(&version), "{version}");
    assert_eq!(properties["version"], env!("CARGO_PKG_VERSION"));
    for example in std::fs::read_dir(folder.join("examples")).expect("examples") {
        let example = example.expect("a folder").path();
        let name = example.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        assert!(example.join(format!("{name}.ino")).exists(), "{name}");
        for board in ["uno", "mega"] {
            let Some(built) = compiled_example(board, &name) else { return };
            assert!(built.join(format!("{name}.hex")).exists(), "{board} {name}");
        }
    }
}
