//! Certificates for tests, made by the program `openssl`.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs `openssl` with these arguments, separated by blanks, in `folder`.
pub fn openssl(folder: &Path, arguments: &str) {
    let mut command = Command::new("openssl");
    let arguments = arguments.split_whitespace();
    let output = command.args(arguments).current_dir(folder).output();
    let output = output.unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
}

/// Arguments that make a new key.
pub const NEW_KEY: &str = "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes";

/// Makes an authority, and certificates of it for `names`: `ca.pem`, `NAME.pem` and
/// `NAME.key` in `folder`.
pub fn authority(folder: &Path, names: &[&str]) {
    let openssl = |arguments: &str| openssl(folder, arguments);
    openssl(&format!(
        "req -x509 {NEW_KEY} -keyout ca.key -out ca.pem -days 2 -subj /CN=test-authority"
    ));
    fs::write(
        folder.join("names"),
        "subjectAltName=IP:127.0.0.1,DNS:localhost\n",
    )
    .unwrap();
    for name in names {
        openssl(&format!(
            "req {NEW_KEY} -keyout {name}.key -out {name}.csr -subj /CN={name}"
        ));
        openssl(&format!(
            "x509 -req -in {name}.csr -CA ca.pem -CAkey ca.key -CAcreateserial -out {name}.pem \
             -days 2 -extfile names"
        ));
    }
}
