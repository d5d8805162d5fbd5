//! Checks that `tests/compose`, which needs a container engine, still fits the Dockerfile and docker-compose.yml.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::compose::services;
use crate::project;

/// Value of an expression of the modules in tests/composing.
fn composing(module: &str, expression: &str) -> Value {
    let program = format!("import json; from composing.{module} import *; print(json.dumps({expression}))");
    let ended = Command::new("python3")
        .args(["-B", "-c", &program])
        .env("PYTHONPATH", project().join("tests"))
        .output()
        .expect("python3 must be installed for this test");
    serde_json::from_slice(&succeeded(&ended).stdout).unwrap()
}

fn succeeded(ended: &Output) -> &Output {
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    ended
}

fn words(value: &Value) -> BTreeSet<String> {
    value.as_array().unwrap().iter().map(|word| word.as_str().unwrap().to_owned()).collect()
}

/// The build steps of the Dockerfile as a shell command, which installs into `out` instead of `/out`.
fn build_steps(dockerfile: &str, out: &Path) -> String {
    let joined = dockerfile.replace("\\\n", " ");
    let steps = joined.lines().filter(|line| line.starts_with("RUN") && line.contains("cargo build"));
    let placed = |word: &str| if word == "/out" { out.display().to_string() } else { word.to_owned() };
    let command = |step: &str| {
        let words = step.split_whitespace().skip(1).skip_while(|word| word.starts_with("--mount="));
        words.map(placed).collect::<Vec<_>>().join(" ")
    };
    steps.map(command).collect::<Vec<_>>().join(" && ")
}

#[test]
fn regress_the_stand_in_of_cargo_builds_all_programs_of_the_images() {
    let dockerfile = std::fs::read_to_string(project().join("Dockerfile")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let [prebuilt, out] = ["prebuilt", "out"].map(|name| folder.path().join(name));
    std::fs::create_dir(&prebuilt).unwrap();
    for program in words(&composing("programs", "programs()")) {
        std::fs::write(prebuilt.join(program), "").unwrap();
    }
    let path = format!("{}:{}", project().join("tests/composing/standins").display(), std::env::var("PATH").unwrap());
    let ended = Command::new("sh")
        .args(["-c", &build_steps(&dockerfile, &out)])
        .current_dir(folder.path())
        .env("PATH", path)
        .env("PREBUILT", &prebuilt)
        .output()
        .unwrap();
    succeeded(&ended);
    let copies = dockerfile.lines().filter(|line| line.starts_with("COPY --from=build-"));
    let copied: Vec<&str> =
        copies.flat_map(|line| line.split(' ')).filter_map(|word| word.strip_prefix("/out/")).collect();
    assert_eq!(copied.len(), 4, "{copied:?}");
    let missing: Vec<&&str> = copied.iter().filter(|program| !out.join(program).exists()).collect();
    assert!(missing.is_empty(), "the stand-ins lack {missing:?}");
}

#[test]
fn every_image_of_the_stack_is_built_or_has_a_stand_in() {
    let stand_ins = composing("stack", "STAND_INS");
    let stand_ins = stand_ins.as_object().unwrap();
    for (name, service) in services() {
        let (image, _) = service["image"].as_str().unwrap().rsplit_once(':').unwrap();
        assert!(image.starts_with("vibrissa") || stand_ins.contains_key(image), "{name}: {image} has no stand-in");
    }
    let stages = std::fs::read_to_string(project().join("tests/composing/standins/Dockerfile")).unwrap();
    for stage in stand_ins.values().map(|stage| stage.as_str().unwrap()).chain(["rust"]) {
        assert!(stages.lines().any(|line| line.ends_with(&format!(" AS {stage}"))), "{stage} is not made");
    }
}

#[test]
fn the_checks_of_the_stack_know_its_services() {
    let checks = std::fs::read_to_string(project().join("tests/composing/checks.py")).unwrap();
    let calls = ["container(\"", "execute(\"", "inspect(\"", "is_ready(\"", "kill(\"", "logs(\""];
    let named: BTreeSet<&str> =
        calls.iter().flat_map(|call| checks.split(call).skip(1).map(|rest| rest.split('"').next().unwrap())).collect();
    assert!(named.len() > 3, "{named:?}");
    for name in named.into_iter().map(str::to_owned).chain(words(&composing("checks", "sorted(ENDS)"))) {
        assert!(services().contains_key(name.as_str()), "{name} is no service");
    }
}
