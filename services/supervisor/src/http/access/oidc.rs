//! Tokens of an OpenID provider: JWTs, checked against its keys, its name, our audience and the time.

use std::sync::Arc;
use std::time::{Duration, Instant};

use jsonwebtoken::jwk::JwkSet;
use jsonwebtoken::{Algorithm, DecodingKey, Validation, decode, decode_header};
use serde_json::{Map, Value};
use tokio::sync::Mutex;
use vibrissa_protocol::Name;

use super::{Caller, Role, Scope};
use crate::http::problem::{Kind, Problem};

/// An OpenID provider whose tokens are taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OidcOptions {
    /// Its name, `iss` of its tokens, letter by letter.
    pub issuer: String,
    /// Ours, `aud` of its tokens.
    pub audience: String,
    /// Where its keys are; asked of the issuer if there is none.
    pub jwks_url: Option<String>,
    /// The claim with the role.
    pub role_claim: String,
    /// The claim with the fleets.
    pub fleets_claim: String,
}

/// A provider with its keys, as they were last.
#[derive(Debug, Clone)]
pub struct Oidc {
    options: Arc<OidcOptions>,
    keys: Arc<Mutex<Keys>>,
}

#[derive(Debug, Default)]
struct Keys {
    set: Option<JwkSet>,
    asked: Option<Instant>,
}

/// Keys older than this are asked for again: one may have been withdrawn.
const KEYS_GOOD_FOR: Duration = Duration::from_secs(600);
/// Keys are not asked for more often than this, whatever tokens name.
const KEYS_ASKED_EVERY: Duration = Duration::from_secs(10);
/// How long the provider is waited for.
const PATIENCE: Duration = Duration::from_secs(5);
/// Bytes of a provider's answer at the most.
const ANSWER_BYTES_MAX: u64 = 1024 * 1024;
/// Whose signature anybody can check without being able to make one.
const ALGORITHMS: [Algorithm; 9] = [
    Algorithm::RS256,
    Algorithm::RS384,
    Algorithm::RS512,
    Algorithm::PS256,
    Algorithm::PS384,
    Algorithm::PS512,
    Algorithm::ES256,
    Algorithm::ES384,
    Algorithm::EdDSA,
];

impl Oidc {
    /// A provider; nothing is asked of it yet.
    #[must_use]
    pub fn new(options: OidcOptions) -> Self {
        Self { options: Arc::new(options), keys: Arc::default() }
    }

    /// Whom a token lets in.
    ///
    /// # Errors
    /// The token is not good, gives no role or no fleet, or the provider does not answer.
    pub async fn caller(&self, token: &str) -> Result<Caller, Problem> {
        let refused = |what: String| Problem::new(Kind::Unauthenticated, what);
        let header = decode_header(token).map_err(|problem| refused(format!("the token is no JWT: {problem}")))?;
        if !ALGORITHMS.contains(&header.alg) {
            return Err(refused(format!("tokens signed with {:?} are not taken", header.alg)));
        }
        let key = self.key(header.kid.as_deref()).await?;
        let mut validation = Validation::new(header.alg);
        validation.set_issuer(&[&self.options.issuer]);
        validation.set_audience(&[&self.options.audience]);
        validation.set_required_spec_claims(&["exp", "iss", "aud", "sub"]);
        validation.validate_nbf = true;
        let claims = decode::<Map<String, Value>>(token, &key, &validation)
            .map_err(|problem| refused(format!("the token is not taken: {problem}")))?
            .claims;
        self.allowed(&claims)
    }

    /// What the claims allow.
    fn allowed(&self, claims: &Map<String, Value>) -> Result<Caller, Problem> {
        let texts = |claim: &str| -> Vec<&str> {
            match claims.get(claim) {
                Some(Value::String(text)) => vec![text],
                Some(Value::Array(items)) => items.iter().filter_map(Value::as_str).collect(),
                _ => Vec::new(),
            }
        };
        let OidcOptions { role_claim, fleets_claim, .. } = &*self.options;
        let roles = texts(role_claim).into_iter().filter_map(|word| Role::of_word(&word.to_ascii_uppercase()));
        let role = roles.max().ok_or_else(|| {
            Problem::new(
                Kind::Forbidden,
                format!("the token's claim {role_claim:?} names no role: viewer, operator ..."),
            )
        })?;
        let fleets = texts(fleets_claim);
        let scope = if fleets.contains(&"*") {
            Scope::All
        } else {
            Scope::Only(fleets.into_iter().filter_map(|fleet| Name::new(fleet).ok()).collect())
        };
        let subject = claims.get("sub").and_then(Value::as_str).unwrap_or_default();
        Ok(Caller { actor: format!("oidc:{subject}"), role, scope })
    }

    /// The provider's key of that name.
    async fn key(&self, kid: Option<&str>) -> Result<DecodingKey, Problem> {
        let mut keys = self.keys.lock().await;
        let since = keys.asked.map(|asked| asked.elapsed());
        let is_stale = since.is_none_or(|since| since > KEYS_GOOD_FOR);
        let may_ask = since.is_none_or(|since| since > KEYS_ASKED_EVERY);
        if is_stale || (may_ask && find(keys.set.as_ref(), kid).is_none()) {
            keys.asked = Some(Instant::now());
            match self.fetch().await {
                Ok(set) => keys.set = Some(set),
                // Those that are there are still good.
                Err(problem) if keys.set.is_some() => tracing::warn!(problem, "the identity provider does not answer"),
                Err(problem) => {
                    keys.asked = None;
                    return Err(Problem::new(Kind::Unavailable, problem));
                }
            }
        }
        find(keys.set.as_ref(), kid).ok_or_else(|| {
            Problem::new(Kind::Unauthenticated, format!("the identity provider has no key {kid:?} for this token"))
        })
    }

    async fn fetch(&self) -> Result<JwkSet, String> {
        let options = self.options.clone();
        let asked = tokio::task::spawn_blocking(move || {
            let url = match &options.jwks_url {
                Some(url) => url.clone(),
                None => {
                    let issuer = options.issuer.trim_end_matches('/');
                    let told: Value = get(&format!("{issuer}/.well-known/openid-configuration"))?;
                    let url = told.get("jwks_uri").and_then(Value::as_str);
                    url.ok_or_else(|| format!("{issuer} does not say where its keys are (jwks_uri)"))?.to_owned()
                }
            };
            get(&url)
        });
        asked.await.map_err(|problem| problem.to_string())?
    }
}

fn find(set: Option<&JwkSet>, kid: Option<&str>) -> Option<DecodingKey> {
    let set = set?;
    let key = match kid {
        Some(kid) => set.find(kid)?,
        // A token may leave it out if there is no choice.
        None => set.keys.first().filter(|_| set.keys.len() == 1)?,
    };
    DecodingKey::from_jwk(key).ok()
}

fn get<T: serde::de::DeserializeOwned>(url: &str) -> Result<T, String> {
    let agent = ureq::Agent::config_builder().timeout_global(Some(PATIENCE)).max_redirects(0).build().new_agent();
    let mut answer = agent.get(url).call().map_err(|problem| format!("{url}: {problem}"))?;
    let body = answer.body_mut().with_config().limit(ANSWER_BYTES_MAX).read_to_vec();
    let body = body.map_err(|problem| format!("{url}: {problem}"))?;
    serde_json::from_slice(&body).map_err(|problem| format!("{url}: not the JSON that is expected: {problem}"))
}
