//! Measures messages of twenty contacts each: rows per second, compared with PostgreSQL's rate for a plain table.

use std::time::Duration;

use serde_json::json;

use crate::Bench;
use crate::burst::{LEARN, Subject, arguments, messages};
use crate::report::{Figure, Target, median};
use crate::stage::{self, Store};
use crate::unnest;

/// Contacts per message.
const CONTACTS: usize = 20;
const PART: &str = "batch";
const FIRST_MESSAGES: u64 = 2000;
/// The target is met by this rate or by this share of the plain table's rate.
const LEAST_PER_S: f64 = 400_000.0;
const LEAST_SHARE: f64 = 0.65;

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    let broker = stage::broker();
    let sqlite = Store::Sqlite(bench.stage.folder.path().join("batch.sqlite3"));
    let stores = [Store::postgres().await, sqlite];
    let mut subjects = Vec::new();
    for store in &stores {
        let subject = Subject::start(bench, &broker, store, PART).await?;
        let mut first = arguments(1, CONTACTS, FIRST_MESSAGES);
        first.push(("learn", LEARN.to_string()));
        let rate = subject.burst(&broker, &first).await?.loaded.messages_per_s();
        subjects.push((subject, rate, Vec::new(), 0));
    }
    let (mut plain, mut cpus) = (Vec::new(), Vec::new());
    let mut round = 0;
    while bench.has_time_for(round) {
        if let Store::Postgres(server) = &stores[0] {
            plain.push(unnest::rows_per_s(server, Duration::from_secs_f64(bench.pace.burst_s / 2.0)).await?);
            bench.line(PART, round, json!({ "subject": "unnest", "contacts_per_s": plain[round] }))?;
        }
        let mut said = format!("{PART}, round {}: UNNEST {:.0} rows/s", round + 1, plain[round]);
        for (subject, rate, rates, wrong) in &mut subjects {
            let burst = subject.burst(&broker, &arguments(1, CONTACTS, messages(&bench.pace, *rate))).await?;
            *rate = burst.loaded.messages_per_s();
            rates.push(*rate * CONTACTS as f64);
            *wrong += burst.lost.abs() + burst.duplicated;
            if subject.store.pid().is_some() {
                let of = |name| burst.loaded.cpu_s_per_million(name) / CONTACTS as f64;
                cpus.push([of("supervisor"), of("broker"), of("postgresql")]);
            }
            said += &format!(", {} {:.0}/s", subject.store.name(), rates[round]);
            bench.report.line(PART, round, burst.json(subject.store.name()))?;
        }
        bench.say(&said);
        round += 1;
    }
    let ceiling = median(plain.iter().copied());
    for (subject, _, rates, wrong) in &subjects {
        let (name, is_judged) = (subject.store.name(), subject.store.pid().is_some());
        let ratio = median(rates.iter().zip(&plain).map(|(rate, plain)| rate / plain));
        let rate = median(rates.iter().copied());
        // One of the two is enough: the share is judged only if the rate is not reached.
        let [of_rate, of_share] = if !is_judged {
            [Target::None; 2]
        } else if rate >= LEAST_PER_S {
            [Target::AtLeast(LEAST_PER_S), Target::None]
        } else {
            [Target::None, Target::AtLeast(LEAST_SHARE)]
        };
        let beside = format!("UNNEST {}", Figure(ceiling, "/s"));
        bench.row(PART, &format!("{name}: contacts recorded"), of_rate, Figure(rate, "/s"), String::new())?;
        bench.row(PART, &format!("{name}: share of UNNEST's rows"), of_share, Figure(ratio, ""), beside)?;
        bench.row(
            PART,
            &format!("{name}: contacts lost or duplicated"),
            Target::AtMost(0.0),
            Figure(*wrong as f64, ""),
            String::new(),
        )?;
    }
    let [supervisor, broker_s, database] = [0, 1, 2].map(|at| median(cpus.iter().map(|cpus| cpus[at])));
    let beside = format!("broker {}, PostgreSQL {}", Figure(broker_s, "s"), Figure(database, "s"));
    bench.row(PART, "CPU per million contacts", Target::None, Figure(supervisor, "s"), beside)?;
    for (subject, ..) in subjects {
        subject.supervisor.stop().await?;
    }
    Ok(())
}
