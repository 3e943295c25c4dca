//! Charts and pages: well-formed, complete, the same bytes from the same input.

use crate::common::{pickline, text};
use roxmltree::{Document, Node};
use std::path::Path;

/// A quick run of each verb with all that its charts can show, and its charts.
const RUNS: [(&[&str], &[&str]); 6] = [
    (
        &[
            "compare",
            "--replicates",
            "4",
            "--robust",
            "SPT,FIFO",
            "--paper",
        ],
        &["rate", "difference", "picked"],
    ),
    (
        &[
            "sweep",
            "--robust",
            "SPT,FIFO",
            "--greedy",
            "--patterns",
            "poisson:0.15:4",
            "--from",
            "0.03",
            "--to",
            "0.05",
            "--step",
            "0.001",
        ],
        &["picked", "rate", "limits"],
    ),
    (
        &[
            "sweep", "--robust", "SPT,FIFO", "--from", "0.04", "--to", "0.05",
        ],
        &["picked", "rate"],
    ),
    (
        &[
            "sweep",
            "--sweep",
            "robots",
            "--to",
            "2",
            "--train-items",
            "5",
            "--patterns",
            "balanced:2",
            "--items",
            "20",
        ],
        &["picked", "rate"],
    ),
    (
        &[
            "sweep", "--sweep", "spacing", "--robust", "SPT,FIFO", "--from", "1.6", "--to", "1.7",
            "--step", "0.05",
        ],
        &["picked", "throughput", "rate"],
    ),
    (
        &[
            "optimize",
            "--patterns",
            "balanced:2",
            "--items",
            "20",
            "--validate",
            "5",
            "--risk",
            "cvar:0.5",
        ],
        &["difference", "spread", "ranking"],
    ),
];

/// What `arguments` with `--svg` or `--html` write.
fn written(arguments: &[&str], flag: &str, more: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("picture");
    let mut all = arguments.to_vec();
    all.extend(["-q", flag, file.to_str().unwrap()]);
    all.extend(more);
    text(&all);
    std::fs::read_to_string(file).unwrap()
}

fn texts<'a>(svg: &'a Document) -> Vec<&'a str> {
    let all = svg.descendants().filter(|node| node.has_tag_name("text"));
    all.map(|node| node.text().unwrap_or_default()).collect()
}

fn number(node: Node, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

#[test]
fn every_chart_is_well_formed_and_scales() {
    for (run, charts) in RUNS {
        for chart in charts {
            let svg = written(run, "--svg", &["--chart", chart]);
            let document = Document::parse(&svg).unwrap();
            let root = document.root_element();
            let size = [number(root, "width"), number(root, "height")];
            let view = format!("0 0 {} {}", size[0], size[1]);
            assert_eq!(
                root.attribute("viewBox"),
                Some(view.as_str()),
                "{run:?} {chart}"
            );
            // Axis titles say their unit, where there is one.
            let texts = texts(&document);
            assert!(texts.iter().any(|text| text.contains('[')), "{texts:?}");
            for node in document
                .descendants()
                .filter(|node| node.has_tag_name("text"))
            {
                let (x, y) = (number(node, "x"), number(node, "y"));
                assert!(
                    (0.0..=size[0]).contains(&x) && (0.0..=size[1]).contains(&y),
                    "{texts:?}"
                );
            }
            // It says what it is, and follows a dark scheme on a screen.
            let title = document
                .descendants()
                .find(|node| node.has_tag_name("title"));
            let title = title.unwrap().text().unwrap();
            assert!(
                texts.iter().any(|text| text.starts_with(&title[..4])),
                "{texts:?}"
            );
            assert!(svg.contains("(prefers-color-scheme: dark)"));
            // Fit for print: every colour is a colour, none is a page's.
            assert!(!svg.contains("var(") && !svg.contains("NaN") && !svg.contains("inf"));
            // How it was made, without where it went.
            let about = document
                .descendants()
                .find(|node| node.has_tag_name("desc"))
                .unwrap();
            let about = about.text().unwrap();
            assert!(
                about.contains("pickline 0") && about.contains("seed 1"),
                "{about}"
            );
            assert!(
                about.contains(run[0]) && !about.contains("--svg"),
                "{about}"
            );
        }
    }
}

#[test]
fn pictures_do_not_depend_on_threads() {
    for (run, charts) in RUNS {
        let main = written(run, "--svg", &["--threads", "1"]);
        assert_eq!(
            main,
            written(run, "--svg", &["--threads", "2", "--chart", charts[0]])
        );
        let page = written(run, "--html", &["--threads", "1"]);
        assert!(
            page == written(run, "--html", &["--threads", "2"]),
            "{run:?}"
        );
        assert_eq!(page.matches("<figure").count(), charts.len(), "{run:?}");
        assert!(
            !page.contains("--html") && !page.contains(" src="),
            "{run:?}"
        );
    }
}

/// Bars are as long as the report's figures, and in its order.
#[test]
fn bars_are_as_long_as_the_figures() {
    let (run, _) = RUNS[0];
    let mut json = run.to_vec();
    json.extend(["-q", "--format", "json"]);
    let report: serde_json::Value = serde_json::from_str(&text(&json)).unwrap();
    let cases = report["cases"].as_array().unwrap();
    let results = cases
        .iter()
        .flat_map(|case| case["results"].as_array().unwrap());
    let rates: Vec<f64> = results
        .map(|result| result["picking_rate_per_min"].as_f64().unwrap())
        .collect();
    let svg = written(run, "--svg", &[]);
    let document = Document::parse(&svg).unwrap();
    let bars = document
        .descendants()
        .filter(|node| node.has_tag_name("rect") && node.attribute("height") != Some("100%"));
    // Those of the legend are all of one width and come last.
    let mut bars: Vec<(f64, f64)> = bars
        .map(|bar| (number(bar, "y"), number(bar, "width")))
        .take(rates.len())
        .collect();
    bars.sort_by(|a, b| a.0.total_cmp(&b.0));
    let scale = bars[0].1 / rates[0];
    for ((_, width), rate) in bars.iter().zip(&rates) {
        assert!((width / scale - rate).abs() < 0.05, "{width} px for {rate}");
    }
    let texts = texts(&document);
    assert!(texts.contains(&"the paper's figure"));
    // Each bar has its number beside it.
    for rate in rates {
        let number = format!("{rate:.2}");
        assert!(texts.contains(&number.as_str()), "{number} in {texts:?}");
    }
}

/// Whether the description of a chart says that an axis does not begin at 0.
fn says_cut(svg: &str) -> bool {
    let document = Document::parse(svg).unwrap();
    let about = document
        .descendants()
        .find(|node| node.has_tag_name("desc"));
    about.unwrap().text().unwrap().contains("not begin at 0")
}

#[test]
fn axes_that_do_not_begin_at_0_say_so_and_counts_are_whole() {
    let (compare, _) = RUNS[0];
    assert!(!says_cut(&written(compare, "--svg", &[])));
    let (speeds, _) = RUNS[2];
    assert!(says_cut(&written(speeds, "--svg", &[])));
    let (robots, _) = RUNS[3];
    let svg = written(robots, "--svg", &[]);
    let document = Document::parse(&svg).unwrap();
    // The ticks of x stand on one line, which that of the first robot is on.
    let ticks: Vec<(f64, &str)> = document
        .descendants()
        .filter(|node| node.has_tag_name("text"))
        .map(|node| (number(node, "y"), node.text().unwrap_or_default()))
        .collect();
    let line = ticks.iter().find(|(_, text)| *text == "1").unwrap().0;
    let below: Vec<&str> = ticks
        .iter()
        .filter(|(y, _)| (y - line).abs() < 1e-6)
        .map(|(_, text)| *text)
        .collect();
    assert_eq!(below, ["1", "2"]);
}

#[test]
fn limits_in_the_same_place_stay_apart() {
    // Twice the same method: all that they do is the same.
    let run = [
        "sweep",
        "--robust",
        "SPT,FIFO",
        "--strategy",
        "rules:SPT,FIFO",
        "--from",
        "0.04",
        "--to",
        "0.05",
    ];
    let svg = written(&run, "--svg", &[]);
    let document = Document::parse(&svg).unwrap();
    let dashed = document.descendants().filter(|node| {
        node.has_tag_name("line")
            && node.attribute("stroke-dasharray").is_some()
            && node.attribute("x1") == node.attribute("x2")
    });
    let mut at: Vec<f64> = dashed.map(|node| number(node, "x1")).collect();
    assert!(at.len() >= 2, "{at:?}");
    at.sort_by(f64::total_cmp);
    assert!(at.windows(2).all(|pair| pair[1] - pair[0] > 1.0), "{at:?}");
}

#[test]
fn names_of_any_kind_stay_names() {
    let folder = tempfile::tempdir().unwrap();
    let cases = folder.path().join("cases.toml");
    let name = "</text><b>$x^2$ & \\u0007 'a' \\\"b\\\" with so many words that no label holds it";
    std::fs::write(
        &cases,
        format!("[[case]]\nname = \"{name}\"\ngrid = 0.3\nitems = 5\n"),
    )
    .unwrap();
    let run = [
        "compare",
        "--robust",
        "SPT,FIFO",
        "--cases",
        cases.to_str().unwrap(),
    ];
    let svg = written(&run, "--svg", &[]);
    let document = Document::parse(&svg).unwrap();
    let label = texts(&document)
        .into_iter()
        .find(|text| text.contains("<b>"))
        .unwrap();
    assert!(label.starts_with("</text><b>$x^2$ & "), "{label}");
    assert!(label.ends_with('\u{2026}'), "{label}");
    let page = written(&run, "--html", &[]);
    assert!(!page.contains("<b>") && page.contains("&lt;b&gt;"));
}

#[test]
fn typing_mistakes_are_reported_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    let (file, twin) = (path("a.svg"), path("folder/../a.svg"));
    let (missing, taken, good) = (path("none/a.html"), path("folder"), path("b.html"));
    let bad: [(&[&str], &str); 7] = [
        (&["--html", &missing], "none/a.html"),
        (&["--svg", &taken], "folder"),
        (&["--html", &file, "--svg", &file], "already used by --html"),
        (&["--html", &file, "--svg", &twin], "already used by --html"),
        (&["--svg", &file, "--chart", "rat"], "known: "),
        (&["--html", &good, "--chart", "rate"], "--svg"),
        (&["--html", &good, "--svg", &missing], "none/a.html"),
    ];
    let left = || std::fs::read_dir(folder.path()).unwrap().count();
    for (run, _) in RUNS {
        for (more, words) in bad {
            refused(&[&run[..1], more].concat(), words);
        }
    }
    // Charts that this run could not have.
    let cases: [(&[&str], &str); 3] = [
        (&["sweep", "--chart", "limits"], "several patterns"),
        (
            &["sweep", "--sweep", "robots", "--chart", "limits"],
            "several patterns",
        ),
        (
            &[
                "compare",
                "--no-greedy",
                "--no-policy",
                "--chart",
                "difference",
            ],
            "second method",
        ),
    ];
    for (run, words) in cases {
        refused(&[run, &["--svg", &file]].concat(), words);
    }
    assert_eq!(left(), 1, "something was left behind");
    assert!(Path::new(&taken).is_dir());
}

/// The call ends with exit code 2, says `words` and prints nothing.
fn refused(arguments: &[&str], words: &str) {
    let output = pickline(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert!(stderr.contains(words), "{arguments:?}: {stderr}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert!(
        !stderr.contains("sweeping") && !stderr.contains("comparing on"),
        "{stderr}"
    );
}
