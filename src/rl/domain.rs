//! The training domain: randomly drawn stations and patterns, from sparse to dense.
//!
//! Tobin et al., "Domain randomization for transferring deep neural networks from
//! simulation to the real world", arXiv 1703.06907; Bengio et al., "Curriculum learning",
//! ICML 2009 (DOI 10.1145/1553374.1553380).

use super::environment::is_playable;
use crate::error::{Error, Result, shown};
use crate::pattern::{ClassShares, Pattern, PatternSource, grid, poisson_disk, random_stream};
use crate::setters::setters;
use crate::sim::{Conditions, Disturbances, RunBuffers, Scene};
use crate::station::Station;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// An interval, both ends included.
pub type ClosedInterval = (f64, f64);

/// How patterns and belt speeds are drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Domain {
    /// Spacing of grids and radius of Poisson disk patterns [m]. Drawn as the square of a
    /// uniform number, so that dense patterns, on which decisions matter, are more frequent.
    pub spacing: ClosedInterval,
    /// Smallest and largest number of items in a pattern.
    pub items: (usize, usize),
    /// Share of grids among the patterns.
    pub grids: f64,
    /// Belt speed as a multiple of the station's.
    pub speed: ClosedInterval,
    /// Share of the training after which the densest patterns are included. Until then, the
    /// smallest spacing falls from the upper to the lower end.
    pub curriculum: f64,
    /// Share of the patterns on which attempts may fail.
    #[serde(default)]
    pub failing: f64,
    /// The probability that a grasp succeeds on these. On half of them it is the same for all items; on
    /// the others each item has its own, and detections are wrong with probabilities from the same
    /// interval.
    #[serde(default = "sure")]
    pub grasp_success: ClosedInterval,
    /// If above 0, decisions are made only at multiples of 1 / this [s]: 10 Hz in the paper. 0
    /// is exact.
    #[serde(default)]
    pub update_hz: f64,
    /// A source such as `balanced` or `poisson:0.12:100`: patterns are those of this set, in turn,
    /// instead of drawn from `spacing` and `grids`. Every station has the set of its own belt under the
    /// training's seed.
    #[serde(default)]
    pub patterns: Option<String>,
}

fn sure() -> ClosedInterval {
    (1.0, 1.0)
}

setters!(Domain {
    /// With grid spacings and Poisson disk radii from this interval [m].
    fn with_spacing(spacing: ClosedInterval);
    /// With numbers of items from this interval.
    fn with_items(items: (usize, usize));
    /// With this share of grids among the patterns.
    fn with_grids(grids: f64);
    /// With belt speeds from this interval, as multiples of the station's.
    fn with_speed(speed: ClosedInterval);
    /// With the densest patterns only after this share of the training.
    fn with_curriculum(curriculum: f64);
    /// With this share of patterns on which attempts may fail.
    fn with_failing(failing: f64);
    /// With probabilities of a grasp's success from this interval.
    fn with_grasp_success(grasp_success: ClosedInterval);
    /// With decisions only at multiples of `1 / update_hz` seconds; 0 for any time [Hz].
    fn with_update_hz(update_hz: f64);
    /// With the patterns of the set that this source generates, or drawn ones.
    fn with_patterns(patterns: impl Into<Option<String>>);
});

impl Domain {
    /// The domain of the built-in presets.
    pub const BROAD: Self = Self {
        spacing: (0.1, 0.4),
        items: (25, 150),
        grids: 0.4,
        speed: (0.8, 1.25),
        curriculum: 0.1,
        failing: 0.0,
        grasp_success: (1.0, 1.0),
        update_hz: 0.0,
        patterns: None,
    };

    /// The source of the patterns if they are those of a set.
    ///
    /// # Errors
    /// An unknown form, or a source that reads a file.
    pub(super) fn source(&self) -> Result<Option<PatternSource>> {
        let Some(text) = &self.patterns else {
            return Ok(None);
        };
        let place = "the training plan: domain.patterns";
        let source: PatternSource = text.parse().map_err(|error: Error| error.inside(place))?;
        let feed = source.feed().and_then(|feed| feed.file());
        if feed.is_some() || source.is_recorded() {
            return Err(Error::usage(
                place,
                format!(
                    "`{}` is read from files, which a record and a checkpoint do not contain",
                    shown(text)
                ),
                "give a set that follows from the seed, such as balanced or poisson:0.12:100",
            ));
        }
        Ok(Some(source))
    }
}

/// A pattern and the line for it.
#[derive(Debug, Clone)]
pub struct Course {
    /// The station on which the pattern is picked.
    pub station: Station,
    /// The items that arrive.
    pub pattern: Pattern,
    /// What can go wrong.
    pub disturbances: Disturbances,
}

impl Course {
    /// The course, prepared for simulation.
    ///
    /// # Errors
    /// A pattern that does not fit on the belt.
    pub fn scene(&self) -> Result<Scene<'_>> {
        let conditions = Conditions::default().with_disturbances(self.disturbances);
        Scene::under(&self.station, &self.pattern, conditions)
    }
}

/// The scenes of all courses.
///
/// # Errors
/// A pattern that does not fit on the belt.
pub fn scenes(courses: &[Course]) -> Result<Vec<Scene<'_>>> {
    courses.par_iter().map(Course::scene).collect()
}

impl Domain {
    /// The scenes of drawn courses, with the domain's update frequency, but for those on which there is
    /// nothing to decide.
    ///
    /// # Errors
    /// A pattern that does not fit on the belt, or an invalid update frequency.
    pub fn scenes<'a>(&self, courses: &'a [Course]) -> Result<Vec<Scene<'a>>> {
        let made = scenes(courses)?.into_iter();
        let made = made.map(|scene| scene.with_update_hz(self.update_hz));
        let mut made: Vec<Scene> = made.collect::<Result<_>>()?;
        let mut buffers = RunBuffers::default();
        made.retain(|scene| is_playable(scene, &mut buffers));
        Ok(made)
    }

    /// Draws `count` courses on `stations` in turn, each with its own random numbers.
    /// `progress` is the completed share of the training, from 0 to 1.
    ///
    /// # Errors
    /// Spacings, counts or speeds that give no valid pattern or station.
    pub fn draw(
        &self,
        stations: &[Station],
        count: usize,
        progress: f64,
        seed: u64,
    ) -> Result<Vec<Course>> {
        let draw = |index: usize| {
            let mut rng = random_stream(seed, index as u64);
            self.course(&stations[index % stations.len()], progress, &mut rng)
        };
        (0..count).into_par_iter().map(draw).collect()
    }

    fn course(&self, station: &Station, progress: f64, rng: &mut ChaCha8Rng) -> Result<Course> {
        let mut within = |(low, high): ClosedInterval, power: i32| {
            low + (high - low) * rng.random::<f64>().powi(power)
        };
        let (least, most) = self.spacing;
        let open = if self.curriculum > 0.0 {
            (progress / self.curriculum).min(1.0)
        } else {
            1.0
        };
        let spacing = within((most + (least - most) * open, most), 2);
        let factor = within(self.speed, 1);
        let items = within((self.items.0 as f64, self.items.1 as f64 + 1.0), 1);
        let items = (items as usize).min(self.items.1);
        let width = station.belt().width;
        let pattern = if rng.random::<f64>() < self.grids {
            grid(width, spacing, items)?
        } else {
            poisson_disk(width, spacing, items, rng)?
        };
        self.course_of(pattern, station, factor, rng)
    }

    /// The course with this pattern on a station with a belt speed that is drawn.
    pub(super) fn course_with(
        &self,
        pattern: Pattern,
        station: &Station,
        rng: &mut ChaCha8Rng,
    ) -> Result<Course> {
        let (low, high) = self.speed;
        let factor = low + (high - low) * rng.random::<f64>();
        self.course_of(pattern, station, factor, rng)
    }

    /// The course with this pattern on a station with its belt speed times `factor`.
    fn course_of(
        &self,
        pattern: Pattern,
        station: &Station,
        factor: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Course> {
        let station = station.with_belt_speed(station.belt().speed * factor)?;
        let pattern = with_classes(&pattern, &station, rng)?.unwrap_or(pattern);
        let (pattern, disturbances) = self.with_failures(pattern, rng)?;
        Ok(Course {
            station,
            pattern,
            disturbances,
        })
    }

    /// Lets attempts fail on some of the patterns.
    fn with_failures(
        &self,
        pattern: Pattern,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Pattern, Disturbances)> {
        let sure = Disturbances::default();
        if self.failing == 0.0 || rng.random::<f64>() >= self.failing {
            return Ok((pattern, sure));
        }
        let (low, high) = self.grasp_success;
        let mut success = || low + (high - low) * rng.random::<f64>();
        let common = success();
        let failing = sure
            .with_grasp_failures(true)
            .with_default_p_grasp(common)
            .with_seed(rng.random());
        if rng.random::<bool>() {
            return Ok((pattern, failing));
        }
        let mut success = || Some(low + (high - low) * rng.random::<f64>());
        let mut items = pattern.items().to_vec();
        for item in &mut items {
            item.p_grasp = success();
            item.p_detection = success();
        }
        Ok((Pattern::new(items)?, failing.with_misdetections(true)))
    }
}

/// `pattern` with the classes that `station` states or bins name, in shares that are drawn, too; `None`
/// if there are no classes.
///
/// # Errors
/// Never, because the names are valid.
pub(crate) fn with_classes(
    pattern: &Pattern,
    station: &Station,
    rng: &mut ChaCha8Rng,
) -> Result<Option<Pattern>> {
    let shares = ClassShares::drawn(class_names(station).into_iter(), rng);
    shares.map(|shares| shares.apply(pattern, rng)).transpose()
}

/// The classes that `station` states, then those that only bins name.
fn class_names(station: &Station) -> Vec<&str> {
    let stated = station.classes().iter().map(|class| class.name.as_str());
    let bins = station.robots().iter().flat_map(|robot| &robot.bins);
    let named = bins.filter_map(|bin| bin.classes.as_ref()).flatten();
    let unstated: BTreeSet<&str> = named
        .map(String::as_str)
        .filter(|name| station.class(name).is_none())
        .collect();
    stated.chain(unstated).collect()
}

/// Checks that some robot of `station` takes items of drawn patterns.
///
/// # Errors
/// All their classes are unwanted or without a bin.
#[cfg(any(test, feature = "onnx"))]
pub(crate) fn check_drawn_classes(station: &Station) -> Result<()> {
    let names = class_names(station);
    let is_wanted = |name: &&str| station.class(name).is_none_or(|class| class.wanted);
    let takes = |name: Option<&str>| station.takes(station.class_id(name));
    let offers = match names.is_empty() {
        true => takes(None),
        false => names
            .iter()
            .filter(|name| is_wanted(name))
            .any(|name| takes(Some(name))),
    };
    if offers {
        return Ok(());
    }
    Err(Error::input(
        "class",
        "all classes are unwanted or no robot has a bin for them, so there is nothing to learn",
        "give a robot a bin for a class that is wanted",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::station::built_in;

    /// A line with these bins and classes, and one robot.
    fn sorting(text: &str) -> Station {
        let text = format!(
            "[belt]\nspeed = 0.3\nwidth = 0.5\n{text}[line]\nrobots = 1\nfirst_base_x = 0.9\nspacing = 1.4\n\
             base_offset = 0.1\ntail = 0.4\nreach = 0.6\nspeed = 2\ngrasp_time = 0.04\n\
             release_time = 0.04\n[[line.bin]]\noffset = [0.0, 0.1]\nclasses = [\"p\"]\n"
        );
        crate::station::parse(&text, "s", crate::station::Overrides::default()).unwrap()
    }

    /// Where few items are wanted, patterns without any are left out, not an error. Classes that only
    /// bins name are drawn as well, and a line that takes nothing is refused.
    #[test]
    fn there_is_something_to_decide_on_every_scene() {
        let unwanted = "[[class]]\nname = \"p\"\n[[class]]\nname = \"u\"\nwanted = false\n";
        for (classes, all) in [(unwanted, false), ("", true)] {
            let station = sorting(classes);
            check_drawn_classes(&station).unwrap();
            let few = Domain::BROAD.with_items((2, 4));
            let courses = few.draw(&[station], 200, 1.0, 3).unwrap();
            let scenes = few.scenes(&courses).unwrap();
            assert!(scenes.len() > 50, "{classes}: {}", scenes.len());
            assert_eq!(scenes.len() == courses.len(), all, "{classes}");
            super::super::environment::check_scenes(&scenes).unwrap();
        }
        let nothing = sorting("[[class]]\nname = \"p\"\nwanted = false\n");
        let refused = check_drawn_classes(&nothing).unwrap_err().to_string();
        assert!(refused.contains("nothing to learn"), "{refused}");
    }

    #[test]
    fn failures_and_classes_are_drawn_and_change_nothing_else() {
        let station = built_in("sorting").unwrap().station(None).unwrap();
        let stations = [station];
        let plain = Domain::BROAD.draw(&stations, 60, 1.0, 3).unwrap();
        let domain = Domain::BROAD
            .with_failing(0.5)
            .with_grasp_success((0.4, 0.9));
        let drawn = domain.draw(&stations, 60, 1.0, 3).unwrap();
        let (mut failing, mut own) = (0, 0);
        for (plain, drawn) in plain.iter().zip(&drawn) {
            assert_eq!(plain.disturbances, Disturbances::default());
            let places = |course: &Course| -> Vec<_> {
                let items = course.pattern.items().iter();
                items.map(|i| (i.x0, i.y, i.class.clone())).collect()
            };
            assert_eq!(places(plain), places(drawn));
            assert!(
                plain
                    .pattern
                    .items()
                    .iter()
                    .all(|item| item.class.is_some())
            );
            let disturbances = &drawn.disturbances;
            if !disturbances.grasp_failures {
                continue;
            }
            failing += 1;
            assert!((0.4..=0.9).contains(&disturbances.default_p_grasp));
            let items = drawn.pattern.items();
            let within = |p: Option<f64>| p.is_some_and(|p| (0.4..=0.9).contains(&p));
            if disturbances.misdetections {
                own += 1;
                assert!(
                    items
                        .iter()
                        .all(|i| within(i.p_grasp) && within(i.p_detection))
                );
            } else {
                assert!(items.iter().all(|i| i.p_grasp.is_none()));
            }
        }
        assert!((20..=40).contains(&failing) && own > 5 && own < failing - 5);
    }

    #[test]
    fn patterns_become_denser_and_the_same_seed_draws_the_same() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let domain = Domain::BROAD;
        let stations = [station];
        let length = |progress: f64| {
            let courses = domain.draw(&stations, 40, progress, 1).unwrap();
            let per_item = |course: &Course| {
                let items = course.pattern.items();
                -items[items.len() - 1].x0 / items.len() as f64
            };
            courses.iter().map(per_item).sum::<f64>()
        };
        assert!(length(0.0) > 1.5 * length(1.0));
        let (a, b) = (
            domain.draw(&stations, 3, 0.5, 7),
            domain.draw(&stations, 5, 0.5, 7),
        );
        let (a, b) = (a.unwrap(), b.unwrap());
        assert!(
            a.iter()
                .zip(&b)
                .all(|(a, b)| a.pattern == b.pattern && a.station == b.station)
        );
    }
}
