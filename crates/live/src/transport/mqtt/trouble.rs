//! Explains a failed connection: whether to retry, and what to tell the user.

use super::tls;
use super::url::Broker;
use pickline::error::{Error, shown};
use pickline::names::LONGEST_NAME;
use rumqttc::mqttbytes::Error as PacketError;
use rumqttc::mqttbytes::v5::ConnectReturnCode;
use rumqttc::tokio_rustls::rustls;
use rumqttc::{ConnectionError, DisconnectReasonCode, StateError, TlsError};

/// The error for a failure that a retry does not solve, because the settings are wrong.
pub(crate) fn fatal(error: &ConnectionError, broker: &Broker) -> Option<Error> {
    use ConnectReturnCode as Code;
    let input = |problem: String, cure: &str| Some(Error::usage("'mqtt'", problem, cure));
    if let Some(trouble) = tls_trouble(error, broker) {
        return Some(trouble);
    }
    let code = match error {
        ConnectionError::ConnectionRefused(code) => code,
        ConnectionError::MqttState(StateError::ConnFail { reason }) => reason,
        ConnectionError::SessionStateMismatch { .. } | ConnectionError::NotConnAck(_) => {
            let cure = "check that an MQTT 5 broker listens there";
            return input(format!("{broker} violates MQTT 5: {error}"), cure);
        }
        _ => return None,
    };
    match code {
        Code::BadUserNamePassword
        | Code::NotAuthorized
        | Code::Banned
        | Code::BadAuthenticationMethod => input(
            match &broker.user {
                Some(user) => format!("{broker} refuses user `{}` or its password", shown(user)),
                None => format!("{broker} requires a user and password"),
            },
            "give 'mqtt_user', and the password in PICKLINE_MQTT_PASSWORD or with \
             'mqtt_password_file'",
        ),
        Code::RefusedProtocolVersion | Code::UnsupportedProtocolVersion => input(
            format!("{broker} refuses MQTT 5"),
            "use a broker that speaks it, or enable MQTT 5 in its settings",
        ),
        Code::BadClientId | Code::ClientIdentifierNotValid => {
            let problem = format!("{broker} refuses this client id");
            Some(Error::usage(
                "'mqtt_client_id'",
                problem,
                "give another one",
            ))
        }
        _ => None,
    }
}

/// The error if another client has connected with the same id.
pub(crate) fn taken_over(error: &ConnectionError, broker: &Broker) -> Option<Error> {
    matches!(
        error,
        ConnectionError::MqttState(StateError::ServerDisconnect {
            reason_code: DisconnectReasonCode::SessionTakenOver,
            ..
        })
    )
    .then(|| {
        let problem = format!("another client has connected to {broker} with the same client id");
        Error::usage(
            "'mqtt_client_id'",
            problem,
            "give every program a different one",
        )
    })
}

/// The error of the operating system, or of TLS through it; none for other failures.
fn system_trouble(error: &ConnectionError) -> Option<&std::io::Error> {
    match error {
        ConnectionError::Io(io)
        | ConnectionError::Tls(TlsError::Io(io))
        | ConnectionError::MqttState(
            StateError::Io(io) | StateError::Deserialization(PacketError::Io(io)),
        ) => Some(io),
        _ => None,
    }
}

/// The error of TLS; none for other failures.
fn tls_trouble(error: &ConnectionError, broker: &Broker) -> Option<Error> {
    if let Some(io) = system_trouble(error) {
        let inner = io.get_ref()?.downcast_ref::<rustls::Error>()?;
        return Some(tls::refused(inner, broker));
    }
    match error {
        ConnectionError::Tls(error) => Some(tls::unusable(error, broker)),
        _ => None,
    }
}

/// A description of the failure, from its original cause.
pub(crate) fn told(error: &ConnectionError) -> String {
    let text = match error {
        ConnectionError::MqttState(StateError::AwaitPingResp) => "it does not answer".into(),
        ConnectionError::Timeout(_) => "no MQTT 5 answer came in time".into(),
        ConnectionError::ConnectionRefused(code) => format!("it refuses: {code:?}"),
        other => match system_trouble(other) {
            Some(io) => io.to_string(),
            None => other.to_string(),
        },
    };
    // A broker may send any text.
    let printable = text.trim().chars().filter(|c| !c.is_control());
    printable.take(LONGEST_NAME).collect()
}
