//! Mails about alarms to people, over a mail server of the test.

use std::time::Duration;

use serde_json::json;
use vibrissa_supervisor::service::Service;
use vibrissa_supervisor::webhooks::{Encryption, MailOptions, Pace, WebhookOptions};
use vibrissa_tests::wait::until_true;

use crate::mailbox::{Mail, Mailbox};
use crate::receiver::{Manner, Receiver};
use crate::stage::{FAST, Raw, Stage, call, hook, shown, taken};

const HOUR: Duration = Duration::from_secs(3600);

fn server(mailbox: &Mailbox) -> MailOptions {
    MailOptions {
        host: mailbox.address.ip().to_string(),
        port: Some(mailbox.address.port()),
        encryption: Encryption::None,
        credentials: None,
        sender: "Vibrissa <vibrissa@robots.example>".to_owned(),
        gather: Duration::ZERO,
        pause: Duration::ZERO,
        console_url: Some("https://v.example".to_owned()),
        runbooks_url: Some("https://v.example/runbooks".to_owned()),
    }
}

/// A supervisor with a robot that never gives up a mail.
async fn supervisor(stage: &Stage, mail: MailOptions) -> Service {
    let pace = Pace { attempts_max: 100_000, ..FAST };
    let options = WebhookOptions { allowed_hosts: vec!["127.0.0.1".to_owned()], pace, mail: Some(mail) };
    let service = stage.delivering("a", options).await;
    stage.robot().await;
    service
}

async fn subscribed(service: &Service) -> i64 {
    let body = json!({ "name": "night", "url": "mailto:ann@example.org", "fleets": ["g"], "kinds": ["ALARM_RAISED", "ALARM_CLEARED"] });
    let answer = call(service, "POST", "/v1/webhooks", Some(body)).await;
    assert_eq!(answer.status, 201, "{}", answer.body);
    assert_eq!(answer.json()["secret"], json!(null), "a person verifies no signature");
    answer.json()["webhook"]["webhook_id"].as_i64().unwrap()
}

/// Writes an event about each whisker in one transaction, in a fleet that has no other alarms.
async fn alarms(raw: &mut Raw, kind: &str, word: &str) {
    let now_us = vibrissa_edge::clock::wall_clock().0;
    let sql = format!(
        "INSERT INTO events (recorded_us, version, kind, audience, word, fleet, robot_id, whisker_id, data) \
         SELECT {now_us}, 2, '{kind}', 'PEOPLE', '{word}', 'g', robot_id, whisker_id, '{{}}' FROM whiskers"
    );
    assert_eq!(raw.run(&sql).await, 3);
}

async fn mails(mailbox: &Mailbox, many: usize) -> Vec<Mail> {
    until_true(&format!("{many} mails"), async || mailbox.mails().len() >= many).await;
    mailbox.mails()
}

#[tokio::test]
async fn several_alarms_are_one_mail_and_their_end_is_in_its_thread() {
    let (stage, mailbox) = (Stage::sqlite().await, Mailbox::start().await);
    let service = supervisor(&stage, server(&mailbox)).await;
    let webhook_id = subscribed(&service).await;
    let mut raw = stage.raw().await;
    alarms(&mut raw, "ALARM_RAISED", "LEAK").await;
    let raised = mails(&mailbox, 1).await.remove(0);
    alarms(&mut raw, "ALARM_CLEARED", "LEAK").await;
    let cleared = mails(&mailbox, 2).await.remove(1);
    assert_eq!(raised.to, "ann@example.org");
    assert_eq!(raised.header("Subject"), "URGENT: 3 whiskers of r of g: leaking");
    assert_eq!(cleared.header("Subject"), "Over: 3 whiskers of r of g: leaking");
    assert_eq!(raised.header("From"), "Vibrissa <vibrissa@robots.example>");
    assert_eq!(raised.header("Auto-Submitted"), "auto-generated");
    assert!(raised.header("Message-ID").starts_with(&format!("<vibrissa-{webhook_id}-")), "{raised:?}");
    assert_ne!(raised.header("Message-ID"), cleared.header("Message-ID"));
    let threads = raised.header("References");
    assert_eq!(threads.split_whitespace().count(), 3, "{threads}");
    assert_eq!(threads, cleared.header("References"));
    assert!(threads.starts_with(&raised.header("In-Reply-To")), "{threads}");
    // Lines end with = where the encoding breaks them.
    let text = raised.text.replace("=\r\n", "");
    for part in
        ["What to do", "https://v.example/runbooks/", "https://v.example/#/fleets/g/robots/r/arrays/left/whiskers/2"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    until_true("all events are noted", async || shown(&service, webhook_id).await["delivered"] == json!(6)).await;
    let state = shown(&service, webhook_id).await;
    assert_eq!(
        (&state["state"], &state["last_status"], &state["waiting"]),
        (&json!("WORKING"), &json!(250), &json!(0))
    );
    service.stop().await;
}

#[tokio::test]
async fn a_person_gets_alarms_and_their_ends_unless_other_kinds_are_asked_for() {
    let (stage, mailbox) = (Stage::sqlite().await, Mailbox::start().await);
    let service = supervisor(&stage, server(&mailbox)).await;
    for (name, url, asked, kinds) in [
        ("usual", "mailto:ann@example.org", json!(null), json!(["ALARM_RAISED", "ALARM_CLEARED"])),
        ("cuts", "mailto:ann@example.org", json!(["TRIM"]), json!(["TRIM"])),
        ("program", "http://127.0.0.1:9/hook", json!(null), json!(null)),
    ] {
        let body = json!({ "name": name, "url": url, "kinds": asked });
        let answer = call(&service, "POST", "/v1/webhooks", Some(body)).await;
        assert_eq!((answer.status, &answer.json()["webhook"]["kinds"]), (201, &kinds), "{name}: {}", answer.body);
    }
    service.stop().await;
}

#[tokio::test]
async fn a_person_gets_the_alarms_between_two_mails_with_the_second() {
    let (stage, mailbox) = (Stage::sqlite().await, Mailbox::start().await);
    let service = supervisor(&stage, MailOptions { pause: HOUR, ..server(&mailbox) }).await;
    let webhook_id = subscribed(&service).await;
    let mut raw = stage.raw().await;
    alarms(&mut raw, "ALARM_RAISED", "LEAK").await;
    mails(&mailbox, 1).await;
    alarms(&mut raw, "ALARM_CLEARED", "LEAK").await;
    alarms(&mut raw, "ALARM_RAISED", "ERODING").await;
    let soon_us = vibrissa_edge::clock::wall_clock().0 as i64 + 1_800_000_000;
    until_true("the next mail waits for its time", async || raw.number("SELECT next_us FROM webhooks").await > soon_us)
        .await;
    assert_eq!(shown(&service, webhook_id).await["waiting"], json!(6));
    assert_eq!(mailbox.mails().len(), 1);
    // The hour is over.
    raw.run("UPDATE webhooks SET last_success_us = last_success_us - 3600000000, next_us = 0").await;
    let second = mails(&mailbox, 2).await.remove(1);
    assert_eq!(second.header("Subject"), "WARNING: 3 whiskers of r of g: eroding, and 3 more");
    service.stop().await;
}

/// The time since the last mail was negative, and counted as none until the clock had passed it.
#[tokio::test]
async fn regress_a_clock_that_was_set_back_stops_no_mail() {
    let (stage, mailbox) = (Stage::sqlite().await, Mailbox::start().await);
    let service = supervisor(&stage, MailOptions { pause: HOUR, ..server(&mailbox) }).await;
    subscribed(&service).await;
    let mut raw = stage.raw().await;
    alarms(&mut raw, "ALARM_RAISED", "LEAK").await;
    mails(&mailbox, 1).await;
    let is_noted = "SELECT count(*) FROM webhooks WHERE delivered = 3 AND holder IS NULL";
    until_true("the first mail is noted", async || raw.number(is_noted).await == 1).await;
    let ahead = "last_success_us = last_success_us + 21600000000, last_us = last_us + 21600000000";
    raw.run(&format!("UPDATE webhooks SET {ahead}")).await;
    alarms(&mut raw, "ALARM_RAISED", "ERODING").await;
    mails(&mailbox, 2).await;
    service.stop().await;
}

/// Each dead letter was a mail of its own, so that newer alarms waited for hours.
#[tokio::test]
async fn regress_dead_letters_of_a_person_are_one_mail() {
    let (stage, mailbox) = (Stage::sqlite().await, Mailbox::start().await);
    mailbox.answers("550 unknown");
    let pace = Pace { attempts_max: 1, ..FAST };
    let mail = Some(MailOptions { pause: HOUR, ..server(&mailbox) });
    let allowed_hosts = vec!["127.0.0.1".to_owned()];
    let service = stage.delivering("a", WebhookOptions { allowed_hosts, pace, mail }).await;
    stage.robot().await;
    let webhook_id = subscribed(&service).await;
    let mut raw = stage.raw().await;
    alarms(&mut raw, "ALARM_RAISED", "LEAK").await;
    let dead = async || shown(&service, webhook_id).await["dead_letters"].as_i64().unwrap();
    until_true("three dead letters", async || dead().await == 3).await;
    mailbox.answers("250 fine");
    let path = format!("/v1/webhooks/{webhook_id}/dead-letters/redeliver");
    assert_eq!(call(&service, "POST", &path, None).await.status, 200);
    let mail = mails(&mailbox, 1).await.remove(0);
    assert_eq!(mail.header("Subject"), "URGENT: 3 whiskers of r of g: leaking");
    until_true("no dead letter is left", async || dead().await == 0).await;
    assert_eq!(mailbox.mails().len(), 1);
    service.stop().await;
}

#[tokio::test]
async fn a_mail_server_that_refuses_is_tried_again_and_stops_nobody() {
    let (stage, mailbox) = (Stage::sqlite().await, Mailbox::start().await);
    mailbox.answers("451 greylisted");
    let service = supervisor(&stage, server(&mailbox)).await;
    let webhook_id = subscribed(&service).await;
    let receiver = Receiver::start(Manner::Status(204)).await;
    hook(&service, &receiver, json!({ "fleets": ["g"] })).await;
    let mut raw = stage.raw().await;
    alarms(&mut raw, "ALARM_RAISED", "LEAK").await;
    taken(&receiver, 3).await;
    until_true("two attempts", async || mailbox.refused() >= 2).await;
    until_true("the failure is shown", async || shown(&service, webhook_id).await["state"] == json!("FAILING")).await;
    let state = shown(&service, webhook_id).await;
    assert_eq!(state["last_status"], json!(451), "{state}");
    assert_eq!(state["last_problem"], json!("the mail server answered 451: greylisted"));
    mailbox.answers("250 fine");
    mails(&mailbox, 1).await;
    until_true("the mail is noted", async || shown(&service, webhook_id).await["state"] == json!("WORKING")).await;
    assert_eq!(mailbox.mails().len(), 1);
    service.stop().await;
}

#[tokio::test]
async fn a_test_reaches_the_person_and_without_the_wanted_encryption_nobody() {
    let (stage, mailbox) = (Stage::sqlite().await, Mailbox::start().await);
    let service = supervisor(&stage, server(&mailbox)).await;
    let webhook_id = subscribed(&service).await;
    let path = format!("/v1/webhooks/{webhook_id}/test");
    let answer = call(&service, "POST", &path, None).await.json();
    assert_eq!((&answer["delivered"], &answer["status"]), (&json!(true), &json!(250)), "{answer}");
    assert_eq!(mails(&mailbox, 1).await[0].header("Subject"), "Test of night");
    service.stop().await;
    let service = supervisor(&stage, MailOptions { encryption: Encryption::StartTls, ..server(&mailbox) }).await;
    let answer = call(&service, "POST", &path, None).await.json();
    assert_eq!(answer["delivered"], json!(false));
    assert!(answer["problem"].as_str().unwrap().contains("STARTTLS"), "{answer}");
    assert_eq!(mailbox.mails().len(), 1);
    service.stop().await;
}

#[tokio::test]
async fn an_address_needs_a_mail_server() {
    let stage = Stage::sqlite().await;
    let service = stage.supervisor("a", FAST).await;
    let body = json!({ "name": "night", "url": "mailto:ann@example.org" });
    let answer = call(&service, "POST", "/v1/webhooks", Some(body)).await;
    assert_eq!(answer.status, 422, "{}", answer.body);
    assert!(answer.body.contains("mail.url"), "{}", answer.body);
    service.stop().await;
}
