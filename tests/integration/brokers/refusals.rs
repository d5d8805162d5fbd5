//! Messages about brokers that cannot be used, which disappear with the cause.

use std::net::TcpListener;

use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use vibrissa_protocol::RobotTopic;
use vibrissa_supervisor::mqtt::{BrokerAddress, ClientCertificate};
use vibrissa_tests::certificates::{Authority, Identity, Validity, write};
use vibrissa_tests::mosquitto::{Mosquitto, free_port};

use crate::link::{Link, PASSWORD, plain, tls, with_certificate, with_password};

fn certificate(folder: &TempDir, identity: &Identity) -> ClientCertificate {
    ClientCertificate {
        certificate_file: write(folder.path(), "me.crt", &identity.certificate),
        key_file: write(folder.path(), "me.key", &identity.key),
    }
}

/// An authority, its file, and a server certificate that it has issued.
fn authority() -> (TempDir, Authority, Identity) {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new("ours");
    write(folder.path(), "ca.crt", &authority.certificate());
    let server = authority.server(&["localhost", "127.0.0.1", "::1"], Validity::Now);
    (folder, authority, server)
}

async fn said(broker: BrokerAddress, words: &[&str]) {
    let link = Link::start(broker);
    link.problem_with(words).await;
    link.stop().await;
}

#[tokio::test]
async fn nothing_listens() {
    let port = free_port();
    said(plain(port), &[&format!("MQTT broker localhost:{port}: nothing listens there"), "mqtt.url"]).await;
}

#[tokio::test]
async fn a_host_that_nobody_knows() {
    said(BrokerAddress::new("broker.invalid", 1883), &["no address is known for host \"broker.invalid\""]).await;
}

#[tokio::test]
async fn a_server_that_says_nothing() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    said(plain(port), &["says nothing within 5 s", "mqtts://"]).await;
}

#[tokio::test]
async fn a_server_of_another_kind() {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let server = tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            let _ = stream.write_all(b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n").await;
        }
    });
    said(plain(port), &["does not answer as an MQTT broker"]).await;
    server.abort();
}

#[tokio::test]
async fn plain_text_to_a_port_with_tls() {
    let (_folder, _, server) = authority();
    let broker = Mosquitto::builder().tls(server).start();
    said(plain(broker.port()), &["does not answer as an MQTT broker", "mqtts://"]).await;
}

#[tokio::test]
async fn tls_to_a_port_in_plain_text() {
    let (folder, _, _) = authority();
    let broker = Mosquitto::start();
    let port = broker.port();
    said(tls(port, &folder.path().join("ca.crt")), &[&format!("does not answer in TLS on port {port}"), "8883"]).await;
}

#[tokio::test]
async fn a_broker_that_wants_a_client_certificate() {
    let (folder, authority, server) = authority();
    let ca_file = folder.path().join("ca.crt");
    let builder = || Mosquitto::builder().tls_with_clients_of(server.clone(), &authority);
    // The two TLS versions report it at different moments and in different words.
    for broker in [builder().line("tls_version tlsv1.3").start(), builder().tls_1_2().start()] {
        let wanted = ["client certificate", "mqtt.client_certificate_file", "mqtt.client_key_file"];
        said(tls(broker.port(), &ca_file), &wanted).await;
        let stranger = certificate(&folder, &Authority::new("theirs").client("vibrissa"));
        said(with_certificate(tls(broker.port(), &ca_file), stranger), &["client certificate", "me.crt"]).await;
        let ours = certificate(&folder, &authority.client("vibrissa"));
        let link = Link::start(with_certificate(tls(broker.port(), &ca_file), ours));
        link.connected().await;
        link.stop().await;
    }
}

#[tokio::test]
async fn a_broker_with_tls_by_name_and_by_address() {
    let (folder, _, server) = authority();
    let broker = Mosquitto::builder().tls(server).start();
    for host in ["localhost", "127.0.0.1"] {
        let address = BrokerAddress { host: host.to_owned(), ..tls(broker.port(), &folder.path().join("ca.crt")) };
        let link = Link::start(address);
        link.connected().await;
        link.stop().await;
    }
}

#[tokio::test]
async fn regress_certificates_as_many_guides_make_them_are_explained() {
    let (folder, authority, _) = authority();
    let without_names = authority.server(&[], Validity::Now);
    let of_a_client = authority.client("localhost");
    for (server, words) in
        [(without_names, ["names no host", "subjectAltName"]), (of_a_client, ["purpose", "serverAuth"])]
    {
        let broker = Mosquitto::builder().tls(server).start();
        said(tls(broker.port(), &folder.path().join("ca.crt")), &words).await;
    }
}

/// Checks nothing on a host without IPv6.
#[tokio::test]
async fn a_broker_on_ipv6() {
    if TcpListener::bind("[::1]:0").is_err() {
        eprintln!("a_broker_on_ipv6: skipped, this host has no IPv6");
        return;
    }
    let (folder, _, server) = authority();
    let own = certificate(&folder, &server);
    let (plain_port, tls_port) = (free_port(), free_port());
    let _broker = Mosquitto::builder()
        .line(&format!("listener {plain_port} ::1\nlistener {tls_port} ::1"))
        .line(&format!("certfile {}", own.certificate_file.display()))
        .line(&format!("keyfile {}", own.key_file.display()))
        .start();
    let encrypted = BrokerAddress { host: "::1".to_owned(), ..tls(tls_port, &folder.path().join("ca.crt")) };
    for address in [BrokerAddress::new("::1", plain_port), encrypted] {
        let link = Link::start(address);
        link.connected().await;
        link.stop().await;
    }
    said(BrokerAddress::new("::1", free_port()), &["MQTT broker [::1]:", "nothing listens there"]).await;
}

#[tokio::test]
async fn a_wrong_password_and_none() {
    let broker = Mosquitto::builder().user("vibrissa", "another password").start();
    let user = with_password(plain(broker.port()), "vibrissa");
    said(user, &["does not accept user \"vibrissa\"", "mqtt.password_file"]).await;
    said(plain(broker.port()), &["requires a user and a password", "mqtt.username"]).await;
}

#[tokio::test]
async fn a_password_that_is_put_right_at_the_broker() {
    let mut broker = Mosquitto::builder().user("vibrissa", "another password").start();
    let link = Link::start(with_password(plain(broker.port()), "vibrissa"));
    link.problem_with(&["does not accept user \"vibrissa\""]).await;
    vibrissa_tests::mosquitto::add_user(&broker.folder().join("passwords"), "vibrissa", PASSWORD);
    broker.kill();
    broker.restart();
    link.connected().await;
    link.stop().await;
}

#[tokio::test]
async fn a_broker_that_takes_nothing_of_what_is_published() {
    // Probes of the receiving connection are allowed, because they come before everything else.
    let kinds = RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot());
    let probes: String = kinds.map(|kind| format!("topic write whisker/v1/f/supervisor/{kind}\n")).collect();
    let broker = Mosquitto::builder().acl(&format!("topic read #\n{probes}")).start();
    let link = Link::start(plain(broker.port()));
    let found = vibrissa_tests::wait::until("a problem", async || {
        link.problem().filter(|problem| problem.contains("rejects publications of"))
    });
    assert!(found.await.contains("supervisor/state"));
    link.stop().await;
}

/// Mosquitto accepts every subscription and only withholds the messages, so this broker is written by hand.
#[tokio::test]
async fn a_refused_subscription_does_not_count_as_connected() {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let server = tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            tokio::spawn(refuse_the_third(stream));
        }
    });
    let link = Link::start(with_password(plain(port), "somebody"));
    let words = [
        "does not let user \"somebody\" subscribe to whisker/v1/f/+/contacts, because this user may not do it",
        "access list",
    ];
    link.problem_with(&words).await;
    link.stop().await;
    server.abort();
}

#[tokio::test]
async fn a_broker_that_lacks_qos_1_is_told_with_its_setting() {
    let broker = Mosquitto::builder().line("max_qos 0").start();
    said(plain(broker.port()), &["it accepts QoS 0 only, and robots need QoS 1", "Mosquitto: max_qos"]).await;
}

/// Accepts the connection and all six subscriptions except the third.
async fn refuse_the_third(mut stream: tokio::net::TcpStream) {
    let mut buffer = vec![0; 4096];
    while let Ok(count @ 1..) = stream.read(&mut buffer).await {
        let answer = match buffer[0] >> 4 {
            1 => vec![0x20, 3, 0, 0, 0],
            8 => {
                // The packet id follows one or two bytes of length.
                let at = if buffer[1] < 0x80 { 2 } else { 3 };
                vec![0x90, 9, buffer[at], buffer[at + 1], 0, 1, 1, 0x87, 1, 1, 1]
            }
            _ => continue,
        };
        if count == 0 || stream.write_all(&answer).await.is_err() {
            return;
        }
    }
}
