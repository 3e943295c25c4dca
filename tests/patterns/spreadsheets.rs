//! Pattern files as spreadsheets and notebooks write them.

use crate::common;
use pickline::pattern::{self, Item, Pattern};

fn read(name: &str) -> pattern::Loaded {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/formats/csv/");
    pattern::load(format!("{folder}{name}").as_ref()).unwrap()
}

fn places(pattern: &Pattern) -> Vec<(&str, f64, f64)> {
    let place = |item: &'_ Item| (item.x0, item.y);
    pattern
        .items()
        .iter()
        .map(|item| (item.id.as_str(), place(item).0, place(item).1))
        .collect()
}

#[test]
fn files_of_spreadsheets_are_patterns() {
    let two = [("D001", 0.0, -0.12), ("D002", -0.15, 0.08)];
    for name in ["capitals.csv", "extra.csv", "tabs.csv", "trailing.csv"] {
        let loaded = read(name);
        assert_eq!(places(&loaded.pattern), two, "{name}");
        let ignored: &[&str] = match name {
            "extra.csv" => &["timestamp"],
            _ => &[],
        };
        assert_eq!(loaded.ignored, ignored, "{name}");
    }
    let german = read("german.csv").pattern;
    assert_eq!(places(&german)[..2], two);
    assert_eq!(places(&german)[2], ("D003", -0.31, 0.1));
    assert_eq!(german.items()[0].class.as_deref(), Some("PET"));
}

#[test]
fn one_pattern_in_many_spellings() {
    let plain = pattern::parse("id,x,y,p_grasp\na,0,0.1,0.5\nb,-1,-0.25,1\n", "t").unwrap();
    for text in [
        "# pickline pattern generate\nid,x,y,p_grasp\n# one\na,0,0.1,0.5\nb,-1,-0.25,1\n",
        "id;x;y;p_grasp\r\na;0;0,1;0,5\r\nb;-1;-0,25;1\r\n",
        "sep=;\r\nid;x;y;p_grasp;\r\na;0;0,1;0,5;\r\nb;-1;-0,25;1;\r\n;;;;\r\n",
        "id\tx\ty\tp_grasp\na\t0\t0.1\t0.5\nb\t-1\t-0.25\t1\n",
        "ID;X [m];Y [m];P_grasp\na;0;0.1;0.5\nb;-1;-0.25;1\n",
        "id,x_mm,y_mm,p_grasp\na,0,100,0.5\nb,-1000,-250,1\n",
        "z,id,x (cm),y,p_grasp,camera frame\n3,a,0,0.1,0.5,1\n3,b,-100,-0.25,1,2\n",
        "id,x,y,p_grasp,,\na,0,0.1,0.5\n,,,,,\nb,-1,-0.25,1,,,,\n   \n",
    ] {
        assert_eq!(pattern::parse(text, "t").unwrap(), plain, "{text}");
    }
}

#[test]
fn ambiguous_input_is_refused() {
    for (text, words) in [
        (
            "id,x,y,wieght\na,0,0,1\n",
            &["t:1: column 4", "did you mean `weight`"][..],
        ),
        ("id,x,y,,note\na,0,0,,n\n", &["t:1: column 4", "no name"]),
        (
            "id,x,y,\na,0,0,0.5\n",
            &["t:2", "expected 3 fields as in the header, found 4"],
        ),
        ("id;x;y\na;0;0.1\nb;-1;-0,25\n", &["t:3: y", "`-0,25`"]),
        (
            "id;x;y\na;0;0,1\nb;-1.000,5;0\n",
            &["t:3: x", "`-1.000,5`", "decimal comma"],
        ),
        (
            "id,x,y\na,0,\"0,1\"\n",
            &["t:2: y", "`0,1`", "decimal point"],
        ),
        (
            "id,x,x_mm,y\na,0,0,0\n",
            &["t:1: column 3", "duplicate column `x`"],
        ),
        (
            "id,x,y\n#1,0,0.1\nb,-1,0\n",
            &["t:2", "`#1,0,0.1`", "quotes"],
        ),
        ("id,x\na,0\n", &["t:1", "`y` is missing"]),
        (
            "name,u,v\na,0,0\n",
            &["t:1: column 1", "`name`", "id, x [m] and y [m]"],
        ),
    ] {
        let message = pattern::parse(text, "t").unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "{word} not in {message}");
        }
    }
    // A name that only looks like a comment.
    let quoted = pattern::parse("id,x,y\n\"#1\",0,0\n# 2\n", "t").unwrap();
    assert_eq!(quoted.items()[0].id, "#1");
    assert_eq!(
        pattern::parse(&pattern::to_csv(&quoted), "t").unwrap(),
        quoted
    );
}

/// What was passed over stands in the result.
#[test]
fn ignored_columns_are_noted() {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/data/formats/csv/extra.csv"
    );
    let text = common::text(&["pattern", "describe", file]);
    assert!(text.contains("column timestamp ignored"), "{text}");
    let text = common::text(&[
        "optimize",
        "--robots",
        "1",
        "--patterns",
        file,
        "--validate",
        "0",
        "-q",
    ]);
    assert!(text.contains("columns ignored: timestamp"), "{text}");
}
