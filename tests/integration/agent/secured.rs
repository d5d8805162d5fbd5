//! An agent at a broker with TLS, users and client certificates: each fault is told once, costs no contact, and needs no
//! restart once it is mended.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};

use rumqttc::{AsyncClient, Event, MqttOptions, Packet, QoS, Transport};
use tempfile::TempDir;
use vibrissa_tests::certificates::{Authority, Identity, Validity, write};
use vibrissa_tests::mosquitto::{Builder, Mosquitto, add_user};
use vibrissa_tests::process::Process;
use vibrissa_tests::wait::until_true;

use crate::stage::{agent, agent_program, board_as_child, configuration};

const PASSWORD: &str = "correct-horse-battery-staple";
const WRONG: &str = "wrong-horse-battery-staple";

/// A folder with files of an authority `ca.crt`, a stranger's `other.crt`, and the robot's `password`.
struct Bench {
    folder: TempDir,
    authority: Authority,
}

impl Bench {
    fn new() -> Self {
        let (folder, authority) = (tempfile::tempdir().unwrap(), Authority::new("ours"));
        write(folder.path(), "ca.crt", &authority.certificate());
        write(folder.path(), "other.crt", &Authority::new("theirs").certificate());
        let password = write(folder.path(), "password", &format!("{PASSWORD}\n"));
        // The agent warns of a file that everyone can read.
        fs::set_permissions(password, fs::Permissions::from_mode(0o600)).unwrap();
        Self { folder, authority }
    }

    fn server(&self) -> Identity {
        self.authority.server(&["localhost"], Validity::Now)
    }

    fn builder(&self) -> Builder {
        Mosquitto::builder().tls(self.server()).user("f/r", PASSWORD).user("watcher", PASSWORD)
    }

    /// The configuration for a broker at this host, with further keys of its section.
    fn configuration(&self, host: &str, port: u16, keys: &str) -> String {
        let driver = board_as_child(self.folder.path(), 20.0);
        let keys = format!(
            "url = \"mqtts://{host}:{port}\"\nusername = \"{{fleet}}/{{robot}}\"\npassword_file = \"password\"\n{keys}"
        );
        configuration(port, &driver).replace(&format!("url = \"mqtt://127.0.0.1:{port}\""), &keys)
    }

    fn start(&self, host: &str, port: u16, keys: &str) -> Process {
        agent(self.folder.path(), &self.configuration(host, port, keys))
    }

    fn log(&self) -> String {
        fs::read_to_string(self.folder.path().join("agent.log")).unwrap_or_default()
    }

    fn is_connected(&self) -> bool {
        self.log().contains("connected to the broker")
    }

    /// Number of contacts that the board has made.
    fn felt(&self) -> usize {
        let log = fs::read_to_string(self.folder.path().join("board.log")).unwrap_or_default();
        log.lines().filter(|line| line.contains("\"log\":\"contact\"")).count()
    }

    /// Waits for the problem and for contacts that have to wait; afterwards nothing is connected or told twice.
    async fn problem(&self, words: &[&str]) {
        let has_words = |line: &str| words.iter().all(|word| line.contains(word));
        until_true(&format!("a problem with {words:?}"), async || self.log().lines().any(has_words)).await;
        // The driver is served during the attempts.
        let before = self.felt();
        until_true("contacts without a broker", async || self.felt() > before + 40).await;
        assert!(!self.is_connected());
        let log = self.log();
        assert_eq!(log.lines().filter(|line| line.contains("WARN")).count(), 1, "{log}");
        self.shows_no_password();
    }

    fn shows_no_password(&self) {
        let log = self.log();
        assert!(!log.contains(PASSWORD) && !log.contains(WRONG) && !log.contains("PRIVATE KEY"), "{log}");
    }
}

/// Numbers of the contacts messages that arrive at the broker, and whether the robot has announced itself.
#[derive(Clone, Default)]
struct Heard(Arc<Mutex<(Vec<u64>, bool)>>);

impl Heard {
    /// Listens as another client of the broker.
    fn listen(bench: &Bench, port: u16, client: Option<&Identity>) -> Self {
        let mut options = MqttOptions::new("watcher", ("localhost".to_owned(), port));
        options.set_credentials("watcher", PASSWORD.as_bytes().to_vec());
        let authority = bench.authority.certificate().into_bytes();
        let client = client.map(|it| (it.certificate.clone().into_bytes(), it.key.clone().into_bytes()));
        options.set_transport(Transport::tls(authority, client, None));
        let (client, mut events) = AsyncClient::builder(options).capacity(10).build();
        let heard = Self::default();
        let taking = heard.clone();
        tokio::spawn(async move {
            client.subscribe("whisker/v1/#", QoS::AtLeastOnce).await.unwrap();
            loop {
                let Ok(event) = events.poll().await else { continue };
                let Event::Incoming(Packet::Publish(publish)) = event else { continue };
                let topic = std::str::from_utf8(&publish.topic).unwrap();
                let message: serde_json::Value = serde_json::from_slice(&publish.payload).unwrap();
                let mut heard = taking.0.lock().unwrap();
                if topic.ends_with("/contacts") {
                    heard.0.push(message["seq"].as_u64().unwrap());
                }
                heard.1 |= topic.ends_with("/r/factsheet");
            }
        });
        heard
    }

    /// Waits for the robot's announcement and all messages of its outbox from the first one on.
    async fn all(&self, bench: &Bench) {
        until_true("an agent that is connected", async || bench.is_connected()).await;
        until_true("all contacts from the first one on", async || {
            let (mut numbers, is_announced) = self.0.lock().unwrap().clone();
            numbers.sort_unstable();
            numbers.dedup();
            is_announced && numbers.len() > 10 && numbers.iter().zip(0..).all(|(&number, at)| number == at)
        })
        .await;
        bench.shows_no_password();
    }
}

fn replace(folder: &Path, to: &str, from: &str) {
    fs::copy(folder.join(from), folder.join(to)).unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn an_unknown_authority_is_told_and_can_be_replaced_while_the_agent_runs() {
    let bench = Bench::new();
    let broker = bench.builder().start();
    let heard = Heard::listen(&bench, broker.port(), None);
    let folder = bench.folder.path();
    replace(folder, "trusted.crt", "other.crt");
    let _agent = bench.start("localhost", broker.port(), "ca_file = \"trusted.crt\"");
    let place = format!("MQTT broker localhost:{}", broker.port());
    bench.problem(&[&place, "not signed by a trusted authority", "trusted.crt", "broker.ca_file"]).await;
    replace(folder, "trusted.crt", "ca.crt");
    heard.all(&bench).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_host_name_is_told_and_the_broker_can_get_another_certificate() {
    let bench = Bench::new();
    let mut broker = bench.builder().start();
    let port = broker.port();
    let _agent = bench.start("127.0.0.1", port, "ca_file = \"ca.crt\"");
    let words =
        [&format!("MQTT broker 127.0.0.1:{port}"), "is not for \"127.0.0.1\" but for", "localhost", "broker.url"];
    bench.problem(&words).await;
    let server = bench.authority.server(&["localhost", "127.0.0.1"], Validity::Now);
    write(broker.folder(), "server.crt", &server.certificate);
    write(broker.folder(), "server.key", &server.key);
    broker.kill();
    broker.restart();
    let heard = Heard::listen(&bench, port, None);
    heard.all(&bench).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_password_is_told_and_can_be_corrected_in_its_file_or_at_the_broker() {
    let bench = Bench::new();
    let mut broker = bench.builder().start();
    let port = broker.port();
    let heard = Heard::listen(&bench, port, None);
    write(bench.folder.path(), "password", WRONG);
    let mut agent = bench.start("localhost", port, "ca_file = \"ca.crt\"");
    let words = ["does not accept user \"f/r\"", "broker.password_file", "list of users"];
    bench.problem(&[&format!("MQTT broker localhost:{port}"), words[0], words[1], words[2]]).await;
    write(bench.folder.path(), "password", &format!("{PASSWORD}\n"));
    heard.all(&bench).await;

    // The broker's administrator changes the password. The connection ends with the broker, and the next one is refused.
    add_user(&broker.folder().join("passwords"), "f/r", WRONG);
    broker.kill();
    broker.restart();
    until_true("another refusal", async || bench.log().matches(words[0]).count() == 2).await;
    add_user(&broker.folder().join("passwords"), "f/r", PASSWORD);
    broker.kill();
    broker.restart();
    until_true("another connection", async || bench.log().matches("connected to the broker").count() == 2).await;
    bench.shows_no_password();
    // Neither the command line nor the check of the configuration shows it.
    agent.kill();
    let path = bench.folder.path().join("agent.toml");
    for arguments in [vec!["--help"], vec!["--check", "--config", path.to_str().unwrap()]] {
        let output = Command::new(agent_program()).args(&arguments).env("VIBRISSA_LOG", "trace").output().unwrap();
        assert!(output.status.success(), "{arguments:?}");
        let said = [output.stdout, output.stderr].concat();
        assert!(!String::from_utf8(said).unwrap().contains(PASSWORD));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_broker_that_wants_a_client_certificate_gets_one() {
    let bench = Bench::new();
    let builder = Mosquitto::builder().tls_with_clients_of(bench.server(), &bench.authority);
    let broker = builder.user("f/r", PASSWORD).user("watcher", PASSWORD).start();
    let folder = bench.folder.path();
    let save = |identity: &Identity| {
        write(folder, "me.crt", &identity.certificate);
        let key = write(folder, "me.key", &identity.key);
        fs::set_permissions(key, fs::Permissions::from_mode(0o600)).unwrap();
    };
    save(&Authority::new("theirs").client("r"));
    let certificate = "ca_file = \"ca.crt\"\nclient_certificate_file = \"me.crt\"\nclient_key_file = \"me.key\"";
    let heard = Heard::listen(&bench, broker.port(), Some(&bench.authority.client("watcher")));
    let mut agent = bench.start("localhost", broker.port(), "ca_file = \"ca.crt\"");
    bench.problem(&["broker.client_certificate_file", "broker.client_key_file"]).await;
    agent.kill();
    fs::remove_file(folder.join("agent.log")).unwrap();
    let mut agent = bench.start("localhost", broker.port(), certificate);
    bench.problem(&["client certificate in", "me.crt"]).await;
    // A half-copied file costs nothing: the files are read again.
    write(folder, "me.key", "-----BEGIN PRIVATE KEY-----\n");
    until_true("a broken key that is told", async || bench.log().contains("me.key contains no private key")).await;
    save(&bench.authority.client("r"));
    until_true("an agent that is connected", async || bench.is_connected()).await;
    until_true("the announcement", async || heard.0.lock().unwrap().1).await;
    bench.shows_no_password();
    agent.kill();
}

#[test]
fn files_that_cannot_be_used_are_named_by_the_check() {
    let bench = Bench::new();
    let folder = bench.folder.path();
    write(folder, "empty.crt", "");
    let own = bench.authority.client("r");
    write(folder, "me.crt", &own.certificate);
    write(folder, "me.key", "-----BEGIN ENCRYPTED PRIVATE KEY-----\nAAAA\n-----END ENCRYPTED PRIVATE KEY-----\n");
    for (keys, why) in [
        ("ca_file = \"empty.crt\"", "empty.crt: the file contains no certificate in PEM"),
        ("ca_file = \"missing.crt\"", "missing.crt: No such file"),
        (
            "ca_file = \"ca.crt\"\nclient_certificate_file = \"me.crt\"\nclient_key_file = \"me.key\"",
            "me.key contains no private key in PEM without a passphrase",
        ),
    ] {
        let path = write(folder, "agent.toml", &bench.configuration("localhost", 1, keys));
        let output = Command::new(agent_program()).args(["--check", "--config"]).arg(path).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.contains(why), "{why}: {said}");
    }
}

/// Lets everybody connect and publish, but not subscribe.
const NO_SUBSCRIPTIONS: &str = r#"{"defaultACLAccess": {"publishClientSend": true, "publishClientReceive": true,
"subscribe": false, "unsubscribe": true}, "clients": [], "groups": [], "roles": []}"#;

/// Mosquitto's access lists of the usual kind accept a subscription and deliver nothing; its plugin refuses it.
#[tokio::test]
async fn each_refused_subscription_is_told_and_contacts_still_arrive() {
    let Some(plugin) = plugin() else {
        println!("skipped: Mosquitto's plugin for dynamic security is not installed");
        return;
    };
    let bench = Bench::new();
    let rules = bench.folder.path().join("dynamic-security.json");
    fs::write(&rules, NO_SUBSCRIPTIONS).unwrap();
    let broker = Mosquitto::builder()
        .line("log_type all")
        .line(&format!("plugin {}", plugin.display()))
        .line(&format!("plugin_opt_config_file {}", rules.display()))
        .start();
    let driver = board_as_child(bench.folder.path(), 20.0);
    let _robot = agent(bench.folder.path(), &configuration(broker.port(), &driver));
    until_true("five refusals in the log", async || bench.log().matches("refuses this subscription").count() == 5)
        .await;
    for topic in ["f/r/receipt", "f/r/setpoint", "f/r/request", "f/r/estimate", "f/supervisor/request"] {
        assert!(bench.log().contains(topic), "{topic}: {}", bench.log());
    }
    until_true("contacts at the broker", async || broker.logged("'whisker/v1/f/r/contacts'") > 3).await;
}

/// The plugin's file.
fn plugin() -> Option<PathBuf> {
    let folders = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib"];
    folders.into_iter().map(|folder| Path::new(folder).join("mosquitto_dynamic_security.so")).find(|file| file.exists())
}
