//! A line picks everything, or it does not: 150 of 151 items are 99.3 %, and no line with
//! that is complete, wherever limits and shares of complete patterns are made.

use super::support::{STATION, environment, run, table_rows};
use pickline::experiment::{
    Case, CaseSource, Draws, Method, Setting, add_bounds, compare_methods, find_limits,
    sweep_settings,
};
use pickline::optimize::{Evaluator, Objective, Risk, SpeedScan, ValidationOptions, validate};
use pickline::pattern::{Item, Pattern};
use pickline::planning::bound::{BoundOptions, upper_bound};
use pickline::sim::{AssignmentTree, Conditions, Scene, simulate_rules};
use pickline::station::{self, Overrides, Station};
use serde_json::Value;

const RULES: &str = "FIFO";

/// One robot, which does not reach the far edge of the belt.
fn one_robot() -> Station {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("line.toml");
    std::fs::write(&file, STATION.replace("robots = 2", "robots = 1")).unwrap();
    let none = Overrides::default();
    station::load(file.to_str().unwrap(), none).unwrap()
}

/// 150 items one after the other within reach, with time for each at any speed here, and
/// `beyond` out of reach.
fn sparse(beyond: usize) -> Pattern {
    let item = |(i, y): (usize, f64)| Item::at(i.to_string(), -0.9 * i as f64, y);
    let within = (0..150).map(|i| (i, -0.2));
    let out = (0..beyond).map(|i| (40 + i, 0.3));
    let mut items: Vec<Item> = within.chain(out).map(item).collect();
    for (place, item) in items.iter_mut().enumerate() {
        item.id = place.to_string();
    }
    Pattern::new(items).unwrap()
}

fn settings(speeds: &[f64]) -> Vec<Setting> {
    let at = |&value: &f64| Setting {
        value,
        station: one_robot().with_belt_speed(value).unwrap(),
        min_detection: None,
        methods: vec![
            Method::Robust(RULES.parse().unwrap()),
            Method::greedy(1).unwrap(),
        ],
    };
    speeds.iter().map(at).collect()
}

#[test]
fn the_pattern_is_picked_but_for_one_item() {
    let station = one_robot();
    for (beyond, picked) in [(0, 150), (1, 150), (2, 150)] {
        let pattern = sparse(beyond);
        let scene = Scene::new(&station, &pattern).unwrap();
        let figures = simulate_rules(&scene, &RULES.parse().unwrap())
            .unwrap()
            .figures;
        assert_eq!((figures.items, figures.picked), (150 + beyond, picked));
        assert_eq!(figures.complete(), beyond == 0);
    }
}

#[test]
fn a_sweep_says_complete_of_everything_only() {
    let speeds = [0.05, 0.1, 0.15];
    let plain = Conditions::default();
    for (beyond, complete, nearly) in [(0, 1.0, 1.0), (1, 0.0, 1.0), (2, 0.0, 0.0)] {
        let patterns = [sparse(beyond)];
        let swept =
            sweep_settings(&settings(&speeds), &patterns, &plain, true, &environment()).unwrap();
        assert_eq!(swept.methods().count(), 2);
        for method in swept.methods() {
            for (_, point) in method.points() {
                assert_eq!(point.complete_share, complete, "{beyond}");
                assert_eq!(point.nearly_complete_share, nearly, "{beyond}");
            }
            let limit = method.complete();
            assert_eq!(limit.highest, (beyond == 0).then_some(0.15), "{beyond}");
            assert_eq!(limit.lowest, (beyond == 0).then_some(0.05), "{beyond}");
            assert_eq!(limit.first_miss, (beyond > 0).then_some(0.05), "{beyond}");
            assert_eq!(method.limits(), [if beyond == 0 { 0.15 } else { 0.0 }]);
            let near = method.nearly_complete(0.95);
            assert_eq!(near.highest, (beyond < 2).then_some(0.15), "{beyond}");
        }
        for bound in swept.values.iter().map(|at| at.bound.as_ref().unwrap()) {
            assert_eq!(bound.picked_share, 150.0 / (150 + beyond) as f64);
            assert_eq!(bound.complete(), beyond == 0);
        }
    }
}

#[test]
fn speed_limits_are_those_of_everything() {
    let station = one_robot();
    let scan = SpeedScan::new(0.05, &station).unwrap();
    let tree = AssignmentTree::new(vec![RULES.parse().unwrap()]);
    let plain = Conditions::default();
    let setting = |value: f64| Ok(settings(&[value]).remove(0));
    for (beyond, above) in [(0, true), (1, false)] {
        let pattern = sparse(beyond);
        let (limits, _) = scan.limits(&station, &pattern, &tree, &plain).unwrap();
        assert_eq!(limits[0] >= 0.1, above, "{beyond}: {limits:?}");
        let run = |scene: &Scene| Ok(simulate_rules(scene, &RULES.parse().unwrap())?.figures);
        let limit = scan.limit(&station, &pattern, &plain, run).unwrap();
        assert_eq!(limit, limits[0], "{beyond}");
        let patterns = [pattern];
        let found = find_limits(setting, (0.05, 0.15), &patterns, &plain, &environment()).unwrap();
        for limit in found {
            assert_eq!(limit.highest, above.then_some(0.15), "{beyond}: {limit:?}");
            assert_eq!(
                limit.first_miss,
                (!above).then_some(0.05),
                "{beyond}: {limit:?}"
            );
        }
    }
}

#[test]
fn a_validation_counts_whole_patterns_only() {
    let station = one_robot();
    let patterns = [sparse(0), sparse(1), sparse(0), sparse(2)];
    let plain = Conditions::default();
    let evaluator = Evaluator::new(&station, &patterns, Objective::PickedShare, &plain).unwrap();
    for flow in [None, Some(0.05)] {
        let rules = RULES.parse().unwrap();
        let options = ValidationOptions::new(Risk::Mean, plain)
            .with_flow(flow)
            .with_certify(true);
        let found = validate(&evaluator, &rules, &options, &environment());
        let found = found.unwrap().unwrap();
        assert_eq!((found.complete, found.complete_share()), (2, 0.5));
        assert_eq!(found.speed, flow.unwrap_or(0.1));
        let certificate = found.certificate.unwrap();
        assert_eq!(certificate.picked_share, 600.0 / 603.0);
        assert_eq!(certificate.percent, 100.0);
    }
}

#[test]
fn a_bound_excludes_items_out_of_reach() {
    let station = one_robot();
    let pattern = sparse(1);
    let scene = Scene::new(&station, &pattern).unwrap();
    let bound = upper_bound(&scene, &BoundOptions::default(), &mut |_, _| true).unwrap();
    assert_eq!((bound.value, bound.all_end), (150.0, None));
}

/// Where the first method picks nothing no other is so many percent better.
#[test]
fn a_line_that_picks_nothing_has_no_rate_to_be_better_than() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.csv");
    std::fs::write(&file, "id,x,y\n1,0,0.3\n2,-0.5,0.3\n").unwrap();
    let (station, plain) = (one_robot(), Conditions::default());
    let cases = [Case {
        name: "beyond".into(),
        source: CaseSource::File(file),
        items: 0,
        attributes: Default::default(),
    }];
    let methods = settings(&[0.1]).remove(0).methods;
    let draws = Draws {
        replicates: 1,
        first_seed: 1,
        conditions: &plain,
    };
    let compared = compare_methods(&station, methods, &cases, draws, &environment());
    let mut comparison = compared.unwrap();
    add_bounds(&mut comparison, &station, draws, &environment()).unwrap();
    let case = &comparison.cases[0];
    for method in &case.methods {
        assert_eq!((method.picking_rate, method.benefit), (0.0, 0.0));
    }
    let bound = case.bound.as_ref().unwrap();
    assert_eq!((bound.picks.as_slice(), bound.benefit), (&[0][..], None));
}

/// In tables the shares of whole patterns and of those picked to 99 % stand side by side.
#[test]
fn tables_distinguish_everything_from_nearly_everything() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(
        file("line.toml"),
        STATION.replace("robots = 2", "robots = 1"),
    )
    .unwrap();
    std::fs::create_dir(file("set")).unwrap();
    for (name, beyond) in [("a", 0), ("b", 1)] {
        let rows = sparse(beyond);
        let rows = rows
            .items()
            .iter()
            .map(|i| format!("{},{},{}\n", i.id, i.x0, i.y));
        let csv = format!("id,x,y\n{}", rows.collect::<String>());
        std::fs::write(file(&format!("set/{name}.csv")), csv).unwrap();
    }
    let (line, set) = (file("line.toml"), file("set"));
    let call = format!(
        "sweep -q --station {line} --patterns {set} --robust {RULES} --from 0.05 --to 0.1 \
         --step 0.05"
    );
    let table = run(&call);
    let rows = table_rows(&table);
    let place = |name: &str| rows[0].iter().position(|cell| cell == name).unwrap();
    for row in &rows[1..] {
        assert_eq!(row[place("complete [%]")], "50.0", "{table}");
        assert_eq!(row[place("to 99 % [%]")], "100.0", "{table}");
    }
    assert!(
        table.contains("limit     robust_gt: misses items already at the first value\n"),
        "{table}"
    );
    let proven =
        "no strategy picks everything at 0.05 m/s or at any value above it; that is proven";
    assert!(table.contains(proven), "{table}");
    let report: Value = serde_json::from_str(&run(&format!("{call} --format json"))).unwrap();
    assert_eq!(
        report["limits"][0]["all_of_patterns"],
        serde_json::json!([0.0, 0.1])
    );
    assert_eq!(report["limits"][0]["highest_95_99"], 0.1);
    assert_eq!(
        report["bounds"]["impossible"],
        serde_json::json!([0.05, 0.1])
    );
}
