//! Tests the service against its OpenAPI document with schemathesis: valid and invalid requests on every route, with
//! every check.

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
    let programs = environment("requirements-schemathesis.txt", env!("CARGO_TARGET_TMPDIR"));
    let running = Running::closed(TOKEN).await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    for whisker in [0, 1] {
        robot.touch(whisker, LEARNED + 20).await;
    }
    robot.cut(0, 54.0);
    robot.touch(0, 80).await;
    robot.receipted().await;
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/schemathesis.toml");
    let output = tokio::process::Command::new(programs.join("schemathesis"))
        .args(["--config-file", config, "run", "--checks", "all", "--max-examples", EXAMPLES, "--seed", "2021"])
        .args(["--phases", "examples,coverage,fuzzing", "--generation-database", "none", "--no-color"])
        .args(["--header", &format!("Authorization: Bearer {TOKEN}")])
        .arg(format!("http://{}/openapi.json", running.service.http))
        .stdin(Stdio::null())
        .kill_on_drop(true)
        .output()
        .await
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    running.service.stop().await;
}
