use std::collections::BTreeMap;

use jsonwebtoken::jwk::Jwk;
use serde::Deserialize;

use super::*;

/// Signatures that another implementation has made.
#[derive(Deserialize)]
struct Vectors {
    message: String,
    keys: BTreeMap<String, Jwk>,
    signatures: Vec<Signed>,
    weak: Signed,
}

#[derive(Deserialize)]
struct Signed {
    alg: Algorithm,
    key: String,
    signature: String,
}

fn vectors() -> Vectors {
    serde_json::from_str(include_str!("vectors.json")).unwrap()
}

fn verify(vectors: &Vectors, signed: &Signed, message: &str) -> Result<bool> {
    install();
    let key = DecodingKey::from_jwk(&vectors.keys[&signed.key]).unwrap();
    jsonwebtoken::crypto::verify(&signed.signature, message.as_bytes(), &key, signed.alg)
}

/// The same text with another character at a place.
fn changed(text: &str, at: usize) -> String {
    let other = if text.as_bytes()[at] == b'A' { "B" } else { "A" };
    format!("{}{other}{}", &text[..at], &text[at + 1..])
}

#[test]
fn each_accepted_algorithm_verifies_its_signatures_and_no_others() {
    let vectors = vectors();
    let algorithms: Vec<Algorithm> = vectors.signatures.iter().map(|signed| signed.alg).collect();
    assert!(ALGORITHMS.iter().all(|known| algorithms.contains(known)) && algorithms.len() == 9);
    for signed in &vectors.signatures {
        let (name, message) = (signed.alg, &vectors.message);
        assert!(verify(&vectors, signed, message).unwrap(), "{name:?}");
        assert!(!verify(&vectors, signed, &changed(message, 5)).unwrap(), "{name:?}: another message");
        let signature = changed(&signed.signature, signed.signature.len() / 2);
        let other = Signed { signature, key: signed.key.clone(), ..*signed };
        assert!(!verify(&vectors, &other, message).unwrap(), "{name:?}: another signature");
        let none = Signed { signature: String::new(), key: signed.key.clone(), ..*signed };
        assert!(!verify(&vectors, &none, message).unwrap(), "{name:?}: no signature");
        // Of those that the same key verifies, each has its own hash or padding.
        for &alg in algorithms.iter().filter(|&&alg| alg != signed.alg) {
            let misread = Signed { alg, key: signed.key.clone(), signature: signed.signature.clone() };
            assert!(!verify(&vectors, &misread, message).unwrap_or(false), "{name:?} as {alg:?}");
        }
    }
}

#[test]
fn keys_of_another_family_and_symmetric_algorithms_are_refused() {
    let vectors = vectors();
    for signed in &vectors.signatures {
        for key in vectors.keys.keys() {
            let family = &signed.key[..1];
            let of_its_family = key.starts_with(family);
            let other = Signed { alg: signed.alg, key: key.clone(), signature: signed.signature.clone() };
            let verified = verify(&vectors, &other, &vectors.message);
            assert_eq!(verified.is_ok(), of_its_family, "{:?} with {key}", signed.alg);
            assert_eq!(verified.is_ok_and(|is_good| is_good), *key == signed.key, "{:?} with {key}", signed.alg);
        }
    }
    for alg in [Algorithm::HS256, Algorithm::HS384, Algorithm::HS512] {
        let signed = Signed { alg, key: "rsa".to_owned(), signature: String::new() };
        assert!(verify(&vectors, &signed, &vectors.message).is_err());
    }
}

#[test]
fn an_rsa_key_of_1024_bits_verifies_nothing() {
    let vectors = vectors();
    assert!(!verify(&vectors, &vectors.weak, &vectors.message).unwrap());
}
