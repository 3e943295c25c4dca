//! Evaluates a network on patterns that no training uses.

use super::player::NetworkPlayer;
use crate::decision::Figures;
use crate::decision::observation::Layout;
use crate::dispatch::RuleAssignment;
use crate::error::Result;
use crate::nn::Network;
use crate::sim::{AssignmentTree, Scene, simulate, simulate_rules};
use crate::stats::mean;
use rayon::prelude::*;
use std::fmt;

/// What a trial is run on. In tables and records it is written `station: case`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrialName {
    /// The station, as the user wrote it.
    pub station: String,
    /// The case whose patterns lie on it.
    pub case: String,
}

impl fmt::Display for TrialName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.station, self.case)
    }
}

/// Patterns of one kind, with the results of rules on them.
#[derive(Debug)]
pub struct Trial<'a> {
    /// The station and the case that it is judged on.
    pub name: TrialName,
    scenes: Vec<Scene<'a>>,
    /// Mean weighted rate [1/min] of the robust assignment: SPT for all but the last robot, FIFO
    /// for the last.
    pub robust: f64,
    /// Mean over patterns of the best assignment's weighted rate [1/min].
    pub greedy: f64,
}

impl<'a> Trial<'a> {
    /// Runs the rules on `scenes`, which all have the same number of robots.
    ///
    /// # Errors
    /// Never for valid scenes; the engines return a `Result`.
    pub fn new(name: TrialName, scenes: Vec<Scene<'a>>, robust: &RuleAssignment) -> Result<Self> {
        let robots = scenes
            .first()
            .map_or(1, |scene| scene.station().robots().len());
        let tree = AssignmentTree::all(robots);
        let both = |scene: &Scene| {
            let mut best = 0.0f64;
            tree.evaluate(scene, |_, figures| best = best.max(figures.weighted_rate()))?;
            Ok((simulate_rules(scene, robust)?.figures.weighted_rate(), best))
        };
        let rates: Vec<(f64, f64)> = scenes.par_iter().map(both).collect::<Result<_>>()?;
        let (rules, best): (Vec<f64>, Vec<f64>) = rates.into_iter().unzip();
        Ok(Self {
            name,
            scenes,
            robust: mean(&rules),
            greedy: mean(&best),
        })
    }

    /// The figures of the network on every pattern.
    ///
    /// # Errors
    /// Never for a network of this layout; the engine returns a `Result`.
    pub fn play(
        &self,
        network: &Network,
        parameters: &[f32],
        layout: Layout,
    ) -> Result<Vec<Figures>> {
        let run = |scene: &Scene| {
            let mut player = NetworkPlayer::new(network, parameters, layout);
            simulate(scene, &mut player).map(|outcome| outcome.figures)
        };
        self.scenes.par_iter().map(run).collect()
    }

    /// The network's mean weighted rate [1/min].
    ///
    /// # Errors
    /// As for [`Trial::play`].
    pub fn rate(&self, network: &Network, parameters: &[f32], layout: Layout) -> Result<f64> {
        let figures = self.play(network, parameters, layout)?;
        let rates: Vec<f64> = figures.iter().map(Figures::weighted_rate).collect();
        Ok(mean(&rates))
    }
}
