//! What `pickline service` and `pickline man` are given.

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Run lines as services of systemd: show the unit, install all that belongs to it
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline service
  sudo pickline service install
  pickline service install --root image --prefix /usr")]
pub struct ServiceArgs {
    #[command(subcommand)]
    pub command: Option<ServiceCommand>,
}

#[derive(Debug, Subcommand)]
pub enum ServiceCommand {
    /// Print the unit
    #[command(after_long_help = "Example:\n  pickline service show --prefix /usr")]
    Show {
        #[command(flatten)]
        place: PlaceArgs,
    },
    /// Install program, unit, manual pages, completions and examples of what goes into /etc
    ///
    /// What stands in /etc already is kept. Other files are replaced only if this command wrote
    /// them and nobody has changed them since.
    #[command(after_long_help = "Example:\n  sudo pickline service install")]
    Install {
        #[command(flatten)]
        place: PlaceArgs,
        /// Replace files whoever wrote them; not those in /etc
        #[arg(long)]
        force: bool,
    },
    /// Remove what install wrote and nobody has changed since; what is in /etc stays
    #[command(after_long_help = "Example:\n  sudo pickline service uninstall")]
    Uninstall {
        #[command(flatten)]
        place: PlaceArgs,
    },
}

/// Where it is installed.
#[derive(Debug, Clone, Args)]
pub struct PlaceArgs {
    /// The folder of bin, lib and share
    #[arg(long, value_name = "DIR", default_value = "/usr/local")]
    pub prefix: PathBuf,
    /// Put all below this folder instead of /: for an image or a package
    #[arg(long, value_name = "DIR")]
    pub root: Option<PathBuf>,
}

impl Default for ServiceCommand {
    /// What `pickline service` alone does.
    fn default() -> Self {
        Self::Show {
            place: PlaceArgs {
                prefix: "/usr/local".into(),
                root: None,
            },
        }
    }
}

/// Print a manual page, as man reads it
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline man run | man -l -
  pickline man station check > pickline-station-check.1")]
pub struct ManArgs {
    /// The command; the program itself when not given
    #[arg(value_name = "COMMAND")]
    pub command: Vec<String>,
}
