//! Scenes and what is made of them: windows and their overlaps, what is in view, assignments
//! as a tree.

use crate::FirstRobots;
use crate::events::{items, line};
use pickline::decision::{Action, Snapshot, Strategy};
use pickline::dispatch::RuleAssignment;
use pickline::sim::{
    AssignmentTree, Cascade, Conditions, Disturbances, Scene, simulate, simulate_rules,
};
use std::cell::Cell;

/// Whichever way a scene comes to them, bad conditions and items beside the belt are refused.
#[test]
fn scenes_are_checked() {
    let station = line(&[1.0], 3.0);
    let pattern = items(&[("a", 0.0, false)]);
    let scene = || Scene::new(&station, &pattern).unwrap();
    let bad_luck = Disturbances::default().with_position_noise(-1.0);
    let bad = Conditions::default().with_disturbances(bad_luck);
    for (made, words) in [
        (
            Scene::under(&station, &pattern, bad),
            "'position_noise': -1",
        ),
        (scene().with_disturbances(bad_luck), "'position_noise': -1"),
        (scene().with_update_hz(-1.0), "'update_hz': -1"),
        (scene().with_camera_x(f64::NAN), "'camera_x': NaN"),
    ] {
        let message = made.unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let mut beside = pattern.items().to_vec();
    beside[0].y = 0.51;
    let beside = pickline::pattern::Pattern::new(beside).unwrap();
    let message = Scene::new(&station, &beside).unwrap_err().to_string();
    assert!(message.contains("y of item `a`"), "{message}");
    // Each sets its own condition and leaves the others.
    let luck = Disturbances::default().with_seed(7);
    let all = scene().with_update_hz(10.0).unwrap();
    let all = all.with_camera_x(0.5).unwrap();
    let all = all.with_disturbances(luck).unwrap();
    let expected = Conditions::default()
        .with_update_hz(10.0)
        .with_camera_x(0.5)
        .with_disturbances(luck);
    assert_eq!(*all.conditions(), expected);
}

/// The item could be left for from 0 to 6 s, when it is at 1.5 m.
#[test]
fn a_camera_shortens_windows_down_to_a_moment() {
    let station = line(&[1.0], 3.0);
    let pattern = items(&[("a", 0.0, false)]);
    let plain = Scene::new(&station, &pattern).unwrap();
    for (camera, window) in [
        (-1.0, Some((0.0, 6.0))),
        (0.0, Some((0.0, 6.0))),
        (0.25, Some((1.0, 6.0))),
        (1.5, Some((6.0, 6.0))),
        (1.5625, None),
    ] {
        let scene = plain.clone().with_camera_x(camera).unwrap();
        let queue = scene.queue(0);
        let windows: Vec<_> = queue.iter().map(|c| (c.open, c.close)).collect();
        assert_eq!(windows, Vec::from_iter(window), "{camera}");
    }
}

/// The first robot's window closes at 6 s; the second's has to open later.
#[test]
fn windows_that_touch_are_not_independent() {
    let pattern = items(&[("a", 0.0, false)]);
    for (second, opens, independent) in [(2.375, 5.5, false), (2.5, 6.0, false), (2.75, 7.0, true)]
    {
        let station = line(&[1.0, second], 5.0);
        let scene = Scene::new(&station, &pattern).unwrap();
        let windows = [0, 1].map(|robot| (scene.queue(robot)[0].open, scene.queue(robot)[0].close));
        assert_eq!((windows[0].1, windows[1].0), (6.0, opens));
        assert_eq!(scene.is_independent(), independent, "{second}");
        assert_eq!(Cascade::new(&scene).is_some(), independent, "{second}");
    }
    // One pair of any item is enough: here the first two robots'.
    let station = line(&[1.0, 1.5, 4.5], 7.0);
    assert!(!Scene::new(&station, &pattern).unwrap().is_independent());
    // What goes wrong gives items back.
    let station = line(&[1.0, 4.5], 7.0);
    let scene = Scene::new(&station, &pattern).unwrap();
    assert!(scene.is_independent());
    let failing = Disturbances::default().with_grasp_failures(true);
    assert!(!scene.with_disturbances(failing).unwrap().is_independent());
}

/// Writes down what is in view, and picks the last candidate.
#[derive(Default)]
struct Watch(Vec<(f64, Vec<u32>)>);

impl Strategy for Watch {
    fn decide(&mut self, s: &Snapshot) -> Action {
        for item in s.in_view {
            assert_eq!(item.x, item.x0 + 0.25 * s.time);
        }
        let seen = s.in_view.iter().map(|item| item.item);
        self.0.push((s.time, seen.collect()));
        Action::Pick(s.candidates.len() - 1)
    }

    fn name(&self) -> String {
        "watch".into()
    }
}

/// From the belt's start, or the camera, to its end, both included; claimed ones are not.
#[test]
fn unclaimed_items_on_the_belt_are_in_view() {
    let station = line(&[1.0], 2.5);
    let list = [
        ("a", 0.0, false),
        ("b", -0.125, false),
        ("c", -2.5, false),
        ("d", -2.625, false),
        ("e", -4.0, false),
    ];
    let pattern = items(&list);
    let run = |camera: Option<f64>| {
        let conditions = Conditions::default().with_camera_x(camera);
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let mut watch = Watch::default();
        simulate(&scene, &mut watch).unwrap();
        watch.0
    };
    // Windows open when an item is at 0 m. `a` is picked at 0 s and the robot is free at
    // 2.75 s, `b` is then at 0.5625 m and taken until 4.625 s or so. `c` comes at 10 s, when
    // `d` is still 0.125 m before the belt; `e` at 16 s.
    let plain = run(None);
    let seen: Vec<&[u32]> = plain.iter().map(|(_, seen)| &seen[..]).collect();
    assert_eq!(seen, [&[0][..], &[1], &[2], &[3], &[4]], "{plain:?}");
    assert_eq!((plain[0].0, plain[1].0, plain[2].0), (0.0, 2.75, 10.0));
    // A camera upstream of the belt knows of them earlier.
    let early = run(Some(-1.5));
    let seen: Vec<&[u32]> = early.iter().map(|(_, seen)| &seen[..]).collect();
    assert_eq!(seen[..3], [&[0, 1][..], &[1], &[2, 3, 4]], "{early:?}");
}

/// An item that is left alone is in view until it is at the very end of the belt.
#[test]
fn items_leave_the_view_behind_the_end() {
    for (length, seen) in [(2.5, vec![0, 1]), (2.4375, vec![1])] {
        let station = line(&[1.0], length);
        // `b` comes to 0 m at 10 s, when `a` is at 2.5 m.
        let pattern = items(&[("a", 0.0, false), ("b", -2.5, false)]);
        let scene = Scene::new(&station, &pattern).unwrap();
        struct Late(Watch);
        impl Strategy for Late {
            fn decide(&mut self, s: &Snapshot) -> Action {
                match s.time < 10.0 {
                    true => Action::WaitForNextWindow,
                    false => self.0.decide(s),
                }
            }
            fn name(&self) -> String {
                "late".into()
            }
        }
        let mut late = Late(Watch::default());
        simulate(&scene, &mut late).unwrap();
        assert_eq!(late.0.0, [(10.0, seen)], "{length}");
    }
}

/// With overlapping windows and without, the tree tells what each robot picks, and stops.
#[test]
fn trees_report_the_picks_of_each_robot_and_stop_on_request() {
    let list: Vec<(String, f64)> = (0..20)
        .map(|i| (i.to_string(), -0.3 * f64::from(i)))
        .collect();
    let list: Vec<(&str, f64, bool)> = list.iter().map(|(id, x)| (&id[..], *x, false)).collect();
    let pattern = items(&list);
    for (bases, independent) in [([1.0, 4.0], true), ([1.0, 1.5], false)] {
        let station = line(&bases, 6.0);
        let scene = Scene::new(&station, &pattern).unwrap();
        assert_eq!(scene.is_independent(), independent);
        let tree = AssignmentTree::new(
            ["FIFO", "FIFO,LD", "SPT,FIFO"]
                .map(|text| text.parse().unwrap())
                .into(),
        );
        let mut visited = 0;
        let all = tree.evaluate_robots(
            &scene,
            || true,
            |place, figures, picks| {
                let rules = &tree.assignments()[place];
                let alone = simulate(&scene, &mut FirstRobots::new(rules)).unwrap();
                let each: Vec<usize> = alone.robots.iter().map(|robot| robot.picked).collect();
                assert_eq!((figures, picks), (alone.figures, &each[..]));
                visited += 1;
            },
        );
        assert!(all.unwrap() && visited == 3);
        // Asked before every assignment.
        let (asked, visited) = (Cell::new(0), Cell::new(0));
        let go_on = || {
            asked.set(asked.get() + 1);
            asked.get() <= 2
        };
        let stopped = tree.evaluate_while(&scene, go_on, |_, _| visited.set(visited.get() + 1));
        assert!(!stopped.unwrap());
        assert_eq!((asked.get(), visited.get()), (3, 2));
        // More rules than robots.
        let long = AssignmentTree::new(vec!["SPT,SPT,SPT".parse().unwrap()]);
        let message = long.evaluate(&scene, |_, _| panic!("nothing to visit"));
        let message = message.unwrap_err().to_string();
        assert!(message.contains("3 rules for 2 robots"), "{message}");
        // For a whole run there is a rule for each.
        let one: RuleAssignment = "SPT".parse().unwrap();
        let message = simulate_rules(&scene, &one).unwrap_err().to_string();
        assert!(message.contains("1 rule for 2 robots"), "{message}");
    }
    let empty = AssignmentTree::new(vec![RuleAssignment::new(Vec::new())]);
    assert_eq!((empty.assignments().len(), empty.passes()), (0, 0));
}
