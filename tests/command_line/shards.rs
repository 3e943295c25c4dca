//! Calls in shards: put together, they give the bytes of the whole call, however it was split.

use crate::common::pickline_in;
use std::path::Path;

/// Runs the program in `folder`, which has to succeed, and returns what it prints.
fn done(folder: &Path, call: &str) -> String {
    let output = pickline_in(folder, &words(call));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{call}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs the program in `folder`, which has to refuse with all of `told`.
fn refused(folder: &Path, call: &str, told: &[&str]) {
    let output = pickline_in(folder, &words(call));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{call}: {stderr}");
    for words in told.iter().chain(&["cure: "]) {
        assert!(stderr.contains(words), "{call}: {words} not in {stderr}");
    }
}

/// Words are separated by blanks; none has one.
fn words(call: &str) -> Vec<&str> {
    call.split_whitespace().collect()
}

/// The files in `folder` by name, with their content.
fn files(folder: &Path) -> Vec<(String, String)> {
    let entries = std::fs::read_dir(folder).unwrap();
    let file = |entry: std::io::Result<std::fs::DirEntry>| {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        (name, std::fs::read_to_string(path).unwrap())
    };
    let mut files: Vec<_> = entries.map(file).collect();
    files.sort();
    files
}

const CASES: &str = "\
[[case]]
name = \"dense\"
poisson = 0.2
items = 25
[[case]]
name = \"grid\"
grid = 0.25
items = 25
[[case]]
name = \"random\"
feed = \"random\"
flow = 90
items = 30
";

/// Every verb that can be split: plain, with other methods than rules, and under disturbances.
const CALLS: [&str; 8] = [
    "compare --cases cases.toml --replicates 5 --train-items 20 --strategy lookahead:budget=50 --tune",
    "compare --cases cases.toml --replicates 4 --robust SPT,FIFO --grasp-success 0.8 --no-bound \
     --reference greedy_gt",
    "sweep --sweep robots --from 1 --to 3 --patterns poisson:0.3:2 --items 40 --strategy zones --tune",
    "sweep --patterns poisson:0.3:3 --items 20 --step 0.02 --greedy",
    "sweep --sweep min-detection --from 0.5 --to 0.9 --step 0.2 --p-detection beta:8,2 --purity 0.8 \
     --patterns poisson:0.3:3 --items 20",
    "optimize --patterns balanced:4 --items 25 --validate 12 --strategy lookahead:budget=50",
    "optimize --robots 3 --search grasp --patterns balanced:3 --items 20 --validate 9 --max-runs 900",
    "benchmark --dir DIR --only *-grid-0.15-20-* --strategy rules:SPT --strategy lookahead:budget=50 --bounds",
];

fn prepared() -> (tempfile::TempDir, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cases.toml"), CASES).unwrap();
    let benchmark = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../patterns/benchmark");
    let benchmark = benchmark.canonicalize().unwrap();
    let name = |call: &&str| call.replace("DIR", benchmark.to_str().unwrap());
    (folder, CALLS.iter().map(name).collect())
}

/// Any number of shards in any order, with what they share made in advance or by each of them, on any
/// number of threads.
#[test]
fn shards_give_the_bytes_of_the_whole_call() {
    let (folder, calls) = prepared();
    let folder = folder.path();
    for (number, call) in calls.iter().enumerate() {
        let whole = done(
            folder,
            &format!("{call} --format json -q --out whole --force"),
        );
        let wanted = files(&folder.join("whole"));
        assert!(!wanted.is_empty(), "{call}");
        for (count, shared) in [(1, false), (2, number % 2 == 0), (5, number % 2 == 1)] {
            let parts = format!("parts-{number}-{count}");
            let shard = |index: usize| {
                let threads = 1 + index % 2;
                done(
                    folder,
                    &format!(
                        "{call} --format json -q --out merged --force --threads {threads} \
                         --shard {index}/{count} --shard-dir {parts}"
                    ),
                )
            };
            let order = (1..=count).rev().chain([0].into_iter().filter(|_| shared));
            for index in order.collect::<Vec<_>>().into_iter().rev() {
                assert_eq!(shard(index), "", "{call}");
            }
            assert!(!folder.join("merged").exists(), "{call}");
            let merged = done(folder, &format!("merge {parts}"));
            assert_eq!(merged, whole, "{call} in {count}");
            assert_eq!(files(&folder.join("merged")), wanted, "{call} in {count}");
            std::fs::remove_dir_all(folder.join("merged")).unwrap();
        }
        std::fs::remove_dir_all(folder.join("whole")).unwrap();
    }
}

/// The units of a call are made once, each in one shard, and none is left for the merge of a comparison.
#[test]
fn shards_divide_the_work() {
    let (folder, calls) = prepared();
    let folder = folder.path();
    for call in [&calls[0], &calls[3], &calls[7]] {
        let units = |index: usize, count: usize| {
            done(
                folder,
                &format!("{call} -q --shard {index}/{count} --shard-dir p{count}"),
            );
            let file = folder.join(format!("p{count}/{index}-of-{count}.json"));
            let file = std::fs::read_to_string(file).unwrap();
            let file: serde_json::Value = serde_json::from_str(&file).unwrap();
            let works = file["recorded"]["units"].as_object().unwrap().clone();
            let keys = works.iter().flat_map(|(work, units)| {
                let units = units.as_object().unwrap();
                units.keys().map(move |unit| format!("{work} {unit}"))
            });
            keys.collect::<Vec<String>>()
        };
        let mut all = units(1, 1);
        let parts: Vec<Vec<String>> = (1..=3).map(|index| units(index, 3)).collect();
        let (least, most) = (
            parts.iter().map(Vec::len).min().unwrap(),
            parts.iter().map(Vec::len).max().unwrap(),
        );
        assert!(least > 0 && most - least <= all.len() / 3, "{least} {most}");
        let mut together = parts.concat();
        together.sort();
        all.sort();
        assert_eq!(together, all, "{call}");
        std::fs::remove_dir_all(folder.join("p1")).unwrap();
        std::fs::remove_dir_all(folder.join("p3")).unwrap();
    }
}

#[test]
fn shards_that_do_not_belong_together_are_refused() {
    let (folder, _) = prepared();
    let folder = folder.path();
    let call = "compare --cases cases.toml --replicates 3 --robust SPT,FIFO --no-bound -q";
    let shard = |index: usize, more: &str| {
        done(folder, &format!("{call} {more} --shard {index}/3"));
    };
    refused(folder, "merge", &["there is no file of a shard in shards"]);
    std::fs::create_dir(folder.join("shards")).unwrap();
    refused(folder, "merge", &["there is no file of a shard in shards"]);
    shard(1, "");
    shard(3, "");
    refused(folder, "merge", &["of 3 shards, 2 is missing", "--partial"]);
    // Another call does not get into the same folder.
    let other = format!("{call} --seed 2 --shard 1/3");
    refused(
        folder,
        &other,
        &["is a shard of another call: pickline compare"],
    );
    done(folder, &format!("{other} --shard-dir other"));
    let both = "merge shards/1-of-3.json other/1-of-3.json";
    refused(folder, both, &["other/1-of-3.json: is of the call"]);
    let twice = "merge shards/1-of-3.json shards";
    refused(folder, twice, &["is the same shard as shards/1-of-3.json"]);
    let halves = format!("{call} --shard 1/2");
    refused(
        folder,
        &halves,
        &["shards/1-of-3.json is one of 3 shards, not 2"],
    );
    done(folder, &format!("{halves} --shard-dir halves"));
    refused(
        folder,
        "merge shards halves",
        &["is one of 2 shards, not 3"],
    );
    // A file that the call reads was changed between two shards, or before the merge.
    std::fs::write(folder.join("cases.toml"), CASES.replace("0.2\n", "0.21\n")).unwrap();
    shard(2, "");
    refused(
        folder,
        "merge",
        &["case dense changed between the shards before it"],
    );
    std::fs::write(folder.join("cases.toml"), CASES).unwrap();
    shard(2, "");
    std::fs::write(folder.join("cases.toml"), CASES.replace("0.2\n", "0.21\n")).unwrap();
    let changed = "the list of cases: changed since other shards of this call were made";
    refused(folder, "merge", &[changed]);
    std::fs::write(folder.join("cases.toml"), CASES).unwrap();
    done(folder, "merge");
    // So were training patterns that no unit shows.
    let trained = "sweep --sweep reach --from 0.5 --to 0.7 --step 0.1 --train-patterns tr -q";
    std::fs::create_dir(folder.join("tr")).unwrap();
    for (name, x) in [("a", "0"), ("b", "-0.2")] {
        let pattern = format!("id,x,y\n1,{x},0\n2,-0.5,0.1\n");
        std::fs::write(folder.join(format!("tr/{name}.csv")), pattern).unwrap();
    }
    done(folder, &format!("{trained} --shard 1/2 --shard-dir t"));
    std::fs::remove_file(folder.join("tr/b.csv")).unwrap();
    done(folder, &format!("{trained} --shard 2/2 --shard-dir t"));
    refused(
        folder,
        "merge t",
        &["the training patterns changed between"],
    );
    // What is no shard, or one of another version.
    let good = std::fs::read_to_string(folder.join("shards/2-of-3.json")).unwrap();
    for (bad, told) in [
        ("{}".to_owned(), "is not the file of a shard"),
        (
            good.replace("pickline-shard", "x"),
            "is not the file of a shard",
        ),
        (
            good.replace("\"pickline 0.", "\"pickline 9."),
            "was written by pickline 9.",
        ),
        (
            good.replace("\"version\":1", "\"version\":2"),
            "was written by version 2 of the",
        ),
        (
            good.replacen("\"items\":25", "\"items\":26", 1),
            "is damaged",
        ),
        (
            good.replace("\"--replicates\"", "\"--replicas\""),
            "is damaged",
        ),
        (
            good.replace("[\"compare\"", "[\"run\""),
            "of a verb that can be split",
        ),
        (
            good.replace("\"shard\":2", "\"shard\":7"),
            "no shard 7 of 3",
        ),
        (
            good[..good.len() / 2].to_owned(),
            "is not the file of a shard",
        ),
    ] {
        std::fs::write(folder.join("shards/2-of-3.json"), &bad).unwrap();
        refused(folder, "merge", &["shards/2-of-3.json", told]);
    }
}

/// What is complete is reported, and marked as a part.
#[test]
fn a_part_of_the_shards_gives_what_is_complete() {
    let (folder, calls) = prepared();
    let folder = folder.path();
    // The grid is the sixth unit, the first of shard 1 of 5.
    let compare = "compare --cases cases.toml --replicates 5 --robust SPT,FIFO -q --format json";
    done(folder, &format!("{compare} --shard 1/5"));
    let told = done(folder, "merge --partial");
    let report: serde_json::Value = serde_json::from_str(&told).unwrap();
    let cases = report["cases"].as_array().unwrap();
    let names: Vec<&str> = cases.iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["grid"]);
    let partial = &report["made"]["partial"];
    assert_eq!(partial, "of 5 shards, 2, 3, 4 and 5 are missing");
    done(folder, &format!("{compare} --shard 2/5 --shard-dir second"));
    refused(folder, "merge second --partial", &["no case is complete"]);
    let optimize = "optimize --patterns balanced:4 --items 25 --validate 0 -q --format json";
    done(folder, &format!("{optimize} --shard 2/4 --shard-dir o"));
    let told = done(folder, "merge o --partial");
    let report: serde_json::Value = serde_json::from_str(&told).unwrap();
    assert_eq!(report["stop_reason"], "interrupted", "{told}");
    assert_eq!(report["patterns"], 2, "{told}");
    let benchmark = format!("{} -q --format json", calls[7]);
    done(folder, &format!("{benchmark} --shard 3/3 --shard-dir b"));
    let told = done(folder, "merge b --partial");
    assert!(told.contains("\"partial\""), "{told}");
}

#[test]
fn what_cannot_be_split_says_so() {
    let (folder, _) = prepared();
    let folder = folder.path();
    for (call, told) in [
        ("optimize --race 0.1 --shard 1/2", "--race"),
        ("optimize --time-limit 5 --shard 1/2", "--time-limit"),
        ("sweep --sweep robots-down --shard 1/2", "robots-down"),
        ("compare --shard 3/2", "there is no shard 3 of 2"),
        ("compare --shard half", "`half` is not a shard"),
    ] {
        refused(folder, &format!("{call} -q"), &[told]);
    }
    assert!(!folder.join("shards").exists());
}
