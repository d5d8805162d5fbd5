//! Tokens of an OpenID provider: JWTs, whose signature, issuer, audience and validity period are checked.

use std::sync::Arc;
use std::time::Duration;

use jsonwebtoken::jwk::Jwk;
use jsonwebtoken::{Algorithm, DecodingKey, Validation, decode, decode_header};
use serde_json::{Map, Value};
use vibrissa_edge::fleets::FleetPattern;

use super::claims::{self, subject};
use super::keys::Keys;
use super::refusal;
use super::signature::{self, ALGORITHMS};
use crate::http::access::OidcOptions;
use crate::http::access::{Authentication, Caller, Role, Scope};
use crate::http::problem::{Kind, Problem};

/// A provider with its keys as of the last fetch.
#[derive(Debug, Clone)]
pub(in crate::http) struct Oidc {
    options: Arc<OidcOptions>,
    keys: Keys,
}

/// Clocks may differ by this much.
pub(super) const LEEWAY: Duration = Duration::from_secs(60);

/// Standard claims that hold a person's name, the best first. The subject stands in for a missing name.
const NAME_CLAIMS: [&str; 3] = ["name", "preferred_username", "email"];

impl Oidc {
    /// A provider; no request is sent to it yet.
    #[must_use]
    pub(in crate::http) fn new(options: OidcOptions) -> Self {
        signature::install();
        let keys = Keys::new(&options.issuer, options.jwks_url.as_deref());
        Self { options: Arc::new(options), keys }
    }

    /// Issuer of the tokens.
    pub(super) fn issuer(&self) -> &str {
        &self.options.issuer
    }

    /// The caller that an access token identifies.
    ///
    /// # Errors
    /// The token is invalid or carries no role, or the provider does not answer.
    pub(in crate::http) async fn caller(&self, token: &str) -> Result<Caller, Problem> {
        self.allowed(&self.verified(token).await?)
    }

    /// Algorithm of a token's signature, and the provider's key for it.
    ///
    /// # Errors
    /// The token is no JWT, or is signed in a way that is not accepted, or the provider does not answer.
    pub(super) async fn key(&self, token: &str) -> Result<(Algorithm, Jwk), Problem> {
        let header = decode_header(token)
            .map_err(|problem| refused(format!("the token is not a JWT: {}", refusal::of_header(&problem))))?;
        if !ALGORITHMS.contains(&header.alg) {
            let accepted = refusal::algorithms();
            return Err(refused(format!(
                "tokens signed with {:?} are not accepted: let the provider sign with one of {accepted}",
                header.alg
            )));
        }
        // A token with a critical extension must be refused by whoever does not support it (RFC 7515, 4.1.11). No
        // extension is supported here.
        if let Some(critical) = &header.crit {
            return Err(refused(format!("the token requires unsupported extensions: {critical:?}")));
        }
        Ok((header.alg, self.keys.key(header.kid.as_deref(), header.alg).await?))
    }

    /// The claims of an access token, once signature, issuer, audience, validity period and subject are checked.
    ///
    /// # Errors
    /// The token is invalid, or the provider does not answer.
    pub(super) async fn verified(&self, token: &str) -> Result<Map<String, Value>, Problem> {
        let (algorithm, key) = self.key(token).await?;
        let key = DecodingKey::from_jwk(&key).map_err(|_| refused("the provider's key is damaged".to_owned()))?;
        let mut validation = Validation::new(algorithm);
        validation.set_issuer(&[&self.options.issuer]);
        validation.set_audience(&[&self.options.audience]);
        validation.set_required_spec_claims(&["exp", "iss", "aud", "sub"]);
        validation.validate_nbf = true;
        validation.leeway = LEEWAY.as_secs();
        let claims =
            decode::<Map<String, Value>>(token, &key, &validation).map(|token| token.claims).map_err(|problem| {
                let why = refusal::of_token(&problem, claims::unverified(token).as_ref(), &self.options);
                refused(format!("the token is not accepted: {why}"))
            })?;
        if subject(&claims).is_none() {
            return Err(refused("the token is not accepted: it names nobody (sub)".to_owned()));
        }
        Ok(claims)
    }

    /// The caller described by the claims.
    pub(super) fn allowed(&self, claims: &Map<String, Value>) -> Result<Caller, Problem> {
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
                format!("the token's claim {role_claim:?} contains no role (viewer, operator, engineer or admin)"),
            )
        })?;
        let scope = Scope::of(texts(fleets_claim).into_iter().filter_map(|fleet| FleetPattern::new(fleet).ok()));
        let text = |claim: &str| claims.get(claim).and_then(Value::as_str).filter(|text| !text.trim().is_empty());
        let subject = subject(claims).unwrap_or_default();
        let name = NAME_CLAIMS.into_iter().find_map(text).unwrap_or(subject).to_owned();
        let expires_us = claims.get("exp").and_then(Value::as_f64).map(|expires_s| (expires_s * 1e6) as i64);
        let (actor, authentication) = (actor(&name, subject), Authentication::Oidc);
        Ok(Caller { name, actor, role, scope, authentication, expires_us })
    }
}

fn refused(what: String) -> Problem {
    Problem::new(Kind::Unauthenticated, what)
}

/// Maximum length of a person's name in the audit log, in characters.
const NAME_CHARS_MAX: usize = 100;

/// Name of a person in the audit log: `oidc:NAME#SUBJECT`, or `oidc:SUBJECT` without a name. Names may change and need not
/// be unique; the subject tells people apart. It follows the first `#`: a name loses its own.
fn actor(name: &str, subject: &str) -> String {
    if name == subject && !subject.contains('#') {
        return format!("oidc:{subject}");
    }
    let name = name.chars().filter(|one| !one.is_control()).take(NAME_CHARS_MAX);
    format!("oidc:{}#{subject}", name.collect::<String>().replace('#', "_"))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The subject in a person's name in the audit log.
    fn subject_of(actor: &str) -> &str {
        let subject_of = actor.strip_prefix("oidc:").unwrap();
        subject_of.split_once('#').map_or(subject_of, |(_, subject)| subject)
    }

    #[test]
    fn regress_people_with_similar_subjects_are_different_actors() {
        // The same name in the audit log before.
        assert_ne!(actor("x#a", "b"), actor("x", "a#b"));
        assert_ne!(actor("a", "b"), actor("a#b", "a#b"));
        assert_eq!(actor("Ann B.", "17"), "oidc:Ann B.#17");
        assert_eq!(actor("ann", "ann"), "oidc:ann");
    }

    proptest! {
        #[test]
        fn property_an_actor_tells_the_subject(name in "[ab#]{0,4}", subject in "[ab#]{1,4}") {
            let actor = actor(&name, &subject);
            prop_assert_eq!(subject_of(&actor), subject);
        }
    }
}
