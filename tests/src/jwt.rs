//! Tokens of an identity provider (RFC 7519), signed with ECDSA on P-256.

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use rcgen::KeyPair;
use ring::rand::SystemRandom;
use ring::signature::{ECDSA_P256_SHA256_FIXED_SIGNING, EcdsaKeyPair};
use serde_json::{Value, json};

/// A header with a key's ID.
#[must_use]
pub fn header(kid: &str) -> Value {
    json!({ "typ": "JWT", "alg": "ES256", "kid": kid })
}

/// The signed token of a header and claims.
///
/// # Panics
/// The key is not one of P-256.
#[must_use]
pub fn signed(header: &Value, claims: &Value, key: &KeyPair) -> String {
    let [header, claims] = [header, claims].map(|part| URL_SAFE_NO_PAD.encode(part.to_string()));
    let message = format!("{header}.{claims}");
    let random = SystemRandom::new();
    let key = EcdsaKeyPair::from_pkcs8(&ECDSA_P256_SHA256_FIXED_SIGNING, &key.serialize_der(), &random)
        .expect("rcgen's keys are of P-256");
    let signature = key.sign(&random, message.as_bytes()).expect("there is randomness");
    format!("{message}.{}", URL_SAFE_NO_PAD.encode(signature))
}
