//! A Patroni pair with synchronous replication: whatever fails, nothing is lost, nothing is twice, and nothing is stale.

use std::time::Instant;

use vibrissa_tests::patroni::Patroni;
use vibrissa_tests::wait::until_within;

use crate::stage::{LONG, Stage};

const ASYNCHRONOUS: &str = "vibrissa_database_asynchronous";

#[tokio::test(flavor = "multi_thread")]
async fn a_leader_a_standby_and_etcd_are_killed_one_after_the_other() {
    let mut cluster = Patroni::start().await;
    let stage = Stage::start(&cluster.url()).await;
    stage.until_busy(&cluster.connect(0)).await;
    assert_eq!(stage.metric(ASYNCHRONOUS).await, Some(0.0), "{}", stage.log());

    let failed = Instant::now();
    cluster.kill(0);
    stage.taken_over(&cluster, 1, "leader killed", failed).await;
    stage.until_metric(ASYNCHRONOUS, |value| value == 1.0).await;

    let begun = Instant::now();
    cluster.restart(0);
    cluster.until_replicated().await;
    let is_rewound = cluster.log(0).contains("pg_rewind: Done!");
    println!("the former leader replicates after {:.1} s, pg_rewind: {is_rewound}", begun.elapsed().as_secs_f64());
    stage.until_metric(ASYNCHRONOUS, |value| value == 0.0).await;

    let failed = Instant::now();
    cluster.kill(0);
    let recorded = stage.until_recorded(&cluster.connect(1)).await;
    println!("standby killed: contacts recorded after {:.1} s", recorded.as_secs_f64());
    stage.until_metric(ASYNCHRONOUS, |value| value == 1.0).await;
    println!("standby killed: commits wait for none after {:.1} s", failed.elapsed().as_secs_f64());
    cluster.restart(0);
    cluster.until_replicated().await;

    let failed = Instant::now();
    cluster.kill_etcd();
    until_within(LONG, "a leader without etcd to give up", async || (!cluster.leads(1).await).then_some(())).await;
    println!("etcd killed: no leader after {:.1} s", failed.elapsed().as_secs_f64());
    let failed = Instant::now();
    cluster.restart_etcd();
    let leader = until_within(LONG, "a leader after etcd's return", async || {
        for node in 0..2 {
            if cluster.leads(node).await {
                return Some(node);
            }
        }
        None
    })
    .await;
    stage.taken_over(&cluster, leader, "etcd back", failed).await;
    stage.end(&cluster.connect(leader)).await.is_clean();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_leader_freezes_and_comes_back() {
    let mut cluster = Patroni::start().await;
    let stage = Stage::start(&cluster.url()).await;
    stage.until_busy(&cluster.connect(0)).await;
    let failed = Instant::now();
    cluster.freeze(0, true);
    stage.taken_over(&cluster, 1, "leader frozen", failed).await;
    // Patroni 3.0.2 may take the lock back when it is continued: docs/postgresql.md. A watchdog ends it before that.
    cluster.kill_patroni(0);
    // It still accepts writes.
    cluster.until_leader(0).await;
    stage.until_recorded(&cluster.connect(1)).await;
    let begun = Instant::now();
    cluster.restart(0);
    cluster.until_replicated().await;
    println!("the old leader replicates after {:.1} s", begun.elapsed().as_secs_f64());
    assert!(cluster.log(0).contains("pg_rewind: Done!"), "{}", cluster.log(0));
    stage.end(&cluster.connect(1)).await.is_clean();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_leader_is_cut_off() {
    let Some(cluster) = Patroni::start_with_network().await else {
        println!("skipped: a leader that is cut off needs root and network namespaces");
        return;
    };
    let stage = Stage::start(&cluster.url()).await;
    stage.until_busy(&cluster.connect(0)).await;
    let failed = Instant::now();
    cluster.cut_off(true);
    stage.taken_over(&cluster, 1, "leader cut off", failed).await;
    cluster.cut_off(false);
    let begun = Instant::now();
    cluster.until_replicated().await;
    println!("the reconnected leader replicates after {:.1} s", begun.elapsed().as_secs_f64());
    stage.end(&cluster.connect(1)).await.is_clean();
}
