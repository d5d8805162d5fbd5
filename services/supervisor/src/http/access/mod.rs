//! Authentication and authorisation: tokens of this service or of an identity provider, or no token on loopback.

mod caller;
pub mod cookies;
mod gate;
pub(super) mod guests;
mod known;
pub mod monitoring;
#[cfg(feature = "oidc")]
mod oidc;
#[cfg(not(feature = "oidc"))]
#[path = "oidc/disabled.rs"]
mod oidc;
mod options;
pub mod origin;
pub(super) mod role;
mod scope;
pub mod token;

use std::net::IpAddr;
use std::num::NonZeroU32;
use std::sync::Arc;

use axum::http::request::Parts;
use axum::http::{Method, header};
use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};

pub use self::caller::{Authentication, Caller, Credential};
pub use self::gate::{Gate, check};
use self::guests::{Guests, client};
use self::known::{HASHES_MAX, Hash, Known};
use self::monitoring::Monitors;
pub(in crate::http) use self::oidc::routes as oidc_routes;
use self::oidc::{Oidc, SignIn};
pub use self::options::{AccessOptions, OidcOptions, SignInOptions};
pub use self::role::Role;
pub use self::scope::Scope;
use super::client_address::TrustedProxies;
use super::problem::{Kind, Problem};
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::Store;
use vibrissa_store::secret::Secret;

/// Decides who is let in.
#[derive(Debug, Clone)]
pub struct Access {
    /// Whether a request without a token is let in, as [`Caller::local`].
    is_open: bool,
    /// Whether only this machine reaches the listener.
    is_loopback: bool,
    /// Hash of the token with every right.
    token: Option<blake3::Hash>,
    oidc: Option<Oidc>,
    sign_in: Option<SignIn>,
    limiter: Arc<DefaultKeyedRateLimiter<String>>,
    guests: Arc<Guests>,
    known: Known,
    monitors: Monitors,
    proxies: TrustedProxies,
}

/// Average request rate allowed per caller, in requests per second.
pub const REQUESTS_PER_S: NonZeroU32 = NonZeroU32::new(200).unwrap();
/// Burst size allowed per caller, in requests.
pub const REQUESTS_BURST: NonZeroU32 = NonZeroU32::new(1000).unwrap();

impl Access {
    /// Access to a service on that address. On loopback no token is required, unless the options configure one.
    #[must_use]
    pub fn new(options: &AccessOptions, listens: IpAddr) -> Self {
        let quota = Quota::per_second(REQUESTS_PER_S).allow_burst(REQUESTS_BURST);
        let (oidc, sign_in) = oidc::configured(options.oidc.as_ref());
        Self {
            is_open: listens.is_loopback() && options.token.is_none() && options.oidc.is_none(),
            is_loopback: listens.is_loopback(),
            token: options.token.as_ref().map(|token| blake3::hash(token.reveal().as_bytes())),
            oidc,
            sign_in,
            limiter: Arc::new(RateLimiter::keyed(quota)),
            guests: Arc::default(),
            known: Known::default(),
            monitors: Monitors::default(),
            proxies: TrustedProxies::default(),
        }
    }

    /// The same access behind these proxies.
    #[must_use]
    pub(super) fn behind(self, proxies: TrustedProxies) -> Self {
        Self { proxies, ..self }
    }

    /// Whether a request without a token is let in.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// How people sign in at the console; `None` if they cannot.
    #[cfg(feature = "oidc")]
    pub(in crate::http) fn sign_in(&self) -> Option<&SignIn> {
        self.sign_in.as_ref()
    }

    /// Whether any caller can be let in. A database that does not answer now may hold a valid token.
    pub async fn admits_anybody(&self, store: &Store, now_us: i64) -> bool {
        self.is_open
            || self.token.is_some()
            || self.oidc.is_some()
            || store.tokens(now_us).await.map_or(true, |tokens| {
                tokens.iter().any(|token| token.revoked_us.is_none() && token.expires_us > now_us)
            })
    }

    /// Reads a request's credential.
    fn credential(&self, request: &Parts) -> Result<Credential, Problem> {
        let Some(value) = request.headers.get(header::AUTHORIZATION) else {
            let cookie = self
                .sign_in
                .as_ref()
                .and_then(|sign_in| cookies::value(&request.headers, &cookies::SESSION, sign_in.site()));
            if let Some(cookie) = cookie {
                if !matches!(request.method, Method::GET | Method::HEAD) {
                    cookies::require_own_page(&request.headers)?;
                }
                return Ok(Credential::Session(Secret::new(cookie)));
            }
            return if self.is_open {
                origin::require_direct(request.version, &request.headers).map(|()| Credential::Nothing)
            } else {
                Err(Problem::new(Kind::Unauthenticated, "send a token: Authorization: Bearer vbr_..."))
            };
        };
        let bearer = value.to_str().ok().and_then(|value| value.split_once(' '));
        let bearer = bearer.filter(|(scheme, _)| scheme.eq_ignore_ascii_case("bearer")).map(|(_, token)| token.trim());
        let Some(bearer) = bearer else {
            return Err(Problem::new(Kind::Unauthenticated, "the header must be Authorization: Bearer TOKEN"));
        };
        Ok(Credential::Bearer(Secret::new(bearer)))
    }

    /// The caller of a request with this credential. Unknown credentials of one address have a limit.
    ///
    /// # Errors
    /// As [`Self::identify`], or there are too many.
    async fn identify_request(
        &self,
        store: &Store,
        request: &Parts,
        credential: &Credential,
    ) -> Result<Caller, Problem> {
        if self.hash_to_find(credential).is_some_and(|hash| !self.known.contains(&hash)) {
            self.guests.unknown(client(&self.proxies, request))?;
        }
        self.identify(store, credential).await
    }

    /// The hash of a credential that the database must have.
    fn hash_to_find(&self, credential: &Credential) -> Option<Hash> {
        match credential {
            Credential::Nothing => None,
            Credential::Session(cookie) => cookies::session_hash(cookie),
            Credential::Bearer(bearer) => {
                // Hashes are compared in constant time.
                let is_static = self.token.is_some_and(|known| known == blake3::hash(bearer.reveal().as_bytes()));
                token::parse(bearer.reveal()).filter(|_| !is_static).map(|(_, hash)| hash)
            }
        }
    }

    /// The caller that this credential identifies now.
    ///
    /// # Errors
    /// The token is unknown, expired or revoked; or the database or the identity provider does not answer.
    pub async fn identify(&self, store: &Store, credential: &Credential) -> Result<Caller, Problem> {
        let bearer = match credential {
            Credential::Nothing => return Ok(Caller::local()),
            Credential::Bearer(bearer) => bearer.reveal(),
            Credential::Session(cookie) => {
                let (sign_in, hash) =
                    self.sign_in.as_ref().zip(cookies::session_hash(cookie)).ok_or_else(cookies::session_ended)?;
                if !self.is_known(store, &hash).await? {
                    return Err(cookies::session_ended());
                }
                return sign_in.caller(store, cookie).await;
            }
        };
        // Hashes are compared in constant time.
        if self.token.is_some_and(|known| known == blake3::hash(bearer.as_bytes())) {
            return Ok(Caller::unlimited("token_file", Authentication::TokenFile));
        }
        if let Some(oidc) = self.oidc.as_ref().filter(|_| !token::is_ours(bearer)) {
            return oidc.caller(bearer).await;
        }
        let unknown = || Problem::new(Kind::Unauthenticated, "the token is unknown, expired or revoked");
        let (id, hash) = token::parse(bearer).ok_or_else(unknown)?;
        if !self.is_known(store, &hash).await? {
            return Err(unknown());
        }
        token::caller(store, id, &hash, wall_clock().0 as i64).await?.ok_or_else(unknown)
    }

    /// Whether a valid credential has this hash. The credential itself is still to be checked.
    async fn is_known(&self, store: &Store, hash: &Hash) -> Result<bool, Problem> {
        self.known.holds(hash, || store.credential_hashes(wall_clock().0 as i64, HASHES_MAX)).await
    }

    /// Counts a request that is refused, and returns the answer to it.
    fn refused(&self, request: &Parts, problem: Problem) -> Problem {
        if problem.kind != Kind::Unauthenticated {
            return problem;
        }
        self.guests.wrong(client(&self.proxies, request)).err().unwrap_or(problem)
    }

    /// Counts a request of an actor.
    ///
    /// # Errors
    /// There are too many.
    pub(crate) fn limit(&self, actor: &str) -> Result<(), Problem> {
        self.limiter.check_key(&actor.to_owned()).map_err(|_| {
            Problem::new(
                Kind::TooManyRequests,
                format!("more than {REQUESTS_PER_S} requests per second: wait a second, then send fewer"),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use axum::extract::Request;

    use super::*;
    use vibrissa_store::DatabaseAddress;

    #[tokio::test]
    async fn regress_beyond_the_limit_no_unknown_token_reaches_the_database() {
        let folder = std::env::temp_dir().join(format!("vibrissa-unknown-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let store = Store::open(&DatabaseAddress::Sqlite(folder.join("v.sqlite3")), "test").await.unwrap();
        store.prepare().await.unwrap();
        let access = Access::new(&AccessOptions::default(), std::net::Ipv4Addr::LOCALHOST.into());
        let request = Request::new(axum::body::Body::empty()).into_parts().0;
        let wrong: Vec<Credential> =
            (1000..4000).map(|number| Credential::Bearer(Secret::new(format!("vbr_1_{number}")))).collect();
        let asked = wrong.iter().map(|credential| access.identify_request(&store, &request, credential));
        let answers = futures_util::future::join_all(asked).await;
        let count = |kind| answers.iter().filter(|one| one.as_ref().is_err_and(|one| one.kind == kind)).count();
        let (refused, limited) = (count(Kind::Unauthenticated), count(Kind::TooManyRequests));
        assert!(refused + limited == 3000 && (1000..2000).contains(&refused), "{refused} and {limited}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
