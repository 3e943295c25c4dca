//! The model of real lines (`docs/real-lines.md`) written down a third time, as plainly as possible:
//! every decision looks at every robot and every item, and every root is found by bisection. Both
//! engines follow it pick by pick.
//!
//! Keys and times that are found by different means differ in the last bits. The transcription
//! therefore follows the picks of a run: each must come at its time and be one of the best, up to
//! rounding, and no decision may be missing.

use nalgebra::Point2;
use pickline::checker;
use pickline::decision::Pick;
use pickline::dispatch::RuleAssignment;
use pickline::kinematics::{Arm, TravelLaw};
use pickline::pattern::{Item, Pattern};
use pickline::sim::{Cascade, Scene, simulate_rules};
use pickline::station::{Belt, Bin, ItemClass, Robot, Station};
use proptest::prelude::*;

/// Differences of times [s] and keys that are due to rounding.
const ROUNDING: f64 = 1e-9;

/// T(|p - q| + 2 h).
fn move_time(robot: &Robot, p: Point2<f64>, q: Point2<f64>) -> f64 {
    let l = ((p.x - q.x).powi(2) + (p.y - q.y).powi(2)).sqrt() + 2.0 * robot.arm.lift;
    match &robot.arm.law {
        TravelLaw::Constant { speed } => l / speed,
        TravelLaw::Trapezoid {
            speed: u,
            acceleration: a,
            deceleration: b,
        } => {
            let c = 1.0 / a + 1.0 / b;
            match l <= u * u * c / 2.0 {
                true => (2.0 * l * c).sqrt(),
                false => l / u + u * c / 2.0,
            }
        }
        TravelLaw::Table(points) => {
            let mut piece = [points[0], points[1]];
            for pair in points.windows(2) {
                if l >= pair[0].0 {
                    piece = [pair[0], pair[1]];
                }
            }
            let [(l0, t0), (l1, t1)] = piece;
            t0 + (l - l0) / (l1 - l0) * (t1 - t0)
        }
    }
}

struct Book<'a> {
    station: &'a Station,
    items: &'a [Item],
}

impl Book<'_> {
    fn wanted(&self, item: &Item) -> bool {
        let stated = self.station.classes().iter();
        let unwanted = stated
            .filter(|class| !class.wanted)
            .any(|class| Some(&class.name) == item.class.as_ref());
        let mut robots = self.station.robots().iter();
        !unwanted && robots.any(|robot| self.bin(robot, item).is_some())
    }

    fn bin(&self, robot: &Robot, item: &Item) -> Option<usize> {
        for (i, bin) in robot.bins.iter().enumerate() {
            for class in bin.classes.iter().flatten() {
                if item.class.as_ref() == Some(class) {
                    return Some(i);
                }
            }
        }
        robot.bins.iter().position(|bin| bin.classes.is_none())
    }

    fn weight(&self, item: &Item) -> f64 {
        let stated = self.station.classes().iter();
        let class = stated.filter(|class| Some(&class.name) == item.class.as_ref());
        let value = class.map(|class| class.value).next().unwrap_or(1.0);
        item.weight.unwrap_or(value * item.reward())
    }

    /// D_o(X).
    fn departure(&self, robot: &Robot, from: Point2<f64>, item: &Item, x: f64) -> f64 {
        (x - item.x0) / self.station.belt().speed - move_time(robot, Point2::new(x, item.y), from)
    }

    fn range(&self, robot: &Robot, item: &Item) -> Option<(f64, f64)> {
        let square = robot.reach.powi(2) - (item.y - robot.base.y).powi(2);
        if square < 0.0 {
            return None;
        }
        let first = (robot.base.x - square.sqrt()).max(0.0);
        let last = (robot.base.x + square.sqrt()).min(self.station.belt().length);
        (first <= last).then_some((first, last))
    }

    fn window(&self, robot: &Robot, from: Point2<f64>, item: &Item) -> Option<(f64, f64)> {
        self.bin(robot, item)?;
        let (first, last) = self.range(robot, item)?;
        let close = self.departure(robot, from, item, last);
        let open = self.departure(robot, from, item, first).max(0.0);
        (close >= 0.0).then_some((open.min(close), close))
    }

    /// Meeting point, grasp and release of a departure at `t`.
    fn pick(&self, robot: &Robot, from: Point2<f64>, item: &Item, t: f64) -> (f64, f64, f64) {
        let (mut low, mut high) = self.range(robot, item).unwrap();
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            match self.departure(robot, from, item, middle) < t {
                true => low = middle,
                false => high = middle,
            }
        }
        let meet = 0.5 * (low + high);
        let grasp = (meet - item.x0) / self.station.belt().speed;
        let bin = &robot.bins[self.bin(robot, item).unwrap()];
        let back = move_time(robot, Point2::new(meet, item.y), bin.at);
        (meet, grasp, grasp + robot.grasp_time + back + bin.release_time)
    }

    fn key(&self, rule: &str, robot: &Robot, from: Point2<f64>, item: &Item, t: f64) -> f64 {
        let x = item.x0 + self.station.belt().speed * t;
        let distance = ((x - robot.base.x).powi(2) + (item.y - robot.base.y).powi(2)).sqrt();
        let processing = || self.pick(robot, from, item, t).2 - t;
        match rule {
            "FIFO" => -x,
            "SPT" => processing(),
            "LPT" => -processing(),
            "SD" => distance,
            "LD" => -distance,
            "PP" => -self.weight(item),
            other => panic!("no rule {other}"),
        }
    }

    /// Follows `picks`, those of a run in which the robots follow `rules`.
    fn follow(&self, rules: &[&str], picks: &[Pick], hz: f64) -> Result<(), TestCaseError> {
        let tick = |t: f64| {
            let ticks = t * hz;
            match hz == 0.0 || (ticks - ticks.round()).abs() <= 1e-7 {
                true => t,
                false => ticks.ceil() / hz,
            }
        };
        let robots = self.station.robots();
        let mut free = vec![0.0; robots.len()];
        let mut place: Vec<Point2<f64>> = robots.iter().map(|robot| robot.rest).collect();
        let mut gone: Vec<bool> = self.items.iter().map(|item| !self.wanted(item)).collect();
        let mut picks = picks.iter();
        loop {
            // The earliest decision, and what each robot could take at its own.
            let mut next: Option<(f64, usize)> = None;
            for (i, robot) in robots.iter().enumerate() {
                let windows = || {
                    let left = self.items.iter().zip(&gone).filter(|(_, gone)| !**gone);
                    left.filter_map(|(item, _)| self.window(robot, place[i], item))
                };
                let mut from: f64 = free[i];
                let decision = loop {
                    let opens = windows().filter(|w| w.1 >= from).map(|w| w.0.max(from));
                    let Some(exact) = opens.reduce(f64::min) else {
                        break None;
                    };
                    let time = tick(exact);
                    if windows().any(|w| w.0 <= time && time <= w.1) {
                        break Some(time);
                    }
                    from = time.max(exact.next_up());
                };
                if let Some(time) = decision
                    && next.is_none_or(|(earliest, _)| time < earliest - ROUNDING)
                {
                    next = Some((time, i));
                }
            }
            let (Some((time, i)), Some(pick)) = (next, picks.clone().next()) else {
                prop_assert_eq!(next.is_some(), picks.len() > 0, "one of them ends early");
                return Ok(());
            };
            picks.next();
            // Two decisions at the same time, up to rounding, may come in either order.
            prop_assert!((pick.decide - time).abs() < ROUNDING * (1.0 + time), "{pick:?} {time}");
            let (i, time) = (if pick.robot == i { i } else { pick.robot }, pick.decide);
            let (robot, from) = (&robots[i], place[i]);
            let slack = ROUNDING * (1.0 + time);
            let can = |j: &usize| {
                let window = self.window(robot, from, &self.items[*j]);
                !gone[*j] && window.is_some_and(|w| w.0 <= time + slack && time - slack <= w.1)
            };
            let can: Vec<usize> = (0..self.items.len()).filter(can).collect();
            let chosen = pick.item as usize;
            prop_assert!(can.contains(&chosen), "{pick:?} is not possible");
            let key = |j: usize| self.key(rules[i], robot, from, &self.items[j], time);
            // One that is possible only up to rounding need not have been seen.
            let sure = |j: &&usize| {
                let window = self.window(robot, from, &self.items[**j]);
                window.is_some_and(|w| w.0 <= time - slack && time + slack <= w.1)
            };
            let best = can.iter().filter(sure).map(|j| key(*j)).fold(key(chosen), f64::min);
            prop_assert!(
                key(chosen) - best <= ROUNDING * (1.0 + best.abs()),
                "{pick:?} has key {}, another one {best}", key(chosen)
            );
            let (meet, grasp, release) = self.pick(robot, from, &self.items[chosen], time);
            prop_assert!((pick.meet.x - meet).abs() < 1e-7, "{pick:?} {meet}");
            prop_assert!((pick.grasp - grasp).abs() < slack, "{pick:?} {grasp}");
            prop_assert!((pick.release - release).abs() < slack, "{pick:?} {release}");
            let bin = self.bin(robot, &self.items[chosen]).unwrap();
            prop_assert_eq!(usize::from(pick.bin), bin);
            place[i] = robot.bins[bin].at;
            free[i] = pick.release;
            gone[chosen] = true;
        }
    }
}

const CLASSES: [&str; 4] = ["a", "b", "c", "d"];

/// What makes a robot beside a belt of the given speed and width.
fn robots(speed: f64, width: f64, apart: f64) -> impl Strategy<Value = Vec<Robot>> {
    let place = (-0.8..0.8f64, 0.01..0.4f64, any::<bool>());
    let robot = (
        (0.0..apart, -0.2..0.5f64, any::<bool>(), 0.3..1.4f64),
        (0..3u8, 1.2..12.0f64, 1.1..40.0f64, 0.3..3.0f64),
        prop_oneof![Just(0.0), 0.0..0.08f64],
        prop::collection::vec((0.02..0.4f64, 0.0..0.95f64), 1..5),
        (prop_oneof![Just(0.0), 0.0..0.6f64], 0.0..0.4f64),
        prop::collection::vec((place.clone(), 0.0..0.4f64), 1..=4),
        prop::collection::vec(0..5usize, 4),
        (any::<bool>(), place),
    );
    prop::collection::vec(robot, 1..=6).prop_map(move |robots| {
        let mut x = 0.4;
        let make = |(i, robot)| {
            let (
                (gap, off, far_side, reach),
                (kind, faster, stronger, unlike),
                lift,
                pieces,
                (grasp_time, first_time),
                bins,
                sorted,
                (rests, rest),
            ): (_, (u8, f64, f64, f64), f64, Vec<(f64, f64)>, _, Vec<_>, Vec<usize>, _) = robot;
            x += gap;
            let side = |far: bool| if far { 1.0 } else { -1.0 };
            let at = |(dx, dy, far): (f64, f64, bool)| {
                Point2::new(x + dx, side(far) * (0.5 * width + dy))
            };
            let count = bins.len();
            let classes_of = |bin: usize| {
                let own = CLASSES.iter().zip(&sorted).filter(|(_, to)| **to % count == bin);
                let own: Vec<String> = own.map(|(class, _)| (*class).to_owned()).collect();
                own
            };
            // The bin with number 4 stands for: this class goes where the others go.
            let open = sorted.iter().position(|to| *to == 4).map(|class| class % count);
            let bins: Vec<Bin> = bins
                .into_iter()
                .enumerate()
                .map(|(bin, (place, release_time))| Bin {
                    name: format!("bin {bin}"),
                    at: at(place),
                    classes: Some(classes_of(bin)).filter(|_| open != Some(bin)),
                    release_time,
                })
                .filter(|bin| bin.classes.as_ref().is_none_or(|classes| !classes.is_empty()))
                .collect();
            let rest = match rests {
                true => at(rest),
                false => bins.first().map_or(at(rest), |bin| bin.at),
            };
            // Fast enough on the shortest path, which is at least as long as this.
            let places = bins.iter().map(|bin| bin.at).chain([rest]);
            let nearest = places.map(|p| p.y.abs() - 0.5 * width).fold(f64::INFINITY, f64::min);
            let shortest = nearest + 2.0 * lift;
            let least = speed * speed / shortest;
            let law = match kind {
                0 => TravelLaw::Constant {
                    speed: speed * faster,
                },
                1 => TravelLaw::Trapezoid {
                    speed: speed * faster,
                    acceleration: least * stronger * (0.5 + 0.5 * unlike),
                    deceleration: least * stronger * (0.5 + 0.5 / unlike),
                },
                _ => {
                    let mut points = vec![(0.0, first_time)];
                    for (length, share) in pieces {
                        let (l, t) = *points.last().unwrap();
                        points.push((l + length, t + length * share / speed));
                    }
                    TravelLaw::Table(points)
                }
            };
            Robot {
                name: format!("r{i}"),
                base: Point2::new(x, side(far_side) * (0.5 * width + off)),
                reach,
                arm: Arm { law, lift },
                grasp_time,
                rest,
                bins,
            }
        };
        robots.into_iter().enumerate().map(make).collect()
    })
}

/// Stations with all laws, overlapping windows or robots far apart, bins by class, and classes that
/// are unwanted or worth more.
fn stations() -> impl Strategy<Value = Station> {
    let belt = (0.05..0.8f64, 1.0..8.0f64, 0.2..1.2f64);
    let class = (0..4usize, 0.0..3.0f64, prop::bool::weighted(0.7));
    let classes = prop::collection::vec(class, 0..4);
    (belt, classes, prop_oneof![Just(0.6), Just(6.0)]).prop_flat_map(
        |((speed, length, width), classes, apart)| {
            let belt = Belt {
                speed,
                length: length + apart,
                width,
            };
            robots(speed, width, apart).prop_filter_map("not a station", move |robots| {
                let mut stated: Vec<ItemClass> = Vec::new();
                for (class, value, wanted) in &classes {
                    if stated.iter().all(|other| other.name != CLASSES[*class]) {
                        stated.push(ItemClass {
                            value: *value,
                            wanted: *wanted,
                            ..ItemClass::new(CLASSES[*class])
                        });
                    }
                }
                Station::new(belt, robots).ok()?.with_classes(stated).ok()
            })
        },
    )
}

fn patterns(width: f64) -> impl Strategy<Value = Pattern> {
    let item = (-4.0..0.0f64, -0.5..0.5f64, 0..6usize, prop::option::of(0.0..2.0f64));
    prop::collection::vec(item, 1..=30).prop_map(move |items| {
        let item = |(i, (x0, y, class, weight)): (usize, (f64, f64, usize, Option<f64>))| Item {
            class: match class {
                4 => None,
                5 => Some("other".into()),
                class => Some(CLASSES[class].into()),
            },
            weight,
            ..Item::at(i.to_string(), x0, y * width)
        };
        Pattern::new(items.into_iter().enumerate().map(item).collect()).unwrap()
    })
}

fn cases() -> impl Strategy<Value = (Station, Pattern, RuleAssignment)> {
    stations().prop_flat_map(|station| {
        let rules = vec!["FIFO", "SPT", "LPT", "SD", "LD", "PP"];
        let count = station.robots().len();
        let rules = prop::collection::vec(prop::sample::select(rules), count);
        let rules = rules.prop_map(|rules| rules.join(",").parse().unwrap());
        let width = station.belt().width;
        (Just(station), patterns(width), rules)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn both_engines_follow_the_page(
        (station, pattern, rules) in cases(),
        hz in prop_oneof![3 => Just(0.0), 1 => 0.5..20.0f64],
    ) {
        let scene = Scene::new(&station, &pattern).unwrap().with_update_hz(hz).unwrap();
        let outcome = simulate_rules(&scene, &rules).unwrap();
        checker::check(&station, &pattern, &outcome).map_err(|e| TestCaseError::fail(e.to_string()))?;
        let book = Book { station: &station, items: pattern.items() };
        book.follow(&rules.names(), &outcome.picks, hz)?;
        let offered = pattern.items().iter().filter(|item| book.wanted(item)).count();
        prop_assert_eq!(outcome.figures.items, offered);
        prop_assert_eq!(outcome.left.len(), pattern.len() - offered);
        if let Some(mut cascade) = Cascade::new(&scene) {
            let mut picks = Vec::new();
            let figures = cascade.run_observed(rules.rules(), |pick| picks.push(pick));
            picks.sort_by(|a, b| a.decide.total_cmp(&b.decide).then(a.robot.cmp(&b.robot)));
            prop_assert_eq!(figures, outcome.figures);
            prop_assert_eq!(picks, outcome.picks);
        }
    }
}
