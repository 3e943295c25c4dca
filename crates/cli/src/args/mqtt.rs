//! The arguments for MQTT: which broker, and how to log in.

use clap::Args;
use std::path::PathBuf;

/// Communication over an MQTT broker.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "MQTT")]
pub(crate) struct MqttArgs {
    /// Use this MQTT 5 broker instead of stdin and stdout: mqtt://HOST:PORT, or
    /// mqtts://HOST:PORT for TLS
    #[arg(long, value_name = "URL", conflicts_with_all = ["listen", "connect"])]
    pub mqtt: Option<String>,
    /// Prefix of all topics
    #[arg(
        long,
        value_name = "TOPIC",
        default_value = "pickline",
        requires = "mqtt"
    )]
    pub mqtt_prefix: String,
    /// User name; the password is read from PICKLINE_MQTT_PASSWORD
    #[arg(long, value_name = "NAME", requires = "mqtt")]
    pub mqtt_user: Option<String>,
    /// File containing only the password, on one line
    #[arg(long, value_name = "FILE", requires = "mqtt")]
    pub mqtt_password_file: Option<PathBuf>,
    /// Client id. If given, and with the system clock, the broker keeps messages for a minute
    /// while this program is disconnected [default: a new one each time]
    #[arg(long, value_name = "ID", requires = "mqtt")]
    pub mqtt_client_id: Option<String>,
    /// Certificate authorities to trust (PEM) [default: those of this machine]
    #[arg(long, value_name = "FILE", requires = "mqtt")]
    pub mqtt_ca: Option<PathBuf>,
    /// Client certificate (PEM), for a broker that asks for one
    #[arg(long, value_name = "FILE", requires = "mqtt_ca", requires = "mqtt_key")]
    pub mqtt_cert: Option<PathBuf>,
    /// Private key of that certificate (PEM)
    #[arg(long, value_name = "FILE", requires = "mqtt_cert")]
    pub mqtt_key: Option<PathBuf>,
}
