//! Calls in shards, and what puts them together.

use super::runs::one;
use super::{Row, hold, row};
use std::path::Path;

/// The verbs that can be split.
const SPLIT: [&str; 4] = ["optimize", "compare", "sweep", "benchmark"];
const MERGE: [&str; 1] = ["merge"];

/// A quick call of `verb`.
fn call(verb: &str) -> String {
    if verb != "benchmark" {
        return format!("{} -q", one(verb));
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../patterns/benchmark");
    let folder = folder.canonicalize().unwrap();
    let folder = folder.to_str().unwrap();
    format!("benchmark --dir {folder} --only *-grid-0.15-20-* -q --format csv")
}

pub const ROWS: &[Row] = &[
    row(&SPLIT, "--shard", |rig, verb| {
        let whole = rig.text(&call(verb));
        assert!(!whole.is_empty());
        for part in ["1/2", "2/2"] {
            assert_eq!(rig.text(&format!("{} --shard {part}", call(verb))), "");
        }
        assert_eq!(rig.names("shards"), ["1-of-2.json", "2-of-2.json"]);
        assert_eq!(rig.text("merge"), whole);
    }),
    row(&SPLIT, "--shard-dir", |rig, verb| {
        rig.done(&format!("{} --shard 1/1 --shard-dir parts", call(verb)));
        assert_eq!(rig.names("parts"), ["1-of-1.json"]);
        let alone = rig.call(&format!("{} --shard-dir parts", call(verb)));
        assert_eq!(alone.code, Some(2), "{}", alone.stderr);
    }),
    row(&MERGE, "<shards>", |rig, verb| {
        for (seed, folder) in [(1, "a"), (2, "b")] {
            let call = format!("{} --seed {seed} --format json", call("compare"));
            rig.done(&format!("{call} --shard 1/1 --shard-dir {folder}"));
            assert_eq!(rig.text(&format!("{verb} {folder}")), rig.text(&call));
        }
    }),
    row(&MERGE, "--force", |rig, verb| {
        rig.done(&format!("{} --html mine.html --shard 1/1", call("compare")));
        rig.write("mine.html", "mine");
        rig.refused(verb, &["mine.html", "--force"]);
        assert_eq!(rig.read("mine.html"), "mine");
        rig.done(&format!("{verb} --force"));
        assert!(rig.read("mine.html").starts_with("<!doctype html>"));
    }),
    row(&MERGE, "--partial", |rig, verb| {
        let cases = "[[case]]\nname = \"a\"\npattern = \"p.csv\"\n\
                     [[case]]\nname = \"b\"\npattern = \"p.csv\"\n";
        rig.write("c.toml", cases);
        rig.done(&format!("{} --shard 2/2", call("compare")));
        rig.refused(verb, &["of 2 shards, 1 is missing", "--partial"]);
        let told = rig.text(&format!("{verb} --partial"));
        assert!(told.contains("of 2 shards, 1 is missing"), "{told}");
    }),
];

#[test]
fn options_of_shards_have_their_effect() {
    hold(ROWS);
}
