//! Sessions of the console. The browser keeps an identifier and a key in a cookie that scripts cannot read; the database
//! keeps the provider's tokens, encrypted with that key. So neither has them alone.

use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use ring::aead::{Aad, CHACHA20_POLY1305, LessSafeKey, NONCE_LEN, Nonce, UnboundKey};
use serde_json::Value;
use tokio::sync::Mutex;

use super::oidc::Oidc;
use super::provider::{Denial, Endpoints, Provider, SignInOptions, Tokens};
use super::{Authentication, Caller};
use crate::http::problem::{Kind, Problem};
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::Store;
use vibrissa_store::secret::Secret;
use vibrissa_store::sessions::SessionRow;

/// Longest time of a session, s.
pub const SESSION_S: i64 = 12 * 3600;
/// Tokens that expire within this time are renewed, s.
const RENEWED_BEFORE_S: f64 = 20.0;
/// Length of the identifier in the cookie, in bytes.
const ID_BYTES: usize = 16;
/// Length of the key in the cookie, in bytes.
const KEY_BYTES: usize = 32;
/// Number of renewals that can be under way at once; those of one session follow each other.
const RENEWALS: usize = 16;

/// Signs people in with the identity provider. Clones share their state.
#[derive(Debug, Clone)]
pub struct SignIn {
    provider: Provider,
    oidc: Oidc,
    renewals: Arc<[Mutex<()>; RENEWALS]>,
}

/// A sign-in that is under way at the provider. The browser keeps it in a cookie.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub struct Attempt {
    /// Ties the provider's answer to this browser.
    pub state: String,
    /// Ties the ID token to this attempt.
    pub nonce: String,
    /// Secret of PKCE: who intercepts the code cannot redeem it.
    pub verifier: String,
    /// Page to show afterwards: a fragment of the console.
    pub to: String,
}

impl Attempt {
    /// A new attempt.
    ///
    /// # Errors
    /// The system provides no randomness.
    pub fn new(to: &str) -> Result<Self, Problem> {
        Ok(Self { state: random(32)?, nonce: random(32)?, verifier: random(32)?, to: to.to_owned() })
    }
}

/// A new session.
#[derive(Debug)]
pub struct Begun {
    /// Value of the cookie.
    pub cookie: Secret,
    /// Row of the session.
    pub row: SessionRow,
    /// The person.
    pub caller: Caller,
}

/// Why a sign-in failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Failure {
    /// The person has no role here.
    NoRole(String),
    /// The provider does not answer, or its answer is not valid.
    Provider(String),
}

impl SignIn {
    pub(super) fn new(issuer: &str, options: &SignInOptions, oidc: Oidc) -> Self {
        let provider = Provider::new(issuer, options);
        Self { provider, oidc, renewals: Arc::new(std::array::from_fn(|_| Mutex::new(()))) }
    }

    /// Whether browsers reach the console over HTTPS.
    #[must_use]
    pub fn is_secure(&self) -> bool {
        self.provider.options().public_url.starts_with("https://")
    }

    /// Where the browser goes for an attempt.
    ///
    /// # Errors
    /// The provider does not answer.
    pub async fn authorization_url(&self, attempt: &Attempt) -> Result<String, Problem> {
        let away =
            |what: String| Problem::new(Kind::Unavailable, format!("the identity provider is not available: {what}"));
        let endpoint = self.provider.endpoints().await.map_err(away)?.authorization_endpoint;
        let mut url = url::Url::parse(&endpoint).map_err(|problem| away(problem.to_string()))?;
        let digest = ring::digest::digest(&ring::digest::SHA256, attempt.verifier.as_bytes());
        url.query_pairs_mut()
            .append_pair("response_type", "code")
            .append_pair("client_id", &self.provider.options().client_id)
            .append_pair("redirect_uri", &self.provider.redirect_uri())
            .append_pair("scope", "openid profile")
            .append_pair("state", &attempt.state)
            .append_pair("nonce", &attempt.nonce)
            .append_pair("code_challenge", &URL_SAFE_NO_PAD.encode(digest))
            .append_pair("code_challenge_method", "S256");
        Ok(url.into())
    }

    /// The session for a code that the provider has given to this attempt.
    ///
    /// # Errors
    /// The provider refuses the code, its tokens are not valid, or they carry no role.
    pub async fn begin(&self, attempt: &Attempt, code: String) -> Result<Begun, Failure> {
        let tokens = self.provider.redeem(code, attempt.verifier.clone()).await.map_err(|denial| match denial {
            Denial::Refused(what) | Denial::Away(what) => Failure::Provider(what),
        })?;
        let id_token = tokens.id_token.as_deref().ok_or_else(|| Failure::Provider("no ID token".to_owned()))?;
        let invalid = |problem: Problem| {
            let failure = if problem.kind == Kind::Forbidden { Failure::NoRole } else { Failure::Provider };
            failure(problem.detail)
        };
        let claims = self.oidc.verified(id_token, &self.provider.options().client_id).await.map_err(invalid)?;
        if claims.get("nonce").and_then(Value::as_str) != Some(&attempt.nonce) {
            return Err(Failure::Provider("the ID token belongs to another attempt (nonce)".to_owned()));
        }
        let caller = self.oidc.caller(&tokens.access_token).await.map_err(invalid)?;
        let subject = claims.get("sub").and_then(Value::as_str).unwrap_or_default();
        if !caller.is_subject(subject) {
            return Err(Failure::Provider("the tokens are about two different people".to_owned()));
        }
        let failed = |problem: Problem| Failure::Provider(problem.detail);
        let bytes = random_bytes(ID_BYTES + KEY_BYTES).map_err(failed)?;
        let now_us = wall_clock().0 as i64;
        let row = SessionRow {
            session_id: blake3::hash(&bytes[..ID_BYTES]).as_bytes().to_vec(),
            actor: caller.actor.clone(),
            sealed: seal(&tokens, &bytes[ID_BYTES..]).map_err(failed)?,
            created_us: now_us,
            expires_us: now_us + SESSION_S * 1_000_000,
        };
        Ok(Begun { cookie: Secret::new(URL_SAFE_NO_PAD.encode(bytes)), row, caller })
    }

    /// The caller whose browser has this cookie. Tokens that expire are renewed.
    ///
    /// # Errors
    /// The session has ended, or the database or the provider does not answer.
    pub async fn caller(&self, store: &Store, cookie: &Secret) -> Result<Caller, Problem> {
        let (row, mut tokens, key) = opened(store, cookie).await?.ok_or_else(ended)?;
        if is_stale(&tokens.access_token) {
            tokens = self.renewed(store, cookie, &row, &key).await?;
        }
        let caller = self.oidc.caller(&tokens.access_token).await?;
        Ok(Caller { authentication: Authentication::Session, expires_us: Some(row.expires_us), ..caller })
    }

    async fn renewed(&self, store: &Store, cookie: &Secret, row: &SessionRow, key: &[u8]) -> Result<Tokens, Problem> {
        let place = usize::from(row.session_id.first().copied().unwrap_or_default()) % RENEWALS;
        let _turn = self.renewals[place].lock().await;
        // Another request may have renewed them meanwhile.
        let (_, tokens, _) = opened(store, cookie).await?.ok_or_else(ended)?;
        if !is_stale(&tokens.access_token) {
            return Ok(tokens);
        }
        match self.provider.renew(&tokens).await {
            Ok(new) => {
                store.reseal_session(&row.session_id, &seal(&new, key)?).await?;
                Ok(new)
            }
            Err(Denial::Refused(what)) => {
                tracing::info!(actor = row.actor, what, "the provider ends a session of the console");
                store.end_session(&row.session_id, None).await?;
                Err(ended())
            }
            Err(Denial::Away(what)) => {
                Err(Problem::new(Kind::Unavailable, format!("the identity provider is not available: {what}")))
            }
        }
    }

    /// Hash of a cookie's identifier, and where the browser signs out at the provider, too.
    pub async fn end(&self, store: &Store, cookie: &Secret) -> Option<(Vec<u8>, Option<String>)> {
        let (row, tokens, _) = opened(store, cookie).await.ok().flatten()?;
        let endpoint = self.provider.endpoints().await.ok().and_then(|known: Endpoints| known.end_session_endpoint);
        let url = endpoint.and_then(|endpoint| {
            let options = self.provider.options();
            let mut url = url::Url::parse(&endpoint).ok()?;
            url.query_pairs_mut()
                .append_pair("client_id", &options.client_id)
                .append_pair("post_logout_redirect_uri", &format!("{}/", options.public_url));
            if let Some(hint) = &tokens.id_token {
                url.query_pairs_mut().append_pair("id_token_hint", hint);
            }
            Some(url.to_string())
        });
        Some((row.session_id, url))
    }
}

pub(super) fn ended() -> Problem {
    Problem::new(Kind::Unauthenticated, "the session has ended: sign in again")
}

/// Hash of the identifier in a cookie, by which the database knows its session; `None` if it has another format.
pub(super) fn hash(cookie: &Secret) -> Option<[u8; 32]> {
    let bytes = URL_SAFE_NO_PAD.decode(cookie.reveal()).ok().filter(|bytes| bytes.len() == ID_BYTES + KEY_BYTES)?;
    Some(*blake3::hash(&bytes[..ID_BYTES]).as_bytes())
}

/// The session of a cookie with its tokens and its key; `None` if it has ended.
async fn opened(store: &Store, cookie: &Secret) -> Result<Option<(SessionRow, Tokens, Vec<u8>)>, Problem> {
    let Ok(bytes) = URL_SAFE_NO_PAD.decode(cookie.reveal()) else { return Ok(None) };
    if bytes.len() != ID_BYTES + KEY_BYTES {
        return Ok(None);
    }
    let (id, key) = bytes.split_at(ID_BYTES);
    let row = store.session(blake3::hash(id).as_bytes()).await?;
    let row = row.filter(|row| row.expires_us > wall_clock().0 as i64);
    Ok(row.and_then(|row| open(&row.sealed, key).map(|tokens| (row, tokens, key.to_vec()))))
}

/// Whether a token expires soon, by its own claim. Its signature is verified elsewhere.
fn is_stale(token: &str) -> bool {
    let claims = token.split('.').nth(1).and_then(|part| URL_SAFE_NO_PAD.decode(part).ok());
    let claims: Option<Value> = claims.and_then(|claims| serde_json::from_slice(&claims).ok());
    let expires_s = claims.and_then(|claims| claims.get("exp").and_then(Value::as_f64));
    expires_s.is_none_or(|expires_s| expires_s - wall_clock().as_s() < RENEWED_BEFORE_S)
}

fn random_bytes(length: usize) -> Result<Vec<u8>, Problem> {
    let mut bytes = vec![0; length];
    getrandom::fill(&mut bytes)
        .map_err(|problem| Problem::new(Kind::Internal, format!("the system provides no randomness: {problem}")))?;
    Ok(bytes)
}

fn random(length: usize) -> Result<String, Problem> {
    random_bytes(length).map(|bytes| URL_SAFE_NO_PAD.encode(bytes))
}

fn cipher(key: &[u8]) -> Option<LessSafeKey> {
    UnboundKey::new(&CHACHA20_POLY1305, key).ok().map(LessSafeKey::new)
}

/// Encrypts tokens: a random nonce, then the sealed JSON.
fn seal(tokens: &Tokens, key: &[u8]) -> Result<Vec<u8>, Problem> {
    let internal = || Problem::new(Kind::Internal, "cannot encrypt the session");
    let nonce: [u8; NONCE_LEN] = random_bytes(NONCE_LEN)?.try_into().map_err(|_| internal())?;
    let mut sealed = serde_json::to_vec(tokens).map_err(|_| internal())?;
    let cipher = cipher(key).ok_or_else(internal)?;
    let nonced = Nonce::assume_unique_for_key(nonce);
    cipher.seal_in_place_append_tag(nonced, Aad::empty(), &mut sealed).map_err(|_| internal())?;
    Ok([nonce.as_slice(), &sealed].concat())
}

fn open(sealed: &[u8], key: &[u8]) -> Option<Tokens> {
    let (nonce, sealed) = sealed.split_at_checked(NONCE_LEN)?;
    let nonce = Nonce::assume_unique_for_key(nonce.try_into().ok()?);
    let mut sealed = sealed.to_vec();
    let opened = cipher(key)?.open_in_place(nonce, Aad::empty(), &mut sealed).ok()?;
    serde_json::from_slice(opened).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_cookies_key_opens_a_session() {
        let tokens = Tokens { access_token: "a".to_owned(), refresh_token: Some("r".to_owned()), id_token: None };
        let sealed = seal(&tokens, &[1; KEY_BYTES]).unwrap();
        assert_eq!(open(&sealed, &[1; KEY_BYTES]).unwrap().access_token, "a");
        assert!(open(&sealed, &[2; KEY_BYTES]).is_none() && open(&sealed[1..], &[1; KEY_BYTES]).is_none());
        assert!(open(&[], &[1; KEY_BYTES]).is_none());
        assert_ne!(sealed, seal(&tokens, &[1; KEY_BYTES]).unwrap(), "each nonce is used once");
    }

    #[test]
    fn a_token_is_renewed_before_it_expires() {
        let token = |expires_s: f64| {
            let claims = serde_json::json!({ "exp": expires_s }).to_string();
            format!("e30.{}.x", URL_SAFE_NO_PAD.encode(claims))
        };
        let now_s = wall_clock().as_s();
        assert!(is_stale(&token(now_s + 10.0)) && is_stale(&token(now_s - 5.0)) && is_stale("not a token"));
        assert!(!is_stale(&token(now_s + 60.0)));
    }
}
