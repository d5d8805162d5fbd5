//! The whole way: the robot's ROS node, the bridge as child process of the agent, the broker, and the supervisor.

use std::net::SocketAddr;
use std::path::Path;

use serde_json::{Value, json};
use tokio::sync::watch;
use vibrissa_robot::{Config, hub};
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{send, try_get};

use crate::stage::Stage;

const ATMOSPHERE_PA: f64 = 101_325.0;
const WHISKER: &str = "/v1/fleets/f/robots/crawler/arrays/left-front/whiskers/0";

async fn get(http: SocketAddr, path: &str) -> Value {
    let (_, body) = try_get(http, path).await.unwrap();
    serde_json::from_str(&body).unwrap()
}

/// A supervisor of fleet `f`, with its files in the folder.
async fn supervisor(broker: &Mosquitto, folder: &Path) -> (Process, SocketAddr) {
    let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
    let arguments = [
        "run".to_owned(),
        "--fleet=f".to_owned(),
        format!("--http={http}"),
        format!("--mqtt-url=mqtt://127.0.0.1:{}", broker.port()),
        format!("--database-url=sqlite:{}", folder.join("v.sqlite3").display()),
    ];
    let process = Process::start(Launch {
        program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
        arguments: arguments.into(),
        environment: Vec::new(),
        log: folder.join("log"),
    });
    until_true("the supervisor answers", async || try_get(http, "/livez").await.is_ok()).await;
    (process, http)
}

/// Slide and gauge of a robot that knows nothing of whiskers; the gauge's message also has the distance of the wall, mm.
const MAPPING: &str = r#"
whiskers:
  left-front/0:
    strain: {topic: /gauges, type: std_msgs/msg/Float32MultiArray, field: "data[0]", scale: 0.001}
    deflection: {topic: /joint_states, type: sensor_msgs/msg/JointState, field: "position[slide_0]"}
    distance: {topic: /gauges, type: std_msgs/msg/Float32MultiArray, field: "data[1]", scale: 0.001}
    pressure: {topic: /chamber, type: std_msgs/msg/Float64, field: data, scale: 100000, offset: 101325}
"#;

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_of_standard_messages_is_supervised_without_orders_to_its_air() {
    let Some(stage) = Stage::make(8) else { return };
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let (_supervisor, http) = supervisor(&broker, folder.path()).await;
    std::fs::write(folder.path().join("mapping.yaml"), MAPPING).unwrap();
    let mut command = stage.command();
    command.extend(["--mapping".to_owned(), "mapping.yaml".to_owned()]);
    let config = format!(
        r#"
        fleet = "f"
        robot = "crawler"
        air_control = "NONE"
        [broker]
        url = "mqtt://127.0.0.1:{}"
        [driver]
        command = {command:?}
        [[arrays]]
        array = "left-front"
        type = "TYPE_2"
        whiskers = [{{ whisker = 0, length_mm = 70.0, pressure_mpa = 0.08, pressure_max_mpa = 0.2, place = "DISTANCE" }}]
        "#,
        broker.port(),
    );
    let config = Config::from_toml_str(&config, folder.path()).unwrap();
    let (stop, stopping) = watch::channel(false);
    let agent = tokio::spawn(hub::run(config, stopping));
    let _peer = stage.peer(&["presses"]);
    until_true("contacts", async || get(http, WHISKER).await["contacts"].as_u64() > Some(2)).await;
    let whisker = get(http, WHISKER).await;
    assert_eq!(whisker["fault"], Value::Null, "{whisker}");
    assert!(whisker["pressure_mpa"].as_f64().is_some_and(|mpa| (mpa - 0.08).abs() < 1e-6), "{whisker}");
    stop.send(true).unwrap();
    agent.await.unwrap().unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_ros_robot_is_supervised() {
    let Some(stage) = Stage::make(3) else { return };
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let (_supervisor, http) = supervisor(&broker, folder.path()).await;
    let config = format!(
        r#"
        fleet = "f"
        robot = "crawler"
        [broker]
        url = "mqtt://127.0.0.1:{}"
        [driver]
        command = {:?}
        own_slew_mpa_per_s = 0.05
        [[arrays]]
        array = "left-front"
        type = "TYPE_2"
        whiskers = [{{ whisker = 0, length_mm = 70.0, pressure_mpa = 0.05, pressure_max_mpa = 0.2, place = "DISTANCE" }}]
        "#,
        broker.port(),
        stage.command(),
    );
    let config = Config::from_toml_str(&config, folder.path()).unwrap();
    let (stop, stopping) = watch::channel(false);
    let agent = tokio::spawn(hub::run(config, stopping));
    let peer = stage.peer(&[]);
    until_true("contacts", async || get(http, WHISKER).await["contacts"].as_u64() > Some(3)).await;
    let body = json!({ "pressure_mpa": 0.06, "reason": "a test" });
    let answer = send(http, "POST", &format!("{WHISKER}/setpoint"), &[], Some(&body)).await.unwrap();
    assert!(answer.status < 300, "{}", answer.body);
    let (wanted_pa, mut last_pa) = (ATMOSPHERE_PA + 60_000.0, ATMOSPHERE_PA + 50_000.0);
    tokio::task::block_in_place(|| {
        peer.hear("the setpoint", |line| {
            let pa = line["setpoint_pa"].as_f64()?;
            assert!(pa >= last_pa - 0.1 && pa <= wanted_pa + 0.1, "{pa} Pa after {last_pa} Pa");
            last_pa = pa;
            ((pa - wanted_pa).abs() < 0.1).then_some(())
        });
    });
    let applied = "/v1/setpoints?fleet=f&robot=crawler&whisker=0&state=APPLIED";
    until_true("the setpoint is applied", async || {
        get(http, applied).await["items"].as_array().is_some_and(|items| !items.is_empty())
    })
    .await;
    // A robot whose ROS nodes are gone has a faulty regulator, and does not look healthy.
    drop(peer);
    until_true("the fault", async || get(http, WHISKER).await["fault"] == "REGULATOR").await;
    stop.send(true).unwrap();
    agent.await.unwrap().unwrap();
}
