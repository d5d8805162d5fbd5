//! The use of a whisker's newest contacts.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::served::Served;

/// Contacts that the answer counts.
const NEWEST: usize = 200;

async fn brute_force_uses(served: &Served) {
    let written = &served.written.contacts;
    let mut times: Vec<i64> = written.iter().map(|one| one.t_us).collect();
    times.sort_unstable();
    let since_us = times[times.len().saturating_sub(NEWEST)];
    let mut expected: BTreeMap<&str, i64> = BTreeMap::new();
    for contact in written.iter().filter(|one| one.t_us >= since_us) {
        *expected.entry(contact.used).or_default() += 1;
    }
    let answer = served.json("/v1/fleets/f/robots/r1/arrays/left/whiskers/0/contact-uses").await;
    let items = answer["items"].as_array().unwrap();
    let uses: BTreeMap<&str, i64> =
        items.iter().map(|one| (one["used"].as_str().unwrap(), one["contacts"].as_i64().unwrap())).collect();
    assert_eq!(uses, expected);
    assert_eq!((&answer["contacts_used"], items.len()), (&json!(expected["USED"]), 2));
    assert_eq!(answer["contacts"], json!(expected.values().sum::<i64>()));
    assert_eq!(items[0]["used"], "USED", "the most frequent use is the first");
    assert_eq!((&items[0]["remedy"], &items[1]["meaning"]), (&Value::Null, &json!("the strain was too small")));
    assert!(items[1]["remedy"].as_str().unwrap().contains("amplifier"), "{answer}");
    let silent = served.json("/v1/fleets/f/robots/r1/arrays/left/whiskers/1/contact-uses").await;
    assert_eq!(silent, json!({ "contacts": 0, "contacts_used": 0, "items": [], "segmenter": null }));
    let (told, advice) = (&answer["segmenter"], "converter");
    assert_eq!((&told["state"], &told["meaning"]), (&json!("NOISY"), &json!("noisy strain")));
    assert!(told["remedy"].as_str().unwrap().contains(advice), "{told}");
    let whisker = served.json("/v1/fleets/f/robots/r1/arrays/left/whiskers/0").await;
    assert_eq!(whisker["segmenter"], "NOISY");
    let robot = served.json("/v1/fleets/f/robots/r1").await;
    assert_eq!(robot["software"], json!([{ "kind": "AGENT", "name": "vibrissa-robot", "version": "0.2.0" }]));
}

#[tokio::test]
async fn brute_force_uses_of_contacts_on_sqlite() {
    brute_force_uses(&Served::sqlite().await).await;
}

#[tokio::test]
async fn brute_force_uses_of_contacts_on_postgres() {
    brute_force_uses(&Served::postgres().await).await;
}
