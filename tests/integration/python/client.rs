//! `vibrissa-client`: types, operations, lists, events, and the notebook.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;

use serde_json::{Value, json};
use vibrissa_tests::proxy::Proxy;
use vibrissa_tests::wait::until;
use vibrissa_tests::web::send;

use crate::stage::{Stage, TOKEN, client_environment, program, project, succeed};

#[tokio::test(flavor = "multi_thread")]
async fn the_client_does_what_its_types_say() {
    let Some(programs) = client_environment() else { return };
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("integration/python");
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mypy-client");
    for checked in [["-p".into(), "vibrissa_client".into()], [here.join("use.py"), here.join("follow.py")]] {
        let mut mypy = Command::new(programs.join("mypy"));
        // Where no file of the checkout hides the installed package.
        mypy.args(["--strict", "--cache-dir"]).arg(&cache).args(checked).current_dir(env!("CARGO_TARGET_TMPDIR"));
        succeed(&mut mypy);
    }
    let stage = Stage::start().await;
    assert_eq!(succeed(&mut program(&programs, "use.py", stage.http)), "used\n");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_notebook_draws_its_first_curve_in_five_lines() {
    let Some(programs) = client_environment() else { return };
    let notebook = project().join("python/notebooks/first-curve.ipynb");
    let cells: Value = serde_json::from_slice(&std::fs::read(&notebook).unwrap()).unwrap();
    let first = cells["cells"].as_array().unwrap().iter().find(|cell| cell["cell_type"] == "code").unwrap();
    assert!(first["source"].as_str().unwrap().lines().count() <= 5);
    let stage = Stage::start().await;
    let pictures = Path::new(env!("CARGO_TARGET_TMPDIR")).join("first-curve");
    std::fs::create_dir_all(&pictures).unwrap();
    let mut run = program(&programs, "notebook.py", stage.http);
    assert_eq!(succeed(run.arg(&notebook).arg(&pictures)), "2 pictures\n");
    for name in ["curve-1.png", "curve-2.png"] {
        assert!(std::fs::metadata(pictures.join(name)).unwrap().len() > 10_000, "{name}");
    }
}

/// An operator's action, which is an event.
async fn act(http: SocketAddr, whisker: u16, word: &str) -> u64 {
    let path = format!("/v1/fleets/f/robots/r/arrays/left/whiskers/{whisker}/{word}");
    let bearer = format!("Bearer {TOKEN}");
    let answer = send(http, "POST", &path, &[("authorization", &bearer)], Some(&json!({}))).await.unwrap();
    assert!(answer.status < 300, "{}", answer.body);
    answer.json()["action_id"].as_u64().unwrap()
}

/// A program that ends with the test, also if the test fails.
struct Follower(Child);

impl Drop for Follower {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Follows events through a link that is cut, and checks that each event comes once.
async fn events_survive_a_cut(kind: &str) {
    let Some(programs) = client_environment() else { return };
    let stage = Stage::start().await;
    let proxy = Proxy::to(stage.http.port()).await;
    let through = SocketAddr::from(([127, 0, 0, 1], proxy.port()));
    let follower = program(&programs, "follow.py", through).arg(kind).stdout(Stdio::piped()).spawn().unwrap();
    let mut follower = Follower(follower);
    let lines = BufReader::new(follower.0.stdout.take().unwrap()).lines();
    let (heard, hear) = mpsc::channel::<Value>();
    thread::spawn(move || {
        lines.map_while(Result::ok).try_for_each(|line| heard.send(serde_json::from_str(&line).unwrap()))
    });
    let actions = |line: &Value| {
        assert_eq!(line["kind"], "change", "{line}");
        let action = &line["change"]["data"]["action"]["action_id"];
        (line["change"]["type"] == "ACTION").then(|| action.as_u64().unwrap())
    };
    // Actions before the stream is open are not heard: act until one is.
    let mut numbers: Vec<u64> = Vec::new();
    until("the first event", async || {
        act(stage.http, 0, "hold").await;
        numbers.extend(hear.try_iter().filter_map(|line| actions(&line)));
        (!numbers.is_empty()).then_some(())
    })
    .await;
    let mut last = 0;
    for word in ["release", "hold", "release"] {
        proxy.cut();
        last = act(stage.http, 0, word).await;
        until("the event after a cut", async || {
            numbers.extend(hear.try_iter().filter_map(|line| actions(&line)));
            numbers.contains(&last).then_some(())
        })
        .await;
    }
    drop(follower);
    // An action is an event when it is requested, and another one when it is done.
    let mut each = numbers.clone();
    each.dedup();
    let expected: Vec<u64> = (numbers[0]..=last).collect();
    assert_eq!(each, expected, "{numbers:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn events_survive_a_cut_connection() {
    events_survive_a_cut("sync").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn events_survive_a_cut_connection_with_asyncio() {
    events_survive_a_cut("async").await;
}
