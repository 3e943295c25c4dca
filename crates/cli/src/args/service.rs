//! The arguments of `pickline service` and `pickline man`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Run lines as systemd services: show the unit, or install everything it needs
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline service
  sudo pickline service install
  pickline service install --root image --prefix /usr")]
pub(crate) struct ServiceArgs {
    #[command(subcommand)]
    pub command: Option<ServiceCommand>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ServiceCommand {
    /// Print the systemd unit
    #[command(after_long_help = "Example:\n  pickline service show --prefix /usr")]
    Show {
        #[command(flatten)]
        place: PlaceArgs,
    },
    /// Install the program, unit, manual pages, completions and example files in /etc
    ///
    /// Existing files in /etc are kept. Other files are replaced only if this command wrote
    /// them and they have not been changed since.
    #[command(after_long_help = "Example:\n  sudo pickline service install")]
    Install {
        #[command(flatten)]
        place: PlaceArgs,
        /// Replace files even if this command did not write them, except in /etc
        #[arg(long)]
        force: bool,
    },
    /// Remove what `install` wrote, except changed files and everything in /etc
    #[command(after_long_help = "Example:\n  sudo pickline service uninstall")]
    Uninstall {
        #[command(flatten)]
        place: PlaceArgs,
    },
}

/// Where to install.
#[derive(Debug, Clone, Args)]
pub(crate) struct PlaceArgs {
    /// The folder that holds bin, lib and share
    #[arg(long, value_name = "DIR", default_value = "/usr/local")]
    pub prefix: PathBuf,
    /// Install below this folder instead of /, for an image or a package
    #[arg(long, value_name = "DIR")]
    pub root: Option<PathBuf>,
}

impl Default for ServiceCommand {
    /// The default of `pickline service` without a subcommand.
    fn default() -> Self {
        Self::Show {
            place: PlaceArgs {
                prefix: "/usr/local".into(),
                root: None,
            },
        }
    }
}

/// Print a manual page in the format that `man` reads
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline man run | man -l -
  pickline man station check > pickline-station-check.1")]
pub(crate) struct ManArgs {
    /// The command [default: the program itself]
    #[arg(value_name = "COMMAND")]
    pub command: Vec<String>,
}
