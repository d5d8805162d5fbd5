//! The identity provider: its access tokens (JWTs), and signing in at the console with it (OpenID Connect).

mod access_token;
mod claims;
mod fetch;
mod id_token;
mod keys;
mod provider;
mod refusal;
mod return_page;
mod session;
mod sign_in;
mod signature;
mod tokens;

pub(super) use self::access_token::Oidc;
pub(in crate::http) use self::session::SignIn;
pub(in crate::http) use self::sign_in::routes;
use super::OidcOptions;

/// The provider, and how people sign in with it; `None` for each that is not configured.
pub(super) fn configured(options: Option<&OidcOptions>) -> (Option<Oidc>, Option<SignIn>) {
    let Some(options) = options else { return (None, None) };
    let oidc = Oidc::new(options.clone());
    let sign_in = options.sign_in.as_ref().map(|sign_in| SignIn::new(&options.issuer, sign_in, oidc.clone()));
    (Some(oidc), sign_in)
}
