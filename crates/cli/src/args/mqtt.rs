//! How a broker is found and convinced.

use clap::Args;
use std::path::PathBuf;

/// Talking over an MQTT broker.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "MQTT")]
pub struct MqttArgs {
    /// Talk over this MQTT 5 broker instead of stdin and stdout: mqtt://HOST:PORT, or
    /// mqtts://HOST:PORT for TLS
    #[arg(long, value_name = "URL", conflicts_with_all = ["listen", "connect"])]
    pub mqtt: Option<String>,
    /// What all topics begin with
    #[arg(
        long,
        value_name = "TOPIC",
        default_value = "pickline",
        requires = "mqtt"
    )]
    pub mqtt_prefix: String,
    /// User name; the password is taken from PICKLINE_MQTT_PASSWORD
    #[arg(long, value_name = "NAME", requires = "mqtt")]
    pub mqtt_user: Option<String>,
    /// File with the password on its only line
    #[arg(long, value_name = "FILE", requires = "mqtt")]
    pub mqtt_password_file: Option<PathBuf>,
    /// Client id. With one, and the system clock, the broker keeps for a minute what comes
    /// while this program is not there [default: a new one each time]
    #[arg(long, value_name = "ID", requires = "mqtt")]
    pub mqtt_client_id: Option<String>,
    /// Certificates of the authorities to trust (PEM) [default: those of this machine]
    #[arg(long, value_name = "FILE", requires = "mqtt")]
    pub mqtt_ca: Option<PathBuf>,
    /// Certificate of this client (PEM), for a broker that asks for one
    #[arg(long, value_name = "FILE", requires = "mqtt_ca", requires = "mqtt_key")]
    pub mqtt_cert: Option<PathBuf>,
    /// Key of that certificate (PEM)
    #[arg(long, value_name = "FILE", requires = "mqtt_cert")]
    pub mqtt_key: Option<PathBuf>,
}
