//! The shipped broker files, with the whole service and robots that keep the contract.

use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::process::{Command, Output};

use vibrissa_tests::certificates::{Authority, Validity, write};
use vibrissa_tests::mosquitto::Mosquitto;

use crate::access::shipped;
use crate::client::{Client, Who};
use crate::link::{PASSWORD, plain, tls, with_password};
use crate::running::{Running, everything_is_recorded, fleet};

const PLAIN: &str = include_str!("../../../deploy/mosquitto/mosquitto.conf");
const TLS: &str = include_str!("../../../deploy/mosquitto/mosquitto-tls.conf");
const SCRIPTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../deploy/mosquitto");

#[tokio::test]
async fn the_service_records_through_the_broker_in_plain_text() {
    let broker = shipped(PLAIN).start();
    let running = Running::start(with_password(plain(broker.supervisor_port()), "vibrissa")).await;
    let fleet = fleet(broker.port(), None);
    everything_is_recorded(&fleet, &running, 200).await;
    fleet.stop().await;
    running.service.stop().await;
}

#[tokio::test]
async fn the_service_records_through_the_broker_with_tls() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new("ours");
    let ca_file = write(folder.path(), "ca.crt", &authority.certificate());
    let broker = shipped(TLS).tls(authority.server(&["localhost"], Validity::Now)).start();
    let running = Running::start(with_password(tls(broker.supervisor_port(), &ca_file), "vibrissa")).await;
    let fleet = fleet(broker.port(), Some(&ca_file));
    everything_is_recorded(&fleet, &running, 200).await;
    fleet.stop().await;
    running.service.stop().await;
}

fn script(name: &str, arguments: &[&str]) -> Output {
    Command::new("sh").arg(format!("{SCRIPTS}/{name}")).args(arguments).output().unwrap()
}

async fn is_let_in(broker: &Mosquitto, user: &str, password: &str) -> bool {
    let port = if user == "vibrissa" { broker.supervisor_port() } else { broker.port() };
    Client::connect(port, &Who { id: "c", user: Some((user, password)), ..Who::default() }).await.is_some()
}

#[tokio::test]
async fn a_robot_is_added_and_given_a_new_password() {
    let mut broker = shipped(PLAIN).start();
    let passwords = broker.folder().join("passwords").display().to_string();
    // A new file would be the caller's with mode 0600, which the broker cannot read, and a container would still see the old one.
    std::fs::set_permissions(&passwords, std::fs::Permissions::from_mode(0o644)).unwrap();
    let file_of = |path: &str| std::fs::metadata(path).map(|found| (found.ino(), found.mode())).unwrap();
    let file_before = file_of(&passwords);
    for password in ["first one", "second"] {
        let file = write(broker.folder(), "new", &format!("{password}\n"));
        let added = script("add-robot", &[&passwords, "lab", "three", &file.display().to_string()]);
        assert!(added.status.success(), "{added:?}");
        assert_eq!(file_of(&passwords), file_before);
        broker.kill();
        broker.restart();
        assert!(is_let_in(&broker, "lab/three", password).await);
        assert!(is_let_in(&broker, "lab/one", PASSWORD).await, "other users must remain");
        assert!(!is_let_in(&broker, "lab/three", "another").await);
    }
    assert!(!is_let_in(&broker, "lab/three", "first one").await, "the old password must be invalid");
    let before = std::fs::read(&passwords).unwrap();
    for (fleet, robot) in
        [("lab", "supervisor"), ("lab", "+"), ("lab", "a/b"), ("", "a"), ("a:b", "c"), ("lab", "a\nb")]
    {
        let refused = script("add-robot", &[&passwords, fleet, robot, "new"]);
        assert!(!refused.status.success(), "{fleet}/{robot}");
        assert!(String::from_utf8_lossy(&refused.stderr).starts_with("add-robot: "), "{refused:?}");
    }
    let colon = write(broker.folder(), "new", "a:b\n").display().to_string();
    assert!(!script("add-robot", &[&passwords, "lab", "three", &colon]).status.success());
    let empty = write(broker.folder(), "new", "\n").display().to_string();
    assert!(!script("add-robot", &[&passwords, "lab", "three", &empty]).status.success());
    assert_eq!(std::fs::read(&passwords).unwrap(), before);
}

#[tokio::test]
async fn the_passwords_that_are_made_let_in_their_users_and_stay_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("secrets").display().to_string();
    let read = |name: &str| std::fs::read_to_string(folder.path().join("secrets").join(name)).unwrap();
    assert!(script("../make-secrets", &[&place]).status.success());
    let made = read("mosquitto_passwords");
    let made_for_supervisors = read("mosquitto_supervisor_passwords");
    assert!(script("../make-secrets", &[&place]).status.success());
    assert_eq!(read("mosquitto_passwords"), made);
    assert_eq!(read("mosquitto_supervisor_passwords"), made_for_supervisors);

    let (supervisor, robots) = (read("supervisor_mqtt_password"), read("robots_mqtt_password"));
    let (supervisor, robots) = (supervisor.trim_end(), robots.trim_end());
    assert_ne!(supervisor, robots);
    assert!(!made.contains(supervisor) && !made.contains(robots));
    let mut broker = shipped(PLAIN).start();
    write(broker.folder(), "passwords", &made);
    write(broker.folder(), "supervisor_passwords", &made_for_supervisors);
    broker.kill();
    broker.restart();
    assert!(is_let_in(&broker, "vibrissa", supervisor).await);
    for robot in ["example/crawler-1", "example/crawler-2"] {
        assert!(is_let_in(&broker, robot, robots).await);
        assert!(!is_let_in(&broker, robot, supervisor).await);
    }
}
