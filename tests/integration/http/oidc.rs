//! Tokens of an identity provider. The test signs them with a key that its own provider publishes.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use rcgen::KeyPair;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpListener;
use vibrissa_simulator::clock::now_us;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::http::access::OidcOptions;
use vibrissa_tests::jwt::{header, signed};
use vibrissa_tests::web::{Answer, ask, open};

use crate::served::Served;
use crate::streams::{checked_always, ended, until_the_end};

/// A provider that serves its discovery document and its keys, and counts the requests for keys.
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
        let keys = json!({ "keys": [{ "kty": "EC", "crv": "P-256", "alg": "ES256", "use": "sig", "kid": "k1", "x": x, "y": y }] });
        let found = json!({ "issuer": issuer, "jwks_uri": format!("{issuer}/keys") });
        let asked = Arc::new(AtomicU32::new(0));
        let count = asked.clone();
        tokio::spawn(async move {
            while let Ok((mut stream, _)) = listener.accept().await {
                let mut request = vec![0; 4096];
                let length = stream.read(&mut request).await.unwrap_or_default();
                let body = if request[..length].starts_with(b"GET /keys ") {
                    count.fetch_add(1, Ordering::SeqCst);
                    keys.to_string()
                } else {
                    found.to_string()
                };
                let answer =
                    format!("HTTP/1.1 200 OK\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{body}", body.len());
                let _ = stream.write_all(answer.as_bytes()).await;
            }
        });
        Self { issuer, key, asked }
    }

    fn options(&self) -> AccessOptions {
        let oidc = OidcOptions {
            issuer: self.issuer.clone(),
            audience: "vibrissa".to_owned(),
            jwks_url: None,
            role_claim: "groups".to_owned(),
            fleets_claim: "fleets".to_owned(),
            sign_in: None,
        };
        AccessOptions { token: None, oidc: Some(oidc) }
    }

    /// A token with valid claims and the given changes; null removes a claim.
    fn token(&self, kid: &str, changed: &Value) -> String {
        let mut claims = json!({ "iss": self.issuer, "aud": "vibrissa", "sub": "ann", "groups": ["staff", "operator"],
                                 "fleets": ["f"], "exp": now_us() / 1_000_000 + 600 });
        for (name, value) in changed.as_object().unwrap() {
            claims[name] = value.clone();
        }
        claims.as_object_mut().unwrap().retain(|_, value| !value.is_null());
        signed(&header(kid), &claims, &self.key)
    }
}

async fn asked(served: &Served, method: &str, path: &str, token: &str) -> Answer {
    let bearer = format!("Bearer {token}");
    ask(served.http, method, path, &[("Authorization", &bearer)]).await.unwrap()
}

#[tokio::test]
async fn tokens_of_the_provider_give_what_their_claims_say_and_others_nothing() {
    let provider = Provider::start().await;
    let served = Served::to(&provider.options()).await;
    let good = provider.token("k1", &json!({}));
    let listed = asked(&served, "GET", "/v1/robots", &good).await;
    assert_eq!(listed.status, 200, "{}", listed.body);
    assert!(listed.json()["items"].as_array().unwrap().iter().all(|robot| robot["fleet"] == "f"));
    assert_eq!(asked(&served, "GET", "/v1/fleets/g", &good).await.status, 403, "another fleet");
    let me = asked(&served, "GET", "/v1/me", &good).await.json();
    assert_eq!([&me["name"], &me["actor"], &me["authentication"]], ["ann", "oidc:ann", "OIDC"]);
    assert!(me["expires_at"].is_string() && me["fleets"] == json!(["f"]), "{me}");
    let named = provider.token("k1", &json!({ "preferred_username": "ann.b", "name": "Ann B." }));
    assert_eq!(asked(&served, "GET", "/v1/me", &named).await.json()["name"], "Ann B.");
    assert_eq!(asked(&served, "POST", "/v1/calibrations", &good).await.status, 403, "insufficient role");
    let all = provider.token("k1", &json!({ "fleets": "*", "groups": "ENGINEER" }));
    assert_eq!(asked(&served, "GET", "/v1/fleets/g", &all).await.status, 200);
    assert_eq!(
        asked(&served, "POST", "/v1/calibrations", &all).await.status,
        415,
        "allowed, but the request has no body"
    );
    assert_eq!(provider.asked.load(Ordering::SeqCst), 1, "the keys must be cached");
    let now_s = now_us() / 1_000_000;
    let forged = {
        let (signed, _) = good.rsplit_once('.').unwrap();
        let other = provider.token("k1", &json!({ "sub": "eve" }));
        format!("{signed}.{}", other.rsplit_once('.').unwrap().1)
    };
    let refused = [
        (provider.token("k1", &json!({ "iss": "https://evil.example" })), 401),
        (provider.token("k1", &json!({ "aud": "another" })), 401),
        (provider.token("k1", &json!({ "exp": now_s - 600 })), 401),
        (provider.token("k1", &json!({ "exp": null })), 401),
        (provider.token("k1", &json!({ "nbf": now_s + 600 })), 401),
        (provider.token("k1", &json!({ "sub": null })), 401),
        (provider.token("k2", &json!({})), 401),
        (forged, 401),
        ("eyJhbGciOiJub25lIn0.e30.".to_owned(), 401),
        (provider.token("k1", &json!({ "groups": ["staff"] })), 403),
        (provider.token("k1", &json!({ "groups": null })), 403),
    ];
    for (token, status) in refused {
        let answer = asked(&served, "GET", "/v1/robots", &token).await;
        assert_eq!(answer.status, status, "{}", answer.body);
    }
    let nowhere = provider.token("k1", &json!({ "fleets": null }));
    assert_eq!(
        asked(&served, "GET", "/v1/robots", &nowhere).await.json()["items"],
        json!([]),
        "a token without fleets sees nothing"
    );
    assert_eq!(provider.asked.load(Ordering::SeqCst), 1, "an unknown key id must not cause a request each time");
}

#[tokio::test]
async fn regress_a_stream_ends_with_the_token_of_the_provider() {
    let provider = Provider::start().await;
    let served = Served::streaming(&provider.options(), checked_always()).await;
    // Clocks have a leeway of one minute; this token expires in some seconds.
    let bearer = format!("Bearer {}", provider.token("k1", &json!({ "exp": now_us() / 1_000_000 - 55 })));
    let (status, mut events) = open(served.http, "/v1/events", &until_the_end(&bearer)).await.unwrap();
    assert_eq!(status, 200);
    ended(&mut events).await;
}

#[tokio::test]
async fn a_provider_that_is_away_lets_nobody_in_and_says_so() {
    let mut provider = Provider::start().await;
    let gone = TcpListener::bind("127.0.0.1:0").await.unwrap();
    provider.issuer = format!("http://{}", gone.local_addr().unwrap());
    drop(gone);
    let served = Served::to(&provider.options()).await;
    let answer = asked(&served, "GET", "/v1/robots", &provider.token("k1", &json!({}))).await;
    assert_eq!((answer.status, &answer.json()["type"]), (503, &json!("/problems/unavailable")), "{}", answer.body);
}
