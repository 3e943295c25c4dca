//! Station files, figures of patterns, what a service is installed with, pages and completions.

use super::rig::Rig;
use super::{Row, hold, row};
use serde_json::Value;

const SHOW: [&str; 1] = ["station show"];
const DESCRIBE: [&str; 1] = ["pattern describe"];
const PLACES: [&str; 2] = ["service install", "service uninstall"];

pub const ROWS: &[Row] = &[
    row(&SHOW, "--svg", |rig, verb| {
        rig.done(&format!("{verb} --station one.toml --svg line.svg"));
        assert!(texts(rig).contains("1 robot along a belt of 4 m by 1 m at 0.1 m/s"));
    }),
    row(&SHOW, "--pattern", |rig, verb| {
        let items = |flags: &str| {
            rig.done(&format!("{verb} --station one.toml --svg line.svg {flags}"));
            shapes(rig, "item")
        };
        // Those of the pattern, and of the legend.
        assert!(items("") > 20);
        assert_eq!(items("--pattern ab.csv"), 2 + 1);
    }),
    row(&SHOW, "--camera-x", |rig, verb| {
        let cameras = |flags: &str| {
            rig.done(&format!("{verb} --station one.toml --svg line.svg {flags}"));
            shapes(rig, "camera")
        };
        assert_eq!(cameras(""), 0);
        assert!(cameras("--camera-x 0.2") > 0);
    }),
    row(&["station check"], "<file>", |rig, verb| {
        let last = |file: &str| {
            let text = rig.text(&format!("{verb} {file}"));
            text.lines().last().unwrap().to_owned()
        };
        assert!(last("").starts_with("ok        paper (2 robots, "));
        assert!(last("one.toml").starts_with("ok        one.toml (1 robot, "));
    }),
    row(&["station init"], "<file>", |rig, verb| {
        let printed = rig.text(verb);
        assert!(printed.contains("[line]") || printed.contains("[[robot]]"));
        assert_eq!(rig.text(&format!("{verb} new.toml")), "");
        assert_eq!(rig.read("new.toml"), printed);
    }),
    row(&["station init"], "--force", |rig, verb| {
        let before = rig.read("one.toml");
        rig.refused(
            &format!("{verb} one.toml"),
            &["one.toml: the file already exists", "--force"],
        );
        assert_eq!(rig.read("one.toml"), before);
        std::fs::hard_link(rig.at("one.toml"), rig.at("kept")).unwrap();
        rig.done(&format!("{verb} one.toml --force"));
        assert_eq!(
            (rig.read("one.toml"), rig.read("kept")),
            (rig.text(verb), before)
        );
    }),
    row(&DESCRIBE, "<file>", |rig, verb| {
        let items = |file: &str, input: &str| {
            let called = rig.feed(&format!("{verb} {file} --format json"), input);
            let report: Value = serde_json::from_str(&called.stdout).unwrap();
            report["items"].as_u64().unwrap()
        };
        assert_eq!((items("", ""), items("ab.csv", "")), (50, 2));
        assert_eq!(items("-", &rig.read("p.csv")), 1);
    }),
    row(&DESCRIBE, "--format", |rig, verb| {
        let text = |format: &str| rig.text(&format!("{verb} ab.csv {format}"));
        let json: Value = serde_json::from_str(&text("--format json")).unwrap();
        assert_eq!(json["items"], 2);
        assert!(text("--format csv").starts_with("figure,value,unit\nitems,2,\n"));
        assert!(text("--format table").starts_with("| figure "));
        assert_eq!(text(""), text("--format table"));
    }),
    row(&["service show"], "--prefix", |rig, verb| {
        let program = |flags: &str| {
            let unit = rig.text(&format!("{verb} {flags}"));
            let line = unit
                .lines()
                .find(|line| line.starts_with("ExecStart="))
                .unwrap();
            line.split([' ', '=']).nth(1).unwrap().to_owned()
        };
        assert_eq!(program(""), "/usr/local/bin/pickline");
        assert_eq!(program("--prefix /opt/p"), "/opt/p/bin/pickline");
    }),
    row(&["service show"], "--root", |rig, verb| {
        // The unit names its place as it will be, not where it is staged.
        assert_eq!(rig.text(&format!("{verb} --root image")), rig.text(verb));
    }),
    row(&PLACES, "--prefix", |rig, verb| {
        rig.done("service install --root image --prefix /opt/p");
        assert!(rig.at("image/opt/p/bin/pickline").exists());
        assert!(!rig.at("image/usr").exists());
        if verb == "service uninstall" {
            rig.refused(
                &format!("{verb} --root image"),
                &["nothing is installed here"],
            );
            rig.done(&format!("{verb} --root image --prefix /opt/p"));
            assert!(!rig.at("image/opt/p/bin/pickline").exists());
        }
    }),
    row(&PLACES, "--root", |rig, verb| {
        rig.done("service install --root image");
        assert!(rig.at("image/usr/local/bin/pickline").exists());
        if verb == "service uninstall" {
            rig.refused(
                &format!("{verb} --root other"),
                &["other/usr/local/share/pickline/installed"],
            );
            rig.done(&format!("{verb} --root image"));
            assert!(!rig.at("image/usr/local/bin/pickline").exists());
        }
    }),
    row(&["service install"], "--force", |rig, verb| {
        let (call, page) = (
            format!("{verb} --root image"),
            "image/usr/local/share/man/man1/pickline.1",
        );
        rig.done(&call);
        let written = rig.read(page);
        rig.write(page, "mine");
        std::fs::hard_link(rig.at(page), rig.at("kept")).unwrap();
        rig.refused(&call, &["pickline.1: the file already exists"]);
        assert_eq!(rig.read(page), "mine");
        rig.done(&format!("{call} --force"));
        assert_eq!((rig.read(page), rig.read("kept")), (written, "mine".into()));
    }),
    row(&["man"], "<command>", |rig, verb| {
        let title = |words: &str| {
            let page = rig.text(&format!("{verb} {words}"));
            let title = page.lines().find(|line| line.starts_with(".TH "));
            title.unwrap().split(' ').nth(1).unwrap().to_owned()
        };
        assert_eq!(title(""), "pickline");
        assert_eq!(title("run"), "pickline-run");
        assert_eq!(title("station check"), "pickline-station-check");
    }),
    row(&["completions"], "<shell>", |rig, verb| {
        for (shell, start) in [
            ("bash", "_pickline() {"),
            ("zsh", "#compdef pickline"),
            ("fish", "# Print an optspec for argparse"),
            ("elvish", "\nuse builtin;"),
            (
                "powershell",
                "\nusing namespace System.Management.Automation",
            ),
        ] {
            let script = rig.text(&format!("{verb} {shell}"));
            assert!(script.starts_with(start), "{shell}: {}", &script[..100]);
        }
    }),
];

#[test]
fn options_of_files_have_their_effect() {
    hold(ROWS);
}

/// Shapes of a class in the picture, alone or in a group.
fn shapes(rig: &Rig, class: &str) -> usize {
    let svg = rig.read("line.svg");
    let svg = roxmltree::Document::parse(&svg).unwrap();
    let of_class = |node: &roxmltree::Node| node.attribute("class") == Some(class);
    let shapes = svg
        .descendants()
        .filter(|node| ["circle", "line", "path"].contains(&node.tag_name().name()));
    let is_in = |node: &roxmltree::Node| node.ancestors().any(|node| of_class(&node));
    shapes.filter(is_in).count()
}

/// The text of the picture.
fn texts(rig: &Rig) -> String {
    let svg = rig.read("line.svg");
    let svg = roxmltree::Document::parse(&svg).unwrap();
    let texts = svg.descendants().filter_map(|node| node.text());
    texts.collect::<Vec<_>>().join("\n")
}
