//! Signatures of requests, as the specification Standard Webhooks 1.0 defines them: HMAC-SHA256 over identifier, time and
//! body.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use ring::hmac;
use vibrissa_host::random;

/// Length of a secret, in bytes.
const SECRET_BYTES: usize = 32;
/// Beginning of a secret as it is shown.
const PREFIX: &str = "whsec_";

/// A new secret.
#[must_use]
pub fn new_secret() -> Vec<u8> {
    random::bytes::<SECRET_BYTES>().into()
}

/// A secret as it is shown once.
#[must_use]
pub fn shown(secret: &[u8]) -> String {
    format!("{PREFIX}{}", STANDARD.encode(secret))
}

/// Value of the header `webhook-signature`: one signature for each secret. `timestamp_s` is s since 1970 UTC.
#[must_use]
pub fn header(secrets: &[Vec<u8>], id: &str, timestamp_s: i64, body: &[u8]) -> String {
    let signed = [format!("{id}.{timestamp_s}.").as_bytes(), body].concat();
    let sign = |secret: &Vec<u8>| {
        let tag = hmac::sign(&hmac::Key::new(hmac::HMAC_SHA256, secret), &signed);
        format!("v1,{}", STANDARD.encode(tag.as_ref()))
    };
    secrets.iter().map(sign).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification's reference libraries.
    #[test]
    fn signatures_are_those_of_the_reference() {
        let secret = STANDARD.decode("MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw").unwrap();
        let header = header(&[secret], "msg_p5jXN8AQM9LWM0D4loKWxJek", 1_614_265_330, br#"{"test": 2432232314}"#);
        assert_eq!(header, "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
    }

    #[test]
    fn secrets_differ_and_both_of_a_rotation_sign() {
        let secrets = [new_secret(), new_secret()];
        assert_ne!(secrets[0], secrets[1]);
        assert!(shown(&secrets[0]).starts_with("whsec_"));
        let both = header(&secrets, "a", 1, b"b");
        let each = secrets.map(|secret| header(&[secret], "a", 1, b"b"));
        assert_eq!(both, each.join(" "));
    }
}
