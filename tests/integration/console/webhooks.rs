//! Webhooks: created, tested, failing, and with dead letters that are delivered again.

use std::sync::Arc;
use std::sync::atomic::{AtomicU16, AtomicUsize, Ordering};

use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio::sync::Notify;
use vibrissa_tests::wait::until_true;

use crate::checks::{complaints, overflow};
use crate::stage::Stage;

/// A receiver that answers 204 at a signal; returns its port and the number of its requests.
async fn slow_receiver(gate: Arc<Notify>) -> (u16, Arc<AtomicUsize>) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let (port, requests) = (listener.local_addr().unwrap().port(), Arc::new(AtomicUsize::new(0)));
    let count = requests.clone();
    tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            let (gate, count) = (gate.clone(), count.clone());
            tokio::spawn(async move {
                let mut got = [0; 16 * 1024];
                let _ = stream.read(&mut got).await;
                count.fetch_add(1, Ordering::SeqCst);
                gate.notified().await;
                let _ = stream.write_all(b"HTTP/1.1 204 X\r\nConnection: close\r\n\r\n").await;
            });
        }
    });
    (port, requests)
}

/// A refresh of the page made the button anew while the test waited for its answer, and a second click sent another test.
#[tokio::test]
async fn regress_a_test_is_sent_once() {
    let mut stage = Stage::start().await;
    let gate = Arc::new(Notify::new());
    let (port, requests) = slow_receiver(gate.clone()).await;
    let body = json!({ "name": "slow", "url": format!("http://127.0.0.1:{port}/"), "fleets": null, "kinds": ["TRIM"] });
    let created =
        vibrissa_tests::web::send(stage.service.http, "POST", "/v1/webhooks", &[], Some(&body)).await.unwrap();
    assert!(created.status < 300, "{}", created.body);
    stage.open("#/webhooks").await;
    press(&mut stage, "Send a test").await;
    until_true("the first", async || requests.load(Ordering::SeqCst) == 1).await;
    let shows = "Number(document.getElementById('main').dataset.shows)";
    let before = stage.browser.js(shows).await;
    stage.browser.js("dispatchEvent(new Event('online'))").await;
    stage.browser.until("a refresh", &format!("{shows} > {before}")).await;
    press(&mut stage, "Send a test").await;
    gate.notify_waiters();
    let taken = "document.getElementById('notices').textContent.split('status 204').length - 1";
    stage.browser.until("the answer", &format!("({taken}) === 1")).await;
    press(&mut stage, "Send a test").await;
    until_true("the second", async || {
        gate.notify_waiters();
        requests.load(Ordering::SeqCst) >= 2
    })
    .await;
    stage.browser.until("its notice", "document.querySelectorAll('.notice').length === 2").await;
    assert_eq!(requests.load(Ordering::SeqCst), 2);
    stage.stop().await;
}

/// A receiver that answers with a status; returns its port and the number of its requests.
async fn receiver(status: Arc<AtomicU16>) -> (u16, Arc<AtomicUsize>) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let (port, requests) = (listener.local_addr().unwrap().port(), Arc::new(AtomicUsize::new(0)));
    let count = requests.clone();
    tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            let mut got = [0; 16 * 1024];
            let _ = stream.read(&mut got).await;
            count.fetch_add(1, Ordering::SeqCst);
            let status = status.load(Ordering::SeqCst);
            let answer = format!("HTTP/1.1 {status} X\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
            let _ = stream.write_all(answer.as_bytes()).await;
        }
    });
    (port, requests)
}

const BUTTON: &str = "[...document.querySelectorAll('main button')].find((one) => one.textContent.startsWith";

async fn press(stage: &mut Stage, words: &str) {
    stage.browser.click(&format!("{BUTTON}('{words}'))")).await;
}

async fn submit(stage: &mut Stage) {
    stage.browser.click("document.querySelector('dialog button[type=submit]')").await;
}

#[tokio::test]
async fn a_webhook_is_created_tested_and_its_dead_letters_are_delivered_again() {
    let mut stage = Stage::start().await;
    let status = Arc::new(AtomicU16::new(500));
    let (port, requests) = receiver(status.clone()).await;
    stage.open("#/webhooks").await;
    press(&mut stage, "Create a webhook").await;
    for (field, value) in [("name", "tickets".to_owned()), ("url", format!("http://127.0.0.1:{port}/hooks/vibrissa"))] {
        stage.browser.js(&format!("document.getElementById('field-{field}').focus()")).await;
        stage.browser.type_text(&value).await;
    }
    assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new());
    stage.picture("webhook-create").await;
    submit(&mut stage).await;
    let secret = "document.querySelector('dialog .secret')?.textContent.startsWith('whsec_')";
    stage.browser.until("the secret is shown", secret).await;
    stage.picture("webhook-secret").await;
    stage.browser.click("[...document.querySelectorAll('dialog button')].pop()").await;
    let row = "document.querySelector(\"tr[data-key='webhook-1']\")?.innerText";
    stage.browser.until("the row", &format!("{row}?.includes('nothing sent yet')")).await;
    press(&mut stage, "Send a test").await;
    let notices = "document.getElementById('notices').textContent";
    stage.browser.until("the test failed", &format!("{notices}.includes('answered 500')")).await;
    status.store(204, Ordering::SeqCst);
    press(&mut stage, "Send a test").await;
    stage.browser.until("the test was taken", &format!("{notices}.includes('status 204')")).await;
    status.store(500, Ordering::SeqCst);

    stage.cut().await;
    stage.open("#/webhooks/1").await;
    stage.browser.until("dead letters", "document.querySelectorAll('tr[data-key^=letter]').length >= 3").await;
    for (scheme, width) in [("light", 1280), ("dark", 390)] {
        stage.browser.prefers(scheme).await;
        stage.browser.size(width, 900).await;
        stage.open("#/webhooks/1").await;
        assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{scheme}");
        assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{width}");
        stage.picture(&format!("webhook-{scheme}-{width}")).await;
    }
    stage.browser.size(1280, 900).await;
    status.store(204, Ordering::SeqCst);
    let before = requests.load(Ordering::SeqCst);
    press(&mut stage, "Deliver all again").await;
    submit(&mut stage).await;
    stage.browser.until("no dead letters", "document.body.innerText.includes('No dead letters.')").await;
    assert!(requests.load(Ordering::SeqCst) >= before + 3);
    stage.open("#/webhooks").await;
    stage.browser.until("it works", &format!("{row}?.includes('working')")).await;
    stage.picture("webhooks-working").await;
    assert_eq!(stage.browser.js("document.querySelector('h1').textContent").await, json!("Webhooks"));
    stage.is_clean();
    stage.stop().await;
}
