//! Access control: a peer needs the token, or a certificate.

use super::tls::Tls;
use pickline::error::{Error, Result};
use pickline::files::read_text;
use sha2::{Digest, Sha256};
use std::path::Path;
use subtle::ConstantTimeEq as _;

/// Minimum length of a token: 64 bits, if they are random hexadecimal digits.
const SHORTEST: usize = 16;
/// Maximum length of a token; it easily fits into a line.
const LONGEST: usize = 1024;

/// A shared secret.
#[derive(Clone)]
pub struct Token {
    text: String,
    digest: [u8; 32],
}

impl Token {
    /// Reads the token from a file with one line, which only its owner and group may read.
    ///
    /// # Errors
    /// The file cannot be read, others can read it or the group can change it, or it is not one
    /// line of 16 to 1024 printable characters.
    pub fn read(file: &Path) -> Result<Self> {
        let place = file.display().to_string();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            let about = std::fs::metadata(file).map_err(|error| Error::read(file, error))?;
            let mode = about.permissions().mode() & 0o777;
            if about.is_file() && mode & 0o027 != 0 {
                return Err(Error::path(
                    place,
                    format!(
                        "its permissions are {mode:03o}: it must not be accessible to other \
                             users"
                    ),
                    format!("run `chmod 600 {}`", file.display()),
                ));
            }
        }
        let text = read_text(file)?;
        let text = text.trim_end_matches(['\n', '\r']);
        let count = text.chars().count();
        if !(SHORTEST..=LONGEST).contains(&count) || !text.chars().all(|c| c.is_ascii_graphic()) {
            return Err(Error::input(
                place,
                format!(
                    "expected one line of {SHORTEST} to {LONGEST} printable ASCII characters \
                     without spaces"
                ),
                format!(
                    "create one with `openssl rand -hex 32 > {}`",
                    file.display()
                ),
            ));
        }
        Ok(Self::new(text))
    }

    /// A token with this text.
    pub fn new(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            digest: Sha256::digest(text.as_bytes()).into(),
        }
    }

    /// Whether `given` is the token, compared in constant time. Digests are compared, so that the
    /// lengths do not matter either.
    pub fn is(&self, given: &str) -> bool {
        let given: [u8; 32] = Sha256::digest(given.as_bytes()).into();
        self.digest.ct_eq(&given).into()
    }

    /// The token itself, to be sent.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// Hides the secret.
impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token")
    }
}

/// What a peer must present when it connects.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Access {
    /// The secret that a peer sends in its hello; if none, no token is needed.
    pub token: Option<Token>,
    /// How connections are encrypted, and whose certificates are trusted.
    pub tls: Option<Tls>,
}

impl Access {
    /// With this token.
    #[must_use]
    pub fn with_token(mut self, token: impl Into<Option<Token>>) -> Self {
        self.token = token.into();
        self
    }

    /// With connections that are encrypted like this.
    #[must_use]
    pub fn with_tls(mut self, tls: impl Into<Option<Tls>>) -> Self {
        self.tls = tls.into();
        self
    }

    /// Whether peers must present anything.
    pub fn is_closed(&self) -> bool {
        self.token.is_some() || self.tls.as_ref().is_some_and(Tls::checks_peers)
    }

    /// The URL scheme of the dashboard.
    pub fn scheme(&self) -> &'static str {
        if self.tls.is_some() { "https" } else { "http" }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_token_is_one_long_line_that_only_its_owner_can_read() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("token");
        let read = |text: &str, mode: u32| {
            let _ = std::fs::remove_file(&file);
            std::fs::write(&file, text).unwrap();
            let permissions = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(&file, permissions).unwrap();
            Token::read(&file).map_err(|error| error.to_string())
        };
        let good = "0123456789abcdef";
        let token = read(&format!("{good}\n"), 0o600).unwrap();
        assert!(token.is(good) && !token.is("0123456789abcdeF") && !token.is(""));
        assert!(!format!("{token:?}").contains(good));
        // The permissions of a systemd credential.
        assert!(read(good, 0o440).is_ok() && read(good, 0o400).is_ok());
        for mode in [0o644, 0o604, 0o620, 0o666] {
            let error = read(good, mode).unwrap_err();
            assert!(error.contains("chmod 600"), "{error}");
        }
        let long = "x".repeat(2000);
        for text in [
            "",
            "\n",
            "short",
            "0123456789abcde f",
            "0123456789abcdef\n0123456789abcdef",
            &long,
        ] {
            let error = read(text, 0o600).unwrap_err();
            assert!(error.contains("openssl rand -hex 32"), "{error}");
        }
    }
}
