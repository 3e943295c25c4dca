//! Turns the MQTT arguments into transport settings.

use super::args::MqttArgs;
use pickline::error::{Error, Result};
use pickline::files::read_text;
use pickline_live::ClockKind;
use pickline_live::transport::Side;
use pickline_live::transport::mqtt::{Broker, MqttSettings};
use std::path::{Path, PathBuf};

/// The environment variable that holds the password.
const PASSWORD: &str = "PICKLINE_MQTT_PASSWORD";

impl MqttArgs {
    /// The settings for the broker; `None` without `--mqtt`.
    ///
    /// # Errors
    /// Invalid or contradictory arguments, or files that cannot be read.
    pub(crate) fn resolve(&self, side: Side, clock: ClockKind) -> Result<Option<MqttSettings>> {
        let Some(url) = &self.mqtt else {
            return Ok(None);
        };
        let mut broker = Broker::read(url)?;
        if let Some(user) = &self.mqtt_user {
            broker.user = Some(user.clone());
        }
        if let Some(password) = self.password()? {
            broker.password = Some(password);
        }
        if broker.password.is_some() && broker.user.is_none() {
            let cure = "give --mqtt-user";
            return Err(Error::usage(
                "--mqtt",
                "there is a password but no user name",
                cure,
            ));
        }
        if self.mqtt_ca.is_some() && !broker.tls {
            let cure = "use mqtts:// for TLS";
            return Err(Error::usage(
                "--mqtt-ca",
                format!("{broker} does not use TLS"),
                cure,
            ));
        }
        let read = |file: &Option<PathBuf>| -> Result<Option<Vec<u8>>> {
            file.as_ref().map(|file| read_pem(file)).transpose()
        };
        let settings = MqttSettings::new(broker, &self.mqtt_prefix, side, clock)
            .with_client_id(self.mqtt_client_id.clone())
            .with_authorities(read(&self.mqtt_ca)?)
            .with_certificate(read(&self.mqtt_cert)?.zip(read(&self.mqtt_key)?));
        Ok(Some(settings))
    }

    fn password(&self) -> Result<Option<String>> {
        if let Some(file) = &self.mqtt_password_file {
            let text = read_text(file)?;
            let password = text.trim_end_matches(['\n', '\r']);
            if password.is_empty() || password.contains('\n') {
                let place = file.display().to_string();
                let cure = "write only the password, on one line";
                return Err(Error::input(
                    place,
                    "the file is not exactly one line",
                    cure,
                ));
            }
            return Ok(Some(password.to_owned()));
        }
        match std::env::var(PASSWORD) {
            Ok(password) => Ok(Some(password).filter(|password| !password.is_empty())),
            Err(std::env::VarError::NotPresent) => Ok(None),
            Err(_) => Err(Error::usage(
                PASSWORD,
                "it is not valid UTF-8",
                "use another password",
            )),
        }
    }
}

fn read_pem(file: &Path) -> Result<Vec<u8>> {
    let text = read_text(file)?;
    if text.contains("-----BEGIN ") {
        return Ok(text.into_bytes());
    }
    let place = file.display().to_string();
    let problem = "the file has no -----BEGIN line";
    Err(Error::input(place, problem, "give a PEM file"))
}
