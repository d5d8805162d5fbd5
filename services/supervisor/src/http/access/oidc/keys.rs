//! The signing keys of an OpenID provider. One task at a time fetches them, outside the lock: a caller whose key is
//! known does not wait for the provider. Callers with unknown keys share a fetch, and cannot repeat it at will.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use jsonwebtoken::jwk::{AlgorithmParameters, EllipticCurve, Jwk, JwkSet, KeyAlgorithm, KeyOperations, PublicKeyUse};
use jsonwebtoken::{Algorithm, DecodingKey};
use tokio::sync::watch;
use tokio::time::Instant;
use vibrissa_host::task;

use super::fetch::{self, Away, blocking};
use crate::http::problem::{Kind, Problem};

/// Timing of fetches.
#[derive(Debug, Clone, Copy)]
struct Pace {
    /// Keys older than this are fetched again in the background, because one may have been withdrawn.
    fresh_for: Duration,
    /// Keys older than this are not used before another fetch was tried.
    trusted_for: Duration,
    /// Shortest interval between two fetches, whatever keys tokens name.
    fetch_every: Duration,
    /// The same while no keys are known.
    retry_every: Duration,
}

const PACE: Pace = Pace {
    fresh_for: Duration::from_secs(600),
    trusted_for: Duration::from_secs(1200),
    fetch_every: Duration::from_secs(10),
    retry_every: Duration::from_secs(1),
};

/// Algorithms of RSA keys.
const OF_RSA: [Algorithm; 6] =
    [Algorithm::RS256, Algorithm::RS384, Algorithm::RS512, Algorithm::PS256, Algorithm::PS384, Algorithm::PS512];

/// Location of a provider's keys.
#[derive(Debug, Clone)]
struct Source {
    issuer: String,
    jwks_url: Option<String>,
}

/// A provider's keys as of the last fetch.
#[derive(Debug, Clone)]
pub(super) struct Keys {
    source: Source,
    pace: Pace,
    state: Arc<Mutex<State>>,
}

#[derive(Debug, Default)]
struct State {
    set: Option<JwkSet>,
    /// When `set` was fetched.
    fetched: Option<Instant>,
    /// When the last fetch began.
    asked: Option<Instant>,
    /// Why the last fetch failed, if it did.
    failure: Option<String>,
    /// Closed at the end of the fetch that is under way.
    fetching: Option<watch::Receiver<()>>,
}

/// Why there is no key for a token.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lack {
    /// The set has no key with this ID, or no set is known.
    Unknown,
    /// The key with this ID is not meant for this use.
    Unfit(&'static str),
}

impl Keys {
    /// Keys of a provider; nothing is fetched yet.
    pub(super) fn new(issuer: &str, jwks_url: Option<&str>) -> Self {
        let source = Source { issuer: issuer.to_owned(), jwks_url: jwks_url.map(ToOwned::to_owned) };
        Self { source, pace: PACE, state: Arc::default() }
    }

    /// The key with this ID, for signatures by this algorithm.
    ///
    /// # Errors
    /// The provider has no such key, the key is for something else, or no keys could be fetched.
    pub(super) async fn key(&self, kid: Option<&str>, algorithm: Algorithm) -> Result<Jwk, Problem> {
        let mut fetching = {
            let mut state = lock(&self.state);
            let now = Instant::now();
            let found = state.find(kid, algorithm);
            let age = state.fetched.map(|fetched| now.saturating_duration_since(fetched));
            let is_wanted = matches!(found, Err(Lack::Unknown)) || age.is_none_or(|age| age > self.pace.fresh_for);
            let fetching = if is_wanted { self.fetching(&mut state, now) } else { None };
            // Known keys stay valid while the provider is unreachable.
            let is_trusted = state.failure.is_some() || age.is_some_and(|age| age <= self.pace.trusted_for);
            match (found, fetching) {
                (Ok(key), _) if is_trusted => return Ok(key),
                (_, Some(fetching)) => fetching,
                (found, None) => return state.verdict(found, kid),
            }
        };
        // No value is ever sent: `changed` returns when the sender is dropped at the end of the fetch.
        let _ = fetching.changed().await;
        let state = lock(&self.state);
        state.verdict(state.find(kid, algorithm), kid)
    }

    /// The fetch that is under way, or a new one; `None` if the last one is too recent.
    fn fetching(&self, state: &mut State, now: Instant) -> Option<watch::Receiver<()>> {
        let under_way = state.fetching.as_ref().filter(|fetching| fetching.has_changed().is_ok());
        if let Some(fetching) = under_way {
            return Some(fetching.clone());
        }
        let pause = if state.set.is_some() { self.pace.fetch_every } else { self.pace.retry_every };
        if state.asked.is_some_and(|asked| now.saturating_duration_since(asked) < pause) {
            return None;
        }
        state.asked = Some(now);
        let (done, fetching) = watch::channel(());
        state.fetching = Some(fetching.clone());
        let (source, state) = (self.source.clone(), self.state.clone());
        // A separate task, so that callers who disconnect do not cancel the fetch.
        task::spawn(async move {
            let fetched = blocking(move || source.fetch()).await;
            let mut state = lock(&state);
            match fetched {
                Ok(set) => {
                    state.set = Some(set);
                    state.fetched = Some(Instant::now());
                    state.failure = None;
                }
                Err(Away(problem)) => {
                    tracing::warn!(problem, "cannot fetch the identity provider's keys");
                    state.failure = Some(problem);
                }
            }
            drop(state);
            drop(done);
        });
        Some(fetching)
    }
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

impl State {
    fn find(&self, kid: Option<&str>, algorithm: Algorithm) -> Result<Jwk, Lack> {
        choose(self.set.as_ref().map_or(&[], |set| &set.keys), kid, algorithm)
    }

    fn verdict(&self, found: Result<Jwk, Lack>, kid: Option<&str>) -> Result<Jwk, Problem> {
        let refused = |what: String| Err(Problem::new(Kind::Unauthenticated, what));
        match found {
            Ok(key) => Ok(key),
            Err(Lack::Unfit(why)) => refused(format!("the identity provider's key {kid:?} {why}")),
            Err(Lack::Unknown) if self.set.is_some() => {
                refused(format!("the identity provider has no key {kid:?} for this token"))
            }
            Err(Lack::Unknown) => {
                let why = self.failure.as_deref().unwrap_or("the fetch is not complete");
                Err(Problem::new(Kind::Unavailable, format!("the identity provider's keys are not available: {why}")))
            }
        }
    }
}

/// The key with this ID that verifies signatures by this algorithm. A token may omit the ID if one key fits.
fn choose(keys: &[Jwk], kid: Option<&str>, algorithm: Algorithm) -> Result<Jwk, Lack> {
    let mut unfit = None;
    let mut fit = Vec::new();
    for key in keys.iter().filter(|key| kid.is_none() || key.common.key_id.as_deref() == kid) {
        match fitness(key, algorithm) {
            Ok(()) => fit.push(key),
            Err(why) => unfit = Some(why),
        }
    }
    match (fit.as_slice(), kid) {
        ([key], _) | ([key, ..], Some(_)) => match DecodingKey::from_jwk(key) {
            Ok(_) => Ok((*key).clone()),
            Err(_) => Err(Lack::Unfit("cannot be parsed")),
        },
        ([], Some(_)) => Err(unfit.map_or(Lack::Unknown, Lack::Unfit)),
        ([] | [_, _, ..], None) => Err(Lack::Unknown),
    }
}

/// Whether the provider allows the key for signatures by this algorithm.
fn fitness(key: &Jwk, algorithm: Algorithm) -> Result<(), &'static str> {
    if key.common.public_key_use.as_ref().is_some_and(|usage| *usage != PublicKeyUse::Signature) {
        return Err("is not for signatures (use)");
    }
    if key.common.key_operations.as_ref().is_some_and(|all| !all.contains(&KeyOperations::Verify)) {
        return Err("is not for checking signatures (key_ops)");
    }
    if key.common.key_algorithm.is_some_and(|of_key| of_key != KeyAlgorithm::from(algorithm)) {
        return Err("is for another algorithm than the token's (alg)");
    }
    let is_on = |curve| matches!(&key.algorithm, AlgorithmParameters::EllipticCurve(point) if point.curve == curve);
    let is_ed25519 =
        matches!(&key.algorithm, AlgorithmParameters::OctetKeyPair(pair) if pair.curve == EllipticCurve::Ed25519);
    // HS256 and the like are never accepted: their secret would be public here.
    let is_of_its_kind = (OF_RSA.contains(&algorithm) && matches!(key.algorithm, AlgorithmParameters::RSA(_)))
        || (algorithm == Algorithm::ES256 && is_on(EllipticCurve::P256))
        || (algorithm == Algorithm::ES384 && is_on(EllipticCurve::P384))
        || (algorithm == Algorithm::EdDSA && is_ed25519);
    if is_of_its_kind { Ok(()) } else { Err("does not fit the token's algorithm (kty, crv)") }
}

impl Source {
    fn fetch(&self) -> Result<JwkSet, Away> {
        match &self.jwks_url {
            Some(url) => fetch::get(url),
            None => {
                let url = fetch::discover(&self.issuer)?.jwks_uri;
                fetch::get(&url.ok_or_else(|| Away(format!("{} publishes no jwks_uri", self.issuer)))?)
            }
        }
    }
}

#[cfg(test)]
mod tests;
