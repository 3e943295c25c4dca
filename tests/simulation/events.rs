//! What an observer sees, event by event, and what a trace makes of it. The arm gains
//! 0.75 + 0.25 m/s on an item that comes straight towards its bin, so all times come out even.

use nalgebra::Point2;
use pickline::checker::check;
use pickline::decision::{Action, Event, MissReason, Observer, Outcome, Snapshot, Strategy};
use pickline::dispatch::RuleStrategy;
use pickline::pattern::{Item, Pattern};
use pickline::sim::{
    Conditions, Disturbances, Outage, Scene, Trace, simulate_observed, simulate_rules,
};
use pickline::station::{Belt, Robot, Station};

/// Robots `r1`, `r2`, ... with base and bin in the middle of the belt at these x [m]. They meet
/// items from 0.75 m before their bins on, for which they leave when the items are 1 m before.
pub fn line(robots: &[f64], length: f64) -> Station {
    let robots = robots.iter().enumerate().map(|(i, &x)| {
        Robot::new(
            format!("r{}", i + 1),
            Point2::new(x, 0.0),
            Point2::new(x, 0.0),
            0.75,
            pickline::kinematics::Arm::constant(0.75),
        )
        .with_dwell(0.5, 0.25)
    });
    let belt = Belt {
        speed: 0.25,
        length,
        width: 1.0,
    };
    Station::new(belt, robots.collect()).unwrap()
}

/// Items in the middle of the belt; no grasp of those marked so succeeds.
pub fn items(list: &[(&str, f64, bool)]) -> Pattern {
    let item = |&(id, x0, fails): &(&str, f64, bool)| Item {
        p_grasp: Some(if fails { 0.0 } else { 1.0 }),
        ..Item::at(id, x0, 0.0)
    };
    Pattern::new(list.iter().map(item).collect()).unwrap()
}

fn scene<'a>(station: &'a Station, pattern: &'a Pattern) -> Scene<'a> {
    let conditions =
        Conditions::default().with_disturbances(Disturbances::default().with_grasp_failures(true));
    Scene::under(station, pattern, conditions).unwrap()
}

/// Every robot makes one attempt at the item that is meant for it, and waits otherwise.
struct Meant {
    /// Item of each robot, until it has been tried.
    items: Vec<Option<u32>>,
}

impl Strategy for Meant {
    fn decide(&mut self, s: &Snapshot) -> Action {
        let meant = &mut self.items[s.robot];
        let place = s.candidates.iter().position(|c| Some(c.item) == *meant);
        match place {
            Some(place) => {
                *meant = None;
                Action::Pick(place)
            }
            None => Action::WaitForNextWindow,
        }
    }

    fn name(&self) -> String {
        "as meant".into()
    }
}

/// Every event in words; decisions to wait are left out.
#[derive(Default)]
struct Diary(Vec<String>);

impl Observer for Diary {
    fn observe(&mut self, event: &Event) {
        let time = event.time();
        let text = match *event {
            Event::Decision { snapshot, action } => match action {
                Action::Pick(place) => {
                    let item = snapshot.candidates[place].item;
                    format!("robot {} leaves for {item}", snapshot.robot)
                }
                _ => return,
            },
            Event::Grasp { robot, item, .. } => format!("robot {robot} takes {item}"),
            Event::Release { robot, item, .. } => format!("robot {robot} drops {item}"),
            Event::GraspFailed {
                robot, item, free, ..
            } => format!("robot {robot} fails at {item}, back at {free}"),
            Event::RobotDown { robot, .. } => format!("robot {robot} is down"),
            Event::RobotUp { robot, .. } => format!("robot {robot} is ready again"),
            Event::LeftBelt { item, .. } => format!("{item} leaves"),
        };
        self.0.push(format!("{time}: {text}"));
    }
}

fn observed(scene: &Scene, strategy: &mut dyn Strategy) -> (Outcome, Vec<String>) {
    let mut diary = Diary::default();
    let outcome = simulate_observed(scene, strategy, Some(&mut diary), || true).unwrap();
    (outcome, diary.0)
}

/// At 40 s everything happens at once.
#[test]
fn at_equal_times_grasps_come_first_and_decisions_last() {
    let station = line(&[1.0, 3.0, 5.0, 7.0], 8.0);
    let pattern = items(&[
        ("left alone", -2.0, false),
        ("of r4", -4.0, false),
        ("of r3", -5.3125, false),
        ("of r2", -7.625, true),
        ("of r1", -9.75, false),
    ]);
    let mut meant = Meant {
        items: vec![Some(4), Some(3), Some(2), Some(1)],
    };
    let (outcome, diary) = observed(&scene(&station, &pattern), &mut meant);
    let expected = [
        "37.25: robot 2 leaves for 2",
        "38.25: robot 2 takes 2",
        "38.5: robot 1 leaves for 3",
        "39: robot 0 leaves for 4",
        "40: robot 0 takes 4",
        "40: robot 1 fails at 3, back at 41.25",
        "40: robot 2 drops 2",
        "40: 0 leaves",
        "40: robot 3 leaves for 1",
        "41: robot 3 takes 1",
        "41.75: robot 0 drops 4",
        "42.75: robot 3 drops 1",
        "62.5: 3 leaves",
    ];
    assert_eq!(diary, expected);
    let missed: Vec<_> = outcome.missed.iter().map(|m| (m.item, m.reason)).collect();
    let reasons = [(0, MissReason::PassedOver), (3, MissReason::GraspFailed)];
    assert_eq!(missed, reasons);
    assert_eq!(outcome.figures.end, 62.5);
}

/// What happens to robots comes before what they do, also after the last decision.
#[test]
fn at_equal_times_outages_begin_and_end_first() {
    let station = line(&[1.0, 3.0, 5.0, 7.0], 8.0);
    let pattern = items(&[
        ("left alone", -2.0, false),
        ("of r4", -4.0, false),
        ("of r3", -5.3125, false),
        ("of r1", -9.75, false),
    ]);
    let mut meant = Meant {
        items: vec![Some(3), None, Some(2), Some(1)],
    };
    let outages = ["r1:40..60", "r4:10..40", "r2:50..61", "r3:60.5.."];
    let outages = outages.map(|text| text.parse::<Outage>().unwrap());
    let conditions = outages
        .into_iter()
        .fold(Conditions::default(), Conditions::with_outage);
    let scene = Scene::under(&station, &pattern, conditions).unwrap();
    let (outcome, diary) = observed(&scene, &mut meant);
    let expected = [
        "10: robot 3 is down",
        "37.25: robot 2 leaves for 2",
        "38.25: robot 2 takes 2",
        "39: robot 0 leaves for 3",
        "40: robot 0 is down",
        "40: robot 3 is ready again",
        "40: robot 0 takes 3",
        "40: robot 2 drops 2",
        "40: 0 leaves",
        "40: robot 3 leaves for 1",
        "41: robot 3 takes 1",
        "41.75: robot 0 drops 3",
        "42.75: robot 3 drops 1",
    ];
    assert_eq!(diary, expected);
    // What begins after the run is not part of it, and no outage ends after it.
    assert_eq!(outcome.figures.end, 42.75);
    let down = outcome.downtimes.iter().map(|d| (d.robot, d.from, d.to));
    assert_eq!(
        down.collect::<Vec<_>>(),
        [(3, 10.0, 40.0), (0, 40.0, 42.75)]
    );
}

/// Events of one kind at one time come in the order of their decisions.
#[test]
fn at_equal_times_robots_come_in_the_order_of_their_decisions() {
    let station = line(&[1.0, 1.0], 4.0);
    for (fails, end) in [
        (
            false,
            [
                "1: robot 0 takes 1",
                "1: robot 1 takes 0",
                "2.75: robot 0 drops 1",
                "2.75: robot 1 drops 0",
            ],
        ),
        (
            true,
            [
                "1.5: robot 0 fails at 1, back at 2.75",
                "1.5: robot 1 fails at 0, back at 2.75",
                "16: 0 leaves",
                "16: 1 leaves",
            ],
        ),
    ] {
        let pattern = items(&[("a", 0.0, fails), ("b", 0.0, fails)]);
        let mut meant = Meant {
            items: vec![Some(1), Some(0)],
        };
        let (_, diary) = observed(&scene(&station, &pattern), &mut meant);
        let expected = [
            &["0: robot 0 leaves for 1", "0: robot 1 leaves for 0"][..],
            &end,
        ];
        assert_eq!(diary, expected.concat());
    }
}

/// No item leaves, whatever their number; that of a word of bits is the one that could.
#[test]
fn nothing_leaves_where_everything_is_picked() {
    let station = line(&[1.0], 2.0);
    for count in [63, 64, 65] {
        let items = (0..count).map(|i| Item::at(i.to_string(), -f64::from(i), 0.0));
        let pattern = Pattern::new(items.collect()).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let mut fifo = RuleStrategy("FIFO".parse().unwrap());
        let (outcome, diary) = observed(&scene, &mut fifo);
        // An item arrives every 4 s and takes 2.75 s.
        let expected = (0..count).flat_map(|i| {
            let start = 4.0 * f64::from(i);
            [
                format!("{start}: robot 0 leaves for {i}"),
                format!("{}: robot 0 takes {i}", start + 1.0),
                format!("{}: robot 0 drops {i}", start + 2.75),
            ]
        });
        assert_eq!(diary, expected.collect::<Vec<_>>());
        assert_eq!(outcome.figures.picked, count as usize);
        assert_eq!(outcome.figures.end, 4.0 * f64::from(count - 1) + 2.75);
    }
}

/// Waits until a time, then tries the first item, then waits for another window.
struct Hesitant {
    actions: std::vec::IntoIter<Action>,
}

impl Strategy for Hesitant {
    fn decide(&mut self, _: &Snapshot) -> Action {
        self.actions.next().unwrap()
    }

    fn name(&self) -> String {
        "hesitant".into()
    }
}

#[test]
fn a_trace_has_a_line_for_every_event() {
    let station = line(&[1.0], 2.5);
    let pattern = items(&[("a", 0.0, true), ("b", -1.0, false)]);
    let scene = scene(&station, &pattern);
    let actions = vec![
        Action::WaitUntil(0.5),
        Action::Pick(0),
        Action::WaitForNextWindow,
        Action::Pick(1),
    ];
    let mut hesitant = Hesitant {
        actions: actions.into_iter(),
    };
    let mut trace = Trace::new(&station, &pattern);
    simulate_observed(&scene, &mut hesitant, Some(&mut trace), || true).unwrap();
    // Leaving late, at 0.5 s, the robot meets `a` after 0.875 s.
    let expected = "\
        time_s,event,robot,item,candidates,until_s\n\
        0,wait,r1,,1,0.5\n\
        0.5,decide,r1,a,1,\n\
        1.875,grasp_failed,r1,a,,3\n\
        3,wait,r1,,1,\n\
        4,decide,r1,b,2,\n\
        5,grasp,r1,b,,\n\
        6.75,release,r1,b,,\n\
        10,left_belt,,a,,\n";
    assert_eq!(trace.to_csv(), expected);
}

/// A claim that ends when the last window closes leaves the item to who is idle then.
#[test]
fn an_item_given_back_at_the_end_of_its_window_is_tried_again() {
    struct Late;
    impl Strategy for Late {
        fn decide(&mut self, s: &Snapshot) -> Action {
            // `r1` leaves 5 s late, when the item is 0.25 m past its bin; `r2` waits for longer.
            match (s.robot, s.time) {
                (0, 0.0) => Action::WaitUntil(5.0),
                (1, 0.0) => Action::WaitUntil(5.5),
                _ => Action::Pick(0),
            }
        }
        fn name(&self) -> String {
            "late".into()
        }
    }
    let station = line(&[1.0, 1.0], 4.0);
    let pattern = items(&[("a", 0.0, true)]);
    let (_, diary) = observed(&scene(&station, &pattern), &mut Late);
    let expected = [
        "5: robot 0 leaves for 0",
        "6: robot 0 fails at 0, back at 6.75",
        "6: robot 1 leaves for 0",
        "7.5: robot 1 fails at 0, back at 8.75",
        "16: 0 leaves",
    ];
    assert_eq!(diary, expected);
}

/// At the bin, an attempt of an arm without dwell takes no time; it is not repeated for ever.
#[test]
fn attempts_that_take_no_time_come_to_an_end() {
    let slow = line(&[0.0], 1.0);
    let robots = slow
        .robots()
        .iter()
        .map(|robot| robot.clone().with_dwell(0.0, 0.0));
    let station = Station::new(*slow.belt(), robots.collect()).unwrap();
    let pattern = items(&[("a", 0.0, true)]);
    let fifo = "FIFO".parse().unwrap();
    let outcome = simulate_rules(&scene(&station, &pattern), &fifo).unwrap();
    check(&station, &pattern, &outcome).unwrap();
    let first = &outcome.failures[0].attempt;
    assert_eq!((first.decide, first.release), (0.0, 0.0));
    assert!(
        outcome
            .failures
            .is_sorted_by(|a, b| a.attempt.decide < b.attempt.decide)
    );
    // The reach ends at 0.75 m, for which the robot leaves at 2 s at the latest.
    let last = outcome.failures.last().unwrap().attempt.decide;
    assert!((0.5..=2.0).contains(&last), "{last}");
}

/// Picks the first candidate, and counts what it is shown of the belt.
struct Looks {
    needs: bool,
    seen: usize,
}

impl Strategy for Looks {
    fn decide(&mut self, s: &Snapshot) -> Action {
        self.seen += s.in_view.len();
        Action::Pick(0)
    }

    fn name(&self) -> String {
        "looks".into()
    }

    fn needs_view(&self) -> bool {
        self.needs
    }
}

/// Who does not look is shown nothing, observed or not.
#[test]
fn the_belt_is_shown_to_those_who_look() {
    let station = line(&[1.0], 3.0);
    let pattern = items(&[("a", 0.0, false), ("b", 0.0, false), ("c", -9.0, false)]);
    let scene = Scene::new(&station, &pattern).unwrap();
    for watched in [false, true] {
        // `a` and `b` are on the belt at 0 s, `b` at 2.75 s, `c` when the robot leaves for it.
        for (needs, seen) in [(true, 4), (false, 0)] {
            let mut looks = Looks { needs, seen: 0 };
            let mut diary = Diary::default();
            let observer = watched.then_some(&mut diary as &mut dyn Observer);
            simulate_observed(&scene, &mut looks, observer, || true).unwrap();
            assert_eq!(looks.seen, seen, "{watched}");
        }
    }
}
