//! Who asks, and whether they may: tokens of our own, an identity provider's, or nobody needed on loopback.

pub mod monitoring;
pub mod oidc;
pub mod token;

use std::collections::BTreeSet;
use std::net::IpAddr;
use std::num::NonZeroU32;
use std::sync::Arc;

use axum::extract::{MatchedPath, RawPathParams, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, Method, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vibrissa_protocol::Name;

use self::oidc::{Oidc, OidcOptions};
use super::problem::{Kind, Problem};
use crate::engine::wall_clock;
use crate::secret::Secret;
use crate::store::Store;
use crate::store::list::Filter;

/// What somebody may do: each role has the rights of those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema, clap::ValueEnum)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Role {
    /// Looks.
    Viewer,
    /// Acts on whiskers and alarms: approves, holds, sets pressures.
    Operator,
    /// Changes what decisions rest on: policy and calibrations.
    Engineer,
    /// Makes and revokes tokens.
    Admin,
}

impl Role {
    /// All of them, the least first.
    pub const ALL: [Self; 4] = [Self::Viewer, Self::Operator, Self::Engineer, Self::Admin];

    /// In the words of the database and of JSON.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Viewer => "VIEWER",
            Self::Operator => "OPERATOR",
            Self::Engineer => "ENGINEER",
            Self::Admin => "ADMIN",
        }
    }

    /// The role of that word.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.word() == word)
    }
}

/// The fleets that somebody may see.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scope {
    /// Every one.
    All,
    /// These.
    Only(BTreeSet<Name>),
}

impl Scope {
    /// Whether it has the fleet.
    #[must_use]
    pub fn covers(&self, fleet: &str) -> bool {
        match self {
            Self::All => true,
            Self::Only(fleets) => fleets.contains(fleet),
        }
    }

    /// Keeps to its fleets a list that has a column of that name.
    #[must_use]
    pub fn filter(&self, column: &'static str) -> Option<Filter> {
        match self {
            Self::All => None,
            Self::Only(fleets) => {
                Some(Filter::IsOneOf(column, fleets.iter().map(|fleet| fleet.as_str().to_owned()).collect()))
            }
        }
    }
}

/// Somebody who was let in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Caller {
    /// As the audit log names them: `token:NAME`, `oidc:SUBJECT`, or `local`.
    pub actor: String,
    /// What they may do.
    pub role: Role,
    /// Where.
    pub scope: Scope,
}

impl Caller {
    /// Who asks on loopback where no token is asked for: whoever is on this machine.
    #[must_use]
    pub fn local() -> Self {
        Self { actor: "local".to_owned(), role: Role::Admin, scope: Scope::All }
    }
}

/// Who is let in, besides those whose tokens the database has.
#[derive(Debug, Clone, Default)]
pub struct AccessOptions {
    /// A token with every right.
    pub token: Option<Secret>,
    /// An identity provider.
    pub oidc: Option<OidcOptions>,
}

/// The right to be let in.
#[derive(Debug, Clone)]
pub struct Access {
    /// Whether a request without a token is let in, as [`Caller::local`].
    is_open: bool,
    /// Whether only this machine reaches the listener.
    is_loopback: bool,
    /// Hash of the token with every right.
    token: Option<blake3::Hash>,
    oidc: Option<Oidc>,
    limiter: Arc<DefaultKeyedRateLimiter<String>>,
}

/// Requests of one caller a second, on average.
pub const REQUESTS_PER_S: NonZeroU32 = NonZeroU32::new(200).unwrap();
/// Requests of one caller at once.
pub const REQUESTS_BURST: NonZeroU32 = NonZeroU32::new(1000).unwrap();

impl Access {
    /// Access to a service that listens there: on loopback nobody is asked for a token, unless options name one.
    #[must_use]
    pub fn new(options: &AccessOptions, listens: IpAddr) -> Self {
        let quota = Quota::per_second(REQUESTS_PER_S).allow_burst(REQUESTS_BURST);
        Self {
            is_open: listens.is_loopback() && options.token.is_none() && options.oidc.is_none(),
            is_loopback: listens.is_loopback(),
            token: options.token.as_ref().map(|token| blake3::hash(token.reveal().as_bytes())),
            oidc: options.oidc.clone().map(Oidc::new),
            limiter: Arc::new(RateLimiter::keyed(quota)),
        }
    }

    /// Whether anybody can be let in at all; a database that does not answer now may know somebody.
    pub async fn admits_anybody(&self, store: &Store, now_us: i64) -> bool {
        self.is_open
            || self.token.is_some()
            || self.oidc.is_some()
            || store.tokens().await.map_or(true, |tokens| {
                tokens.iter().any(|token| token.revoked_us.is_none() && token.expires_us > now_us)
            })
    }

    async fn caller(&self, store: &Store, headers: &HeaderMap) -> Result<Caller, Problem> {
        let Some(told) = headers.get(header::AUTHORIZATION) else {
            return if self.is_open {
                require_direct(headers)?;
                Ok(Caller::local())
            } else {
                Err(Problem::new(Kind::Unauthenticated, "send a token: Authorization: Bearer vbr_..."))
            };
        };
        let bearer = told.to_str().ok().and_then(|told| told.split_once(' '));
        let bearer = bearer.filter(|(scheme, _)| scheme.eq_ignore_ascii_case("bearer")).map(|(_, token)| token.trim());
        let Some(bearer) = bearer else {
            return Err(Problem::new(Kind::Unauthenticated, "the header must be Authorization: Bearer TOKEN"));
        };
        self.bearer(store, bearer).await
    }

    async fn bearer(&self, store: &Store, bearer: &str) -> Result<Caller, Problem> {
        // Hashes are compared in constant time.
        if self.token.is_some_and(|known| known == blake3::hash(bearer.as_bytes())) {
            return Ok(Caller { actor: "token_file".to_owned(), role: Role::Admin, scope: Scope::All });
        }
        if let Some(oidc) = self.oidc.as_ref().filter(|_| !token::is_ours(bearer)) {
            return oidc.caller(bearer).await;
        }
        token::caller(store, bearer, wall_clock().0 as i64)
            .await?
            .ok_or_else(|| Problem::new(Kind::Unauthenticated, "the token is not known, has expired, or was revoked"))
    }

    fn limit(&self, actor: &str) -> Result<(), Problem> {
        self.limiter.check_key(&actor.to_owned()).map_err(|_| {
            Problem::new(
                Kind::TooManyRequests,
                format!("more than {REQUESTS_PER_S} requests a second: wait a second, and ask less often"),
            )
        })
    }
}

/// Without a token only a browser or program that was pointed at this machine by name is let in: a page of
/// another site cannot reach it through a name of its own that leads here, nor can whoever comes through a proxy.
fn require_direct(headers: &HeaderMap) -> Result<(), Problem> {
    if ["forwarded", "x-forwarded-for", "x-real-ip"].iter().any(|name| headers.contains_key(*name)) {
        return Err(Problem::new(
            Kind::Unauthenticated,
            "the request came through a proxy, and without tokens only this machine is answered: set http.token_file \
             or http.oidc_issuer",
        ));
    }
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    let name = host.rsplit_once(':').filter(|(_, port)| port.bytes().all(|byte| byte.is_ascii_digit()));
    let name = name.map_or(host, |(name, _)| name).trim_start_matches('[').trim_end_matches(']');
    let is_local = name == "localhost" || name.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback());
    if is_local {
        return Ok(());
    }
    Err(Problem::new(
        Kind::CrossSite,
        format!("without a token only localhost and loopback addresses are answered, not {name:?}: make a token"),
    ))
}

/// A page of another site may not act through the browser of somebody who can.
fn require_same_site(method: &Method, headers: &HeaderMap) -> Result<(), Problem> {
    if matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS) {
        return Ok(());
    }
    let text = |name| headers.get(name).and_then(|value: &axum::http::HeaderValue| value.to_str().ok());
    let site = text(header::HeaderName::from_static("sec-fetch-site"));
    let foreign_site = site.is_some_and(|site| !matches!(site, "same-origin" | "none"));
    let foreign_origin = match (text(header::ORIGIN), text(header::HOST)) {
        (Some(origin), Some(host)) => origin.split_once("://").is_none_or(|(_, from)| from != host),
        (Some(_), None) => true,
        (None, _) => false,
    };
    if foreign_site || foreign_origin {
        return Err(Problem::new(Kind::CrossSite, "the request comes from another site's page"));
    }
    Ok(())
}

/// What the check of a request needs.
#[derive(Debug, Clone)]
pub struct Gate {
    /// Where tokens are.
    pub store: Store,
    /// Whether they are asked for.
    pub access: Access,
    /// Which role each route asks for.
    pub roles: Arc<super::document::Roles>,
}

/// Lets a request in whose caller may do what the route does, in the fleet that its path names.
pub async fn check(State(gate): State<Gate>, params: RawPathParams, request: Request, next: Next) -> Response {
    let (mut parts, body) = request.into_parts();
    match admit(&gate, &params, &parts).await {
        Ok(caller) => {
            parts.extensions.insert(caller);
            next.run(Request::from_parts(parts, body)).await
        }
        Err(problem) => problem.into_response(),
    }
}

async fn admit(gate: &Gate, params: &RawPathParams, request: &Parts) -> Result<Caller, Problem> {
    require_same_site(&request.method, &request.headers)?;
    let caller = match gate.access.caller(&gate.store, &request.headers).await {
        Ok(caller) => caller,
        // Nor may anybody guess without end.
        Err(problem) => return Err(gate.access.limit("nobody").err().unwrap_or(problem)),
    };
    gate.access.limit(&caller.actor)?;
    let path = request.extensions.get::<MatchedPath>().map(MatchedPath::as_str).unwrap_or_default();
    // A method that the route does not know is answered by the router.
    let Some(needed) = gate.roles.needed(&request.method, path) else { return Ok(caller) };
    if caller.role < needed {
        return Err(Problem::new(
            Kind::Forbidden,
            format!("this needs the role {}; your token has {}", needed.word(), caller.role.word()),
        ));
    }
    let fleet = params.iter().find(|(name, _)| *name == "fleet").map(|(_, fleet)| fleet);
    if let Some(fleet) = fleet.filter(|fleet| !caller.scope.covers(fleet)) {
        return Err(Problem::new(Kind::Forbidden, format!("your token does not cover the fleet {fleet:?}")));
    }
    Ok(caller)
}
