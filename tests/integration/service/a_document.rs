//! Tests the service against its OpenAPI document with schemathesis: valid and invalid requests on every route, with
//! every check. Its tests are the longest of the suite: by the module's name they begin first.

use std::net::SocketAddr;
use std::path::Path;
use std::process::Stdio;

use vibrissa_protocol::ArrayType;
use vibrissa_tests::python::environment;
use vibrissa_tests::robot::{HandRobot, array};

use crate::running::{LEARNED, Running};

const TOKEN: &str = "a-token-of-more-than-32-characters-for-the-test";
/// Number of requests of each kind on a route.
const EXAMPLES: &str = "10";

#[tokio::test(flavor = "multi_thread")]
async fn property_the_service_does_what_its_document_says() {
    does_what_its_document_says("2021", "examples,coverage,fuzzing").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn property_the_service_does_what_its_document_says_with_other_requests() {
    // The other phases make the same requests with each seed.
    does_what_its_document_says("20261124", "fuzzing").await;
}

async fn does_what_its_document_says(seed: &str, phases: &str) {
    let programs = environment("requirements-schemathesis.txt", env!("CARGO_TARGET_TMPDIR"));
    let running = Running::closed(TOKEN).await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    for whisker in [0, 1] {
        robot.touch(whisker, LEARNED + 20).await;
    }
    robot.cut(0, 54.0);
    robot.touch(0, 80).await;
    robot.receipted().await;
    check(&programs, running.service.http, seed, phases).await;
    running.service.stop().await;
}

/// Runs all checks with the requests of a seed.
async fn check(programs: &Path, http: SocketAddr, seed: &str, phases: &str) {
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/schemathesis.toml");
    let output = tokio::process::Command::new(programs.join("schemathesis"))
        .args(["--config-file", config, "run", "--checks", "all", "--max-examples", EXAMPLES, "--seed", seed])
        .args(["--phases", phases, "--generation-database", "none", "--no-color"])
        .args(["--header", &format!("Authorization: Bearer {TOKEN}")])
        // The document's own address of the server is relative, which leaves out most requests.
        .args(["--url", &format!("http://{http}")])
        .arg(format!("http://{http}/openapi.json"))
        .stdin(Stdio::null())
        .kill_on_drop(true)
        .output()
        .await
        .unwrap();
    assert!(output.status.success(), "seed {seed}: {}", String::from_utf8_lossy(&output.stdout));
}
