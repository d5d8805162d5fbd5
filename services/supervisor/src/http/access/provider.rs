//! Requests to the identity provider for the sign-in at the console: its endpoints, and tokens for a code or a refresh token.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use url::form_urlencoded::byte_serialize;

use vibrissa_store::secret::Secret;

/// Time limit of a request.
const PATIENCE: Duration = Duration::from_secs(5);
/// Size limit of an answer, in bytes.
const ANSWER_BYTES_MAX: u64 = 1024 * 1024;
/// Time for which the endpoints are remembered.
const FRESH_FOR: Duration = Duration::from_secs(600);

/// How people sign in at the console.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignInOptions {
    /// This service's identifier at the provider.
    pub client_id: String,
    /// Its secret; `None` for a public client.
    pub client_secret: Option<Secret>,
    /// Address at which browsers reach the console, without a slash at the end.
    pub public_url: String,
}

/// The provider's endpoints, by its discovery document.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Endpoints {
    issuer: String,
    pub(super) authorization_endpoint: String,
    token_endpoint: String,
    pub(super) end_session_endpoint: Option<String>,
}

/// Tokens of a person.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Tokens {
    pub(super) access_token: String,
    pub(super) refresh_token: Option<String>,
    pub(super) id_token: Option<String>,
}

/// Why the provider gave no tokens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Denial {
    /// It refuses them: the code or the refresh token is not valid any more.
    Refused(String),
    /// It does not answer, or not as expected.
    Away(String),
}

/// A provider. Clones share what is remembered.
#[derive(Debug, Clone)]
pub(super) struct Provider {
    issuer: Arc<str>,
    options: Arc<SignInOptions>,
    known: Arc<Mutex<Option<(Instant, Endpoints)>>>,
}

impl Provider {
    pub(super) fn new(issuer: &str, options: &SignInOptions) -> Self {
        Self { issuer: issuer.into(), options: Arc::new(options.clone()), known: Arc::default() }
    }

    pub(super) fn options(&self) -> &SignInOptions {
        &self.options
    }

    /// Where the provider sends browsers back to.
    pub(super) fn redirect_uri(&self) -> String {
        format!("{}/auth/callback", self.options.public_url)
    }

    /// The provider's endpoints.
    pub(super) async fn endpoints(&self) -> Result<Endpoints, String> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some((fetched, endpoints)) = known
            && fetched.elapsed() < FRESH_FOR
        {
            return Ok(endpoints);
        }
        let url = format!("{}/.well-known/openid-configuration", self.issuer.trim_end_matches('/'));
        let endpoints: Endpoints = blocking(move || {
            let answer = agent().get(&url).call().map_err(|problem| format!("{url}: {problem}"))?;
            read(answer)
                .and_then(|(status, text)| if status == 200 { parsed(&text) } else { Err(format!("{url}: {status}")) })
        })
        .await?;
        if endpoints.issuer != *self.issuer {
            return Err(format!("the provider calls itself {}, not {}", endpoints.issuer, self.issuer));
        }
        *self.known.lock().unwrap_or_else(PoisonError::into_inner) = Some((Instant::now(), endpoints.clone()));
        Ok(endpoints)
    }

    /// The tokens for a code.
    pub(super) async fn redeem(&self, code: String, verifier: String) -> Result<Tokens, Denial> {
        let redirect_uri = self.redirect_uri();
        let form = vec![
            ("grant_type", "authorization_code".to_owned()),
            ("code", code),
            ("redirect_uri", redirect_uri),
            ("code_verifier", verifier),
        ];
        self.tokens(form).await
    }

    /// New tokens for a refresh token.
    pub(super) async fn renew(&self, tokens: &Tokens) -> Result<Tokens, Denial> {
        let Some(refresh_token) = tokens.refresh_token.clone() else {
            return Err(Denial::Refused("the provider gave no refresh token".to_owned()));
        };
        let form = vec![("grant_type", "refresh_token".to_owned()), ("refresh_token", refresh_token)];
        let new = self.tokens(form).await?;
        // A provider may keep the refresh token, and need not repeat the ID token.
        Ok(Tokens {
            refresh_token: new.refresh_token.or_else(|| tokens.refresh_token.clone()),
            id_token: new.id_token.or_else(|| tokens.id_token.clone()),
            access_token: new.access_token,
        })
    }

    async fn tokens(&self, mut form: Vec<(&'static str, String)>) -> Result<Tokens, Denial> {
        let url = self.endpoints().await.map_err(Denial::Away)?.token_endpoint;
        let options = self.options.clone();
        let authorization = options.client_secret.as_ref().map(|secret| {
            let encoded = |text: &str| byte_serialize(text.as_bytes()).collect::<String>();
            let pair = format!("{}:{}", encoded(&options.client_id), encoded(secret.reveal()));
            format!("Basic {}", STANDARD.encode(pair))
        });
        if authorization.is_none() {
            form.push(("client_id", options.client_id.clone()));
        }
        let answered = blocking(move || {
            let mut request = agent().post(&url).header("accept", "application/json");
            if let Some(authorization) = authorization {
                request = request.header("authorization", authorization);
            }
            let form = form.iter().map(|(name, value)| (*name, value.as_str()));
            read(request.send_form(form).map_err(|problem| format!("{url}: {problem}"))?)
        });
        let (status, text) = answered.await.map_err(Denial::Away)?;
        match status {
            200 => parsed(&text).map_err(Denial::Away),
            400..=499 => {
                let told: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
                let what =
                    |name: &str| told.get(name).and_then(serde_json::Value::as_str).unwrap_or_default().to_owned();
                Err(Denial::Refused(format!("{status} {} {}", what("error"), what("error_description"))))
            }
            _ => Err(Denial::Away(format!("the provider answered {status}"))),
        }
    }
}

async fn blocking<T: Send + 'static>(work: impl FnOnce() -> Result<T, String> + Send + 'static) -> Result<T, String> {
    tokio::task::spawn_blocking(work).await.unwrap_or_else(|problem| Err(problem.to_string()))
}

fn agent() -> ureq::Agent {
    let config = ureq::Agent::config_builder().timeout_global(Some(PATIENCE)).max_redirects(0);
    config.http_status_as_error(false).build().new_agent()
}

fn read(mut answer: ureq::http::Response<ureq::Body>) -> Result<(u16, Vec<u8>), String> {
    let status = answer.status().as_u16();
    let body = answer.body_mut().with_config().limit(ANSWER_BYTES_MAX).read_to_vec();
    Ok((status, body.map_err(|problem| problem.to_string())?))
}

fn parsed<T: DeserializeOwned>(text: &[u8]) -> Result<T, String> {
    serde_json::from_slice(text).map_err(|problem| format!("unexpected JSON from the provider: {problem}"))
}
