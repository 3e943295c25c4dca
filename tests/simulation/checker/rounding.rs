//! How much is put down to rounding: 1e-9 per unit of the times, lengths and speeds involved,
//! on either side, and no more.

use super::bench::{BELT, Bench, Draft, front, idle};
use nalgebra::Point2;
use pickline::checker::check;
use pickline::decision::{MissReason, Outcome, Pick};
use pickline::error::Result;
use pickline::station::{Belt, Robot, Station};

/// 1e-9 of a size and of 1.
fn slack(size: f64) -> f64 {
    1e-9 * (1.0 + size.abs())
}

/// What the places of a trip may be off by [m].
fn tolerance(bench: &Bench, trip: &Pick) -> f64 {
    let speeds = 1.0
        + bench.station.belt().speed
        + bench.station.robots()[trip.robot]
            .arm
            .constant_speed()
            .unwrap();
    slack(trip.release) * speeds
}

/// Checks the bench's run with one number of it off by 97 % and by 103 % of `limit`.
fn assert_limit(name: &str, bench: &Bench, limit: f64, words: &str, bend: impl Fn(f64) -> Draft) {
    let checked = |share: f64| {
        let outcome = bench.finish(bend(share * limit));
        check(&bench.station, &bench.pattern, &outcome)
    };
    assert_between(name, checked, words);
}

fn assert_between(name: &str, checked: impl Fn(f64) -> Result<()>, words: &str) {
    checked(0.97).unwrap_or_else(|error| panic!("{name}: {error}"));
    let message = checked(1.03).expect_err(name).to_string();
    assert!(message.contains(words), "{name}: {message}");
}

#[test]
fn ways_and_meeting_points_may_be_off_by_rounding_alone() {
    let bench = Bench::new();
    let run = bench.run();
    let plain = run.picks[0];
    let places = tolerance(&bench, &plain);
    let with = |pick: Pick| {
        let mut draft = run.clone();
        draft.picks[0] = pick;
        draft
    };
    for sign in [-1.0, 1.0] {
        // The arm moves 0.9 m/s and goes 0.3 m.
        let limit = sign * (places + slack(0.3)) / 0.9;
        assert_limit("way", &bench, limit, "does not take", |off| {
            with(Pick {
                decide: plain.decide + off,
                ..plain
            })
        });
        let limit = sign * (places + slack(plain.release));
        assert_limit("back", &bench, limit, "it returns at", |off| {
            with(Pick {
                release: plain.release + off,
                ..plain
            })
        });
        let limit = sign * (places + slack(1.5));
        assert_limit("along", &bench, limit, "while the item is at", |off| {
            with(bench.trip(0, 0, Point2::new(1.5 + off, -0.2), 5.0))
        });
        let limit = sign * (places + slack(0.2));
        assert_limit("across", &bench, limit, "while the item is at", |off| {
            with(bench.trip(0, 0, Point2::new(1.5, -0.2 + off), 5.0))
        });
    }
}

/// On a line through the base a distance changes by as much as the place.
#[test]
fn the_reach_and_the_belts_ends_may_be_passed_by_rounding_alone() {
    let robot = |x: f64| {
        Robot {
            base: Point2::new(x, -0.2),
            ..front()
        }
        .with_only_bin(Point2::new(x, -0.5))
    };
    for (name, base, x, sign, words) in [
        ("reach", 1.5, 2.4, 1.0, "beyond its reach"),
        ("reach", 1.5, 0.6, -1.0, "beyond its reach"),
        ("start", 0.5, 0.0, -1.0, "is off the belt"),
        ("end", 2.5, 3.0, 1.0, "is off the belt"),
    ] {
        let bench = Bench::of(BELT, vec![robot(base)], &[(-3.0, -0.2)]);
        let limit = sign * tolerance(&bench, &bench.pick(0, 0, x));
        assert_limit(name, &bench, limit, words, |off| {
            let mut draft = idle(&[]);
            draft.picks.push(bench.pick(0, 0, x + off));
            draft
        });
        // From the other side: what can be met by no more than rounding was not met.
        let words = "it found nothing";
        let goes = Point2::new(base, 0.0);
        let way = bench.vain_way(0, 0, x, goes).attempt;
        let limit = -sign * tolerance(&bench, &way);
        assert_limit("vain", &bench, limit, words, |off| {
            let mut draft = idle(&[MissReason::GraspFailed]);
            draft.failures.push(bench.vain_way(0, 0, x + off, goes));
            draft
        });
    }
}

/// Claims and busy times: exactly to the last digit.
#[test]
fn claims_and_busy_times_may_be_missed_by_rounding_alone() {
    let bench = Bench::new();
    let run = bench.run();
    // Leaving at this time for it is the earliest that is confirmed.
    let earliest = |from: f64| {
        let mut time = from;
        for _ in 0..10 {
            time = from - slack(time);
        }
        assert_eq!(time, from - slack(time));
        time
    };
    let ends = run.failures[1].claim_ends(0.2);
    let claimed = |decide: f64| {
        let mut draft = run.clone();
        draft.failures[2].attempt = bench.leave(1, 5, decide);
        check(&bench.station, &bench.pattern, &bench.finish(draft))
    };
    let free = run.picks[0].release;
    let busy = |decide: f64| {
        let mut draft = run.clone();
        // Item 1 instead of item 2, as soon as it is free.
        draft.picks[1] = bench.leave(0, 1, decide);
        check(&bench.station, &bench.pattern, &bench.finish(draft))
    };
    type Leaving<'a> = &'a dyn Fn(f64) -> Result<()>;
    let late: [(f64, Leaving, &str); 2] = [
        (ends, &claimed, "already claimed by robot `front`"),
        (free, &busy, "the robot is busy until"),
    ];
    for (from, checked, words) in late {
        checked(earliest(from)).unwrap();
        let message = checked(earliest(from).next_down()).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

/// The last number that is confirmed, and the next one that a float can hold.
#[test]
fn places_at_the_very_limit_are_confirmed() {
    // Bin, base and item are at one place when the run begins.
    let robot = Robot {
        base: Point2::new(0.0, 0.0),
        arm: pickline::kinematics::Arm::constant(2.0),
        ..front()
    }
    .with_only_bin(Point2::new(0.0, 0.0));
    let bench = Bench::of(BELT, vec![robot], &[(0.0, 0.0)]);
    let at_once = bench.pick(0, 0, 0.0);
    assert_eq!((at_once.decide, at_once.grasp), (0.0, 0.0));
    let places = tolerance(&bench, &at_once);
    let met_at = |x: f64, y: f64| {
        let meet = Point2::new(x, y);
        let mut draft = idle(&[]);
        draft.picks.push(Pick { meet, ..at_once });
        check(&bench.station, &bench.pattern, &bench.finish(draft))
    };
    let start = -places;
    met_at(start, 0.0).unwrap();
    let message = met_at(start.next_down(), 0.0).unwrap_err().to_string();
    assert!(message.contains("is off the belt"), "{message}");
    let beside = -(places + slack(0.0));
    met_at(0.0, beside).unwrap();
    let message = met_at(0.0, beside.next_down()).unwrap_err().to_string();
    assert!(message.contains("while the item is at"), "{message}");
}

#[test]
fn the_smallest_reach_and_belt_are_confirmed() {
    let robot = Robot {
        base: Point2::new(1.5, -0.2),
        ..front()
    };
    let bench = Bench::of(BELT, vec![robot], &[(-3.0, -0.2)]);
    let pick = bench.pick(0, 0, 2.25);
    let places = tolerance(&bench, &pick);
    let mut draft = idle(&[]);
    draft.picks.push(pick);
    let outcome = bench.finish(draft);
    let least = |of: f64| {
        let near = of - places;
        let all = [near.next_down(), near, near.next_up()];
        all.into_iter().find(|least| least + places == of).unwrap()
    };
    let with = |reach: f64, length: f64| {
        let belt = Belt { length, ..BELT };
        let robots = bench.station.with_reach(reach).unwrap().robots().to_vec();
        let station = Station::new(belt, robots).unwrap();
        check(&station, &bench.pattern, &outcome)
    };
    let (reach, length) = (least(0.75), least(2.25));
    with(reach, length).unwrap();
    let message = with(reach.next_down(), length).unwrap_err().to_string();
    assert!(message.contains("beyond its reach"), "{message}");
    let message = with(reach, length.next_down()).unwrap_err().to_string();
    assert!(message.contains("is off the belt"), "{message}");
}

#[test]
fn figures_may_be_off_by_rounding_alone() {
    let bench = Bench::new();
    let outcome = bench.finish(bench.run());
    type Number = fn(&mut Outcome) -> &mut f64;
    let numbers: [(Number, &str); 4] = [
        (|o| &mut o.figures.weight, "weight is reported as"),
        (|o| &mut o.figures.end, "end is reported as"),
        (
            |o| &mut o.robots[1].weight,
            "weight of robot 1 is reported as",
        ),
        (
            |o| &mut o.robots[0].busy,
            "busy time of robot 0 is reported as",
        ),
    ];
    for (number, words) in numbers {
        for sign in [-1.0, 1.0] {
            let checked = |share: f64| {
                let mut bent = outcome.clone();
                let value = number(&mut bent);
                *value += sign * share * slack(*value);
                check(&bench.station, &bench.pattern, &bent)
            };
            assert_between(words, checked, words);
        }
    }
}

/// Where nothing is to be picked the slack is 1e-9 itself.
#[test]
fn the_slack_of_nothing_is_exact() {
    let bench = Bench::new();
    let outcome = bench.finish(idle(&[MissReason::Busy; 7]));
    let with = |weight: f64| {
        let mut bent = outcome.clone();
        bent.figures.weight = weight;
        check(&bench.station, &bench.pattern, &bent)
    };
    with(1e-9).unwrap();
    let message = with(1e-9f64.next_up()).unwrap_err().to_string();
    assert!(message.contains("weight is reported as"), "{message}");
}
