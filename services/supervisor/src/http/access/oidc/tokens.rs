//! The provider's tokens of a session, as they are stored: sealed with a key that only the browser has.

use openidconnect::{OAuth2TokenResponse as _, TokenResponse as _};
use ring::aead::{Aad, CHACHA20_POLY1305, LessSafeKey, NONCE_LEN, Nonce, UnboundKey};
use serde::{Deserialize, Serialize};
use vibrissa_host::random;

use super::claims;
use super::id_token::TokenResponse;
use crate::http::problem::{Kind, Problem};

/// Tokens of a person.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Tokens {
    pub(super) access_token: String,
    pub(super) refresh_token: Option<String>,
    /// The newest ID token. It was verified before it was sealed.
    pub(super) id_token: Option<String>,
    /// The nonce of the first ID token. ID tokens of renewals may leave it out.
    #[serde(default)]
    first_nonce: Option<String>,
}

impl Tokens {
    /// The provider's tokens. It may keep the refresh token, and need not repeat the ID token.
    pub(super) fn of(answer: &TokenResponse, before: Option<Self>) -> Self {
        let access_token = answer.access_token().secret().clone();
        let refresh_token = answer.refresh_token().map(|token| token.secret().clone());
        Self::renewed(access_token, refresh_token, answer.id_token().map(ToString::to_string), before)
    }

    fn renewed(
        access_token: String,
        refresh_token: Option<String>,
        id_token: Option<String>,
        before: Option<Self>,
    ) -> Self {
        let first_nonce = before.as_ref().and_then(Self::nonce).or_else(|| claims::nonce(id_token.as_ref()?));
        let (old_refresh_token, old_id_token) =
            before.map(|before| (before.refresh_token, before.id_token)).unwrap_or_default();
        Self {
            access_token,
            refresh_token: refresh_token.or(old_refresh_token),
            id_token: id_token.or(old_id_token),
            first_nonce,
        }
    }

    /// The person who signed in.
    pub(super) fn subject(&self) -> Option<String> {
        claims::subject(&claims::unverified(self.id_token.as_ref()?)?).map(ToOwned::to_owned)
    }

    /// The nonce of the person's first ID token. An earlier version has stored it within that token only.
    pub(super) fn nonce(&self) -> Option<String> {
        self.first_nonce.clone().or_else(|| claims::nonce(self.id_token.as_ref()?))
    }
}

fn cipher(key: &[u8]) -> Option<LessSafeKey> {
    UnboundKey::new(&CHACHA20_POLY1305, key).ok().map(LessSafeKey::new)
}

/// Encrypts tokens: a random nonce, then the sealed JSON.
pub(super) fn seal(tokens: &Tokens, key: &[u8]) -> Result<Vec<u8>, Problem> {
    let internal = || Problem::new(Kind::Internal, "cannot encrypt the session");
    let nonce: [u8; NONCE_LEN] = random::bytes();
    let mut sealed = serde_json::to_vec(tokens).map_err(|_| internal())?;
    let cipher = cipher(key).ok_or_else(internal)?;
    let nonced = Nonce::assume_unique_for_key(nonce);
    cipher.seal_in_place_append_tag(nonced, Aad::empty(), &mut sealed).map_err(|_| internal())?;
    Ok([nonce.as_slice(), &sealed].concat())
}

/// The tokens, if this key has sealed them.
pub(super) fn open(sealed: &[u8], key: &[u8]) -> Option<Tokens> {
    let (nonce, sealed) = sealed.split_at_checked(NONCE_LEN)?;
    let nonce = Nonce::assume_unique_for_key(nonce.try_into().ok()?);
    let mut sealed = sealed.to_vec();
    let opened = cipher(key)?.open_in_place(nonce, Aad::empty(), &mut sealed).ok()?;
    serde_json::from_slice(opened).ok()
}

#[cfg(test)]
mod tests {
    use base64::Engine as _;
    use base64::engine::general_purpose::URL_SAFE_NO_PAD;
    use serde_json::Value;

    use super::*;
    use crate::http::access::cookies::KEY_BYTES;

    #[test]
    fn only_the_cookies_key_opens_a_session() {
        let tokens = Tokens::renewed("a".to_owned(), Some("r".to_owned()), None, None);
        let sealed = seal(&tokens, &[1; KEY_BYTES]).unwrap();
        assert_eq!(open(&sealed, &[1; KEY_BYTES]).unwrap().access_token, "a");
        assert!(open(&sealed, &[2; KEY_BYTES]).is_none() && open(&sealed[1..], &[1; KEY_BYTES]).is_none());
        assert!(open(&[], &[1; KEY_BYTES]).is_none());
        assert_ne!(sealed, seal(&tokens, &[1; KEY_BYTES]).unwrap(), "each nonce is used once");
    }

    #[test]
    fn regress_the_first_nonce_stays_over_renewals_that_leave_it_out() {
        let id_token = |claims: Value| format!("e30.{}.x", URL_SAFE_NO_PAD.encode(claims.to_string()));
        let first = id_token(serde_json::json!({ "sub": "p", "nonce": "n" }));
        let second = id_token(serde_json::json!({ "sub": "p" }));
        let mut tokens = Tokens::renewed("a".to_owned(), None, Some(first.clone()), None);
        for id_token in [Some(second), None, Some(first)] {
            tokens = Tokens::renewed("b".to_owned(), None, id_token, Some(tokens));
            tokens = open(&seal(&tokens, &[1; KEY_BYTES]).unwrap(), &[1; KEY_BYTES]).unwrap();
            assert_eq!(tokens.nonce().as_deref(), Some("n"));
        }
        // As an earlier version has stored it.
        let old = r#"{"access_token":"a","refresh_token":null,"id_token":"e30.eyJub25jZSI6Im0ifQ.x"}"#;
        assert_eq!(serde_json::from_str::<Tokens>(old).unwrap().nonce().as_deref(), Some("m"));
    }
}
