//! Turns the access arguments into the checks on whoever connects.

use super::args::AccessArgs;
use pickline::error::{Error, Result, shown};
use pickline_live::transport::tls::{Tls, TlsFiles};
use pickline_live::transport::{Access, Side, Token};
use std::net::ToSocketAddrs as _;

/// The addresses over which other programs may reach this one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TcpAddresses<'a> {
    /// Where it listens.
    pub listen: Option<&'a str>,
    /// Where it connects to.
    pub connect: Option<&'a str>,
    /// Where its dashboard is.
    pub dashboard: Option<&'a str>,
}

/// A flag and its value, if it is given.
type FlagValue<'a> = (&'static str, Option<&'a str>);

impl AccessArgs {
    /// The token and TLS settings for peers that connect to this program.
    ///
    /// # Errors
    /// Files that cannot be read or have invalid content.
    pub(crate) fn listening(&self) -> Result<Access> {
        // Authorities without a certificate are for --connect; see `check`.
        self.resolve(|files| files.certificate.is_some().then(|| Tls::listening(files)))
    }

    /// The token and TLS settings for the peer that this program connects to.
    ///
    /// # Errors
    /// Files that cannot be read or have invalid content.
    pub(crate) fn connecting(&self) -> Result<Access> {
        self.resolve(|files| files.is_any().then(|| Tls::connecting(files)))
    }

    fn resolve(&self, tls: impl Fn(&TlsFiles) -> Option<Result<Tls>>) -> Result<Access> {
        Ok(Access::default()
            .with_token(self.token.as_deref().map(Token::read).transpose()?)
            .with_tls(tls(&self.files()).transpose()?))
    }

    fn files(&self) -> TlsFiles {
        #[cfg(feature = "tls")]
        let files = TlsFiles::default()
            .with_certificate(self.tls_cert.clone())
            .with_key(self.tls_key.clone())
            .with_authorities(self.tls_ca.clone());
        #[cfg(not(feature = "tls"))]
        let files = TlsFiles::default();
        files
    }

    /// Checks that the other side must authenticate wherever it can be another machine, and
    /// that no token or certificate is unused.
    ///
    /// # Errors
    /// An unprotected address that other machines can reach, unless `--insecure` is given; a
    /// token or a certificate that is never used.
    pub(crate) fn check(&self, side: Side, addresses: TcpAddresses) -> Result<()> {
        let files = self.files();
        let listen = ("--listen", addresses.listen);
        let connect = ("--connect", addresses.connect);
        let dashboard = ("--dashboard", addresses.dashboard);
        // The side that connects sends the token to the node that listens.
        let by_token = match side {
            Side::Node => vec![listen, dashboard],
            Side::Station => vec![connect],
        };
        let is_any = |places: &[(&str, Option<&str>)]| places.iter().any(|(_, at)| at.is_some());
        if self.token.is_some() && !is_any(&by_token) {
            let cure = "use it on a node that listens, and on the emulator that connects to it; \
                        --tls-ca checks the program that answers at --connect";
            return Err(Error::usage("--token", "it is not used here", cure));
        }
        if files.is_any() && !is_any(&[listen, connect, dashboard]) {
            let cure = "give --listen, --connect or --dashboard as well, or leave it out";
            return Err(Error::usage("--tls-ca", "there is no TCP connection", cure));
        }
        if files.authorities.is_some() && files.certificate.is_none() && !is_any(&[connect]) {
            let cure = "also give --tls-cert and --tls-key";
            let problem = "listening with TLS requires a certificate";
            return Err(Error::usage("--tls-ca", problem, cure));
        }
        match self.insecure {
            true => Ok(()),
            false => self.check_reach(side, &files, listen, connect, dashboard),
        }
    }

    /// Checks that no address without authentication can be reached by other machines.
    fn check_reach(
        &self,
        side: Side,
        files: &TlsFiles,
        listen: FlagValue,
        connect: FlagValue,
        dashboard: FlagValue,
    ) -> Result<()> {
        let who_answers_is_checked = files.authorities.is_some();
        let who_connects_is_checked = who_answers_is_checked && files.certificate.is_some();
        let mut open = Vec::new();
        if !who_connects_is_checked {
            let listening = [listen, dashboard];
            let asks = side == Side::Node && self.token.is_some();
            open.extend(listening.into_iter().filter(|_| !asks));
        }
        if side == Side::Node && !who_answers_is_checked {
            open.push(connect);
        }
        for (flag, address) in open {
            let Some(address) = address.filter(|address| !is_local(address)) else {
                continue;
            };
            let what = match flag {
                "--dashboard" => "watch",
                _ => "control",
            };
            return Err(Error::usage(
                flag,
                format!(
                    "other machines can reach {}, so anyone in that network could {what} the \
                     line",
                    shown(address)
                ),
                format!(
                    "{}; or --insecure if nobody else is in that network",
                    cure(flag)
                ),
            ));
        }
        Ok(())
    }
}

fn cure(flag: &str) -> &'static str {
    match (flag, cfg!(feature = "tls")) {
        ("--connect", true) => "give --tls-ca FILE, which checks the program that answers",
        ("--connect", false) => "connect over an encrypted tunnel to a loopback address",
        (_, true) => {
            "give --token FILE to require a secret, or --tls-cert, --tls-key and --tls-ca to \
             require certificates"
        }
        (_, false) => "give --token FILE to require a secret",
    }
}

/// Whether only this machine can reach an address. An invalid address is reported where it
/// is used.
fn is_local(address: &str) -> bool {
    let found = address.to_socket_addrs();
    found.map_or(true, |mut all| all.all(|at| at.ip().is_loopback()))
}
