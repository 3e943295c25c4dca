//! The committed results are what the program prints.

use std::path::Path;
use std::process::Command;

#[test]
fn the_committed_tables_are_made_again_to_the_byte() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let folder = tempfile::tempdir().unwrap();
    let status = Command::new("bash")
        .arg(root.join("results/make.sh"))
        .arg(folder.path())
        .env("PICKLINE", env!("CARGO_BIN_EXE_pickline"))
        .status()
        .unwrap();
    assert!(status.success());
    let mut compared = 0;
    for part in ["optimize", "compare", "lookahead", "sweep"] {
        compared += compare_folders(&root.join("results").join(part), &folder.path().join(part));
    }
    assert_eq!(compared, 6 + 4 * 7 + 2 * 7 + 2 * 4);
}

/// Holds every file below `committed` to its like below `made`; returns how many.
fn compare_folders(committed: &Path, made: &Path) -> usize {
    let mut compared = 0;
    for entry in std::fs::read_dir(committed).unwrap() {
        let committed = entry.unwrap().path();
        let made = made.join(committed.file_name().unwrap());
        if committed.is_dir() {
            compared += compare_folders(&committed, &made);
            continue;
        }
        let read = |path: &Path| std::fs::read_to_string(path).unwrap();
        assert!(
            read(&made) == read(&committed),
            "{} differs: run bash results/make.sh",
            committed.display()
        );
        compared += 1;
    }
    compared
}

/// The table in the README is what its first command prints.
#[test]
fn the_readme_shows_what_optimize_prints() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let printed = std::fs::read_to_string(root.join("results/optimize/paper-2.txt")).unwrap();
    let table: Vec<&str> = printed
        .lines()
        .filter(|line| line.starts_with('|'))
        .collect();
    assert_eq!(table.len(), 12);
    assert!(
        readme.contains(&table.join("\n")),
        "the README's table is not {table:#?}"
    );
    let best = printed
        .lines()
        .find(|line| line.starts_with("validated"))
        .unwrap();
    assert!(readme.contains(best), "the README lacks `{best}`");
}
