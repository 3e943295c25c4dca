//! The model of real lines (`docs/real-lines.md`) written down as plainly as possible, and random
//! stations with all of it.
#![allow(dead_code)]

use nalgebra::Point2;
use pickline::kinematics::{Arm, TravelLaw};
use pickline::pattern::{Item, Pattern};
use pickline::station::{Belt, Bin, ItemClass, Robot, Station};
use proptest::prelude::*;

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

/// A pattern on a station.
pub struct Book<'a> {
    pub station: &'a Station,
    pub items: &'a [Item],
}

impl Book<'_> {
    pub fn wanted(&self, item: &Item) -> bool {
        let stated = self.station.classes().iter();
        let unwanted = stated
            .filter(|class| !class.wanted)
            .any(|class| Some(&class.name) == item.class.as_ref());
        let mut robots = self.station.robots().iter();
        !unwanted && robots.any(|robot| self.bin(robot, item).is_some())
    }

    pub fn bin(&self, robot: &Robot, item: &Item) -> Option<usize> {
        for (i, bin) in robot.bins.iter().enumerate() {
            for class in bin.classes.iter().flatten() {
                if item.class.as_ref() == Some(class) {
                    return Some(i);
                }
            }
        }
        robot.bins.iter().position(|bin| bin.classes.is_none())
    }

    pub fn weight(&self, item: &Item) -> f64 {
        let stated = self.station.classes().iter();
        let class = stated.filter(|class| Some(&class.name) == item.class.as_ref());
        let value = class.map(|class| class.value).next().unwrap_or(1.0);
        item.weight.unwrap_or(value * item.reward())
    }

    /// D_o(X).
    pub fn departure(&self, robot: &Robot, from: Point2<f64>, item: &Item, x: f64) -> f64 {
        (x - item.x0) / self.station.belt().speed - move_time(robot, Point2::new(x, item.y), from)
    }

    pub fn range(&self, robot: &Robot, item: &Item) -> Option<(f64, f64)> {
        let square = robot.reach.powi(2) - (item.y - robot.base.y).powi(2);
        if square < 0.0 {
            return None;
        }
        let first = (robot.base.x - square.sqrt()).max(0.0);
        let last = (robot.base.x + square.sqrt()).min(self.station.belt().length);
        (first <= last).then_some((first, last))
    }

    pub fn window(&self, robot: &Robot, from: Point2<f64>, item: &Item) -> Option<(f64, f64)> {
        self.bin(robot, item)?;
        let (first, last) = self.range(robot, item)?;
        let close = self.departure(robot, from, item, last);
        let open = self.departure(robot, from, item, first).max(0.0);
        (close >= 0.0).then_some((open.min(close), close))
    }

    /// Meeting point, grasp and release of a departure at `t`.
    pub fn pick(&self, robot: &Robot, from: Point2<f64>, item: &Item, t: f64) -> (f64, f64, f64) {
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
        (
            meet,
            grasp,
            grasp + robot.grasp_time + back + bin.release_time,
        )
    }

    pub fn key(&self, rule: &str, robot: &Robot, from: Point2<f64>, item: &Item, t: f64) -> f64 {
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
        let robots = robots.into_iter().enumerate().map(|(i, robot)| {
            let (
                (gap, off, far_side, reach),
                (kind, faster, stronger, unlike),
                lift,
                pieces,
                (grasp_time, first_time),
                bins,
                sorted,
                (rests, rest),
            ) = robot;
            x += gap;
            let side = |far: bool| if far { 1.0 } else { -1.0 };
            let at = |(dx, dy, far): (f64, f64, bool)| {
                Point2::new(x + dx, side(far) * (0.5 * width + dy))
            };
            let count = bins.len();
            let classes_of = |bin: usize| {
                let own = CLASSES
                    .iter()
                    .zip(&sorted)
                    .filter(|(_, to)| **to % count == bin);
                let own: Vec<String> = own.map(|(class, _)| (*class).to_owned()).collect();
                own
            };
            // The bin with number 4 stands for: this class goes where the others go.
            let open = sorted
                .iter()
                .position(|to| *to == 4)
                .map(|class| class % count);
            let bins: Vec<Bin> = bins
                .into_iter()
                .enumerate()
                .map(|(bin, (place, release_time))| Bin {
                    name: format!("bin {bin}"),
                    at: at(place),
                    classes: Some(classes_of(bin)).filter(|_| open != Some(bin)),
                    release_time,
                })
                .filter(|bin| {
                    bin.classes
                        .as_ref()
                        .is_none_or(|classes| !classes.is_empty())
                })
                .collect();
            let rest = match rests {
                true => at(rest),
                false => bins.first().map_or(at(rest), |bin| bin.at),
            };
            // Fast enough on the shortest path, which is at least as long as this.
            let places = bins.iter().map(|bin| bin.at).chain([rest]);
            let nearest = places
                .map(|p| p.y.abs() - 0.5 * width)
                .fold(f64::INFINITY, f64::min);
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
        });
        robots.collect()
    })
}

/// Stations with all laws, overlapping windows or robots far apart, bins by class, and classes that
/// are unwanted or worth more.
pub fn stations() -> impl Strategy<Value = Station> {
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

pub fn patterns(width: f64, most: usize) -> impl Strategy<Value = Pattern> {
    let item = (
        -4.0..0.0f64,
        -0.5..0.5f64,
        0..6usize,
        prop::option::of(0.0..2.0f64),
    );
    prop::collection::vec(item, 1..=most).prop_map(move |items| {
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
