//! Why a request to another service fails, with what to do: the errors of `ureq`.

use std::io::ErrorKind;

use ureq::Error;
use vibrissa_protocol::plain;

/// Why a request has no answer.
#[must_use]
pub fn failure(problem: &Error) -> String {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the text of the others is sufficient")]
    let text = match problem {
        Error::Timeout(_) => "no answer in time: check its address, the network and firewalls",
        Error::HostNotFound => "no address is known for the host: correct its name, or DNS",
        Error::ConnectionFailed => "no connection: check its address, the network and firewalls",
        Error::Protocol(_) | Error::Http(_) => {
            "it does not answer in HTTP: correct the port, or write https:// if it expects TLS"
        }
        Error::BadUri(_) => "the address is no URL of the web: write https://HOST/PATH",
        Error::Rustls(problem) => return plain::tls(&format!("{problem:?}")),
        Error::Tls(_) | Error::Pem(_) => "TLS cannot be used with it: correct the port, or its certificate",
        Error::BodyExceedsLimit(bytes) => {
            return format!("its answer has more than {bytes} bytes: correct the address");
        }
        Error::TooManyRedirects | Error::RedirectFailed => "it leads to another address: configure that one",
        Error::Io(problem) => match problem.kind() {
            ErrorKind::ConnectionRefused => "nothing listens there: start it, or correct host and port",
            ErrorKind::ConnectionReset
            | ErrorKind::ConnectionAborted
            | ErrorKind::UnexpectedEof
            | ErrorKind::BrokenPipe => {
                "it closed the connection without an answer: correct the port, or write https:// if it expects TLS"
            }
            ErrorKind::TimedOut => "no answer in time: check its address, the network and firewalls",
            ErrorKind::HostUnreachable | ErrorKind::NetworkUnreachable => "there is no route to it: check the network",
            _ => return plain::io(problem),
        },
        other => return plain::text(&other.to_string()),
    };
    text.to_owned()
}

/// Why a request has no answer, if that is what this error is about.
#[must_use]
pub fn known(cause: &(dyn std::error::Error + 'static)) -> Option<String> {
    cause.downcast_ref().map(failure)
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    #[test]
    fn regress_each_failure_has_a_remedy_and_no_words_of_the_library() {
        let certificate = rustls::Error::InvalidCertificate(rustls::CertificateError::UnknownIssuer);
        let wrapped = rustls::Error::InvalidCertificate(rustls::CertificateError::Expired);
        for (problem, part) in [
            (Error::Timeout(ureq::Timeout::Connect), "in time"),
            (Error::HostNotFound, "DNS"),
            (Error::ConnectionFailed, "no connection"),
            (Error::BadUri("x".to_owned()), "https://"),
            (Error::Rustls(certificate), "no trusted authority"),
            (Error::Tls("x"), "certificate"),
            (Error::BodyExceedsLimit(9), "9 bytes"),
            (Error::TooManyRedirects, "another address"),
            (Error::Io(io::Error::from_raw_os_error(111)), "nothing listens"),
            (Error::Io(io::Error::from_raw_os_error(104)), "closed the connection"),
            (Error::Io(io::Error::from_raw_os_error(113)), "no route"),
            (Error::Io(io::Error::other(wrapped)), "it has expired"),
        ] {
            let text = failure(&problem);
            assert!(text.contains(part), "{problem:?}: {text}");
            assert!(text.contains(": ") && !text.contains("os error"), "{problem:?}: {text}");
        }
        let own = io::Error::other("the host is private: see webhooks.allowed_hosts");
        assert_eq!(failure(&Error::Io(own)), "the host is private: see webhooks.allowed_hosts");
    }
}
