//! TLS between peers, with certificates on one or both sides.

use pickline::error::{Error, Result};
use std::path::PathBuf;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;

/// A bidirectional connection.
pub trait ByteStream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<S: AsyncRead + AsyncWrite + Send + Unpin> ByteStream for S {}

/// A connection, encrypted or not.
pub type Stream = Box<dyn ByteStream>;

/// The files for TLS (PEM).
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct TlsFiles {
    /// Certificate of this side, with the chain to its authority.
    pub certificate: Option<PathBuf>,
    /// Private key of that certificate.
    pub key: Option<PathBuf>,
    /// Certificates of the authorities trusted to sign the other side's certificate.
    pub authorities: Option<PathBuf>,
}

impl TlsFiles {
    /// With this certificate of this side.
    #[must_use]
    pub fn with_certificate(mut self, certificate: impl Into<Option<PathBuf>>) -> Self {
        self.certificate = certificate.into();
        self
    }

    /// With the private key of the certificate.
    #[must_use]
    pub fn with_key(mut self, key: impl Into<Option<PathBuf>>) -> Self {
        self.key = key.into();
        self
    }

    /// With the certificates of these authorities.
    #[must_use]
    pub fn with_authorities(mut self, authorities: impl Into<Option<PathBuf>>) -> Self {
        self.authorities = authorities.into();
        self
    }

    /// Whether any file is given.
    pub fn is_any(&self) -> bool {
        self.certificate.is_some() || self.key.is_some() || self.authorities.is_some()
    }
}

#[cfg(feature = "tls")]
pub use with_rustls::Tls;
#[cfg(not(feature = "tls"))]
pub use without::Tls;

#[cfg(feature = "tls")]
mod with_rustls {
    use super::*;
    use std::path::Path;
    use std::sync::Arc;
    use tokio_rustls::rustls::crypto::ring;
    use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
    use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
    use tokio_rustls::rustls::server::WebPkiClientVerifier;
    use tokio_rustls::rustls::{self, ClientConfig, RootCertStore, ServerConfig};
    use tokio_rustls::{TlsAcceptor, TlsConnector};

    /// How connections are encrypted, and whose certificates are trusted.
    #[derive(Clone)]
    pub struct Tls {
        accepts: Option<TlsAcceptor>,
        connects: Option<TlsConnector>,
        checks_peers: bool,
    }

    impl std::fmt::Debug for Tls {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.debug_struct("Tls")
                .field("checks_peers", &self.checks_peers)
                .finish_non_exhaustive()
        }
    }

    impl Tls {
        /// TLS for the listening side. With `authorities` only peers with a certificate from them
        /// are admitted.
        ///
        /// # Errors
        /// A file is missing, or contains no certificate or no matching key.
        pub fn listening(files: &TlsFiles) -> Result<Self> {
            let (Some(certificate), Some(key)) = (&files.certificate, &files.key) else {
                return Err(Error::usage(
                    "'tls_cert'",
                    "the listening side needs a certificate and its key for TLS",
                    "give 'tls_cert' and 'tls_key'; add 'tls_ca' to require certificates of peers",
                ));
            };
            let builder = ServerConfig::builder_with_provider(ring::default_provider().into())
                .with_safe_default_protocol_versions()
                .map_err(|error| unusable("'tls_cert'", &error))?;
            let builder = match &files.authorities {
                None => builder.with_no_client_auth(),
                Some(file) => {
                    let roots = Arc::new(roots(file)?);
                    let provider = ring::default_provider().into();
                    let verifier = WebPkiClientVerifier::builder_with_provider(roots, provider);
                    let verifier = verifier.build().map_err(|error| {
                        let cure = "give the certificate of an authority";
                        Error::input(file.display().to_string(), error.to_string(), cure)
                            .caused_by(error)
                    })?;
                    builder.with_client_cert_verifier(verifier)
                }
            };
            let config = builder
                .with_single_cert(certificates(certificate)?, private_key(key)?)
                .map_err(|error| unusable("'tls_key'", &error))?;
            Ok(Self {
                accepts: Some(TlsAcceptor::from(Arc::new(config))),
                connects: None,
                checks_peers: files.authorities.is_some(),
            })
        }

        /// TLS for the connecting side. The other side needs a certificate from `authorities`; this
        /// side's certificate is sent if requested.
        ///
        /// # Errors
        /// A file is missing, or contains no certificate or no matching key.
        pub fn connecting(files: &TlsFiles) -> Result<Self> {
            let Some(authorities) = &files.authorities else {
                return Err(Error::usage(
                    "'tls_ca'",
                    "the connecting side needs to know which certificates to trust",
                    "give the certificate of the other side's authority with 'tls_ca'",
                ));
            };
            let builder = ClientConfig::builder_with_provider(ring::default_provider().into())
                .with_safe_default_protocol_versions()
                .map_err(|error| unusable("'tls_ca'", &error))?
                .with_root_certificates(roots(authorities)?);
            let config = match (&files.certificate, &files.key) {
                (None, None) => builder.with_no_client_auth(),
                (Some(certificate), Some(key)) => builder
                    .with_client_auth_cert(certificates(certificate)?, private_key(key)?)
                    .map_err(|error| unusable("'tls_key'", &error))?,
                _ => {
                    return Err(Error::usage(
                        "'tls_cert'",
                        "a certificate and its key belong together",
                        "give both 'tls_cert' and 'tls_key'",
                    ));
                }
            };
            Ok(Self {
                accepts: None,
                connects: Some(TlsConnector::from(Arc::new(config))),
                checks_peers: true,
            })
        }

        /// Whether the other side needs a trusted certificate.
        pub(crate) fn checks_peers(&self) -> bool {
            self.checks_peers
        }

        /// Encrypts an accepted connection.
        ///
        /// # Errors
        /// The other side does not speak TLS, or presents no trusted certificate.
        pub async fn accept(&self, stream: TcpStream) -> std::io::Result<Stream> {
            match &self.accepts {
                Some(acceptor) => Ok(Box::new(acceptor.accept(stream).await?)),
                None => Err(std::io::Error::other("this side does not listen")),
            }
        }

        /// Encrypts a connection to `host`.
        ///
        /// # Errors
        /// As for [`Tls::accept`].
        pub async fn connect(&self, host: &str, stream: TcpStream) -> std::io::Result<Stream> {
            let name = host
                .trim_start_matches('[')
                .trim_end_matches(']')
                .to_owned();
            let name = ServerName::try_from(name).map_err(std::io::Error::other)?;
            match &self.connects {
                Some(connector) => Ok(Box::new(connector.connect(name, stream).await?)),
                None => Err(std::io::Error::other("this side does not connect")),
            }
        }
    }

    fn unusable(flag: &str, error: &rustls::Error) -> Error {
        let cure = "give a certificate and its private key, as PEM files";
        Error::usage(flag, error.to_string(), cure).caused_by(error.clone())
    }

    fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>> {
        let read: std::result::Result<Vec<_>, pem::Error> =
            CertificateDer::pem_file_iter(file).and_then(Iterator::collect);
        match read {
            Ok(found) if !found.is_empty() => Ok(found),
            Ok(_) => Err(no_pem(file, "certificate", "CERTIFICATE")),
            Err(error) => Err(unread(file, error, "certificate", "CERTIFICATE")),
        }
    }

    fn private_key(file: &Path) -> Result<PrivateKeyDer<'static>> {
        PrivateKeyDer::from_pem_file(file)
            .map_err(|error| unread(file, error, "private key", "PRIVATE KEY"))
    }

    fn roots(file: &Path) -> Result<RootCertStore> {
        let mut roots = RootCertStore::empty();
        for certificate in certificates(file)? {
            roots.add(certificate).map_err(|error| {
                let cure = "give the certificate of an authority, as a PEM file";
                Error::input(file.display().to_string(), error.to_string(), cure).caused_by(error)
            })?;
        }
        Ok(roots)
    }

    fn unread(file: &Path, error: pem::Error, what: &str, section: &str) -> Error {
        match error {
            pem::Error::Io(error) => Error::read(file, error),
            _ => no_pem(file, what, section),
        }
    }

    fn no_pem(file: &Path, what: &str, section: &str) -> Error {
        Error::input(
            file.display().to_string(),
            format!("it contains no {what}"),
            format!("give a PEM file with a section -----BEGIN {section}-----"),
        )
    }
}

/// The replacement in a build without TLS.
#[cfg(not(feature = "tls"))]
mod without {
    use super::*;

    /// There is no TLS in this build.
    #[derive(Debug, Clone)]
    pub enum Tls {}

    impl Tls {
        /// Refused: there is no TLS in this build.
        ///
        /// # Errors
        /// Always.
        pub fn listening(_: &TlsFiles) -> Result<Self> {
            Err(Error::usage(
                "'tls_cert'",
                "pickline was built without the feature `tls`",
                "build it with that feature, or leave out the TLS settings",
            ))
        }

        /// Refused: there is no TLS in this build.
        ///
        /// # Errors
        /// Always.
        pub fn connecting(files: &TlsFiles) -> Result<Self> {
            Self::listening(files)
        }

        /// Whether the other side needs a trusted certificate.
        pub(crate) fn checks_peers(&self) -> bool {
            match *self {}
        }

        /// Encrypts an accepted connection.
        ///
        /// # Errors
        /// None: there is no TLS.
        #[expect(clippy::unused_async, reason = "as with TLS")]
        pub async fn accept(&self, _: TcpStream) -> std::io::Result<Stream> {
            match *self {}
        }

        /// Encrypts a connection to `host`.
        ///
        /// # Errors
        /// None: there is no TLS.
        #[expect(clippy::unused_async, reason = "as with TLS")]
        pub async fn connect(&self, _: &str, _: TcpStream) -> std::io::Result<Stream> {
            match *self {}
        }
    }
}
