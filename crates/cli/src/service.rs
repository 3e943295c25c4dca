//! `pickline service`: the files that a line needs to run as a service, and where they go.

use super::args::{PlaceArgs, ServiceCommand};
use super::man;
use super::session::Session;
use clap_complete::Shell;
use pickline::error::{Error, Result, counted, shown};
use pickline::files::{self, fingerprint};
use pickline::station::commented_example;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const UNIT: &str = include_str!("../../../packaging/systemd/pickline@.service");
const FLAGS: &str = include_str!("../../../packaging/systemd/line1.conf");
const LOG_TO_FILE: &str = include_str!("../../../packaging/systemd/log-to-file.conf");
const LOGROTATE: &str = include_str!("../../../packaging/logrotate/pickline");

/// Under the prefix: the list of installed files, each with its fingerprint.
const LIST: &str = "share/pickline/installed";

/// What to do after an installation.
const NEXT: &str = "next: edit /etc/pickline/line1.toml and line1.conf, then\n  systemctl \
     daemon-reload\n  systemctl enable --now pickline@line1\n  journalctl -fu pickline@line1\n";

pub(crate) fn run(command: ServiceCommand, session: &Session) -> Result<()> {
    match command {
        ServiceCommand::Show { place } => session.print(unit(&place.resolve()?.prefix).as_bytes()),
        ServiceCommand::Install { place, force } => place.resolve()?.install(force, session),
        ServiceCommand::Uninstall { place } => place.resolve()?.uninstall(session),
    }
}

/// Where the files of a service are.
struct Installation {
    /// The folder with bin, lib and share, an absolute path.
    prefix: PathBuf,
    /// The folder that stands for /, if it is another one.
    root: Option<PathBuf>,
}

impl PlaceArgs {
    /// The place, with an absolute prefix, which the unit requires.
    fn resolve(self) -> Result<Installation> {
        let text = self.prefix.to_string_lossy();
        let is_text = self.prefix.to_str().is_some();
        if self.prefix.is_absolute() && is_text && !text.contains(char::is_whitespace) {
            return Ok(Installation {
                prefix: self.prefix,
                root: self.root,
            });
        }
        let problem = format!("`{}` is not an absolute path without blanks", shown(&text));
        let cure = "give one such as /usr/local; to install below another folder, use --root";
        Err(Error::usage("--prefix", problem, cure))
    }
}

fn unit(prefix: &Path) -> String {
    UNIT.replace("@BINDIR@", &prefix.join("bin").to_string_lossy())
}

/// A file to be installed.
struct InstalledFile {
    /// The absolute path.
    path: PathBuf,
    content: Vec<u8>,
    /// Whether it is executable.
    runs: bool,
    /// Whether it belongs to the user once it exists.
    kept: bool,
}

impl InstalledFile {
    fn new(path: PathBuf, content: impl Into<Vec<u8>>) -> Self {
        Self {
            path,
            content: content.into(),
            runs: false,
            kept: false,
        }
    }
}

/// All files that a service needs.
fn all(prefix: &Path) -> Result<Vec<InstalledFile>> {
    let program = std::env::current_exe().and_then(|path| {
        std::fs::read(&path).map_err(|e| std::io::Error::other(format!("{}: {e}", path.display())))
    });
    let program = program.map_err(|error| Error::read(Path::new("this program"), error))?;
    let share = prefix.join("share");
    let mut list = vec![
        InstalledFile {
            runs: true,
            ..InstalledFile::new(prefix.join("bin/pickline"), program)
        },
        InstalledFile::new(
            prefix.join("lib/systemd/system/pickline@.service"),
            unit(prefix),
        ),
        InstalledFile::new(share.join("doc/pickline/log-to-file.conf"), LOG_TO_FILE),
        InstalledFile::new(share.join("doc/pickline/logrotate"), LOGROTATE),
    ];
    for page in man::pages() {
        let path = share.join(format!("man/man1/{}.1", page.name));
        list.push(InstalledFile::new(path, page.text));
    }
    for (shell, path) in [
        (Shell::Bash, "bash-completion/completions/pickline"),
        (Shell::Zsh, "zsh/site-functions/_pickline"),
        (Shell::Fish, "fish/vendor_completions.d/pickline.fish"),
    ] {
        let mut script = Vec::new();
        clap_complete::generate(shell, &mut super::command(), "pickline", &mut script);
        list.push(InstalledFile::new(share.join(path), script));
    }
    let station = commented_example();
    for (path, content) in [
        ("/etc/pickline/line1.conf", FLAGS),
        ("/etc/pickline/line1.toml", station),
    ] {
        list.push(InstalledFile {
            kept: true,
            ..InstalledFile::new(path.into(), content)
        });
    }
    Ok(list)
}

impl Installation {
    /// `path`, which is absolute, below the root.
    fn below(&self, path: &Path) -> PathBuf {
        match (&self.root, path.strip_prefix("/")) {
            (Some(root), Ok(rest)) => root.join(rest),
            _ => path.to_owned(),
        }
    }

    /// The list of the installed files.
    fn list(&self) -> PathBuf {
        self.below(&self.prefix.join(LIST))
    }

    fn install(&self, force: bool, session: &Session) -> Result<()> {
        if session.is_hosted() {
            return Err(Error::usage(
                "service install",
                "this pickline runs inside another program, such as Python, which cannot be \
                 installed in its place",
                "build the program with `cargo build --release` and run its `service install`",
            ));
        }
        let list = self.list();
        let files = all(&self.prefix)?;
        if !force {
            self.check_ours(&files, &installed(&list))?;
        }
        let mut text = String::new();
        let mut now = String::new();
        for file in &files {
            let path = self.below(&file.path);
            if file.kept && path.symlink_metadata().is_ok() {
                text += &format!("kept      {}\n", path.display());
                continue;
            }
            files::make_folder(files::folder_of(&path))?;
            files::write_whole(&path, &file.content)?;
            allow(&path, file.runs)?;
            if !file.kept {
                now += &format!("{} {}\n", fingerprint(&file.content), file.path.display());
            }
            text += &format!("installed {}\n", path.display());
        }
        files::make_folder(files::folder_of(&list))?;
        files::write_whole(&list, now.as_bytes())?;
        text += NEXT;
        session.print(text.as_bytes())
    }

    /// Checks that all of `files` can be installed: they do not exist yet, or are as this
    /// command would write or has written them (`before`).
    ///
    /// # Errors
    /// The first other file.
    fn check_ours(
        &self,
        files: &[InstalledFile],
        before: &BTreeMap<PathBuf, String>,
    ) -> Result<()> {
        for file in files.iter().filter(|file| !file.kept) {
            let path = self.below(&file.path);
            let is_ours = match std::fs::read(&path) {
                Ok(found) => {
                    found == file.content || before.get(&file.path) == Some(&fingerprint(&found))
                }
                Err(_) => path.symlink_metadata().is_err(),
            };
            if !is_ours {
                return Err(Error::path(
                    path.display().to_string(),
                    "the file already exists and is not as this command wrote it",
                    "move it away, or add --force to replace it",
                ));
            }
        }
        Ok(())
    }

    fn uninstall(&self, session: &Session) -> Result<()> {
        let list = self.list();
        let before = installed(&list);
        if before.is_empty() {
            return Err(Error::path(
                list.display().to_string(),
                "nothing is installed here",
                "give the --prefix and --root used for the installation",
            ));
        }
        let mut text = String::new();
        let mut kept = 0;
        for (path, print) in &before {
            let path = self.below(path);
            match std::fs::read(&path) {
                Ok(found) if fingerprint(&found) == *print => {
                    std::fs::remove_file(&path).map_err(|error| Error::write(&path, error))?;
                    text += &format!("removed   {}\n", path.display());
                }
                Ok(_) => {
                    kept += 1;
                    text += &format!("kept      {}: it was changed\n", path.display());
                }
                Err(_) => {}
            }
        }
        std::fs::remove_file(&list).map_err(|error| Error::write(&list, error))?;
        if kept > 0 {
            text += &format!("kept {}\n", counted(kept, "changed file"));
        }
        session.print(text.as_bytes())
    }
}

/// The installed files with their fingerprints.
fn installed(list: &Path) -> BTreeMap<PathBuf, String> {
    let text = std::fs::read_to_string(list).unwrap_or_default();
    let lines = text.lines().filter_map(|line| line.split_once(' '));
    lines
        .map(|(print, path)| (PathBuf::from(path), print.to_owned()))
        .collect()
}

/// Makes the file readable for everyone, and executable if it `runs`.
#[cfg(unix)]
fn allow(path: &Path, runs: bool) -> Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    let mode = if runs { 0o755 } else { 0o644 };
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode))
        .map_err(|error| Error::write(path, error))
}

#[cfg(not(unix))]
fn allow(_: &Path, _: bool) -> Result<()> {
    Ok(())
}
