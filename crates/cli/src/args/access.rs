//! The arguments that control who may connect.

use clap::Args;
use std::path::PathBuf;

/// Named by each argument: a heading on the struct would also apply to the arguments after it.
const HEADING: &str = "Access control";

/// Who may connect over TCP, and to the dashboard.
#[derive(Debug, Clone, Args)]
pub(crate) struct AccessArgs {
    /// Require the token in this file from TCP peers, in their hello, and from browsers of
    /// the dashboard, as the password; emulate sends it
    #[arg(long, help_heading = HEADING, value_name = "FILE")]
    pub token: Option<PathBuf>,
    /// Certificate of this program (PEM); enables TLS for --listen and --dashboard
    #[cfg(feature = "tls")]
    #[arg(long, help_heading = HEADING, value_name = "FILE", requires = "tls_key")]
    pub tls_cert: Option<PathBuf>,
    /// Private key of that certificate (PEM)
    #[cfg(feature = "tls")]
    #[arg(long, help_heading = HEADING, value_name = "FILE", requires = "tls_cert")]
    pub tls_key: Option<PathBuf>,
    /// Certificate authorities that must have issued the other side's certificate (PEM)
    #[cfg(feature = "tls")]
    #[arg(long, help_heading = HEADING, value_name = "FILE")]
    pub tls_ca: Option<PathBuf>,
    /// Allow an address that other machines can reach, without checking who connects
    #[arg(long, help_heading = HEADING)]
    pub insecure: bool,
    /// Maximum number of simultaneous TCP peers
    #[arg(long, help_heading = HEADING, value_name = "N", default_value_t = 64,
        value_parser = clap::value_parser!(u16).range(1..))]
    pub max_peers: u16,
}
