//! Failures of TLS handshakes, as rustls names them.

use super::{certificate, variant, words};

/// Why TLS fails, and what to do. `debug` is the `Debug` output of the library's error.
#[must_use]
pub fn tls(debug: &str) -> String {
    let inner = |prefix: &str| debug.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(')'));
    if let Some(detail) = inner("AlertReceived(") {
        return alert(detail);
    }
    if let Some(problem) = inner("InvalidCertificate(") {
        return format!("the certificate cannot be used: {}", certificate(problem));
    }
    let text = match variant(debug) {
        "PeerIncompatible" => {
            "the other side supports no version and no cipher in common: it needs TLS 1.2 or 1.3, with a cipher of ECDHE and \
             AES-GCM or ChaCha20"
        }
        "InvalidMessage" | "InappropriateMessage" | "InappropriateHandshakeMessage" => {
            "the other side does not answer in TLS: correct the port, or switch TLS off"
        }
        "PeerMisbehaved" | "PeerSentOversizedRecord" | "DecryptError" => {
            "the other side breaks the rules of TLS, or something between changes the bytes: look for a proxy between, and \
             update the other side"
        }
        "NoCertificatesPresented" => "the other side shows no certificate: give it one",
        "InconsistentKeys" => "the private key does not belong to the certificate: give the files of one pair",
        "FailedToGetCurrentTime" => "this host's clock is before 1970: correct it",
        "FailedToGetRandomBytes" => "this system provides no randomness: repair it",
        other => return format!("TLS reports {}: look at the log of the other side", words(other)),
    };
    text.to_owned()
}

/// What an alert of the other side means, and what to do. `debug` is the alert's `Debug` output.
#[must_use]
pub fn alert(debug: &str) -> String {
    let text = match variant(debug) {
        "UnknownCA" => "the other side does not know the authority of our certificate: let one sign it that it trusts",
        "BadCertificate" | "CertificateUnknown" | "UnsupportedCertificate" | "DecryptError" => {
            "the other side finds our certificate unusable: issue one for clients (extendedKeyUsage clientAuth), of X.509 \
             version 3"
        }
        "CertificateExpired" => "our certificate has expired, or the other side's clock is wrong: renew it",
        "CertificateRevoked" => "our certificate is revoked: use a new one",
        "CertificateRequired" | "NoCertificate" => "the other side requires a client certificate: give one",
        "AccessDenied" => "the other side does not let the owner of our certificate in: allow it there",
        "ProtocolVersion" | "InsufficientSecurity" | "HandshakeFailure" => {
            "the other side supports no version and no cipher in common: it needs TLS 1.2 or 1.3, with a cipher of ECDHE and \
             AES-GCM or ChaCha20"
        }
        "UnrecognisedName" => "the other side serves no host of this name: correct the name, or its configuration",
        "NoApplicationProtocol" => "the other side offers no common protocol in TLS (ALPN): correct the port",
        "InternalError" => "the other side has a fault of its own: look at its log",
        other => return format!("the other side ends TLS ({}): look at its log", words(other)),
    };
    text.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_failure_has_a_remedy_and_no_words_of_the_library() {
        for (debug, part) in [
            ("PeerIncompatible(ServerTlsVersionIsDisabledByOurConfig)", "TLS 1.2 or 1.3"),
            ("AlertReceived(ProtocolVersion)", "TLS 1.2 or 1.3"),
            ("AlertReceived(UnknownCA)", "does not know the authority"),
            ("AlertReceived(UserCanceled)", "(user canceled)"),
            ("InvalidCertificate(Other(OtherError(CaUsedAsEndEntity)))", "CA:FALSE"),
            ("InvalidCertificate(Expired)", "it has expired"),
            ("PeerMisbehaved(TooManyKeyUpdates)", "breaks the rules"),
            ("InappropriateMessage { expect_types: [], got_type: Alert }", "correct the port"),
            ("BadMaxFragmentSize", "bad max fragment size"),
        ] {
            let text = tls(debug);
            assert!(text.contains(part) && text.contains(": ") && !text.contains(variant(debug)), "{debug}: {text}");
        }
    }
}
