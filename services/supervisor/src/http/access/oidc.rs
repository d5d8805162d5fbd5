//! Tokens of an OpenID provider: JWTs, checked against its keys, its name, our audience and the time.

use std::sync::Arc;

use jsonwebtoken::{Algorithm, Validation, decode, decode_header};
use serde_json::{Map, Value};
use vibrissa_protocol::Name;

use super::keys::Keys;
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
    keys: Keys,
}

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
        let keys = Keys::new(&options.issuer, options.jwks_url.as_deref());
        Self { options: Arc::new(options), keys }
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
        // Whoever does not understand an extension that is critical must refuse the token (RFC 7515, 4.1.11); none is
        // understood here.
        if let Some(critical) = &header.crit {
            return Err(refused(format!("the token needs extensions that are not known here: {critical:?}")));
        }
        let key = self.keys.key(header.kid.as_deref(), header.alg).await?;
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
}
