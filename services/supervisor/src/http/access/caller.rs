//! An authenticated caller, and the credential by which it was authenticated.

use serde::Serialize;
use utoipa::ToSchema;

use super::role::Role;
use super::scope::Scope;
use vibrissa_store::secret::Secret;

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
    pub(super) fn unlimited(name: &str, authentication: Authentication) -> Self {
        let (name, actor) = (name.to_owned(), name.to_owned());
        Self { name, actor, role: Role::Admin, scope: Scope::All, authentication, expires_us: None }
    }
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
