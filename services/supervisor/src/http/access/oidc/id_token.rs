//! ID tokens: `openidconnect` checks them by the rules of OpenID Connect, and ring verifies their signatures.

use std::time::Duration;

use jsonwebtoken::jwk::{AlgorithmParameters, Jwk};
use jsonwebtoken::{Algorithm, DecodingKey};
use openidconnect::core::{
    CoreGenderClaim, CoreJsonWebKeyType, CoreJsonWebKeyUse, CoreJweContentEncryptionAlgorithm, CoreJwsSigningAlgorithm,
    CoreTokenType,
};
use openidconnect::{
    AccessToken, AccessTokenHash, AdditionalClaims, ClientId, EmptyExtraTokenFields, IdTokenFields, IdTokenVerifier,
    IssuerUrl, JsonWebKey, JsonWebKeyAlgorithm, JsonWebKeyId, JsonWebKeySet, NonceVerifier, SignatureVerificationError,
    StandardTokenResponse,
};
use ring::digest::{SHA256, SHA384, SHA512, digest};
use serde::{Deserialize, Serialize};

use super::access_token::{LEEWAY, Oidc};
use super::{refusal, signature};
use crate::http::problem::{Kind, Problem};
use vibrissa_edge::clock::wall_clock;

/// Claims that OpenID Connect does not name.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct MoreClaims {
    /// Time before which the token is not valid, s since 1970 UTC.
    nbf: Option<f64>,
}

impl AdditionalClaims for MoreClaims {}

/// An ID token.
pub(super) type IdToken =
    openidconnect::IdToken<MoreClaims, CoreGenderClaim, CoreJweContentEncryptionAlgorithm, CoreJwsSigningAlgorithm>;

/// The provider's answer to a code or a refresh token.
pub(super) type TokenResponse = StandardTokenResponse<
    IdTokenFields<
        MoreClaims,
        EmptyExtraTokenFields,
        CoreGenderClaim,
        CoreJweContentEncryptionAlgorithm,
        CoreJwsSigningAlgorithm,
    >,
    CoreTokenType,
>;

/// The subject of an ID token that the provider has issued to this client, together with the access token.
///
/// # Errors
/// The token breaks a rule of OpenID Connect Core 1.0 (3.1.3.7, 3.1.3.8), or the provider's keys are not available.
pub(super) async fn subject(
    oidc: &Oidc,
    client_id: &str,
    (token, access_token): (&IdToken, &AccessToken),
    nonce: impl NonceVerifier,
) -> Result<String, Problem> {
    let refused = |what: String| Problem::new(Kind::Unauthenticated, format!("the ID token is not accepted: {what}"));
    let (_, key) = oidc.key(&token.to_string()).await?;
    let issuer = IssuerUrl::new(oidc.issuer().to_owned()).map_err(|problem| refused(problem.to_string()))?;
    let keys = JsonWebKeySet::new(vec![VerifyingKey::new(key)]);
    let algorithm = token.signing_alg().map_err(|problem| refused(problem.to_string()))?;
    // Public, because this allows no signatures by the client's secret. `azp` decides about further audiences.
    let verifier = IdTokenVerifier::new_public_client(ClientId::new(client_id.to_owned()), issuer, keys)
        .set_allowed_algs([algorithm.clone()])
        .set_other_audience_verifier_fn(|_| true)
        .set_time_fn(|| (vibrissa_host::clock::system_time() - LEEWAY).into());
    let claims = token.claims(&verifier, nonce).map_err(|problem| refused(refusal::of_id_token(&problem)))?;
    match claims.authorized_party() {
        Some(party) if party.as_str() != client_id => {
            return Err(refused(format!(
                "it was issued to the client {:?}, not to {client_id:?} (azp)",
                party.as_str()
            )));
        }
        None if claims.audiences().len() > 1 => {
            return Err(refused(
                "it has several audiences, and names no client to which it was issued (azp)".to_owned(),
            ));
        }
        Some(_) | None => {}
    }
    let leeway_s = Duration::as_secs_f64(&LEEWAY);
    if claims.additional_claims().nbf.is_some_and(|nbf| nbf > wall_clock().as_s() + leeway_s) {
        return Err(refused("it is not valid yet (nbf)".to_owned()));
    }
    if let Some(claimed) = claims.access_token_hash() {
        let key = token.signing_key(&verifier).map_err(|problem| refused(problem.to_string()))?;
        let hash = AccessTokenHash::from_token(access_token, algorithm, key);
        if hash.map_err(|problem| refused(problem.to_string()))? != *claimed {
            return Err(refused("it belongs to another access token (at_hash)".to_owned()));
        }
    }
    Some(claims.subject().to_string())
        .filter(|subject| !subject.trim().is_empty())
        .ok_or_else(|| refused("it names nobody (sub)".to_owned()))
}

/// A key of the provider that was chosen for a token. Only ring verifies with it: its rules are in `signature`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct VerifyingKey {
    /// `None` for a shared secret, which verifies nothing.
    key: Option<Jwk>,
    kid: Option<JsonWebKeyId>,
    kind: CoreJsonWebKeyType,
}

impl VerifyingKey {
    fn new(key: Jwk) -> Self {
        let kind = match key.algorithm {
            AlgorithmParameters::RSA(_) => CoreJsonWebKeyType::RSA,
            AlgorithmParameters::EllipticCurve(_) => CoreJsonWebKeyType::EllipticCurve,
            AlgorithmParameters::OctetKeyPair(_) => CoreJsonWebKeyType::OctetKeyPair,
            // Neither a shared secret nor an unknown kind verifies anything.
            AlgorithmParameters::OctetKey(_) | AlgorithmParameters::Other(_) => CoreJsonWebKeyType::Symmetric,
            // The list may grow with versions of the library.
            _ => CoreJsonWebKeyType::Symmetric,
        };
        Self { kid: key.common.key_id.clone().map(JsonWebKeyId::new), key: Some(key), kind }
    }
}

/// The algorithm by the name that both libraries write: that of RFC 7518.
fn algorithm(name: &CoreJwsSigningAlgorithm) -> Option<Algorithm> {
    serde_json::from_value(serde_json::to_value(name).ok()?).ok()
}

impl JsonWebKey for VerifyingKey {
    type KeyUse = CoreJsonWebKeyUse;
    type SigningAlgorithm = CoreJwsSigningAlgorithm;

    fn key_id(&self) -> Option<&JsonWebKeyId> {
        self.kid.as_ref()
    }

    fn key_type(&self) -> &CoreJsonWebKeyType {
        &self.kind
    }

    // Use, operations and algorithm of the key were checked when it was chosen.
    fn key_use(&self) -> Option<&CoreJsonWebKeyUse> {
        None
    }

    fn signing_alg(&self) -> JsonWebKeyAlgorithm<&CoreJwsSigningAlgorithm> {
        JsonWebKeyAlgorithm::Unspecified
    }

    fn new_symmetric(_: Vec<u8>) -> Self {
        Self { key: None, kid: None, kind: CoreJsonWebKeyType::Symmetric }
    }

    fn verify_signature(
        &self,
        signing: &CoreJwsSigningAlgorithm,
        message: &[u8],
        signature: &[u8],
    ) -> Result<(), SignatureVerificationError> {
        let unfit = || SignatureVerificationError::InvalidKey("the key does not fit the algorithm".to_owned());
        let algorithm = algorithm(signing).ok_or_else(unfit)?;
        let key = self.key.as_ref().and_then(|key| DecodingKey::from_jwk(key).ok()).ok_or_else(unfit)?;
        let verifier = signature::verifier(&algorithm, &key).map_err(|_| unfit())?;
        let wrong = |_| SignatureVerificationError::CryptoError("the signature is wrong".to_owned());
        verifier.verify(message, &signature.to_vec()).map_err(wrong)
    }

    fn hash_bytes(&self, bytes: &[u8], signing: &CoreJwsSigningAlgorithm) -> Result<Vec<u8>, String> {
        let hash = match algorithm(signing) {
            Some(Algorithm::RS256 | Algorithm::PS256 | Algorithm::ES256) => &SHA256,
            Some(Algorithm::RS384 | Algorithm::PS384 | Algorithm::ES384) => &SHA384,
            Some(Algorithm::RS512 | Algorithm::PS512 | Algorithm::EdDSA) => &SHA512,
            Some(Algorithm::HS256 | Algorithm::HS384 | Algorithm::HS512) | None => {
                return Err("this algorithm is not accepted".to_owned());
            }
            // The list may grow with versions of the library.
            Some(_) => return Err("this algorithm is not known".to_owned()),
        };
        Ok(digest(hash, bytes).as_ref().to_vec())
    }
}
