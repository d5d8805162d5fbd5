//! Stands in for the module `oidc` in a build without the feature `oidc`: the same names, and no identity provider. The
//! configuration refuses one. [`Oidc`] and [`SignIn`] have no value, so none of their methods ever runs.

use axum::Router;
use axum::response::Json;
use axum::routing::get;
use serde_json::json;
use vibrissa_store::Store;
use vibrissa_store::secret::Secret;

use super::cookies::Site;
use super::{Caller, OidcOptions};
use crate::http::App;
use crate::http::problem::Problem;

/// An identity provider, which does not exist.
#[derive(Debug, Clone, Copy)]
pub(super) enum Oidc {}

/// The way to sign in, which does not exist.
#[derive(Debug, Clone, Copy)]
pub(in crate::http) enum SignIn {}

/// Nothing, whatever is configured.
pub(super) fn configured(_: Option<&OidcOptions>) -> (Option<Oidc>, Option<SignIn>) {
    (None, None)
}

#[expect(clippy::unused_async, reason = "as in the module that this one stands in for")]
impl Oidc {
    pub(super) async fn caller(&self, _: &str) -> Result<Caller, Problem> {
        match *self {}
    }
}

#[expect(clippy::unused_async, reason = "as in the module that this one stands in for")]
impl SignIn {
    pub(super) fn site(&self) -> &Site {
        match *self {}
    }

    pub(super) async fn caller(&self, _: &Store, _: &Secret) -> Result<Caller, Problem> {
        match *self {}
    }
}

/// The console learns that nobody can sign in.
pub(in crate::http) fn routes() -> Router<App> {
    Router::new().route("/auth/options", get(async || Json(json!({ "sign_in": false }))))
}
