//! Explains a failed TLS handshake, with a cure.

use super::url::Broker;
use pickline::error::{Error, shown};
use rumqttc::TlsError;
use rumqttc::tokio_rustls::rustls;
use rustls::{AlertDescription as Alert, CertificateError};

/// The error for a failed TLS handshake with `broker`, from the error of rustls.
pub(crate) fn refused(error: &rustls::Error, broker: &Broker) -> Error {
    let (place, problem, cure) = match error {
        rustls::Error::InvalidCertificate(reason) => certificate(reason, broker),
        rustls::Error::AlertReceived(alert) => alerted(*alert),
        rustls::Error::InvalidMessage(_) => (
            "'mqtt'",
            "the server there does not speak TLS".to_owned(),
            format!(
                "write mqtt://{}:{}, or give the port for TLS, usually 8883",
                broker.host, broker.port
            ),
        ),
        rustls::Error::PeerIncompatible(reason) => (
            "'mqtt'",
            format!("the broker offers no current TLS version or cipher: {reason:?}"),
            "enable TLS 1.2 or 1.3 in the broker".to_owned(),
        ),
        other => (
            "'mqtt'",
            other.to_string(),
            "check the broker's certificate, and that 'mqtt_ca', 'mqtt_cert' and 'mqtt_key' match \
             the broker"
                .to_owned(),
        ),
    };
    Error::usage(place, format!("no TLS with {broker}: {problem}"), cure).caused_by(error.clone())
}

/// The error for unusable TLS settings.
pub(crate) fn unusable(error: &TlsError, broker: &Broker) -> Error {
    let (place, cure) = match error {
        TlsError::TLS(error) => return refused(error, broker),
        TlsError::NoValidCertInChain => (
            "'mqtt_ca'",
            "give a PEM file with the certificate of the authority (-----BEGIN CERTIFICATE)",
        ),
        TlsError::NoValidClientCertInChain => (
            "'mqtt_cert'",
            "give a PEM file with the certificate of this client (-----BEGIN CERTIFICATE)",
        ),
        TlsError::NoValidKeyInChain => (
            "'mqtt_key'",
            "give a PEM file with the private key of 'mqtt_cert' (-----BEGIN PRIVATE KEY)",
        ),
        _ => (
            "'mqtt'",
            "check the files of 'mqtt_ca', 'mqtt_cert' and 'mqtt_key'",
        ),
    };
    Error::usage(place, format!("no TLS with {broker}: {error}"), cure)
}

type TlsProblem = (&'static str, String, String);

/// Explains what is wrong with the broker's certificate.
fn certificate(reason: &CertificateError, broker: &Broker) -> TlsProblem {
    let host = shown(&broker.host);
    let machine_clock = "or correct the clock of this machine, if it is wrong";
    match reason {
        CertificateError::UnknownIssuer => (
            "'mqtt_ca'",
            "its certificate is signed by an authority that is not trusted here, or self-signed"
                .into(),
            "give the certificate of that authority with 'mqtt_ca'; for a self-signed certificate, \
             give the certificate itself"
                .into(),
        ),
        CertificateError::BadSignature => (
            "'mqtt_ca'",
            "its certificate is not signed by the authority in 'mqtt_ca', but by another one with \
             the same name"
                .into(),
            "give the certificate of the authority that signed the broker's".into(),
        ),
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => (
            "'mqtt'",
            "its certificate, or that of its authority, has expired".into(),
            format!("renew the broker's certificate, {machine_clock}"),
        ),
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => (
            "'mqtt'",
            "its certificate is not valid yet".into(),
            format!("wait until it is, {machine_clock}"),
        ),
        CertificateError::Revoked => (
            "'mqtt'",
            "its certificate is revoked".into(),
            "give the broker another certificate".into(),
        ),
        CertificateError::NotValidForName => other_name("other hosts", &host),
        CertificateError::NotValidForNameContext { presented, .. } => {
            let names: Vec<String> = presented.iter().map(|name| plain_name(name)).collect();
            match names.join(", ") {
                none if none.is_empty() => other_name("no host (it has no subjectAltName)", &host),
                names => other_name(&names, &host),
            }
        }
        other => ("'mqtt'", other_problem(other), own_certificate(&host)),
    }
}

/// What is wrong with a certificate that no broker can use. The reason is known only by its text.
fn other_problem(reason: &CertificateError) -> String {
    let text = format!("{reason:?}");
    if text.contains("CaUsedAsEndEntity") {
        "its certificate is a CA certificate (basicConstraints CA:TRUE), which openssl creates by \
         default for self-signed ones"
            .into()
    } else if text.contains("UnsupportedCertVersion") {
        "its certificate has X.509 version 1, which names no host".into()
    } else {
        format!("its certificate is not accepted: {reason}")
    }
}

fn other_name(names: &str, host: &str) -> TlsProblem {
    (
        "'mqtt'",
        format!("its certificate is for {names}, not for `{host}`"),
        format!(
            "give 'mqtt' the host name that the certificate is for, or create one with \
             subjectAltName for `{host}`"
        ),
    )
}

/// The name in `DnsName("a")` or `IpAddress(1.2.3.4)`, as a user writes it.
fn plain_name(name: &str) -> String {
    let inside = name.split_once('(').map_or(name, |(_, rest)| rest);
    shown(inside.trim_end_matches(')').trim_matches('"'))
}

/// How to create a usable certificate.
fn own_certificate(host: &str) -> String {
    let kind = match host.parse::<std::net::IpAddr>() {
        Ok(_) => "IP",
        Err(_) => "DNS",
    };
    format!(
        "create one for a server, and give it with 'mqtt_ca': openssl req -x509 -newkey rsa:2048 \
         -nodes -keyout broker.key -out broker.pem -days 365 -subj /CN={host} -addext \
         subjectAltName={kind}:{host} -addext basicConstraints=critical,CA:FALSE"
    )
}

/// Explains a TLS alert from the broker.
fn alerted(alert: Alert) -> TlsProblem {
    let own = "give a certificate that the broker trusts, and its key, with 'mqtt_cert' and \
               'mqtt_key'";
    match alert {
        Alert::CertificateRequired => (
            "'mqtt_cert'",
            "the broker requires a client certificate".into(),
            own.into(),
        ),
        Alert::UnknownCA
        | Alert::BadCertificate
        | Alert::UnsupportedCertificate
        | Alert::CertificateRevoked
        | Alert::CertificateExpired
        | Alert::CertificateUnknown
        | Alert::DecryptError
        | Alert::AccessDenied => (
            "'mqtt_cert'",
            format!("the broker does not accept the client certificate ({alert:?})"),
            own.into(),
        ),
        // The alert of old brokers if a certificate is missing.
        Alert::HandshakeFailure => (
            "'mqtt_cert'",
            "the broker ends the handshake: it may require a client certificate".into(),
            own.into(),
        ),
        Alert::ProtocolVersion | Alert::InsufficientSecurity => (
            "'mqtt'",
            "the broker does not accept TLS 1.2 or 1.3".into(),
            "enable TLS 1.2 or 1.3 in the broker".into(),
        ),
        Alert::UnrecognisedName => (
            "'mqtt'",
            "the broker does not know this host name".into(),
            "give the host name that the broker's certificate is for".into(),
        ),
        other => (
            "'mqtt'",
            format!("the broker ends the handshake: {other:?}"),
            "check the broker's log".into(),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_shown_as_they_are_written() {
        assert_eq!(plain_name("DnsName(\"broker.line\")"), "broker.line");
        assert_eq!(plain_name("IpAddress(10.0.0.1)"), "10.0.0.1");
        assert_eq!(plain_name("broker"), "broker");
    }
}
