//! Who may connect.

use clap::Args;
use std::path::PathBuf;

/// Each argument names its heading: one for all would also be that of those that follow.
const HEADING: &str = "Who may connect";

/// Who may connect over TCP, and to the dashboard.
#[derive(Debug, Clone, Args)]
pub struct AccessArgs {
    /// Peers over TCP have to show the token in this file in their hello, and browsers of
    /// the dashboard as the password; emulate shows it
    #[arg(long, help_heading = HEADING, value_name = "FILE")]
    pub token: Option<PathBuf>,
    /// Certificate of this program (PEM): TLS for --listen and --dashboard
    #[cfg(feature = "tls")]
    #[arg(long, help_heading = HEADING, value_name = "FILE", requires = "tls_key")]
    pub tls_cert: Option<PathBuf>,
    /// Private key of that certificate (PEM)
    #[cfg(feature = "tls")]
    #[arg(long, help_heading = HEADING, value_name = "FILE", requires = "tls_cert")]
    pub tls_key: Option<PathBuf>,
    /// Certificates of the authorities whose certificates the other side has to have (PEM)
    #[cfg(feature = "tls")]
    #[arg(long, help_heading = HEADING, value_name = "FILE")]
    pub tls_ca: Option<PathBuf>,
    /// Let anybody connect who reaches an address that other machines can reach
    #[arg(long, help_heading = HEADING)]
    pub insecure: bool,
    /// Peers over TCP at a time
    #[arg(long, help_heading = HEADING, value_name = "N", default_value_t = 64,
        value_parser = clap::value_parser!(u16).range(1..))]
    pub max_peers: u16,
}
