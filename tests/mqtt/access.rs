//! Passwords and certificates.

use crate::authority::{NEW_KEY, authority, openssl};
use crate::broker::Broker;
use crate::programs::Program;
use std::fs;

#[test]
fn passwords_and_certificates_are_asked_for() {
    let mut broker = Broker::place(
        "allow_anonymous false\npassword_file FOLDER/users\n\
         cafile FOLDER/ca.pem\ncertfile FOLDER/broker.pem\nkeyfile FOLDER/broker.key\n\
         require_certificate true\n",
    );
    authority(broker.path("").as_path(), &["broker", "line"]);
    let users = broker.path("users");
    let mut passwd = std::process::Command::new("mosquitto_passwd");
    let passwd = passwd
        .args(["-c", "-b"])
        .arg(&users)
        .args(["line", "s3cret-word"]);
    assert!(passwd.status().unwrap().success());
    broker.start();
    let file = |name: &str| broker.path(name).display().to_string();
    let url = format!("mqtts://127.0.0.1:{}", broker.port);
    let (ca, cert, key) = (file("ca.pem"), file("line.pem"), file("line.key"));
    let whole = format!("--mqtt {url} --mqtt-ca {ca} --mqtt-cert {cert} --mqtt-key {key}");
    let right = [("PICKLINE_MQTT_PASSWORD", "s3cret-word")];
    let wrong = [("PICKLINE_MQTT_PASSWORD", "wr0ng-word")];
    for (arguments, environment, word) in [
        (
            format!("{whole} --mqtt-user line"),
            &wrong[..],
            "refuses user `line`",
        ),
        (whole.clone(), &[], "requires a user"),
        (
            format!(
                "--mqtt mqtts://line:wr0ng-word@127.0.0.1:{} --mqtt-ca {ca} --mqtt-cert {cert} \
            --mqtt-key {key}",
                broker.port
            ),
            &[],
            "refuses user `line`",
        ),
        (
            format!("--mqtt {url} --mqtt-user line"),
            &right[..],
            "--mqtt-ca",
        ),
        (
            format!("--mqtt {url} --mqtt-user line --mqtt-ca {ca}"),
            &right[..],
            "requires a client certificate",
        ),
        (
            format!("--mqtt {url} --mqtt-user line --mqtt-ca {cert}"),
            &right[..],
            "no TLS with",
        ),
        (whole.clone(), &right[..], "no user"),
    ] {
        let mut node = Program::pickline(&format!("run {arguments}"), environment);
        let (code, remarks) = node.finish();
        assert_eq!(code, Some(2), "{arguments}: {remarks}");
        assert!(
            remarks.contains(word) && remarks.contains("cure: "),
            "{arguments}: {remarks}"
        );
        assert!(
            !remarks.contains("s3cret") && !remarks.contains("wr0ng"),
            "{remarks}"
        );
    }
    fs::write(broker.path("secret"), "s3cret-word\n").unwrap();
    let secret = file("secret");
    let line = format!("--clock messages {whole} --mqtt-user line");
    let run = format!("run --mqtt-prefix plant/one {line} --mqtt-password-file {secret}");
    let mut node = Program::pickline(&run, &[]);
    let mut station = Program::pickline(&format!("emulate --mqtt-prefix plant/one {line}"), &right);
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(remarks.contains("44 of 50 picked"), "{remarks}");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(!remarks.contains("s3cret"), "{remarks}");
}

#[test]
fn errors_of_certificates_name_the_cure() {
    let folder = tempfile::tempdir().unwrap();
    let openssl = |arguments: &str| openssl(folder.path(), arguments);
    let own = |name: &str, more: &str| {
        openssl(&format!(
            "req -x509 {NEW_KEY} -keyout {name}.key -out {name}.pem -subj /CN=127.0.0.1 {more}"
        ));
    };
    let here = "-addext subjectAltName=IP:127.0.0.1";
    let leaf = "-addext basicConstraints=critical,CA:FALSE";
    // As openssl does by default, as the cure says, past its time, of another host.
    own("authority", &format!("{here} -days 2"));
    own("good", &format!("{here} {leaf} -days 2"));
    fs::write(
        folder.path().join("ca.cnf"),
        "[ca]\ndefault_ca = d\n[d]\ndatabase = index\nserial = serial\nnew_certs_dir = .\n\
         policy = p\ndefault_md = sha256\n[p]\ncommonName = supplied\n[v3]\n\
         subjectAltName = IP:127.0.0.1\nbasicConstraints = critical,CA:FALSE\n",
    )
    .unwrap();
    fs::write(folder.path().join("index"), "").unwrap();
    fs::write(folder.path().join("serial"), "01\n").unwrap();
    openssl(&format!(
        "req -new {NEW_KEY} -keyout expired.key -out expired.csr -subj /CN=127.0.0.1"
    ));
    openssl(
        "ca -batch -config ca.cnf -selfsign -keyfile expired.key -in expired.csr -out expired.pem \
         -startdate 20200101000000Z -enddate 20210101000000Z -extensions v3 -notext",
    );
    own(
        "other",
        &format!("-addext subjectAltName=DNS:broker.plant {leaf} -days 2"),
    );
    let pem = |name: &str| {
        folder
            .path()
            .join(format!("{name}.pem"))
            .display()
            .to_string()
    };
    for (server, trusted, words) in [
        (
            "authority",
            Some("authority"),
            &[
                "CA:TRUE",
                "basicConstraints=critical,CA:FALSE",
                "subjectAltName=IP:127.0.0.1",
            ][..],
        ),
        (
            "good",
            Some("other"),
            &["another one with the same name", "--mqtt-ca"],
        ),
        ("good", None, &["not trusted here", "--mqtt-ca"]),
        (
            "expired",
            Some("expired"),
            &["has expired", "renew the broker's certificate"],
        ),
        (
            "other",
            Some("other"),
            &["is for broker.plant, not for `127.0.0.1`"],
        ),
        ("good", Some("good"), &[]),
    ] {
        let broker = |name: &str| folder.path().join(name).display().to_string();
        let mut mosquitto = Broker::place(&format!(
            "allow_anonymous true\ncertfile {}\nkeyfile {}\n",
            broker(&format!("{server}.pem")),
            broker(&format!("{server}.key"))
        ));
        mosquitto.start();
        let trusted = trusted.map_or(String::new(), |name| format!(" --mqtt-ca {}", pem(name)));
        let arguments = format!("run --mqtt mqtts://127.0.0.1:{}{trusted}", mosquitto.port);
        let mut node = Program::pickline(&arguments, &[]);
        if words.is_empty() {
            mosquitto.wait_for_a_client();
            node.signal("TERM");
            let (code, remarks) = node.finish();
            assert_eq!(code, Some(0), "{remarks}");
            assert!(!remarks.contains("TLS"), "{remarks}");
            continue;
        }
        let (code, remarks) = node.finish();
        assert_eq!(code, Some(2), "{server}: {remarks}");
        for word in words.iter().chain(&["no TLS with", "cure: "]) {
            assert!(remarks.contains(word), "{server}: {remarks}");
        }
        assert!(!remarks.contains("CaUsedAsEndEntity"), "{remarks}");
    }
}
