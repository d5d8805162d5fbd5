//! The model store answers as SQLite and PostgreSQL do, whatever is asked of it.
//!
//! Each step is drawn by chance, the same one for all of them. Answers are compared as texts, in which the numbers that a
//! database has given to robots, whiskers, boots and actions are replaced by their places in the order of their arrival.

mod batches;
mod leases;
mod records;
mod steps;
mod subject;
mod webhooks;

use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use vibrissa_protocol::Name;
use vibrissa_simulation::store::AtHand;
use vibrissa_store::{Store, StoreError};

use crate::Fresh;
use crate::refused::Admin;
use subject::{Behind, Subject};

const RUNS: u64 = 16;
const STEPS: u64 = 210;

/// What a caller can tell of an answer.
fn text<T: std::fmt::Debug>(answer: Result<T, StoreError>) -> String {
    match answer {
        Ok(answer) => format!("{answer:?}"),
        Err(StoreError::LeaseLost { cause, .. }) => format!("lost: {cause:?}"),
        Err(problem) => match problem.rejection() {
            Some(rejection) => format!("refused: {:?}", rejection.cause),
            None => panic!("{problem}"),
        },
    }
}

/// Sequences of steps in fleets of their own. The texts of the last one that are alike for `step` name what was asked.
#[tokio::test]
async fn property_the_model_answers_as_both_databases() {
    let (lite, server, at_hand) = (Fresh::sqlite().await, Fresh::postgres().await, Arc::new(AtHand::default()));
    // Its transactions would keep events of others back for a moment.
    let mut admin = Admin::of(&server).await;
    admin.execute("ALTER SYSTEM SET autovacuum = off".to_owned()).await;
    admin.execute("SELECT pg_reload_conf()".to_owned()).await;
    let modelled = Store::modelled(at_hand.clone());
    for seed in 0..RUNS {
        let fleet = Name::new(&format!("f{seed}")).unwrap();
        let behind = Behind::Model(at_hand.clone());
        let mut model = Subject::new(modelled.clone(), behind, &fleet).await;
        let mut others = Vec::new();
        for database in [&lite, &server] {
            let behind = Behind::of(database).await;
            others.push(Subject::new(database.store.clone(), behind, &fleet).await);
        }
        for step in 0..STEPS {
            let random = || ChaCha8Rng::seed_from_u64(seed << 32 | step);
            let expected = steps::step(&mut model, &mut random()).await;
            for (other, name) in others.iter_mut().zip(["SQLite", "PostgreSQL"]) {
                let answer = steps::step(other, &mut random()).await;
                assert_eq!(answer, expected, "{name} (left) and the model differ: seed {seed}, step {step}");
            }
        }
    }
    let expected = subject::kept(&mut at_hand.store());
    for database in [&lite, &server] {
        let rows = subject::stored(&database.store).await;
        assert_eq!(rows.counts, expected.counts);
        assert_eq!(rows.events, expected.events);
        assert!(rows.counts.iter().all(|count| *count > 20) && rows.events.len() > 100, "{:?}", rows.counts);
    }
}
