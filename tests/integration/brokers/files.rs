//! Certificate and key files are read before the first connection, and problems name the file.

use std::path::{Path, PathBuf};

use vibrissa_supervisor::mqtt::{BrokerAddress, ClientCertificate, PrepareError, TlsOptions, prepare};
use vibrissa_tests::certificates::{Authority, write};

fn with_ca(path: PathBuf) -> BrokerAddress {
    BrokerAddress {
        tls: Some(TlsOptions { ca_file: Some(path), client: None }),
        ..BrokerAddress::new("localhost", 8883)
    }
}

fn with_client(folder: &Path, certificate: &str, key: &str) -> BrokerAddress {
    let mut address = with_ca(folder.join("ca.crt"));
    let (certificate_file, key_file) = (folder.join(certificate), folder.join(key));
    address.tls.as_mut().unwrap().client = Some(ClientCertificate { certificate_file, key_file });
    address
}

/// The problem, which must contain all of these words.
fn refused(address: &BrokerAddress, words: &[&str]) -> PrepareError {
    let refusal = prepare(address).unwrap_err();
    let said = refusal.to_string();
    for word in words {
        assert!(said.contains(word), "{word} in: {said}");
    }
    refusal
}

#[test]
fn a_bad_file_of_authorities_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let own = Authority::new("ours").client("x");
    let path = |name: &str, text: &str| write(folder.path(), name, text);
    let missing = refused(&with_ca(folder.path().join("gone.crt")), &["mqtt.ca_file", "gone.crt", "cannot read"]);
    assert!(matches!(missing, PrepareError::Unreadable { .. }));
    for (name, text, words) in [
        ("empty.crt", "", ["is not PEM", "it is empty"]),
        ("noise.crt", "hello\n", ["is not PEM", "it has no BEGIN line"]),
        ("cut.crt", "-----BEGIN CERTIFICATE-----\nMIIB\n", ["is not PEM", "cut.crt"]),
        ("key.crt", own.key.as_str(), ["there is no certificate in", "key.crt"]),
        (
            "wrong.crt",
            "-----BEGIN CERTIFICATE-----\nMIIB\n-----END CERTIFICATE-----\n",
            ["wrong.crt", "cannot be used"],
        ),
    ] {
        refused(&with_ca(path(name, text)), &["mqtt.ca_file", name, words[0], words[1]]);
    }
}

#[test]
fn a_bad_certificate_or_key_of_ones_own_is_named_and_no_key_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new("ours");
    let (one, other) = (authority.client("one"), authority.client("other"));
    let body = one.key.lines().nth(1).unwrap();
    for (name, text) in [
        ("ca.crt", authority.certificate()),
        ("one.crt", one.certificate.clone()),
        ("one.key", one.key.clone()),
        ("other.key", other.key),
        ("locked.key", one.key.replace("PRIVATE", "ENCRYPTED PRIVATE")),
        ("cut.key", one.key.replace("-----END PRIVATE KEY-----", "")),
        ("damaged.key", one.key.replace("PRIVATE KEY-----\n", "PRIVATE KEY-----\n!")),
    ] {
        write(folder.path(), name, &text);
    }
    let client = |certificate, key| with_client(folder.path(), certificate, key);
    prepare(&client("one.crt", "one.key")).unwrap();
    for (certificate, key, words) in [
        ("gone.crt", "one.key", ["mqtt.client_certificate_file", "gone.crt"]),
        ("one.key", "one.key", ["mqtt.client_certificate_file", "there is no certificate in"]),
        ("one.crt", "gone.key", ["mqtt.client_key_file", "gone.key"]),
        ("one.crt", "one.crt", ["mqtt.client_key_file", "there is no private key in"]),
        ("one.crt", "other.key", ["other.key does not belong to the certificate in", "one.crt"]),
        ("one.crt", "locked.key", ["mqtt.client_key_file", "is encrypted"]),
        ("one.crt", "cut.key", ["mqtt.client_key_file", "is damaged"]),
        ("one.crt", "damaged.key", ["mqtt.client_key_file", "damaged.key"]),
    ] {
        let said = refused(&client(certificate, key), &words).to_string();
        assert!(!said.contains(body), "{said}");
    }
}

#[test]
fn a_host_that_no_certificate_can_be_for_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let ca = write(folder.path(), "ca.crt", &Authority::new("ours").certificate());
    refused(&BrokerAddress { host: "a b".to_owned(), ..with_ca(ca) }, &["mqtt.url", "a b"]);
}
