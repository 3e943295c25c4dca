//! Puts mutants into one build: each is written beside the code that it replaces, and the
//! variable `PICKLINE_MUTANT` chooses the one that runs (mutant schemata: R. Untch,
//! J. Offutt, M. J. Harrold, ISSTA 1993, doi:10.1145/154183.154265). A build for each mutant
//! takes far longer than the tests that notice it.
//!
//!     mutant-switch ROOT LIST LEFT_OUT REPORT
//!
//! ROOT is a copy of the tree, which is changed; LIST the output of
//! `cargo mutants --list --json`; LEFT_OUT a JSON list of places in LIST that are not built
//! because they do not compile. REPORT says for each place in LIST where in the changed file
//! it stands, or why it is not built.

mod places;
mod rewrite;

use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::path::{Path, PathBuf};

/// A mutant as cargo-mutants lists it.
#[derive(Deserialize)]
pub struct Mutant {
    file: String,
    genre: String,
    replacement: String,
    span: TextSpan,
}

#[derive(Deserialize)]
struct TextSpan {
    start: TextPosition,
    end: TextPosition,
}

/// Line and column [characters], both counted from 1.
#[derive(Clone, Copy, Deserialize, PartialEq, Eq, PartialOrd, Ord)]
pub struct TextPosition {
    line: usize,
    column: usize,
}

const SWITCH: &str = r#"
/// Which mutant runs.
#[doc(hidden)]
pub mod mutant {
    use std::sync::atomic::{AtomicU32, Ordering};

    const NOT_READ: u32 = u32::MAX;
    const NONE: u32 = u32::MAX - 1;
    static CHOSEN: AtomicU32 = AtomicU32::new(NOT_READ);

    #[inline(always)]
    pub fn on(place: u32) -> bool {
        let chosen = CHOSEN.load(Ordering::Relaxed);
        if chosen == NOT_READ { read() == place } else { chosen == place }
    }

    #[cold]
    fn read() -> u32 {
        let chosen = std::env::var("PICKLINE_MUTANT").ok();
        let chosen = chosen.and_then(|text| text.parse().ok()).unwrap_or(NONE);
        CHOSEN.store(chosen, Ordering::Relaxed);
        chosen
    }
}
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [root, list, left_out, report] = arguments.as_slice() else {
        return Err("usage: mutant-switch ROOT LIST LEFT_OUT REPORT".into());
    };
    let root = PathBuf::from(root);
    let mutants: Vec<Mutant> = serde_json::from_str(&std::fs::read_to_string(list)?)?;
    let left_out: BTreeSet<usize> = serde_json::from_str(&std::fs::read_to_string(left_out)?)?;
    let mut files: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (place, mutant) in mutants.iter().enumerate() {
        files.entry(&mutant.file).or_default().push(place);
    }
    let mut fates = vec![serde_json::Value::Null; mutants.len()];
    let mut libraries = BTreeSet::new();
    for (file, places) in files {
        let path = root.join(file);
        // Each crate has its own switch.
        let (package, _) = file.split_once("src/").ok_or("a file that is in no src/")?;
        libraries.insert(root.join(package).join("src/lib.rs"));
        let source = std::fs::read_to_string(&path)?;
        let chosen = places.iter().map(|&place| (place, &mutants[place]));
        let chosen: Vec<_> = chosen.filter(|(p, _)| !left_out.contains(p)).collect();
        let written = rewrite::rewrite(&source, &chosen).map_err(|e| format!("{file}: {e}"))?;
        for (place, fate) in written.fates {
            fates[place] = fate;
        }
        std::fs::write(&path, written.text)?;
    }
    for library in libraries {
        add_switch(&library)?;
    }
    std::fs::write(report, serde_json::to_string(&fates)?)?;
    Ok(())
}

fn add_switch(library: &Path) -> Result<(), Box<dyn Error>> {
    let mut text = std::fs::read_to_string(library)?;
    text.push_str(SWITCH);
    Ok(std::fs::write(library, text)?)
}
