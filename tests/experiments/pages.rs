//! The figures of the pages: each is the number of the JSON report that it says it is, and
//! stands in the column that says so.

use super::support::{STATION, run, shown, weighted};
use serde_json::Value;

/// A figure on a page.
#[derive(Debug)]
struct Figure {
    name: String,
    value: f64,
    shown: String,
}

/// What stands between `from` and `to`, and what comes behind.
fn between<'a>(text: &'a str, from: &str, to: &str) -> Option<(&'a str, &'a str)> {
    text.split_once(from)?.1.split_once(to)
}

fn figures(html: &str) -> Vec<Figure> {
    let (mut found, mut rest) = (Vec::new(), html);
    while let Some((inner, behind)) = between(rest, "<data data-name=\"", "</data>") {
        let (name, inner) = inner.split_once("\" value=\"").unwrap();
        let (value, shown) = inner.split_once("\">").unwrap();
        found.push(Figure {
            name: name.into(),
            value: value.parse().unwrap(),
            shown: shown.into(),
        });
        rest = behind;
    }
    found
}

/// The names of fields that the columns of tables may hold, by how headers begin; `95 %` is
/// the interval of the column before.
const COLUMNS: [(&str, &[&str]); 44] = [
    ("throughput [1/min]", &["throughput_per_min"]),
    ("flow [1/min]", &["flow_per_min"]),
    ("added a robot [1/min]", &["added_per_robot_per_min"]),
    ("picked [%]", &["picked_share"]),
    ("time [s]", &["end_s"]),
    ("picking rate [1/min]: ours", &["picking_rate_per_min"]),
    ("picking rate [1/min]", &["picking_rate_per_min"]),
    ("weighted [1/min]", &["weighted_rate_per_min"]),
    (
        "picking rate minus the first's, 95 %",
        &["diff_low", "diff_high"],
    ),
    ("benefit [%]", &["benefit_percent"]),
    ("certified: picks [%]", &["certified_percent"]),
    ("rate [%]", &["certified_rate_percent"]),
    ("certified [%]", &["certified_percent"]),
    ("bound: picked [%]", &["picked_share"]),
    ("complete [%]", &["complete_share"]),
    ("to 99 % [%]", &["nearly_complete_share"]),
    ("speed [m/s]", &["value"]),
    ("min-detection", &["value"]),
    ("binned", &["binned"]),
    ("rightly binned", &["rightly_binned"]),
    ("due", &["due"]),
    ("purity [%]", &["purity"]),
    ("recovery [%]", &["recovery"]),
    ("threshold", &["threshold"]),
    ("purity in training [%]", &["trained.purity"]),
    ("purity on fresh patterns [%]", &["purity"]),
    ("recovery on fresh patterns [%]", &["recovery"]),
    ("everything up to", &["highest", "robust_gt", "rl"]),
    ("first miss at", &["first_miss"]),
    ("everything again at", &[]),
    ("95 % of the patterns to 99 % up to", &["highest_95_99"]),
    ("limits of the patterns: least", &["of_patterns.0"]),
    ("median", &["of_patterns.1"]),
    ("greatest", &["of_patterns.2"]),
    ("best minus this, 95 %", &["diff_low", "diff_high"]),
    ("minus [", &["diff_low", "diff_high"]),
    ("mean", &["mean", "value"]),
    ("worst", &["worst", "value"]),
    ("max speed [m/s]", &["max_speed"]),
    ("patterns", &["count"]),
    ("cvar:0.5", &["value"]),
    ("at belt speed [m/s]", &["speed"]),
    ("fully picked", &["complete"]),
    ("[%]", &["complete_share"]),
];

/// What the column behind one of these fields holds, where its header is `95 %`.
fn interval_of(field: &str) -> [String; 2] {
    let stem = match field {
        "complete_share" => "complete",
        field => field.trim_end_matches("_per_min"),
    };
    ["low", "high"].map(|end| format!("{stem}_{end}"))
}

/// What the column `paper` behind one of these fields holds.
fn printed_for(field: &str) -> &'static str {
    match field {
        "picked_share" => "paper.picked_percent",
        "end_s" => "paper.time_s",
        _ => "paper.picking_rate_per_min",
    }
}

/// Holds the figures of every table to the names of their columns; how many there are.
fn check_tables(html: &str) -> usize {
    let mut checked = 0;
    for table in html.split("<table>").skip(1) {
        let table = table.split("</table>").next().unwrap();
        let cells = |row: &str, tag: &str| -> Vec<String> {
            let (open, close) = (format!("<{tag}"), format!("</{tag}>"));
            let parts = row.split(&open).skip(1);
            let inner = parts.map(|part| part.split_once('>').unwrap().1);
            let inner = inner.map(|part| part.split(&close).next().unwrap().to_owned());
            inner.collect()
        };
        let mut rows = table.split("<tr").skip(1);
        let header = cells(rows.next().unwrap(), "th");
        for row in rows {
            let mut before = String::new();
            for (name, cell) in header.iter().zip(cells(row, "td")) {
                let found = figures(&cell);
                let name = name.replace("&#39;", "'");
                let expected: Vec<String> = match name.as_str() {
                    "95 %" => interval_of(&before).to_vec(),
                    "paper" => vec![printed_for(&before).into()],
                    name => {
                        let known = COLUMNS.iter().find(|known| name.starts_with(known.0));
                        known
                            .map_or(&[][..], |known| known.1)
                            .iter()
                            .map(|f| (*f).to_owned())
                            .collect()
                    }
                };
                for (place, figure) in found.iter().enumerate() {
                    let ends = |field: &String| figure.name.ends_with(&format!(".{field}"));
                    let fits = match expected.len() {
                        2 if found.len() == 2 => ends(&expected[place]),
                        _ => expected.iter().any(ends),
                    };
                    assert!(fits, "{figure:?} in the column {name}");
                    assert_eq!(
                        figure.name.contains(".paper."),
                        name == "paper",
                        "{figure:?}"
                    );
                    checked += 1;
                }
                if !["95 %", "paper"].contains(&name.as_str()) && !expected.is_empty() {
                    before.clone_from(&expected[0]);
                }
            }
        }
    }
    checked
}

/// Runs the verb and holds every figure of its page to its JSON; how many figures there are.
fn check(call: &str, json: &str) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (page, out) = (file("p.html"), file("out"));
    run(&format!("{call} -q --html {page} --out {out}"));
    let page = std::fs::read_to_string(page).unwrap();
    let report = std::fs::read_to_string(format!("{out}/{json}")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    let all = figures(&page);
    for figure in &all {
        let pointer = format!("/{}", figure.name.replace('.', "/"));
        let value = report.pointer(&pointer).and_then(Value::as_f64);
        assert_eq!(value, Some(figure.value), "{figure:?}");
        let digits = figure
            .shown
            .split_once('.')
            .map_or(0, |(_, digits)| digits.len());
        let as_shares = [
            "picked_share",
            "complete_share",
            "complete_low",
            "complete_high",
            ".purity",
            ".recovery",
        ];
        let is_share = as_shares.iter().any(|name| figure.name.contains(name));
        let value = if is_share {
            100.0 * figure.value
        } else {
            figure.value
        };
        assert_eq!(figure.shown, shown(Some(value), digits), "{figure:?}");
    }
    assert!(check_tables(&page) > 20, "{call}");
    all.len()
}

#[test]
fn figures_of_pages_are_those_of_their_reports() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(file("line.toml"), STATION).unwrap();
    std::fs::create_dir(file("set")).unwrap();
    for n in 0..2 {
        std::fs::write(file(&format!("set/{n}.csv")), weighted(n)).unwrap();
    }
    let own = file("set/0.csv");
    let cases = format!(
        "[[case]]\nname = \"a\"\nfeed = \"random\"\nflow = 60\nitems = 110\n\
         [[case]]\nname = \"b\"\npattern = \"{own}\"\n"
    );
    std::fs::write(file("cases.toml"), cases).unwrap();
    let (line, list, set) = (file("line.toml"), file("cases.toml"), file("set"));
    let doubtful = "--p-detection uniform:0.3,1";
    let given = format!("--station {line} --robust SPT,FIFO --strategy rules:LPT,PP");
    for (call, json) in [
        (
            format!("compare --cases {list} --replicates 3 --no-policy {given}"),
            "compare.json",
        ),
        (
            "compare --paper --replicates 2 --no-policy --robust SPT,FIFO".into(),
            "compare.json",
        ),
        (
            format!("sweep --patterns {set} --from 0.02 --to 0.12 --step 0.02 {given}"),
            "sweep.json",
        ),
        (
            format!(
                "sweep --patterns random:60/min:2 --items 110 --from 0.1 --to 0.12 --step 0.02 \
                 {given}"
            ),
            "sweep.json",
        ),
        (
            format!(
                "compare --cases {list} --replicates 3 --no-policy --misdetections {doubtful} {given}"
            ),
            "compare.json",
        ),
        (
            format!(
                "sweep --patterns random:60/min:3 --items 40 --sweep min-detection --from 0.4 --to \
                 1 --step 0.2 --purity 0.6 {doubtful} {given}"
            ),
            "sweep.json",
        ),
    ] {
        assert!(check(&call, json) > 40, "{call}");
    }
    for risk in ["mean", "worst", "cvar:0.5"] {
        let call = format!(
            "optimize --station {line} --patterns random:60/min:4 --items 40 --validate 3 \
             --risk {risk} --strategy rules:LPT,PP"
        );
        assert!(check(&call, "optimize.json") > 60, "{call}");
    }
}
