//! Authentication and authorisation: tokens of this service or of an identity provider, or no token on loopback.

pub mod cookies;
mod fetch;
pub(super) mod guests;
mod id_token;
mod keys;
mod known;
pub mod monitoring;
pub mod oidc;
pub mod origin;
pub mod provider;
mod refusal;
pub mod return_page;
pub mod session;
mod signature;
pub mod token;
mod tokens;

use std::collections::BTreeSet;
use std::net::IpAddr;
use std::num::NonZeroU32;
use std::sync::Arc;

use axum::extract::{MatchedPath, RawPathParams, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderValue, Method, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use self::guests::{Guests, client};
use self::known::{HASHES_MAX, Hash, Known};
use self::monitoring::Monitors;
use self::oidc::{Oidc, OidcOptions};
use self::session::SignIn;
use super::client_address::TrustedProxies;
use super::document::Need;
use super::problem::{Kind, Problem};
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::fleets::FleetPattern;
use vibrissa_store::Store;
use vibrissa_store::list::Filter;
use vibrissa_store::secret::Secret;

/// Role of a caller; each role includes the rights of those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Role {
    /// Reads all data of its fleets.
    Viewer,
    /// Acts on whiskers and alarms: approves, holds, sets pressures.
    Operator,
    /// Changes policies, calibrations and allow lists.
    Engineer,
    /// Has every right.
    Admin,
}

impl Role {
    /// All roles, in ascending order of rights.
    pub const ALL: [Self; 4] = [Self::Viewer, Self::Operator, Self::Engineer, Self::Admin];

    /// Name of the role in the database and in JSON.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Viewer => "VIEWER",
            Self::Operator => "OPERATOR",
            Self::Engineer => "ENGINEER",
            Self::Admin => "ADMIN",
        }
    }

    /// The role with this name; `None` if the name is unknown.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.word() == word)
    }
}

/// Fleets that a caller may access.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scope {
    /// Every fleet, including future ones.
    All,
    /// The fleets of these names and patterns only. A pattern includes future fleets that match it.
    Only(BTreeSet<FleetPattern>),
}

impl Scope {
    /// The fleets of these names and patterns. The pattern `*` is every fleet.
    #[must_use]
    pub fn of(fleets: impl IntoIterator<Item = FleetPattern>) -> Self {
        let fleets: BTreeSet<_> = fleets.into_iter().collect();
        if fleets.iter().any(FleetPattern::is_all) { Self::All } else { Self::Only(fleets) }
    }

    /// Whether the scope includes the fleet.
    #[must_use]
    pub fn covers(&self, fleet: &str) -> bool {
        match self {
            Self::All => true,
            Self::Only(fleets) => fleets.iter().any(|one| one.matches(fleet)),
        }
    }

    /// Whether one name or pattern of the scope includes all fleets that this one matches, also future ones.
    #[must_use]
    pub fn includes(&self, fleets: &FleetPattern) -> bool {
        match self {
            Self::All => true,
            Self::Only(own) => own.iter().any(|one| one.includes(fleets)),
        }
    }

    /// Limits a list to these fleets by the column of that name; `None` for all fleets.
    #[must_use]
    pub fn filter(&self, column: &'static str) -> Option<Filter> {
        match self {
            Self::All => None,
            Self::Only(fleets) => Some(Filter::fleets(column, fleets)),
        }
    }
}

/// How a caller was authenticated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Authentication {
    /// By a direct request on loopback, without a token.
    Loopback,
    /// By the token in the supervisor's token file.
    TokenFile,
    /// By a token of the supervisor's database.
    Token,
    /// By a token of the identity provider.
    Oidc,
    /// By a session of the console, after signing in with the identity provider.
    Session,
}

/// An authenticated caller.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Caller {
    /// Name for people: that of the token or of the person; it need not be unique.
    pub name: String,
    /// Name in the audit log: `token:NAME#ID`, `oidc:NAME#SUBJECT`, `token_file`, or `local`. It is unique, because
    /// idempotency keys, the rate limit and the limit of event streams are per actor.
    pub actor: String,
    /// Rights of the caller.
    pub role: Role,
    /// Fleets that the caller may access.
    pub scope: Scope,
    /// How the caller was authenticated.
    pub authentication: Authentication,
    /// Expiry of the caller's token, µs since 1970 UTC; `None` without expiry.
    pub expires_us: Option<i64>,
}

impl Caller {
    /// The caller of a request without a token on loopback: any user of this machine.
    #[must_use]
    pub fn local() -> Self {
        Self::unlimited("local", Authentication::Loopback)
    }

    /// A caller with every right, whose name is also its actor.
    fn unlimited(name: &str, authentication: Authentication) -> Self {
        let (name, actor) = (name.to_owned(), name.to_owned());
        Self { name, actor, role: Role::Admin, scope: Scope::All, authentication, expires_us: None }
    }
}

/// Configured credentials, in addition to the tokens in the database.
#[derive(Debug, Clone, Default)]
pub struct AccessOptions {
    /// Static token with every right.
    pub token: Option<Secret>,
    /// Identity provider whose tokens are accepted.
    pub oidc: Option<OidcOptions>,
}

/// A caller's credential. An event stream keeps it to identify the caller again.
#[derive(Debug, Clone)]
pub enum Credential {
    /// No credential: a direct request on loopback, where no token is required.
    Nothing,
    /// A bearer token.
    Bearer(Secret),
    /// The cookie of a session.
    Session(Secret),
}

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
        let oidc = options.oidc.clone().map(Oidc::new);
        let sign_in = options.oidc.as_ref().zip(oidc.clone()).and_then(|(options, oidc)| {
            options.sign_in.as_ref().map(|sign_in| SignIn::new(&options.issuer, sign_in, oidc))
        });
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
    #[must_use]
    pub fn sign_in(&self) -> Option<&SignIn> {
        self.sign_in.as_ref()
    }

    /// Whether any caller can be let in. A database that does not answer now may hold a valid token.
    pub async fn admits_anybody(&self, store: &Store, now_us: i64) -> bool {
        self.is_open
            || self.token.is_some()
            || self.oidc.is_some()
            || store.tokens().await.map_or(true, |tokens| {
                tokens.iter().any(|token| token.revoked_us.is_none() && token.expires_us > now_us)
            })
    }

    /// Reads a request's credential.
    fn credential(&self, request: &Parts) -> Result<Credential, Problem> {
        let Some(told) = request.headers.get(header::AUTHORIZATION) else {
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
        let bearer = told.to_str().ok().and_then(|told| told.split_once(' '));
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
            Credential::Session(cookie) => session::hash(cookie),
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
                let (sign_in, hash) = self.sign_in.as_ref().zip(session::hash(cookie)).ok_or_else(session::ended)?;
                if !self.is_known(store, &hash).await? {
                    return Err(session::ended());
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

/// State of the access check.
#[derive(Debug, Clone)]
pub struct Gate {
    /// Database of the tokens.
    pub store: Store,
    /// Decides who is let in.
    pub access: Access,
    /// Role that each route requires.
    pub roles: Arc<super::document::Roles>,
}

/// Lets a request pass if the caller's role allows the route and the caller's scope covers the fleet in the path.
pub async fn check(State(gate): State<Gate>, params: RawPathParams, request: Request, next: Next) -> Response {
    let (mut parts, body) = request.into_parts();
    let path = parts.extensions.get::<MatchedPath>().cloned();
    let path = path.as_ref().map(MatchedPath::as_str).unwrap_or_default();
    match admit(&gate, &params, &parts, path).await {
        Ok((caller, credential)) => {
            parts.extensions.insert(caller);
            parts.extensions.insert(credential);
            next.run(Request::from_parts(parts, body)).await
        }
        Err(problem) => {
            let is_method = problem.kind == Kind::MethodNotAllowed;
            let mut response = problem.into_response();
            let allowed = HeaderValue::from_str(&gate.roles.methods(path).join(","));
            if let (true, Ok(allowed)) = (is_method, allowed) {
                response.headers_mut().insert(header::ALLOW, allowed);
            }
            response
        }
    }
}

async fn admit(
    gate: &Gate,
    params: &RawPathParams,
    request: &Parts,
    path: &str,
) -> Result<(Caller, Credential), Problem> {
    let identified = async {
        let credential = gate.access.credential(request)?;
        Ok((gate.access.identify_request(&gate.store, request, &credential).await?, credential))
    };
    let (caller, credential) = match identified.await {
        Ok(identified) => identified,
        Err(problem) => return Err(gate.access.refused(request, problem)),
    };
    gate.access.limit(&caller.actor)?;
    let needed = match gate.roles.needed(&request.method, path) {
        Need::Role(role) => role,
        Need::NoSuchMethod => {
            return Err(Problem::new(
                Kind::MethodNotAllowed,
                "this path does not support the method; see /openapi.json",
            ));
        }
        Need::Undeclared => {
            tracing::error!(path, "refusing a request: the route declares no role");
            return Err(Problem::new(Kind::Forbidden, "this route is closed because it declares no role"));
        }
    };
    if caller.role < needed {
        return Err(Problem::new(
            Kind::Forbidden,
            format!("this requires the role {}; your token has {}", needed.word(), caller.role.word()),
        ));
    }
    let fleet = params.iter().find(|(name, _)| *name == "fleet").map(|(_, fleet)| fleet);
    if let Some(fleet) = fleet.filter(|fleet| !caller.scope.covers(fleet)) {
        return Err(Problem::new(Kind::Forbidden, format!("your token does not cover the fleet {fleet:?}")));
    }
    Ok((caller, credential))
}

#[cfg(test)]
mod tests {
    use axum::Router;
    use axum::middleware::{from_fn, from_fn_with_state};
    use axum::routing::{any, get};
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
    use tokio::net::{TcpListener, TcpStream};

    use super::super::document;
    use super::*;
    use vibrissa_store::DatabaseAddress;

    #[test]
    fn a_scope_gives_no_more_than_it_has() {
        let scope = |fleets: &[&str]| Scope::of(fleets.iter().map(|fleet| FleetPattern::new(fleet).unwrap()));
        let may_give = |own: &[&str], given| scope(own).includes(&FleetPattern::new(given).unwrap());
        assert!(may_give(&["hall-*"], "hall-*") && may_give(&["hall-*"], "hall-1*") && may_give(&["hall-*"], "hall-7"));
        assert!(!may_give(&["hall-*"], "hall*") && !may_give(&["hall-*"], "*") && !may_give(&["hall-1"], "hall-*"));
        assert!(may_give(&["lab", "h*"], "hall-*") && !may_give(&[], "lab") && may_give(&["*"], "*"));
        assert_eq!((scope(&["lab", "*"]), scope(&[]).covers("lab")), (Scope::All, false));
        assert!(scope(&["hall-*"]).covers("hall-9") && !scope(&["hall-*"]).covers("hall-*"));
    }

    /// Statuses of requests to a router whose document declares `GET /v1/told` only.
    async fn statuses(requests: &[(&str, &str)]) -> Vec<u16> {
        let folder = std::env::temp_dir().join(format!("vibrissa-access-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let store = Store::open(&DatabaseAddress::Sqlite(folder.join("v.sqlite3")), "test").await.unwrap();
        let mut told = document::base();
        let item: utoipa::openapi::PathItem =
            serde_json::from_value(serde_json::json!({ "get": { "responses": {} } })).unwrap();
        told.paths.paths.insert("/v1/told".to_owned(), item);
        let roles = Arc::new(document::Roles::of(&mut told));
        let access = Access::new(&AccessOptions::default(), std::net::Ipv4Addr::LOCALHOST.into());
        let router = Router::new()
            .route("/v1/told", get(async || "told").post(async || "not told"))
            .route("/v1/not-told", any(async || "not told"))
            .route_layer(from_fn_with_state(Gate { store, access, roles }, check))
            .layer(from_fn(origin::refuse_other_sites));
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let serving = tokio::spawn(async move { axum::serve(listener, router).await });
        let mut statuses = Vec::new();
        for (method, path) in requests {
            let mut stream = TcpStream::connect(address).await.unwrap();
            let request = format!("{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
            stream.write_all(request.as_bytes()).await.unwrap();
            let mut answer = String::new();
            stream.read_to_string(&mut answer).await.unwrap();
            statuses.push(answer.split(' ').nth(1).unwrap().parse().unwrap());
        }
        serving.abort();
        std::fs::remove_dir_all(&folder).unwrap();
        statuses
    }

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

    #[tokio::test]
    async fn regress_a_route_or_method_without_a_role_is_closed_to_everybody() {
        let requests = [
            ("GET", "/v1/told"),
            ("HEAD", "/v1/told"),
            ("POST", "/v1/told"),
            ("GET", "/v1/not-told"),
            ("POST", "/v1/not-told"),
        ];
        assert_eq!(statuses(&requests).await, [200, 200, 405, 403, 403]);
    }
}
