//! Configured credentials and identity provider.

use vibrissa_store::secret::Secret;

/// Configured credentials, in addition to the tokens in the database.
#[derive(Debug, Clone, Default)]
pub struct AccessOptions {
    /// Static token with every right.
    pub token: Option<Secret>,
    /// Identity provider whose tokens are accepted.
    pub oidc: Option<OidcOptions>,
}

/// An accepted OpenID provider.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OidcOptions {
    /// Issuer: `iss` of its tokens, compared exactly.
    pub issuer: String,
    /// Audience: `aud` of its tokens.
    pub audience: String,
    /// URL of its keys; by default discovered from the issuer.
    pub jwks_url: Option<String>,
    /// Claim that holds the role.
    pub role_claim: String,
    /// Claim that holds the fleets as names and patterns; `*` means all.
    pub fleets_claim: String,
    /// How people sign in at the console; `None` if they cannot.
    pub sign_in: Option<SignInOptions>,
}

/// How people sign in at the console.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignInOptions {
    /// This service's identifier at the provider.
    pub client_id: String,
    /// Its secret; `None` for a public client.
    pub client_secret: Option<Secret>,
    /// Scopes to ask for besides `openid`.
    pub scopes: Vec<String>,
    /// Address at which browsers reach the console, without a slash at the end.
    pub public_url: String,
}
