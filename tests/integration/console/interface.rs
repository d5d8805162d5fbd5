//! The pages of the REST interface, from the service's own document.

use serde_json::{Value, json};
use vibrissa_tests::web::try_get;

use crate::checks::{complaints, overflow};
use crate::stage::Stage;

async fn operations(stage: &Stage) -> Vec<(String, String, String)> {
    let (_, text) = try_get(stage.service.http, "/openapi.json").await.unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    let mut all = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let id = operation["operationId"].as_str().unwrap().to_owned();
            all.push((id, method.to_uppercase(), path.clone()));
        }
    }
    all
}

#[tokio::test]
async fn every_operation_has_a_page_with_its_parameters_and_answers() {
    let mut stage = Stage::start().await;
    stage.open("#/api").await;
    let all = operations(&stage).await;
    let listed = stage.browser.js("document.querySelectorAll('a.operation').length").await;
    assert_eq!(listed, json!(all.len()));
    for (id, method, path) in &all {
        stage.open(&format!("#/api/{id}")).await;
        let title = stage.browser.js("document.querySelector('h1').textContent").await;
        assert_eq!(title, json!(format!("{method} {path}")));
        let rows = stage.browser.js("document.querySelectorAll('main tbody tr').length").await;
        let wanted = path.matches('{').count() as u64;
        assert!(rows.as_u64().unwrap() >= wanted, "{id}: {rows}");
        let text = stage.browser.js("document.querySelector('main').textContent").await;
        let text = text.as_str().unwrap();
        assert!(!text.contains("undefined") && !text.contains("[object"), "{id}: {text}");
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{id}");
    }
    for (width, scheme) in [(1280, "light"), (390, "dark")] {
        stage.browser.size(width, 844).await;
        stage.browser.prefers(scheme).await;
        for hash in ["#/api", "#/api/list_compensations", "#/api/start_rollout"] {
            stage.open(hash).await;
            assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{hash} {width} {scheme}");
        }
    }
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn a_reading_operation_is_tried_on_its_page() {
    let mut stage = Stage::start().await;
    stage.open("#/api/get_robot").await;
    for (name, value) in [("fleet", "f"), ("robot", "r")] {
        stage.browser.js(&format!("document.querySelector('.try [name={name}]').value = '{value}'")).await;
    }
    stage.browser.click("document.querySelector('.try button')").await;
    stage.browser.until("the answer", "document.querySelector('pre.answer').textContent.startsWith('{')").await;
    let told = stage.browser.js("document.querySelector('pre.answer').textContent").await;
    let told: Value = serde_json::from_str(told.as_str().unwrap()).unwrap();
    assert_eq!((&told["fleet"], &told["robot"]), (&json!("f"), &json!("r")));
    stage.stop().await;
}
