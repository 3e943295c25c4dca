//! A set of patterns with their labels.

use super::feeder::Feeder;
use super::grid::grid;
use super::item::Pattern;
use super::poisson::poisson_disk;
use super::random_stream;
use super::recipe::Recipe;
use crate::error::Result;
use crate::station::Station;
use rayon::prelude::*;

/// A set of patterns, each with a label, and how they were made.
#[derive(Debug, Clone)]
pub struct PatternSet {
    /// Where the patterns come from, in words, including the seed.
    pub description: String,
    /// One label per pattern: `grid s=0.15`, `poisson r=0.2 #3`, or a file name.
    pub labels: Vec<String>,
    /// The patterns, in the order of the labels.
    pub patterns: Vec<Pattern>,
}

/// A pattern to be generated, with its spacing or radius [m].
#[derive(Debug, Clone, Copy)]
pub(super) enum Draw<'a> {
    Grid(f64),
    Poisson(f64),
    Feed(&'a Feeder),
}

impl PatternSet {
    /// Checks that all items are on the station's belt.
    ///
    /// # Errors
    /// The first item that is beside it, with its pattern.
    pub(crate) fn check_on(&self, station: &Station) -> Result<()> {
        for (label, pattern) in self.labels.iter().zip(&self.patterns) {
            let on_belt = pattern.check_on(station);
            on_belt.map_err(|error| error.inside(label))?;
        }
        Ok(())
    }

    /// Draws patterns in parallel, each from the random stream of its index. `place` is what a recipe that
    /// cannot be drawn is called.
    pub(super) fn draw(&mut self, recipe: &Recipe, draws: Vec<Draw>, place: &str) -> Result<()> {
        let draw = |(index, draw): (usize, &Draw)| {
            let mut rng = random_stream(recipe.seed, index as u64);
            let pattern = match *draw {
                Draw::Grid(spacing) => grid(recipe.belt.width, spacing, recipe.items),
                Draw::Poisson(radius) => {
                    poisson_disk(recipe.belt.width, radius, recipe.items, &mut rng)
                }
                Draw::Feed(feeder) => feeder.draw(recipe.items, &mut rng),
            };
            let pattern = pattern.map_err(|error| error.at(place))?;
            recipe.attributes.apply(pattern, &mut rng)
        };
        let patterns = draws.par_iter().enumerate().map(draw);
        self.patterns = patterns.collect::<Result<_>>()?;
        let label = |(index, draw): (usize, &Draw)| match draw {
            Draw::Grid(spacing) => format!("grid s={spacing:.4}"),
            Draw::Poisson(radius) => format!("poisson r={radius:.4} #{}", index + 1),
            Draw::Feed(feeder) => feeder.label(index),
        };
        self.labels = draws.iter().enumerate().map(label).collect();
        Ok(())
    }
}
