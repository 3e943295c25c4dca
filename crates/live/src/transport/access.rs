//! Who may talk to this program: those that know a token, or have a certificate.

use super::tls::Tls;
use pickline::error::{Error, Result};
use pickline::files::read_text;
use sha2::{Digest, Sha256};
use std::path::Path;
use subtle::ConstantTimeEq as _;

/// A token has at least so many characters: 64 bits, if they are hexadecimal digits drawn
/// at random.
const SHORTEST: usize = 16;
/// A token has at most so many characters; a line holds it with room to spare.
const LONGEST: usize = 1024;

/// A secret that both sides know.
#[derive(Clone)]
pub struct Token {
    text: String,
    digest: [u8; 32],
}

impl Token {
    /// The token in a file: one line, of which others than its owner and group know nothing.
    ///
    /// # Errors
    /// A file that cannot be read, that others can read or the group can change, or that
    /// holds anything but one line of 16 to 1024 printable characters.
    pub fn read(file: &Path) -> Result<Self> {
        let place = file.display().to_string();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            let about = std::fs::metadata(file).map_err(|error| Error::read(file, error))?;
            let mode = about.permissions().mode() & 0o777;
            if about.is_file() && mode & 0o027 != 0 {
                return Err(Error::input(
                    place,
                    format!("its permissions are {mode:03o}: others than its owner can use it"),
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
                    "this is not one line of {SHORTEST} to {LONGEST} printable ASCII characters \
                     without blanks"
                ),
                format!("make one with `openssl rand -hex 32 > {}`", file.display()),
            ));
        }
        Ok(Self::new(text))
    }

    /// This text as a token.
    pub fn new(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            digest: Sha256::digest(text.as_bytes()).into(),
        }
    }

    /// Whether `given` is the token, found out in a time that does not depend on where the
    /// two differ. Digests are compared, so that their lengths do not matter either.
    pub fn is(&self, given: &str) -> bool {
        let given: [u8; 32] = Sha256::digest(given.as_bytes()).into();
        self.digest.ct_eq(&given).into()
    }

    /// The token itself, to be sent.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// Without the secret.
impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token")
    }
}

/// What whoever connects has to show.
#[derive(Debug, Clone, Default)]
pub struct Access {
    /// The secret that it has to know.
    pub token: Option<Token>,
    /// How connections are encrypted, and whose certificates are trusted.
    pub tls: Option<Tls>,
}

impl Access {
    /// Whether strangers are kept out.
    pub fn is_closed(&self) -> bool {
        self.token.is_some() || self.tls.as_ref().is_some_and(Tls::checks_peers)
    }

    /// The scheme of an address at which a page is.
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
        // What systemd makes of a credential.
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
