//! Lines as services: what the service manager hears, what is installed, the manual.

use crate::common::{pickline, text};
use crate::programs::wait_for;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Starts the node as systemd would, with a watchdog of this many microseconds.
fn start(socket: &Path, watchdog: &str, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .env("NOTIFY_SOCKET", socket)
        .env("WATCHDOG_USEC", watchdog)
        .env_remove("WATCHDOG_PID")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn next(socket: &UnixDatagram) -> String {
    let mut datagram = [0; 4096];
    let length = socket.recv(&mut datagram).unwrap();
    String::from_utf8(datagram[..length].to_vec()).unwrap()
}

#[test]
fn the_service_manager_receives_the_state() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notify");
    let socket = UnixDatagram::bind(&path).unwrap();
    socket
        .set_read_timeout(Some(Duration::from_secs(60)))
        .unwrap();
    let mut node = start(&path, "400000", &["run", "--status-every", "0.05"]);
    assert_eq!(next(&socket), "READY=1");
    // Nobody reads its stdout, which fills up: it is at work all the same.
    let (mut signs, mut statuses) = (Vec::new(), 0);
    let until = Instant::now() + Duration::from_secs(5);
    while Instant::now() < until {
        match &*next(&socket) {
            "WATCHDOG=1" => signs.push(Instant::now()),
            "STATUS=0 of 0 items picked" => statuses += 1,
            other => panic!("{other}"),
        }
    }
    // Every 0.1 s, and far less often than its loop comes by.
    assert!((15..=55).contains(&signs.len()), "{}", signs.len());
    assert!(statuses > 0);
    let id = node.id().to_string();
    assert!(Command::new("kill").arg(&id).status().unwrap().success());
    let last = std::iter::repeat_with(|| next(&socket));
    assert!(last.take(1000).any(|text| text == "STOPPING=1"));
    drop(node.stdout.take());
    wait_for("the end", || node.try_wait().unwrap().is_some());
}

/// A manager that does not read, or is not there, is no trouble.
#[test]
fn a_busy_service_manager_does_not_delay_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notify");
    let unread = UnixDatagram::bind(&path).unwrap();
    for path in [path.clone(), folder.path().join("nobody")] {
        let mut node = start(&path, "1000", &["run", "--clock", "messages"]);
        let mut stdin = node.stdin.take().unwrap();
        for stamp in 0..2000 {
            writeln!(stdin, "{{\"kind\":\"tick\",\"stamp\":{stamp}}}").unwrap();
        }
        drop(stdin);
        let output = node.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        assert!(output.stdout.split(|byte| *byte == b'\n').count() > 2000);
    }
    drop(unread);
}

/// Every file below `root`, as it is from there.
fn files(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(root).unwrap().display().to_string();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

fn service(verb: &str, root: &Path, more: &[&str]) -> std::process::Output {
    let root = root.to_str().unwrap();
    let arguments = [&["service", verb, "--root", root, "--prefix", "/usr"], more].concat();
    pickline(&arguments)
}

#[test]
fn all_is_installed_in_one_step_and_nothing_of_the_users_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    let output = service("install", root, &[]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let installed = files(root);
    for name in [
        "usr/bin/pickline",
        "usr/lib/systemd/system/pickline@.service",
        "usr/share/man/man1/pickline.1",
        "usr/share/man/man1/pickline-run.1",
        "usr/share/man/man1/pickline-station-check.1",
        "usr/share/bash-completion/completions/pickline",
        "usr/share/zsh/site-functions/_pickline",
        "usr/share/fish/vendor_completions.d/pickline.fish",
        "usr/share/doc/pickline/log-to-file.conf",
        "usr/share/doc/pickline/logrotate",
        "etc/pickline/line1.toml",
        "etc/pickline/line1.conf",
    ] {
        assert!(
            installed.contains_key(name),
            "{name} not in {:?}",
            installed.keys()
        );
    }
    let program = root.join("usr/bin/pickline");
    assert_eq!(
        program.metadata().unwrap().permissions().mode() & 0o777,
        0o755
    );
    let version = Command::new(&program).arg("--version").output().unwrap();
    assert!(version.status.success());
    let unit = String::from_utf8(installed["usr/lib/systemd/system/pickline@.service"].clone());
    let unit = unit.unwrap();
    for line in ["Type=notify", "WatchdogSec=5", "Restart=on-failure"] {
        assert!(
            unit.lines().any(|found| found == line),
            "{line} not in {unit}"
        );
    }
    assert!(unit.contains("\nExecStart=/usr/bin/pickline run ") && !unit.contains("@BINDIR@"));
    // What the unit calls is what the program understands.
    let station = root.join("etc/pickline/line1.toml");
    assert!(
        pickline(&["station", "check", station.to_str().unwrap()])
            .status
            .success()
    );

    // Again: the same, and what the user has changed in /etc stays.
    let flags = root.join("etc/pickline/line1.conf");
    std::fs::write(&flags, "PICKLINE_FLAGS=mine\n").unwrap();
    let output = service("install", root, &["--force"]);
    assert!(output.status.success());
    assert_eq!(
        std::fs::read_to_string(&flags).unwrap(),
        "PICKLINE_FLAGS=mine\n"
    );
    // A file of somebody else is not replaced, and nothing else is either.
    let page = root.join("usr/share/man/man1/pickline-run.1");
    std::fs::write(&page, "mine").unwrap();
    let before = files(root);
    let output = service("install", root, &[]);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(
        errors.contains("pickline-run.1: ") && errors.contains("--force"),
        "{errors}"
    );
    assert_eq!(files(root), before);

    let output = service("uninstall", root, &[]);
    assert!(output.status.success());
    let left: Vec<String> = files(root).into_keys().collect();
    let expected = [
        "etc/pickline/line1.conf",
        "etc/pickline/line1.toml",
        "usr/share/man/man1/pickline-run.1",
    ];
    assert_eq!(left, expected);
    assert_eq!(service("uninstall", root, &[]).status.code(), Some(2));
}

#[test]
fn a_prefix_is_a_folder_from_the_root() {
    for prefix in ["usr", "/opt/my lines"] {
        let output = pickline(&["service", "show", "--prefix", prefix]);
        assert_eq!(output.status.code(), Some(2));
    }
    assert!(text(&["service", "show", "--prefix", "/opt/p"]).contains("=/opt/p/bin/pickline run"));
}

#[test]
fn every_command_has_a_manual_page() {
    let page = text(&["man", "run"]);
    assert!(
        page.starts_with(".ie") && page.contains(".TH pickline-run 1"),
        "{page}"
    );
    for word in ["\\-\\-dashboard", "\\-\\-log\\-format", ".SH EXAMPLES"] {
        assert!(page.contains(word), "{word} not in {page}");
    }
    assert!(text(&["man", "station", "check"]).contains(".TH pickline-station-check 1"));
    let output = pickline(&["man", "runs"]);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(errors.contains("did you mean `run`"), "{errors}");
    // Each verb that the help names has one.
    let help = text(&["--help"]);
    let verbs = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let verbs = verbs.take_while(|line| !line.is_empty());
    let verbs: Vec<&str> = verbs
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(verbs.contains(&"emulate"), "{verbs:?}");
    for verb in verbs.iter().filter(|verb| **verb != "help") {
        assert!(text(&["man", verb]).contains(&format!(".TH pickline-{verb} 1")));
    }
}

/// The examples that the documentation names are there.
#[test]
fn the_page_names_files_that_are_there() {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let page = std::fs::read_to_string(root.join("docs/operation.md")).unwrap();
    for name in page
        .split(['(', ')', '`', ' '])
        .filter(|word| word.contains("packaging/"))
    {
        let name = name.trim_start_matches("../");
        assert!(root.join(name).exists(), "{name}");
    }
}
