//! HAProxy in front of a Patroni pair: one address, which leads to the server whose Patroni answers `/primary`.

use std::time::Instant;

use tempfile::TempDir;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::patroni::Patroni;
use vibrissa_tests::process::{Launch, Process};

use crate::stage::Stage;

/// Starts HAProxy as docs/postgresql.md configures it; its port.
fn start(cluster: &Patroni) -> (Process, u16, TempDir) {
    let (folder, port) = (tempfile::tempdir().unwrap(), free_port());
    let server = |node: usize| {
        let (address, rest_port) = cluster.addresses(node);
        format!("    server pg{node} {address} check port {rest_port}\n")
    };
    let text = format!(
        "defaults\n    mode tcp\n    timeout connect 2s\n    timeout client 30m\n    timeout server 30m\n\
         listen postgres\n    bind 127.0.0.1:{port}\n    option httpchk OPTIONS /primary\n    http-check expect status 200\n    \
         default-server inter 1s fall 2 rise 1 on-marked-down shutdown-sessions\n{}{}",
        server(0),
        server(1)
    );
    let file = folder.path().join("haproxy.cfg");
    std::fs::write(&file, text).unwrap();
    let program =
        ["/usr/sbin/haproxy", "/usr/local/sbin/haproxy"].into_iter().find(|path| std::fs::exists(path).unwrap());
    let process = Process::start(Launch {
        program: program.unwrap_or("haproxy").into(),
        arguments: vec!["-db".to_owned(), "-f".to_owned(), file.display().to_string()],
        environment: Vec::new(),
        log: folder.path().join("log"),
    });
    (process, port, folder)
}

#[tokio::test(flavor = "multi_thread")]
async fn one_address_leads_to_the_leader_before_and_after_a_failover() {
    let mut cluster = Patroni::start().await;
    let (_haproxy, port, _folder) = start(&cluster);
    let stage = Stage::start(&format!("postgres://vibrissa@127.0.0.1:{port}/vibrissa")).await;
    stage.until_busy(&cluster.connect(0)).await;
    let failed = Instant::now();
    cluster.kill(0);
    cluster.until_leader(1).await;
    let led = failed.elapsed();
    let recorded = stage.until_recorded(&cluster.connect(1)).await;
    println!(
        "leader killed behind HAProxy: a new leader after {:.1} s, contacts recorded {:.1} s later",
        led.as_secs_f64(),
        recorded.as_secs_f64()
    );
    // HAProxy's checks take up to a second longer.
    assert!(recorded < crate::stage::TAKEOVER_MAX * 2, "{recorded:?}\n{}", stage.log());
    stage.end(&cluster.connect(1)).await.is_clean();
}
