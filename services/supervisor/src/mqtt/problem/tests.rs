use std::sync::Arc;

use rustls::OtherError;
use rustls::pki_types::ServerName;

use super::*;

/// An error of webpki, which rustls hands on as it is. Its `Debug` output is the name of its variant.
#[derive(thiserror::Error)]
#[error("{0}")]
struct Foreign(&'static str);

impl fmt::Debug for Foreign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// What people read about a certificate of their broker.
fn remedy_of(defect: CertificateError) -> String {
    let broker: BrokerAddress = "mqtts://localhost".parse().unwrap();
    let error = rustls::Error::InvalidCertificate(defect);
    let wrapped = ConnectionError::Tls(TlsError::Io(io::Error::other(error)));
    Problem::of(&broker, &wrapped, true, false).to_string()
}

#[test]
fn regress_each_defect_of_a_certificate_has_a_remedy_and_no_words_of_the_library() {
    let foreign = |name| CertificateError::Other(OtherError(Arc::new(Foreign(name))));
    let without_names = CertificateError::NotValidForNameContext {
        expected: ServerName::try_from("localhost").unwrap(),
        presented: Vec::new(),
    };
    let other_name = CertificateError::NotValidForNameContext {
        expected: ServerName::try_from("localhost").unwrap(),
        presented: vec!["DnsName(\"a.example\")".to_owned()],
    };
    for (defect, part) in [
        (foreign("UnsupportedCertVersion"), "version 1"),
        (foreign("CaUsedAsEndEntity"), "CA:TRUE"),
        (foreign("ExtensionValueInvalid"), "malformed"),
        (foreign("SomethingNew"), "(something new)"),
        (without_names, "names no host"),
        (other_name, "but for a.example"),
        (CertificateError::BadEncoding, "damaged"),
        (CertificateError::InvalidPurpose, "serverAuth"),
        (CertificateError::Revoked, "revoked"),
        (CertificateError::Expired, "renew"),
        (CertificateError::UnknownIssuer, "mqtt.ca_file"),
    ] {
        let name = format!("{defect:?}");
        let text = remedy_of(defect);
        assert!(text.contains(part) && text.matches(": ").count() >= 2, "{name}: {text}");
        let words = ["Other(", "OtherError", "DnsName", "for : ", "UnsupportedCertVersion", "CaUsedAsEndEntity"];
        assert!(!words.iter().any(|word| text.contains(word)), "{name}: {text}");
    }
}

#[test]
fn regress_each_refusal_of_a_broker_has_a_remedy_and_not_the_name_of_its_code() {
    let broker: BrokerAddress = "mqtt://broker".parse().unwrap();
    for code in [
        ConnectReturnCode::QuotaExceeded,
        ConnectReturnCode::ServerBusy,
        ConnectReturnCode::Banned,
        ConnectReturnCode::ClientIdentifierNotValid,
        ConnectReturnCode::PacketTooLarge,
        ConnectReturnCode::UseAnotherServer,
    ] {
        let text = Problem::of(&broker, &ConnectionError::ConnectionRefused(code), true, false).to_string();
        assert!(!text.contains(&format!("{code:?}")) && text.matches(": ").count() >= 2, "{text}");
    }
}
