//! Claims of a provider's tokens.

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde_json::{Map, Value};
use vibrissa_edge::clock::wall_clock;

/// Tokens that expire within this time are renewed, s.
const RENEWED_BEFORE_S: f64 = 20.0;

/// The person whom claims are about, by the provider's own name for it. It is compared exactly.
pub(super) fn subject(claims: &Map<String, Value>) -> Option<&str> {
    claims.get("sub").and_then(Value::as_str).filter(|subject| !subject.trim().is_empty())
}

/// The nonce of an ID token whose signature is verified elsewhere.
pub(super) fn nonce(id_token: &str) -> Option<String> {
    unverified(id_token)?.get("nonce").and_then(Value::as_str).map(ToOwned::to_owned)
}

/// The claims of a token whose signature is verified elsewhere.
pub(super) fn unverified(token: &str) -> Option<Map<String, Value>> {
    let claims = URL_SAFE_NO_PAD.decode(token.split('.').nth(1)?).ok()?;
    serde_json::from_slice(&claims).ok()
}

/// Whether a token expires soon, by its own claim.
pub(super) fn is_stale(token: &str) -> bool {
    let expires_s = unverified(token).and_then(|claims| claims.get("exp").and_then(Value::as_f64));
    expires_s.is_none_or(|expires_s| expires_s - wall_clock().as_s() < RENEWED_BEFORE_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_renewed_before_it_expires() {
        let token = |expires_s: f64| {
            let claims = serde_json::json!({ "exp": expires_s }).to_string();
            format!("e30.{}.x", URL_SAFE_NO_PAD.encode(claims))
        };
        let now_s = wall_clock().as_s();
        assert!(is_stale(&token(now_s + 10.0)) && is_stale(&token(now_s - 5.0)) && is_stale("not a token"));
        assert!(!is_stale(&token(now_s + 60.0)));
    }
}
