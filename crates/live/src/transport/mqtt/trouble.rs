//! What a failed connection means: whether to try again, and what to tell the user.

use super::tls;
use super::url::Broker;
use pickline::error::{Error, shown};
use pickline::names::LONGEST_NAME;
use rumqttc::mqttbytes::Error as PacketError;
use rumqttc::mqttbytes::v5::ConnectReturnCode;
use rumqttc::tokio_rustls::rustls;
use rumqttc::{ConnectionError, DisconnectReasonCode, StateError, TlsError};

/// A failure that trying again does not mend: the settings are wrong.
pub fn fatal(error: &ConnectionError, broker: &Broker) -> Option<Error> {
    use ConnectReturnCode as Code;
    let input = |problem: String, cure: &str| Some(Error::input("--mqtt", problem, cure));
    if let Some(trouble) = tls_trouble(error, broker) {
        return Some(trouble);
    }
    let code = match error {
        ConnectionError::ConnectionRefused(code) => code,
        ConnectionError::MqttState(StateError::ConnFail { reason }) => reason,
        ConnectionError::SessionStateMismatch { .. } | ConnectionError::NotConnAck(_) => {
            let cure = "check that an MQTT 5 broker listens there";
            return input(
                format!("{broker} breaks the rules of MQTT 5: {error}"),
                cure,
            );
        }
        _ => return None,
    };
    match code {
        Code::BadUserNamePassword
        | Code::NotAuthorized
        | Code::Banned
        | Code::BadAuthenticationMethod => input(
            match &broker.user {
                Some(user) => format!("{broker} refuses user `{}` or the password", shown(user)),
                None => format!("{broker} lets nobody in without user and password"),
            },
            "give --mqtt-user, and the password in PICKLINE_MQTT_PASSWORD or with \
             --mqtt-password-file",
        ),
        Code::RefusedProtocolVersion | Code::UnsupportedProtocolVersion => input(
            format!("{broker} refuses MQTT 5"),
            "use a broker that speaks it, or switch MQTT 5 on in its settings",
        ),
        Code::BadClientId | Code::ClientIdentifierNotValid => {
            let problem = format!("{broker} refuses this client id");
            Some(Error::input(
                "--mqtt-client-id",
                problem,
                "give another one",
            ))
        }
        _ => None,
    }
}

/// Another client has come with the same id.
pub fn taken_over(error: &ConnectionError, broker: &Broker) -> Option<Error> {
    matches!(
        error,
        ConnectionError::MqttState(StateError::ServerDisconnect {
            reason_code: DisconnectReasonCode::SessionTakenOver,
            ..
        })
    )
    .then(|| {
        let problem = format!("another client has connected to {broker} with the same client id");
        Error::input("--mqtt-client-id", problem, "give every program its own")
    })
}

/// What the operating system, or TLS through it, has to say; none when the trouble is
/// another one.
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

/// What TLS has to say; none when the trouble is another one.
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

/// What happened, in the words of the one who knows.
pub fn told(error: &ConnectionError) -> String {
    let text = match error {
        ConnectionError::MqttState(StateError::AwaitPingResp) => "it does not answer".into(),
        ConnectionError::Timeout(_) => "no answer in MQTT 5 came in time".into(),
        ConnectionError::ConnectionRefused(code) => format!("it refuses: {code:?}"),
        other => match system_trouble(other) {
            Some(io) => io.to_string(),
            None => other.to_string(),
        },
    };
    // A broker may say anything.
    let printable = text.trim().chars().filter(|c| !c.is_control());
    printable.take(LONGEST_NAME).collect()
}
