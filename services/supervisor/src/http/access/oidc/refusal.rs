//! Why a token is refused, with the values that differ and what to do: the errors of `jsonwebtoken` and `openidconnect`.

use jsonwebtoken::errors::{Error, ErrorKind};
use openidconnect::{ClaimsVerificationError, SignatureVerificationError};
use serde_json::{Map, Value};

use super::signature::ALGORITHMS;
use crate::http::access::OidcOptions;

const DAMAGED: &str =
    "it is damaged: a JWT has three parts in base64url, separated by dots, with JSON in the first two";
const FORGED: &str = "its signature is wrong: it was changed, or another provider has signed it";

/// The accepted algorithms, as a list.
pub(super) fn algorithms() -> String {
    ALGORITHMS.map(|algorithm| format!("{algorithm:?}")).join(", ")
}

/// Why a header cannot be read.
pub(super) fn of_header(problem: &Error) -> String {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others are about damage")]
    match problem.kind() {
        ErrorKind::Json(cause) if cause.to_string().contains("unknown variant") => {
            format!("its algorithm (alg) is not accepted: let the provider sign with one of {}", algorithms())
        }
        _ => DAMAGED.to_owned(),
    }
}

/// Why an access token with these claims is refused.
pub(super) fn of_token(problem: &Error, claims: Option<&Map<String, Value>>, options: &OidcOptions) -> String {
    let claimed =
        |claim: &str| claims.and_then(|claims| claims.get(claim)).map_or("missing".to_owned(), Value::to_string);
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the library's errors: the others are about keys and algorithms"
    )]
    match problem.kind() {
        ErrorKind::InvalidIssuer => format!(
            "its issuer (iss) is {}, and http.oidc_issuer is {:?}: both must be equal to the last character",
            claimed("iss"),
            options.issuer
        ),
        ErrorKind::InvalidAudience => format!(
            "its audience (aud) is {}, and http.oidc_audience is {:?}: let the provider name it, or correct the setting",
            claimed("aud"),
            options.audience
        ),
        ErrorKind::ExpiredSignature => {
            "it has expired (exp): get a new one; if it is new, correct this host's clock".to_owned()
        }
        ErrorKind::ImmatureSignature => {
            "it is not valid yet (nbf): correct the clock of this host or of the provider".to_owned()
        }
        ErrorKind::MissingRequiredClaim(claim) => {
            format!("it lacks the claim {claim}: let the provider add it")
        }
        ErrorKind::InvalidClaimFormat(claim) => {
            format!("its claim {claim} has a wrong type, {}: let the provider correct it", claimed(claim))
        }
        ErrorKind::InvalidSignature => FORGED.to_owned(),
        ErrorKind::InvalidToken | ErrorKind::Base64(_) | ErrorKind::Json(_) | ErrorKind::Utf8(_) => DAMAGED.to_owned(),
        _ => "its signature does not fit the provider's key: let the provider sign with a key that it publishes"
            .to_owned(),
    }
}

/// Why an ID token is refused. The library's texts about claims name both values.
pub(super) fn of_id_token(problem: &ClaimsVerificationError) -> String {
    let quoted = |text: &str| text.replace('`', "\"");
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the library's errors: the others are about requirements that are not set here"
    )]
    match problem {
        ClaimsVerificationError::Expired(_) => {
            "it has expired (exp): correct the clock of this host or of the provider".to_owned()
        }
        ClaimsVerificationError::InvalidIssuer(detail) => {
            format!(
                "its issuer (iss) is not http.oidc_issuer: {}; both must be equal to the last character",
                quoted(detail)
            )
        }
        ClaimsVerificationError::InvalidAudience(detail) => {
            format!("its audience (aud) is not http.oidc_client_id: it {}", quoted(detail))
        }
        ClaimsVerificationError::InvalidNonce(_) => "it belongs to another attempt (nonce): sign in again".to_owned(),
        ClaimsVerificationError::SignatureVerification(SignatureVerificationError::CryptoError(_)) => FORGED.to_owned(),
        ClaimsVerificationError::SignatureVerification(_) => {
            format!("it is not signed by a key of the provider: let the provider sign with one of {}", algorithms())
        }
        _ => format!("it breaks a rule of OpenID Connect: {}", quoted(&problem.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use serde_json::json;

    use super::*;

    fn options() -> OidcOptions {
        OidcOptions {
            issuer: "https://login.example".to_owned(),
            audience: "vibrissa".to_owned(),
            jwks_url: None,
            role_claim: String::new(),
            fleets_claim: String::new(),
            sign_in: None,
        }
    }

    #[test]
    fn regress_each_refusal_of_a_token_has_both_values_and_a_remedy() {
        let claims = json!({ "iss": "https://login.example/", "aud": ["account"], "exp": "soon" });
        let claims = claims.as_object().unwrap();
        let not_json = serde_json::from_str::<Value>("{").unwrap_err();
        for (kind, parts) in [
            (ErrorKind::InvalidIssuer, ["\"https://login.example/\"", "\"https://login.example\""]),
            (ErrorKind::InvalidAudience, ["[\"account\"]", "\"vibrissa\""]),
            (ErrorKind::ExpiredSignature, ["exp", "clock"]),
            (ErrorKind::ImmatureSignature, ["nbf", "clock"]),
            (ErrorKind::MissingRequiredClaim("sub".to_owned()), ["claim sub", "provider"]),
            (ErrorKind::InvalidClaimFormat("exp".to_owned()), ["\"soon\"", "provider"]),
            (ErrorKind::InvalidSignature, ["signature", "another provider"]),
            (ErrorKind::InvalidToken, ["three parts", "base64url"]),
            (ErrorKind::Json(Arc::new(not_json)), ["three parts", "JSON"]),
            (ErrorKind::InvalidAlgorithm, ["signature", "key"]),
            (ErrorKind::InvalidKeyFormat, ["signature", "key"]),
        ] {
            let name = format!("{kind:?}");
            let text = of_token(&kind.into(), Some(claims), &options());
            assert!(parts.iter().all(|part| text.contains(part)) && text.contains(": "), "{name}: {text}");
            assert!(!text.contains(name.split('(').next().unwrap()), "{name}: {text}");
        }
        let missing = of_token(&ErrorKind::InvalidIssuer.into(), None, &options());
        assert!(missing.starts_with("its issuer (iss) is missing"), "{missing}");
    }

    #[test]
    fn regress_each_refusal_of_a_header_and_of_an_id_token_has_a_remedy() {
        // {"alg":"none"}
        let text = of_header(&jsonwebtoken::decode_header("eyJhbGciOiJub25lIn0.e30.").unwrap_err());
        assert!(text.contains("(alg)") && text.contains("RS256") && !text.contains("HS256"), "{text}");
        assert_eq!(of_header(&jsonwebtoken::decode_header("x.y.z").unwrap_err()), DAMAGED);
        let unsigned = ClaimsVerificationError::SignatureVerification(SignatureVerificationError::NoSignature);
        for (problem, part) in [
            (ClaimsVerificationError::Expired("x".to_owned()), "clock"),
            (
                ClaimsVerificationError::InvalidIssuer("expected `a` (found `b`)".to_owned()),
                "expected \"a\" (found \"b\")",
            ),
            (ClaimsVerificationError::InvalidNonce("nonce mismatch".to_owned()), "sign in again"),
            (unsigned, "RS256"),
        ] {
            let text = of_id_token(&problem);
            assert!(text.contains(part) && text.contains(": "), "{problem:?}: {text}");
        }
    }
}
