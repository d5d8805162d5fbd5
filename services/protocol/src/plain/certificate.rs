//! Defects of certificates, as rustls and webpki name them.

use super::{variant, words};

/// Defect of a certificate, and its remedy. `debug` is the error's `Debug` output, or its text, which is the same.
#[must_use]
pub fn certificate(debug: &str) -> String {
    let text = match variant(debug) {
        "UnsupportedCertVersion" => {
            "it is of X.509 version 1, which cannot name hosts: issue one of version 3 with a subjectAltName (openssl x509 \
             -req needs -extfile for it)"
        }
        "CaUsedAsEndEntity" => {
            "it is the certificate of an authority (CA:TRUE): let this authority sign one for the host, with CA:FALSE and a \
             subjectAltName"
        }
        "EndEntityUsedAsCa" => {
            "it is signed by a certificate that is no authority's (CA:FALSE): sign it with one that has CA:TRUE"
        }
        "InvalidPurpose" | "InvalidPurposeContext" | "RequiredEkuNotFound" | "RequiredEkuNotFoundContext" => {
            "it is meant for another purpose: its extendedKeyUsage must contain serverAuth for a server, clientAuth for a client"
        }
        "EmptyEkuExtension" => "its extendedKeyUsage is empty: issue one with serverAuth, or without this extension",
        "UnsupportedSignatureAlgorithm"
        | "UnsupportedSignatureAlgorithmContext"
        | "UnsupportedSignatureAlgorithmForPublicKey"
        | "UnsupportedSignatureAlgorithmForPublicKeyContext"
        | "SignatureAlgorithmMismatch"
        | "UnsupportedAlgorithm" => {
            "it is signed by an algorithm that is not accepted, such as SHA-1: issue it with SHA-256, and a key of ECDSA P-256 \
             or of RSA with at least 2048 bits"
        }
        "BadSignature" | "InvalidSignatureForPublicKey" => {
            "its signature is not that of the trusted authority, or the authority's RSA key has less than 2048 bits: give \
             the certificate of the authority that has signed it"
        }
        "UnknownIssuer" => "no trusted authority has signed it: give the certificate of its authority",
        "NotValidForName" | "NotValidForNameContext" | "CertNotValidForName" => {
            "it is for another host: use a name of its subjectAltName, or issue one for this host"
        }
        "Expired" | "ExpiredContext" | "CertExpired" => "it has expired: renew it, or correct this host's clock",
        "NotValidYet" | "NotValidYetContext" | "CertNotValidYet" => {
            "it is not valid yet: correct this host's clock, or the certificate"
        }
        "InvalidCertValidity" => "it ends before it begins: issue it anew",
        "Revoked" | "CertRevoked" | "CertDistrusted" => "its authority has revoked it: issue a new one",
        "UnhandledCriticalExtension" | "UnsupportedCriticalExtension" => {
            "it has a critical extension that is not known here: issue one without it, or with the extension not critical"
        }
        "NameConstraintViolation" => {
            "its authority may not sign for this host (nameConstraints): let another one sign it"
        }
        "PathLenConstraintViolated"
        | "MaximumPathDepthExceeded"
        | "MaximumPathBuildCallsExceeded"
        | "MaximumSignatureChecksExceeded"
        | "MaximumNameConstraintComparisonsExceeded" => {
            "its chain of authorities is too long: sign it with an authority nearer to the trusted one"
        }
        "MalformedDnsIdentifier" => "a name in its subjectAltName is no host name: issue it with valid names",
        "MalformedExtensions"
        | "ExtensionValueInvalid"
        | "MalformedNameConstraint"
        | "InvalidNetworkMaskConstraint" => "one of its extensions is malformed: issue it anew",
        "BadEncoding" | "BadDer" | "BadDerTime" | "TrailingData" | "InvalidSerialNumber" => {
            "it is damaged or not in DER: replace it by a complete copy (openssl x509 -in FILE -text reads a good one)"
        }
        "UnknownRevocationStatus" | "ExpiredRevocationList" | "ExpiredRevocationListContext" => {
            "its authority does not tell whether it is revoked: ask the authority for a new list"
        }
        other => return format!("it breaks a rule of X.509 ({}): issue it anew", words(other)),
    };
    text.to_owned()
}

/// The names of a certificate, as rustls lists them: `a.example, 10.0.0.1` of `DnsName("a.example")`, `IpAddress(10.0.0.1)`;
/// `None` if there are none.
#[must_use]
pub fn host_names(presented: &[String]) -> Option<String> {
    let name = |text: &String| {
        let inner = text.split_once('(').and_then(|(_, inner)| inner.strip_suffix(')')).unwrap_or(text);
        inner.trim_matches('"').to_owned()
    };
    let names: Vec<String> = presented.iter().map(name).filter(|name| !name.is_empty()).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_defect_has_a_text_of_its_own_with_a_remedy() {
        for debug in [
            "Other(OtherError(UnsupportedCertVersion))",
            "Other(OtherError(CaUsedAsEndEntity))",
            "Other(OtherError(EndEntityUsedAsCa))",
            "InvalidPurposeContext { required: ServerAuth, presented: [ClientAuth] }",
            "UnsupportedSignatureAlgorithmContext { signature_algorithm_id: [1], supported_algorithms: [] }",
            "Other(OtherError(ExtensionValueInvalid))",
            "Other(OtherError(PathLenConstraintViolated))",
            "Other(OtherError(SomethingNew))",
            "BadEncoding",
            "Revoked",
            "UnhandledCriticalExtension",
            "BadSignature",
        ] {
            let text = certificate(debug);
            assert!(text.contains(": "), "a remedy: {text}");
            assert!(!text.contains(variant(debug)) && !text.contains("Other"), "{debug}: {text}");
        }
        assert!(certificate("Other(OtherError(SomethingNew))").contains("(something new)"));
    }

    #[test]
    fn names_are_listed_without_the_words_of_the_library() {
        let presented = ["DnsName(\"a.example\")".to_owned(), "IpAddress(10.0.0.1)".to_owned()];
        assert_eq!(host_names(&presented).as_deref(), Some("a.example, 10.0.0.1"));
        assert_eq!(host_names(&[]), None);
        assert_eq!(host_names(&[String::new()]), None);
    }
}
