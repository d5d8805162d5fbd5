//! Forged tokens of an identity provider, and a flood of unknown keys.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use rcgen::KeyPair;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpListener;
use vibrissa_simulator::clock::now_us;
use vibrissa_tests::jwt::{header, signed};

use crate::started::{EmptyDatabase, ROOT, Started};

/// An identity provider with one key under several ids, each with different members. It counts the requests for its
/// keys.
struct Provider {
    issuer: String,
    key: KeyPair,
    asked: Arc<AtomicU32>,
}

impl Provider {
    async fn start() -> Self {
        let key = KeyPair::generate().unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let issuer = format!("http://{}", listener.local_addr().unwrap());
        let (x, y) = key.public_key_raw()[1..].split_at(32);
        let [x, y] = [x, y].map(|part| URL_SAFE_NO_PAD.encode(part));
        let named = |kid: &str, more: &Value| {
            let mut key = json!({ "kty": "EC", "crv": "P-256", "kid": kid, "x": x, "y": y });
            for (name, value) in more.as_object().unwrap() {
                key[name] = value.clone();
            }
            key
        };
        let keys = json!({ "keys": [
            named("good", &json!({ "use": "sig", "alg": "ES256" })),
            named("plain", &json!({})),
            named("verify", &json!({ "key_ops": ["verify"] })),
            named("enc", &json!({ "use": "enc" })),
            named("derive", &json!({ "key_ops": ["deriveKey"] })),
            named("es384", &json!({ "use": "sig", "alg": "ES384" })),
            named("agreement", &json!({ "alg": "ECDH-ES" })),
        ] });
        let asked = Arc::new(AtomicU32::new(0));
        let count = asked.clone();
        tokio::spawn(async move {
            while let Ok((mut stream, _)) = listener.accept().await {
                count.fetch_add(1, Ordering::SeqCst);
                let _ = stream.read(&mut [0; 4096]).await;
                let body = keys.to_string();
                let head = format!("HTTP/1.1 200 OK\r\nContent-Length: {}\r\nConnection: close\r\n\r\n", body.len());
                let _ = stream.write_all(format!("{head}{body}").as_bytes()).await;
            }
        });
        Self { issuer, key, asked }
    }

    fn supervise(&self, place: &EmptyDatabase) -> Started {
        let keys = format!("{}/keys", self.issuer);
        // The embedded broker needs a password as soon as HTTP needs tokens; here nobody uses it.
        let password = place.folder.path().join("mqtt.password");
        std::fs::write(&password, ROOT).unwrap();
        place.start(&[
            "--http",
            "127.0.0.1:0",
            "--http-oidc-issuer",
            &self.issuer,
            "--http-oidc-audience",
            "vibrissa",
            "--http-oidc-jwks-url",
            &keys,
            "--mqtt-username",
            "robots",
            "--mqtt-password-file",
            &password.display().to_string(),
        ])
    }

    /// A token that is valid apart from its header.
    fn token(&self, header: &Value) -> String {
        let claims = json!({ "iss": self.issuer, "aud": "vibrissa", "sub": "ann", "vibrissa_role": "viewer",
                             "vibrissa_fleets": "*", "exp": now_us() / 1_000_000 + 600 });
        signed(header, &claims, &self.key)
    }
}

async fn status(started: &Started, token: &str) -> (u16, String) {
    let answer = started.get("/v1/fleets", &[("Authorization", &format!("Bearer {token}"))]).await;
    (answer.status, answer.body)
}

#[tokio::test]
async fn regress_keys_for_something_else_and_critical_extensions_are_refused() {
    let (provider, place) = (Provider::start().await, EmptyDatabase::sqlite());
    let started = provider.supervise(&place);
    for kid in ["good", "plain", "verify"] {
        let (status, body) = status(&started, &provider.token(&header(kid))).await;
        assert_eq!(status, 200, "{kid}: {body}");
    }
    for (kid, why) in [("enc", "(use)"), ("derive", "(key_ops)"), ("es384", "(alg)"), ("agreement", "(alg)")] {
        let (status, body) = status(&started, &provider.token(&header(kid))).await;
        assert!(status == 401 && body.contains(why), "{kid}: {status} {body}");
    }
    for critical in [vec!["exp2"], vec!["b64"], Vec::new()] {
        let mut header = header("good");
        header["crit"] = json!(critical);
        let (status, body) = status(&started, &provider.token(&header)).await;
        assert!(status == 401 && body.contains("extensions"), "{critical:?}: {status} {body}");
    }
}

#[tokio::test]
async fn unknown_keys_do_not_make_it_ask_the_provider_each_time() {
    let (provider, place) = (Provider::start().await, EmptyDatabase::sqlite());
    let started = provider.supervise(&place);
    for number in 0..300 {
        let (status, body) = status(&started, &provider.token(&header(&format!("k{number}")))).await;
        assert_eq!(status, 401, "{body}");
    }
    assert_eq!(status(&started, &provider.token(&header("good"))).await.0, 200);
    // At most one request per ten seconds; a slow machine may need that long for the requests above.
    assert!(provider.asked.load(Ordering::SeqCst) <= 3, "{}", provider.asked.load(Ordering::SeqCst));
}
