//! Signing in at the console with a provider that answers as each test wants.

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use rcgen::KeyPair;
use serde_json::{Value, json};
use sqlx::{Connection as _, Executor as _, SqliteConnection};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use url::Url;
use vibrissa_simulator::clock::now_us;
use vibrissa_store::DatabaseAddress;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::http::access::OidcOptions;
use vibrissa_supervisor::http::access::SignInOptions;
use vibrissa_supervisor::http::streams::StreamOptions;
use vibrissa_tests::jwt::{header, signed};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{Answer, ask};

use crate::served::Served;

/// A provider with one key. Its token endpoint gives the tokens that were put there last.
pub(crate) struct Provider {
    issuer: String,
    key: KeyPair,
    /// Status and body of the token endpoint's next answers.
    next: Arc<Mutex<(u16, Value)>>,
    tokens: Arc<TokenEndpoint>,
}

/// State of a provider's token endpoint.
#[derive(Default)]
struct TokenEndpoint {
    /// Whoever holds it delays the answers.
    turn: tokio::sync::Mutex<()>,
    /// Number of requests so far.
    asked: AtomicUsize,
    /// Whether each refresh token is valid once.
    is_strict: AtomicBool,
    spent: Mutex<BTreeSet<String>>,
}

impl TokenEndpoint {
    async fn answer(&self, asked: &str, next: &Mutex<(u16, Value)>) -> (u16, Value) {
        self.asked.fetch_add(1, Ordering::SeqCst);
        let _turn = self.turn.lock().await;
        let token = asked.split('&').find_map(|pair| pair.strip_prefix("refresh_token="));
        let is_new = token.is_none_or(|token| self.spent.lock().unwrap().insert(token.to_owned()));
        if self.is_strict.load(Ordering::SeqCst) && !is_new {
            return (400, json!({ "error": "invalid_grant" }));
        }
        next.lock().unwrap().clone()
    }
}

/// The head of a request and its body.
async fn whole(stream: &mut TcpStream) -> (String, String) {
    let mut request = String::new();
    let mut part = vec![0; 16 * 1024];
    loop {
        let length = stream.read(&mut part).await.unwrap_or_default();
        request.push_str(std::str::from_utf8(&part[..length]).unwrap());
        let (head, body) = request.split_once("\r\n\r\n").unwrap_or((&request, ""));
        let lines = head.lines().map(str::to_ascii_lowercase);
        let size = lines.filter_map(|line| line.strip_prefix("content-length: ")?.parse::<usize>().ok()).next();
        if length == 0 || request.contains("\r\n\r\n") && body.len() >= size.unwrap_or_default() {
            return (head.to_owned(), body.to_owned());
        }
    }
}

const PUBLIC_URL: &str = "http://127.0.0.1:1";

impl Provider {
    pub(crate) async fn start() -> Self {
        let key = KeyPair::generate().unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let issuer = format!("http://{}", listener.local_addr().unwrap());
        let (x, y) = key.public_key_raw()[1..].split_at(32);
        let [x, y] = [x, y].map(|part| URL_SAFE_NO_PAD.encode(part));
        let keys = json!({ "keys": [{ "kty": "EC", "crv": "P-256", "kid": "k1", "x": x, "y": y }] });
        let found = json!({ "issuer": issuer, "jwks_uri": format!("{issuer}/keys"),
                            "authorization_endpoint": format!("{issuer}/authorize"),
                            "token_endpoint": format!("{issuer}/token"), "end_session_endpoint": format!("{issuer}/end") });
        let next = Arc::new(Mutex::new((500, Value::Null)));
        let endpoint = Arc::new(TokenEndpoint::default());
        let (given, tokens) = (next.clone(), endpoint.clone());
        tokio::spawn(async move {
            while let Ok((mut stream, _)) = listener.accept().await {
                let (keys, found, given, tokens) = (keys.clone(), found.clone(), given.clone(), tokens.clone());
                tokio::spawn(async move {
                    let (head, body) = whole(&mut stream).await;
                    let (status, body) = match head {
                        asked if asked.starts_with("GET /keys ") => (200, keys),
                        asked if asked.starts_with("POST /token ") => tokens.answer(&body, &given).await,
                        _ => (200, found),
                    };
                    let body = body.to_string();
                    let head =
                        format!("HTTP/1.1 {status} X\r\nContent-Length: {}\r\nConnection: close\r\n\r\n", body.len());
                    let _ = stream.write_all(format!("{head}{body}").as_bytes()).await;
                });
            }
        });
        Self { issuer, key, next, tokens: endpoint }
    }

    async fn served(&self) -> Served {
        self.served_at(PUBLIC_URL).await
    }

    /// A service that browsers reach at this address.
    pub(crate) async fn served_at(&self, public_url: &str) -> Served {
        Served::to(&self.access(public_url)).await
    }

    fn access(&self, public_url: &str) -> AccessOptions {
        let sign_in = SignInOptions {
            client_id: "console".to_owned(),
            client_secret: None,
            scopes: vec!["profile".to_owned(), "offline_access".to_owned()],
            public_url: public_url.to_owned(),
        };
        let oidc = OidcOptions {
            issuer: self.issuer.clone(),
            audience: "vibrissa".to_owned(),
            jwks_url: None,
            role_claim: "role".to_owned(),
            fleets_claim: "fleets".to_owned(),
            sign_in: Some(sign_in),
        };
        AccessOptions { token: None, oidc: Some(oidc) }
    }

    /// Claims of a valid token with changes; null removes a claim.
    fn token(&self, claims: &[&Value]) -> String {
        let mut all = json!({ "iss": self.issuer, "sub": "ann", "iat": now_us() / 1_000_000,
                              "exp": now_us() / 1_000_000 + 600 });
        for (name, value) in claims.iter().flat_map(|claims| claims.as_object().unwrap()) {
            all[name] = value.clone();
        }
        all.as_object_mut().unwrap().retain(|_, value| !value.is_null());
        signed(&header("k1"), &all, &self.key)
    }

    fn access_token(&self, changed: &Value) -> String {
        self.token(&[&json!({ "aud": "vibrissa", "role": "operator", "fleets": "*" }), changed])
    }

    fn id_token(&self, nonce: &str, changed: &Value) -> String {
        self.token(&[&json!({ "aud": "console", "nonce": nonce }), changed])
    }

    /// The next tokens are those of an operator.
    pub(crate) fn gives_operator(&self, nonce: &str) {
        self.gives(tokens(&self.access_token(&json!({})), Some(&self.id_token(nonce, &json!({})))));
    }

    fn gives(&self, tokens: Value) {
        *self.next.lock().unwrap() = (200, tokens);
    }
}

fn tokens(access_token: &str, id_token: Option<&str>) -> Value {
    json!({ "token_type": "Bearer", "access_token": access_token, "refresh_token": "r", "id_token": id_token })
}

/// A browser that has gone to the provider.
pub(crate) struct Attempt {
    pub(crate) state: String,
    pub(crate) nonce: String,
    pub(crate) cookie: String,
    /// Address to which the provider leads the browser back.
    pub(crate) redirect_uri: String,
}

impl Attempt {
    async fn begin(served: &Served, to: &str) -> Self {
        Self::begin_at(served.http, "", to).await
    }

    /// Begins at a service, or at a proxy with a path.
    pub(crate) async fn begin_at(http: SocketAddr, path: &str, to: &str) -> Self {
        let answer = ask(http, "GET", &format!("{path}/auth/sign-in?to={to}"), &[]).await.unwrap();
        assert_eq!(answer.status, 303, "{}", answer.body);
        let url = Url::parse(&answer.headers["location"]).unwrap();
        let asked = |name: &str| url.query_pairs().find(|(one, _)| one == name).unwrap().1.into_owned();
        assert_eq!(
            (asked("code_challenge_method").as_str(), asked("scope").as_str()),
            ("S256", "openid profile offline_access")
        );
        let redirect_uri = asked("redirect_uri");
        Self { state: asked("state"), nonce: asked("nonce"), cookie: cookie(&answer), redirect_uri }
    }

    async fn end(&self, served: &Served, more: &str) -> Answer {
        let path = format!("/auth/callback?code=c&state={}{more}", self.state);
        ask(served.http, "GET", &path, &[("Cookie", &self.cookie)]).await.unwrap()
    }
}

/// The last cookie that an answer sets.
pub(crate) fn cookie(answer: &Answer) -> String {
    answer.headers["set-cookie"].split(';').next().unwrap().to_owned()
}

/// Place to which a sign-in with these tokens leads.
async fn led(provider: &Provider, served: &Served, answer_for: impl Fn(&str) -> Value) -> String {
    let attempt = Attempt::begin(served, "%23/robots").await;
    provider.gives(answer_for(&attempt.nonce));
    attempt.end(served, "").await.headers["location"].clone()
}

const IN: &str = "/#/robots";
const FAILED: &str = "/#/fleets?sign_in=PROVIDER";

#[tokio::test]
async fn regress_an_id_token_that_breaks_a_rule_signs_nobody_in() {
    let provider = Provider::start().await;
    let served = provider.served().await;
    let access = provider.access_token(&json!({}));
    let hash = ring::digest::digest(&ring::digest::SHA256, access.as_bytes());
    let at_hash = URL_SAFE_NO_PAD.encode(&hash.as_ref()[..16]);
    let now_s = now_us() / 1_000_000;
    let cases = [
        (json!({}), IN),
        (json!({ "azp": "console", "at_hash": at_hash }), IN),
        (json!({ "aud": ["console", "other"], "azp": "console" }), IN),
        (json!({ "updated_at": "2026-01-01T00:00:00Z", "email_verified": "true" }), IN),
        (json!({ "azp": "other" }), FAILED),
        (json!({ "aud": ["console", "other"] }), FAILED),
        (json!({ "aud": ["console", "other"], "azp": "other" }), FAILED),
        (json!({ "aud": "other" }), FAILED),
        (json!({ "nonce": "other" }), FAILED),
        (json!({ "nonce": null }), FAILED),
        (json!({ "at_hash": URL_SAFE_NO_PAD.encode([0; 16]) }), FAILED),
        (json!({ "iss": format!("{}/", provider.issuer) }), FAILED),
        (json!({ "exp": now_s - 600 }), FAILED),
        (json!({ "nbf": now_s + 600 }), FAILED),
        (json!({ "iat": null }), FAILED),
        (json!({ "sub": null }), FAILED),
        (json!({ "sub": "" }), FAILED),
    ];
    for (changed, place) in &cases {
        let answer_for = |nonce: &str| tokens(&access, Some(&provider.id_token(nonce, changed)));
        assert_eq!(led(&provider, &served, answer_for).await, *place, "{changed}");
    }
    assert_eq!(led(&provider, &served, |_| tokens(&access, None)).await, FAILED, "no ID token");
    let forged = |nonce: &str| {
        let token = provider.id_token(nonce, &json!({}));
        let other = provider.id_token(nonce, &json!({ "sub": "eve" }));
        tokens(&access, Some(&format!("{}.{}", token.rsplit_once('.').unwrap().0, other.rsplit_once('.').unwrap().1)))
    };
    assert_eq!(led(&provider, &served, forged).await, FAILED, "another signature");
}

#[tokio::test]
async fn regress_both_tokens_are_about_the_very_same_person() {
    let provider = Provider::start().await;
    let served = provider.served().await;
    // Similar subjects: each of them ends with the other one, or is its name.
    let pairs = [("ann", "x#ann"), ("x#ann", "ann"), ("ann", "Ann"), ("ann", "ann "), ("7", "77"), ("a#b", "b")];
    for (subject, other) in pairs {
        for name in ["ann", "x"] {
            let access = provider.access_token(&json!({ "sub": other, "name": name }));
            let answer_for = |nonce: &str| tokens(&access, Some(&provider.id_token(nonce, &json!({ "sub": subject }))));
            assert_eq!(led(&provider, &served, answer_for).await, FAILED, "{subject:?} {other:?} {name}");
        }
    }
}

#[tokio::test]
async fn regress_an_answer_leads_to_the_consoles_own_pages_only() {
    let provider = Provider::start().await;
    let served = provider.served().await;
    let signed_in = async |attempt: &Attempt, more: &str| {
        let access = provider.access_token(&json!({}));
        provider.gives(tokens(&access, Some(&provider.id_token(&attempt.nonce, &json!({})))));
        attempt.end(&served, more).await
    };
    for to in ["//evil.example", "/%5Cevil.example", "https://evil.example", "%23//evil.example", "%23/a%0D%0Ab", ""] {
        let attempt = Attempt::begin(&served, to).await;
        assert_eq!(signed_in(&attempt, "").await.headers["location"], "/#/fleets", "{to}");
    }
    let attempt = Attempt::begin(&served, "%23/search/Gr%C3%BCn").await;
    assert_eq!(signed_in(&attempt, "").await.headers["location"], "/#/search/Gr%C3%BCn");
    // A cookie that somebody else has planted.
    for to in ["/evil.example", "\\evil.example", "//evil.example", ".evil.example"] {
        let planted = json!({ "state": "s", "nonce": "n", "verifier": "v".repeat(43), "to": to }).to_string();
        let cookie = format!("vibrissa-sign-in={}", URL_SAFE_NO_PAD.encode(planted));
        let redirect_uri = String::new();
        let attempt = Attempt { state: "s".to_owned(), nonce: "n".to_owned(), cookie, redirect_uri };
        assert_eq!(signed_in(&attempt, "").await.headers["location"], "/#/fleets?sign_in=EXPIRED", "{to}");
    }
    let attempt = Attempt::begin(&served, "").await;
    assert_eq!(signed_in(&attempt, "&iss=https://other.example").await.headers["location"], FAILED);
    let attempt = Attempt { state: String::new(), ..Attempt::begin(&served, "").await };
    assert_eq!(signed_in(&attempt, "").await.headers["location"], "/#/fleets?sign_in=EXPIRED", "no state");
}

#[tokio::test]
async fn regress_a_renewal_continues_the_session_of_the_same_person_only() {
    let provider = Provider::start().await;
    let served = provider.served().await;
    // Tokens that expire within 20 s are renewed at each request.
    let short = json!({ "exp": now_us() / 1_000_000 + 18 });
    let renewed = async |status: u16, answer_for: &dyn Fn(&str) -> Value| {
        let attempt = Attempt::begin(&served, "").await;
        let id_token = provider.id_token(&attempt.nonce, &json!({}));
        provider.gives(tokens(&provider.access_token(&short), Some(&id_token)));
        let session = cookie(&attempt.end(&served, "").await);
        assert!(session.starts_with("vibrissa-session="), "{session}");
        *provider.next.lock().unwrap() = (status, answer_for(&attempt.nonce));
        let me = async || ask(served.http, "GET", "/v1/me", &[("Cookie", &session)]).await.unwrap();
        let first = me().await;
        // The provider gives valid tokens of the same person again: a session that has ended stays so.
        provider.gives(tokens(&provider.access_token(&json!({})), None));
        (first.status, me().await.status)
    };
    let access = |changed: Value| provider.access_token(&changed);
    let person = |changed: &Value| tokens(&access(json!({})), Some(&provider.id_token("", changed)));
    let no_nonce = json!({ "nonce": null });
    for (answer, what) in
        [(tokens(&access(json!({})), None), "no ID token"), (person(&no_nonce), "an ID token without a nonce")]
    {
        assert_eq!(renewed(200, &|_| answer.clone()).await, (200, 200), "{what}");
    }
    let same_nonce = |nonce: &str| tokens(&access(json!({})), Some(&provider.id_token(nonce, &json!({}))));
    assert_eq!(renewed(200, &same_nonce).await, (200, 200), "the same nonce");
    let admin = json!({ "sub": "eve", "role": "admin" });
    let others = [
        (tokens(&access(admin.clone()), None), "another person's access token"),
        (tokens(&access(admin), Some(&provider.id_token("", &json!({ "sub": "eve", "nonce": null })))), "both"),
        (person(&json!({ "sub": "eve", "nonce": null })), "another person's ID token"),
        (person(&json!({ "sub": "x#ann", "nonce": null })), "a similar subject"),
        (person(&json!({ "iss": "https://other.example", "nonce": null })), "another issuer"),
        (person(&json!({ "nonce": "other" })), "another nonce"),
        (person(&json!({ "azp": "other", "nonce": null })), "another client"),
        (person(&json!({ "aud": "other", "nonce": null })), "another audience"),
        (tokens(&access(json!({ "iss": "https://other.example" })), None), "an access token of another issuer"),
    ];
    for (answer, what) in others {
        assert_eq!(renewed(200, &|_| answer.clone()).await, (401, 401), "{what}");
    }
    let refused = json!({ "error": "invalid_grant" });
    assert_eq!(renewed(400, &|_| refused.clone()).await, (401, 401), "refused");
    // A provider that is away for a while ends no session.
    for status in [429, 500, 503] {
        let away = json!({ "error": "temporarily_unavailable" });
        assert_eq!(renewed(status, &|_| away.clone()).await, (503, 200), "{status}");
    }
}

/// A session whose tokens are renewed at the next request, at a provider whose refresh tokens are valid once.
async fn due(provider: &Provider, served: &Served) -> String {
    let attempt = Attempt::begin(served, "").await;
    let short = provider.access_token(&json!({ "exp": now_us() / 1_000_000 + 18 }));
    provider.gives(tokens(&short, Some(&provider.id_token(&attempt.nonce, &json!({})))));
    let session = cookie(&attempt.end(served, "").await);
    provider.tokens.is_strict.store(true, Ordering::SeqCst);
    let renewed =
        json!({ "token_type": "Bearer", "access_token": provider.access_token(&json!({})), "refresh_token": "s" });
    provider.gives(renewed);
    session
}

async fn me(http: SocketAddr, session: &str) -> u16 {
    ask(http, "GET", "/v1/me", &[("Cookie", session)]).await.unwrap().status
}

#[tokio::test]
async fn regress_a_renewal_outlives_its_request() {
    let provider = Provider::start().await;
    let served = provider.served().await;
    let session = due(&provider, &served).await;
    let turn = provider.tokens.turn.lock().await;
    // Through a proxy its caller must be identified, and it waits for 250 ms only.
    let headers = [("Cookie", session.as_str()), ("X-Forwarded-For", "192.0.2.1")];
    assert_eq!(ask(served.http, "GET", "/readyz", &headers).await.unwrap().status, 401);
    drop(turn);
    assert_eq!(me(served.http, &session).await, 200);
}

#[tokio::test]
async fn regress_two_supervisors_renew_a_session_at_the_same_time() {
    let provider = Provider::start().await;
    let access = provider.access(PUBLIC_URL);
    // A database in a file has one supervisor.
    let served = Served::streaming_from_postgres(&access, StreamOptions::default()).await;
    let (other, _stop) = served.another(&access).await;
    let session = due(&provider, &served).await;
    // It knows the provider's keys, as the first one does.
    let bearer = format!("Bearer {}", provider.access_token(&json!({})));
    assert_eq!(ask(other, "GET", "/v1/me", &[("Authorization", &bearer)]).await.unwrap().status, 200);
    let before = provider.tokens.asked.load(Ordering::SeqCst);
    let turn = provider.tokens.turn.lock().await;
    let both = async { tokio::join!(me(served.http, &session), me(other, &session)) };
    let release = async {
        until_true("two renewals", async || provider.tokens.asked.load(Ordering::SeqCst) == before + 2).await;
        drop(turn);
    };
    assert_eq!(tokio::join!(both, release).0, (200, 200));
    assert_eq!((me(served.http, &session).await, me(other, &session).await), (200, 200));
}

#[tokio::test]
async fn regress_a_sign_out_that_has_ended_nothing_says_so() {
    let provider = Provider::start().await;
    let served = provider.served().await;
    let session = due(&provider, &served).await;
    let headers = [("Cookie", session.as_str()), ("Sec-Fetch-Site", "same-origin")];
    let sign_out = async || ask(served.http, "POST", "/auth/sign-out", &headers).await.unwrap();
    let DatabaseAddress::Sqlite(file) = &served.database else { panic!("not SQLite") };
    let mut link = SqliteConnection::connect(&format!("sqlite:{}", file.display())).await.unwrap();
    link.execute("ALTER TABLE console_sessions RENAME TO others").await.unwrap();
    let failed = sign_out().await;
    assert!((failed.status, failed.headers.get("set-cookie")) == (503, None), "{failed:?}");
    link.execute("ALTER TABLE others RENAME TO console_sessions").await.unwrap();
    // Its tokens are stale, and the provider does not answer.
    *provider.next.lock().unwrap() = (503, json!({}));
    let done = sign_out().await;
    assert_eq!(done.status, 200, "{}", done.body);
    assert!(done.headers["set-cookie"].contains("Max-Age=0"), "{done:?}");
    assert_eq!(me(served.http, &session).await, 401);
    let operator = format!("Bearer {}", provider.access_token(&json!({})));
    let audit = ask(served.http, "GET", "/v1/audit", &[("Authorization", &operator)]).await.unwrap().json();
    let last = &audit["items"][0];
    assert_eq!(
        (&last["kind"], &last["actor"], &last["role"]),
        (&json!("SIGN_OUT"), &json!("oidc:ann"), &json!("OPERATOR"))
    );
}
