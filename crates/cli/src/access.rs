//! From what was typed about who may connect to what is asked of those who do.

use super::args::{AccessArgs, TransportArgs};
use pickline::error::{Error, Result, shown};
use pickline_live::transport::tls::{Files, Tls};
use pickline_live::transport::{Access, Side, Token};
use std::net::ToSocketAddrs as _;

impl AccessArgs {
    /// What is asked of those who connect to this program.
    ///
    /// # Errors
    /// Files that cannot be read, or do not hold what they should.
    pub fn listening(&self) -> Result<Access> {
        // Authorities alone are for --connect; see `check`.
        self.resolve(|files| files.certificate.is_some().then(|| Tls::listening(files)))
    }

    /// What is asked of the one that this program connects to.
    ///
    /// # Errors
    /// Files that cannot be read, or do not hold what they should.
    pub fn connecting(&self) -> Result<Access> {
        self.resolve(|files| files.is_any().then(|| Tls::connecting(files)))
    }

    fn resolve(&self, tls: impl Fn(&Files) -> Option<Result<Tls>>) -> Result<Access> {
        Ok(Access {
            token: self.token.as_deref().map(Token::read).transpose()?,
            tls: tls(&self.files()).transpose()?,
        })
    }

    fn files(&self) -> Files {
        #[cfg(feature = "tls")]
        let files = Files {
            certificate: self.tls_cert.clone(),
            key: self.tls_key.clone(),
            authorities: self.tls_ca.clone(),
        };
        #[cfg(not(feature = "tls"))]
        let files = Files::default();
        files
    }

    /// Checks that something is asked of the other side where others than this machine can
    /// be that, and that there is somebody to ask. `dashboard` is its address.
    ///
    /// # Errors
    /// An open address that others reach, unless that is said to be wanted; a secret that
    /// nobody is asked for or shown.
    pub fn check(
        &self,
        side: Side,
        transport: &TransportArgs,
        dashboard: Option<&str>,
    ) -> Result<()> {
        let files = self.files();
        let listen = ("--listen", transport.listen.as_deref());
        let connect = ("--connect", transport.connect.as_deref());
        let dashboard = ("--dashboard", dashboard);
        // Who connects shows the token to the node that listens.
        let by_token = match side {
            Side::Node => vec![listen, dashboard],
            Side::Station => vec![connect],
        };
        let is_any = |places: &[(&str, Option<&str>)]| places.iter().any(|(_, at)| at.is_some());
        if self.token.is_some() && !is_any(&by_token) {
            let cure = "the node that listens asks for it, and whoever connects shows it; who \
                        answers at --connect is checked with --tls-ca";
            return Err(Error::input("--token", "nobody is asked for it", cure));
        }
        if files.is_any() && !is_any(&[listen, connect, dashboard]) {
            let cure = "give --listen, --connect or --dashboard as well, or leave it out";
            return Err(Error::input("--tls-ca", "nobody connects over TCP", cure));
        }
        if files.authorities.is_some() && files.certificate.is_none() && !is_any(&[connect]) {
            let cure = "give --tls-cert and --tls-key too";
            let problem = "whoever listens with TLS needs a certificate of its own";
            return Err(Error::input("--tls-ca", problem, cure));
        }
        if self.insecure {
            return Ok(());
        }
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
                _ => "command",
            };
            return Err(Error::input(
                flag,
                format!(
                    "{} is not of this machine alone: whoever is in that network could {what} \
                     the line",
                    shown(address)
                ),
                format!("{}; or --insecure if nobody else is in it", cure(flag)),
            ));
        }
        Ok(())
    }
}

fn cure(flag: &str) -> &'static str {
    match (flag, cfg!(feature = "tls")) {
        ("--connect", true) => "give --tls-ca FILE, which checks who answers",
        ("--connect", false) => "connect over an encrypted tunnel to a loopback address",
        (_, true) => {
            "give --token FILE, a secret to ask for, or --tls-cert, --tls-key and --tls-ca, to \
             ask for certificates"
        }
        (_, false) => "give --token FILE, a secret to ask for",
    }
}

/// Whether only this machine reaches an address. One that is none is told of where it is
/// used.
fn is_local(address: &str) -> bool {
    let found = address.to_socket_addrs();
    found.map_or(true, |mut all| all.all(|at| at.ip().is_loopback()))
}
