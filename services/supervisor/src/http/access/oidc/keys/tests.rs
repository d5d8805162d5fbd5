use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::sync::mpsc;

use futures_util::future::join_all;
use serde_json::{Value, json};
use tokio::time::timeout;
use vibrissa_host::task;

use super::*;

/// Much longer than any step here takes.
const LONG: Duration = Duration::from_secs(20);
/// The key of RFC 7515, appendix A.3.
const POINT: (&str, &str) =
    ("f83OJ3D2xF1Bg8vub9tLe1gHMzV76e8Tus9uPHvRVEU", "x_FEzRu9m36HLN_tue659LNpXW6pCyStikYjKIWI5a0");

/// A key with this ID and these additional members.
fn key(kid: &str, more: &Value) -> Value {
    let mut key = json!({ "kty": "EC", "crv": "P-256", "x": POINT.0, "y": POINT.1, "kid": kid });
    for (name, value) in more.as_object().unwrap() {
        key[name] = value.clone();
    }
    key
}

/// A provider that answers each request for its keys only after a message in `answer`.
struct Provider {
    keys: Keys,
    /// One message per request received.
    asked: mpsc::Receiver<()>,
    /// Each message releases one answer.
    answer: mpsc::Sender<()>,
}

impl Provider {
    fn start(pace: Pace) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}/keys", listener.local_addr().unwrap());
        let ((tell, asked), (answer, may_answer)) = (mpsc::channel(), mpsc::channel());
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                let mut stream = stream.unwrap();
                let _ = stream.read(&mut [0; 4096]).unwrap();
                if tell.send(()).is_err() || may_answer.recv().is_err() {
                    return;
                }
                let body = json!({ "keys": [key("k1", &json!({}))] }).to_string();
                let head = format!("HTTP/1.1 200 OK\r\nContent-Length: {}\r\nConnection: close\r\n\r\n", body.len());
                // The client may have given up.
                let _ = stream.write_all(format!("{head}{body}").as_bytes());
            }
        });
        let keys = Keys { pace, ..Keys::new("http://127.0.0.1:9", Some(&url)) };
        Self { keys, asked, answer }
    }

    async fn is_known(&self, kid: &str) -> bool {
        timeout(LONG, self.keys.key(Some(kid), Algorithm::ES256)).await.expect("an answer").is_ok()
    }
}

#[tokio::test]
async fn regress_unknown_keys_neither_make_it_ask_without_end_nor_hold_up_those_who_are_known() {
    let provider = Provider::start(Pace { fetch_every: Duration::ZERO, ..PACE });
    provider.answer.send(()).unwrap();
    assert!(provider.is_known("k1").await);
    provider.asked.recv_timeout(LONG).unwrap();
    // The provider does not answer now. Many callers ask for keys that do not exist.
    let names: Vec<String> = (0..20).map(|number| format!("x{number}")).collect();
    let strangers = names.iter().map(|name| provider.keys.key(Some(name), Algorithm::ES256));
    let mut strangers = Box::pin(join_all(strangers));
    assert!(futures_util::poll!(&mut strangers).is_pending());
    // The provider has not answered: the caller with the known key does not wait for it.
    assert!(provider.is_known("k1").await);
    assert!(futures_util::poll!(&mut strangers).is_pending());
    provider.answer.send(()).unwrap();
    let strangers = timeout(LONG, strangers).await.expect("an answer");
    assert!(strangers.iter().all(Result::is_err));
    provider.asked.recv_timeout(LONG).unwrap();
    assert!(provider.asked.try_recv().is_err(), "all of them share one fetch");
}

#[tokio::test]
async fn unknown_keys_are_not_asked_for_again_at_once() {
    let provider = Provider::start(PACE);
    provider.answer.send(()).unwrap();
    for number in 0..20 {
        assert!(!provider.is_known(&format!("x{number}")).await);
    }
    assert!(provider.is_known("k1").await);
    assert_eq!(provider.asked.try_iter().count(), 1);
}

#[tokio::test]
async fn a_provider_that_is_away_is_not_asked_by_each_caller() {
    // Nothing listens there.
    let gone = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/keys", gone.local_addr().unwrap());
    drop(gone);
    let keys = Keys { pace: Pace { retry_every: LONG, ..PACE }, ..Keys::new("http://127.0.0.1:9", Some(&url)) };
    let first = keys.key(Some("k1"), Algorithm::ES256).await.unwrap_err();
    assert_eq!(first.kind, Kind::Unavailable);
    let asked = lock(&keys.state).asked;
    let second = keys.key(Some("k1"), Algorithm::ES256).await.unwrap_err();
    assert_eq!((second.kind, lock(&keys.state).asked), (Kind::Unavailable, asked), "no second fetch");
}

#[tokio::test(flavor = "multi_thread")]
async fn old_keys_serve_while_new_ones_are_fetched_and_very_old_ones_do_not() {
    for (trusted_for, is_served) in [(LONG, true), (Duration::ZERO, false)] {
        let provider =
            Provider::start(Pace { fresh_for: Duration::ZERO, fetch_every: Duration::ZERO, trusted_for, ..PACE });
        provider.answer.send(()).unwrap();
        assert!(provider.is_known("k1").await);
        let keys = provider.keys.clone();
        let mut asking = task::spawn(async move { keys.key(Some("k1"), Algorithm::ES256).await.is_ok() });
        for _ in 0..2 {
            // The first fetch, and the one due because the keys are old.
            provider.asked.recv_timeout(LONG).unwrap();
            tokio::task::yield_now().await;
        }
        if is_served {
            assert!(timeout(LONG, &mut asking).await.expect("it does not wait").unwrap());
        } else {
            assert!(!asking.is_finished(), "it waits for the fetch");
            provider.answer.send(()).unwrap();
            assert!(timeout(LONG, &mut asking).await.expect("an answer").unwrap());
        }
    }
}

#[test]
fn regress_a_key_serves_only_what_its_provider_means_it_for() {
    let chosen = |keys: &Value, kid: Option<&str>, algorithm| {
        let set: JwkSet = serde_json::from_value(json!({ "keys": keys })).unwrap();
        choose(&set.keys, kid, algorithm).map(drop)
    };
    let one = |more: &Value| chosen(&json!([key("k", more)]), Some("k"), Algorithm::ES256);
    for good in [
        json!({}),
        json!({ "use": "sig" }),
        json!({ "alg": "ES256" }),
        json!({ "key_ops": ["verify"] }),
        json!({ "use": "sig", "alg": "ES256", "key_ops": ["sign", "verify"] }),
    ] {
        assert_eq!(one(&good), Ok(()), "{good}");
    }
    for bad in [
        json!({ "use": "enc" }),
        json!({ "use": "anything" }),
        json!({ "key_ops": [] }),
        json!({ "key_ops": ["deriveKey"] }),
        json!({ "alg": "ES384" }),
        json!({ "alg": "RS256" }),
        json!({ "alg": "ECDH-ES" }),
        json!({ "crv": "P-384" }),
        json!({ "kty": "oct", "k": "c2VjcmV0" }),
    ] {
        assert!(matches!(one(&bad), Err(Lack::Unfit(_))), "{bad}");
    }
    let rsa = json!([{ "kty": "RSA", "n": "AQAB", "e": "AQAB", "kid": "r", "alg": "RS256" }]);
    assert_eq!(chosen(&rsa, Some("r"), Algorithm::RS256), Ok(()));
    assert!(chosen(&rsa, Some("r"), Algorithm::PS256).is_err() && chosen(&rsa, Some("r"), Algorithm::RS512).is_err());
    // Two of one name, and two with nothing to tell them apart.
    let twins = json!([key("k", &json!({ "use": "enc" })), key("k", &json!({ "use": "sig" }))]);
    assert_eq!(chosen(&twins, Some("k"), Algorithm::ES256), Ok(()));
    assert_eq!(chosen(&twins, None, Algorithm::ES256), Ok(()));
    let pair = json!([key("a", &json!({})), key("b", &json!({}))]);
    assert_eq!(chosen(&pair, None, Algorithm::ES256), Err(Lack::Unknown));
    assert_eq!(chosen(&pair, Some("c"), Algorithm::ES256), Err(Lack::Unknown));
}
