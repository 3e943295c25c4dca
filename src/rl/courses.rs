//! Where a training's courses come from: random draws, or the patterns of a set.

use super::domain::{Course, Domain};
use crate::error::{Error, Result};
use crate::pattern::{Pattern, Recipe, random_stream};
use crate::station::Station;
use rayon::prelude::*;

/// The courses of a training.
#[derive(Debug, Clone)]
pub struct Courses {
    /// The patterns for each station, if they are those of [`Domain::patterns`].
    sets: Option<Vec<Vec<Pattern>>>,
}

impl Courses {
    /// Those of `domain` on `stations`, with the sets of patterns that `seed` gives.
    ///
    /// # Errors
    /// A source that cannot be read, or a set that cannot be generated for a station.
    pub fn new(domain: &Domain, stations: &[Station], seed: u64) -> Result<Self> {
        let Some(source) = domain.source()? else {
            return Ok(Self { sets: None });
        };
        let build = |station: &Station| {
            let recipe = Recipe::new(*station.belt(), domain.items.0, seed);
            let set = source.build(&recipe);
            set.map(|set| set.patterns)
                .map_err(|error| error.inside("the training plan: domain.patterns"))
        };
        let sets = stations.iter().map(build).collect::<Result<_>>()?;
        Ok(Self { sets: Some(sets) })
    }

    /// Leaves the patterns out of the sets whose items lie as those of one of `tests`, so that a policy
    /// is never scored on a pattern that it was trained on.
    ///
    /// # Errors
    /// Nothing is left of a set.
    pub fn leave_out(&mut self, tests: &[&Pattern]) -> Result<()> {
        for set in self.sets.iter_mut().flatten() {
            set.retain(|pattern| !tests.iter().any(|test| same_places(pattern, test)));
            if set.is_empty() {
                return Err(Error::usage(
                    "the training plan: domain.patterns",
                    "the policy is scored on all patterns of the set",
                    "give a set with others, such as balanced or poisson:0.12:100",
                ));
            }
        }
        Ok(())
    }

    /// Draws `count` courses as [`Domain::draw`] does. Those of sets have their patterns in turn.
    ///
    /// # Errors
    /// As for [`Domain::draw`].
    pub fn draw(
        &self,
        domain: &Domain,
        stations: &[Station],
        count: usize,
        progress: f64,
        seed: u64,
    ) -> Result<Vec<Course>> {
        let Some(sets) = &self.sets else {
            return domain.draw(stations, count, progress, seed);
        };
        let draw = |index: usize| {
            let mut rng = random_stream(seed, index as u64);
            let (turn, place) = (index / stations.len(), index % stations.len());
            let set = &sets[place];
            let pattern = set[turn % set.len()].clone();
            domain.course_with(pattern, &stations[place], &mut rng)
        };
        (0..count).into_par_iter().map(draw).collect()
    }
}

/// Whether the items of both lie at the same places.
fn same_places(a: &Pattern, b: &Pattern) -> bool {
    let places = |pattern: &Pattern| -> Vec<(f64, f64)> {
        let items = pattern.items().iter();
        items.map(|item| (item.x0, item.y)).collect()
    };
    a.items().len() == b.items().len() && places(a) == places(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::PatternSource;
    use crate::station::built_in;

    fn stations() -> [Station; 2] {
        ["paper", "paper-narrow"].map(|name| built_in(name).unwrap().station(None).unwrap())
    }

    fn domain(source: &str) -> Domain {
        Domain::BROAD
            .with_items((20, 20))
            .with_curriculum(0.0)
            .with_patterns(source.to_owned())
    }

    #[test]
    fn without_a_set_the_draws_are_those_of_the_domain() {
        let stations = stations();
        let courses = Courses::new(&Domain::BROAD, &stations, 1).unwrap();
        let ours = courses.draw(&Domain::BROAD, &stations, 6, 0.5, 7).unwrap();
        let theirs = Domain::BROAD.draw(&stations, 6, 0.5, 7).unwrap();
        for (a, b) in ours.iter().zip(&theirs) {
            assert_eq!((&a.pattern, &a.station), (&b.pattern, &b.station));
        }
    }

    #[test]
    fn every_station_has_the_set_of_its_belt_in_turn_whatever_the_seed_of_the_draw() {
        let stations = stations();
        let domain = domain("balanced:2");
        let courses = Courses::new(&domain, &stations, 5).unwrap();
        let drawn = courses.draw(&domain, &stations, 10, 0.0, 99).unwrap();
        let source: PatternSource = "balanced:2".parse().unwrap();
        for (place, station) in stations.iter().enumerate() {
            let set = source
                .build(&Recipe::new(*station.belt(), 20, 5))
                .unwrap()
                .patterns;
            let own: Vec<&Course> = drawn.iter().skip(place).step_by(2).collect();
            assert_eq!((set.len(), own.len()), (4, 5));
            for (course, pattern) in own.iter().zip(set.iter().cycle()) {
                assert_eq!(course.pattern, *pattern);
            }
            // The speeds are still drawn.
            let speeds = |course: &&Course| course.station.belt().speed / station.belt().speed;
            let speeds: Vec<f64> = own.iter().map(speeds).collect();
            assert!(speeds.iter().all(|factor| (0.8..=1.25).contains(factor)));
            assert!(speeds.windows(2).all(|pair| pair[0] != pair[1]));
        }
        let fixed = domain.clone().with_speed((1.0, 1.0));
        let drawn = courses.draw(&fixed, &stations, 2, 0.0, 1).unwrap();
        assert_eq!(drawn[1].station.belt(), stations[1].belt());
    }

    #[test]
    fn what_a_policy_is_scored_on_is_left_out_of_the_sets() {
        let [station, _] = stations();
        let stations = [station];
        let domain = domain("balanced:3");
        let mut courses = Courses::new(&domain, &stations, 5).unwrap();
        let of = |courses: &Courses| courses.draw(&domain, &stations, 6, 0.0, 1).unwrap();
        let all = of(&courses);
        let tests = [&all[4].pattern, &all[0].pattern];
        courses.leave_out(&tests).unwrap();
        let left = of(&courses);
        for (place, from) in [1, 2, 3, 5, 1, 2].into_iter().enumerate() {
            assert_eq!(left[place].pattern, all[from].pattern);
        }
        let rest: Vec<&Pattern> = left.iter().map(|course| &course.pattern).collect();
        let error = courses.leave_out(&rest).unwrap_err().to_string();
        assert!(error.contains("scored on all patterns"), "{error}");
    }
}
