//! Each engine's features, compared with docs/brokers.md; and those of the model broker.

use std::collections::BTreeMap;
use std::time::Instant;

use crate::document::stated;
use crate::engine::Engine;
use crate::feature::{Feature, Stage};

/// What the model broker need not do: it knows neither users nor MQTT 3.1.1.
const NOT_MODELLED: [Feature; 3] = [Feature::WrongPassword, Feature::RefusedSubscription, Feature::OldVersion];

async fn conforms(engine: Engine) {
    conforms_to(engine, stated(engine)).await;
}

async fn conforms_to(engine: Engine, stated: BTreeMap<&'static str, bool>) {
    let Some(started) = engine.start().await else { return };
    let mut stage = Stage::new(&started.ports());
    let mut wrong = Vec::new();
    for feature in Feature::EVERY {
        let begun = Instant::now();
        let checked = stage.check(feature).await;
        let (title, works) = (feature.title(), checked.is_ok());
        eprintln!("{}: {title}: {checked:?} in {:.1} s", engine.title(), begun.elapsed().as_secs_f32());
        if stated[title] != works && !(works && feature.is_by_chance()) {
            wrong.push(format!("{title}: {checked:?}"));
        }
    }
    eprintln!("{}: subscriptions reach the other node within {:?}", engine.title(), stage.settled_in);
    started.stop().await;
    assert!(wrong.is_empty(), "the opposite is stated for {}: {wrong:#?}", engine.title());
}

#[tokio::test]
async fn the_embedded_broker_does_what_the_document_states() {
    conforms(Engine::Embedded).await;
}

#[tokio::test]
async fn mosquitto_does_what_the_document_states() {
    conforms(Engine::Mosquitto).await;
}

#[tokio::test]
async fn rmqtt_does_what_the_document_states() {
    conforms(Engine::Rmqtt).await;
}

#[tokio::test]
async fn three_nodes_of_rmqtt_do_what_the_document_states() {
    conforms(Engine::RmqttCluster).await;
}

#[tokio::test]
async fn artemis_does_what_the_document_states() {
    conforms(Engine::Artemis).await;
}

#[tokio::test]
async fn the_model_broker_does_everything_that_it_models() {
    let does = |feature: Feature| (feature.title(), !NOT_MODELLED.contains(&feature));
    conforms_to(Engine::Model, Feature::EVERY.map(does).into()).await;
}
