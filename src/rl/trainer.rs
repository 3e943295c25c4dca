//! Training in phases: each phase draws patterns, plays and learns on them for a few updates.
//!
//! Everything random in a phase depends only on the seed and the phase's number. A training
//! resumed from a checkpoint, which is written between two phases, therefore continues
//! bit-exactly as if it had never stopped, on any number of threads.

use super::courses::Courses;
use super::domain::Course;
use super::imitation::{Answers, Pupil};
use super::plan::Plan;
use super::ppo::{GROUP, Group, Learner, Terms};
use crate::decision::Figures;
use crate::decision::observation::Layout;
use crate::error::{Error, Result};
use crate::nn::{Adam, Network, Shape};
use crate::optimize::Environment;
use crate::pattern::{Pattern, random_stream};
use crate::sim::Scene;
use crate::station::{Station, station_hash};
use crate::strategies::Blueprint;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Distance between the seeds from which neighbouring phases draw.
const PHASE_STRIDE: u64 = 1_000_003;
/// Minimum number of phases of a training with enough updates.
const LEAST_PHASES: u64 = 7;
/// Random stream for the order of samples, beyond those of environments and patterns.
const SHUFFLE: u64 = u64::MAX - 1;

/// A training in progress.
#[derive(Debug)]
pub struct Trainer {
    plan: Plan,
    layout: Layout,
    stations: Vec<Station>,
    courses: Courses,
    seed: u64,
    learner: Learner,
    /// Number of completed rounds of imitation.
    rounds: usize,
    phase: u64,
    steps: u64,
}

/// What a phase of the training reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Phase {
    /// Number of decisions so far.
    pub steps: u64,
    /// Mean picking rate of the completed episodes [1/min].
    pub rate: f64,
    /// Mean share of the items picked in these episodes.
    pub picked_share: f64,
    /// Mean entropy of the policy in the last update.
    pub entropy: f64,
    /// Mean squared error of the value in the last update.
    pub value_loss: f64,
    /// Approximate divergence in the last update.
    pub divergence: f64,
    /// Share of the samples in the last update whose ratio was clipped.
    pub clipped: f64,
}

/// The results of a round of imitation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Round {
    /// Number of answers learned from so far.
    pub answers: usize,
    /// Share of these answers that the network also gives.
    pub agreement: f64,
}

/// The state needed to resume a training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Checkpoint {
    /// The settings of the training.
    pub plan: Plan,
    /// Master seed of the training.
    pub seed: u64,
    /// Fingerprints of the stations.
    pub stations: Vec<String>,
    /// Number of completed rounds of imitation.
    pub rounds: usize,
    /// Number of completed phases.
    pub phase: u64,
    /// Number of completed decisions.
    pub steps: u64,
    /// The parameters of the network, flat.
    pub parameters: Vec<f32>,
    /// The state of the optimiser Adam.
    pub adam: Adam,
}

impl Trainer {
    /// Starts a new training on `stations` in turn.
    ///
    /// # Errors
    /// An invalid plan, or no station.
    pub fn new(plan: Plan, stations: Vec<Station>, seed: u64) -> Result<Self> {
        let layout = plan.layout()?;
        plan.check()?;
        if stations.is_empty() {
            let problem = "no station to train on";
            return Err(Error::usage("the training", problem, "give one or more"));
        }
        // Every arm must be faster than the belt at every speed that can be drawn.
        for (station, factor) in stations
            .iter()
            .flat_map(|s| [(s, plan.domain.speed.0), (s, plan.domain.speed.1)])
        {
            let speed = station.belt().speed * factor;
            let made = station.with_belt_speed(speed);
            made.map_err(|error| error.inside("the training plan: domain.speed").into_usage())?;
        }
        let network = Network::new(&plan.architecture, Shape::of(&layout));
        let parameters = network.initial(&mut random_stream(seed, SHUFFLE));
        Ok(Self {
            learner: Learner::new(network, parameters),
            courses: Courses::new(&plan.domain, &stations, seed)?,
            plan,
            layout,
            stations,
            seed,
            rounds: 0,
            phase: 0,
            steps: 0,
        })
    }

    /// Resumes a training from `checkpoint`.
    ///
    /// # Errors
    /// As for [`Trainer::new`], or a checkpoint whose parts do not match.
    pub fn resume(checkpoint: Checkpoint, stations: Vec<Station>) -> Result<Self> {
        let planned = checkpoint.plan.imitation.as_ref().map_or(0, |i| i.rounds);
        if checkpoint.rounds < planned {
            return Err(Error::input(
                "the checkpoint",
                format!(
                    "its imitation was stopped after {} of {planned} rounds, and the answers were \
                     not kept",
                    checkpoint.rounds
                ),
                "start again with 'imitate'; the policy file has the best network so far",
            ));
        }
        let trainer = Self::new(checkpoint.plan, stations, checkpoint.seed);
        // The plan is part of the checkpoint.
        let mut trainer = trainer.map_err(Error::into_input)?;
        if trainer.station_hashes() != checkpoint.stations {
            return Err(Error::input(
                "the checkpoint",
                "it belongs to a training on other stations",
                "give the station files of that training",
            ));
        }
        let expected = trainer.learner.parameters.len();
        let found = [checkpoint.parameters.len(), checkpoint.adam.parameters()];
        if found != [expected; 2] {
            return Err(Error::input(
                "the checkpoint",
                format!(
                    "it has {} parameters and moments of {}, but its plan needs {expected}",
                    found[0], found[1]
                ),
                "use an unmodified checkpoint",
            ));
        }
        trainer.learner.parameters = checkpoint.parameters;
        trainer.learner.adam = checkpoint.adam;
        trainer.rounds = checkpoint.rounds;
        trainer.phase = checkpoint.phase;
        trainer.steps = checkpoint.steps;
        Ok(trainer)
    }

    /// The state needed to resume from here.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            plan: self.plan.clone(),
            seed: self.seed,
            stations: self.station_hashes(),
            rounds: self.rounds,
            phase: self.phase,
            steps: self.steps,
            parameters: self.learner.parameters.clone(),
            adam: self.learner.adam.clone(),
        }
    }

    /// The settings of the training.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Shape of observations and actions.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// The network, without its parameters.
    pub fn network(&self) -> &Network {
        &self.learner.network
    }

    /// The parameters of the network so far, flat.
    pub fn parameters(&self) -> &[f32] {
        &self.learner.parameters
    }

    /// Master seed of the training.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The stations trained on, in turn.
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }

    /// Hashes of the stations, as in result files.
    pub(crate) fn station_hashes(&self) -> Vec<String> {
        self.stations.iter().map(station_hash).collect()
    }

    /// All numbers of robots in the training, each once.
    pub fn robots(&self) -> String {
        let counts = self.stations.iter().map(|station| station.robots().len());
        let counts: BTreeSet<usize> = counts.collect();
        let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
        counts.join(", ")
    }

    /// Number of completed rounds of imitation.
    pub fn rounds(&self) -> usize {
        self.rounds
    }

    /// Changes the planned number of decisions to `steps`.
    pub fn up_to(&mut self, steps: u64) {
        self.plan.steps = steps;
    }

    /// Number of decisions learned from.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Whether the planned steps are complete.
    pub fn done(&self) -> bool {
        self.steps >= self.plan.steps
    }

    /// The completed share of the planned steps.
    fn progress(&self) -> f64 {
        (self.steps as f64 / self.plan.steps.max(1) as f64).min(1.0)
    }

    /// Learns from an expert according to the plan; `expert` returns it for a number of robots.
    /// Calls `report` after every round. A stop request takes effect after a whole round.
    ///
    /// # Errors
    /// Patterns that cannot be drawn, an expert that acts illegally, or an error of `report`.
    pub fn imitate(
        &mut self,
        expert: &(dyn Fn(usize) -> Result<Blueprint> + Sync),
        environment: &Environment,
        mut report: impl FnMut(&Self, Round) -> Result<()>,
    ) -> Result<()> {
        let Some(imitation) = self.plan.imitation.clone() else {
            return Ok(());
        };
        let mut all = Answers::default();
        let total = imitation.rounds * imitation.courses;
        environment
            .progress
            .begin("imitating", total as u64, "patterns");
        for round in 0..imitation.rounds {
            // Far from the phases' seeds.
            let seed = !self
                .seed
                .wrapping_mul(PHASE_STRIDE)
                .wrapping_add(round as u64);
            let plan = &self.plan;
            let courses = self.drawn(imitation.courses, 1.0, seed)?;
            let scenes = plan.domain.scenes(&courses)?;
            let pupil = match round {
                0 => Pupil::Expert,
                _ => Pupil::Network(&self.learner.network, &self.learner.parameters),
            };
            let ask = |scene: &Scene| {
                if environment.stopped() {
                    return Err(Error::interrupted());
                }
                let mut expert = expert(scene.station().robots().len())?.make();
                let (reward, gamma) = (plan.reward, plan.ppo.gamma);
                let answers =
                    Answers::collect(scene, expert.as_mut(), &pupil, self.layout, reward, gamma);
                environment.progress.advance(1);
                answers
            };
            let answers: Result<Vec<Answers>> = scenes.par_iter().map(ask).collect();
            let answers = match answers {
                Err(error) if error.is_interrupted() => break,
                answers => answers?,
            };
            answers.into_iter().for_each(|answers| all.append(answers));
            let mut rng = random_stream(seed, SHUFFLE);
            let terms = all.teach(&mut self.learner, &imitation, &plan.ppo, &mut rng);
            let round = Round {
                answers: all.len(),
                agreement: terms.agreement,
            };
            self.rounds += 1;
            report(self, round)?;
        }
        environment.progress.end();
        // Moments of another loss would mislead the first updates.
        self.learner.adam = self.learner.network.adam(1e-5);
        Ok(())
    }

    /// Trains on no pattern of a set that is one of `tests`.
    ///
    /// # Errors
    /// Nothing is left of the set.
    pub fn leave_out(&mut self, tests: &[&Pattern]) -> Result<()> {
        self.courses.leave_out(tests)
    }

    /// `count` courses; see [`Courses::draw`].
    fn drawn(&self, count: usize, progress: f64, seed: u64) -> Result<Vec<Course>> {
        let domain = &self.plan.domain;
        self.courses
            .draw(domain, &self.stations, count, progress, seed)
    }

    /// Updates per phase: as planned, but fewer in short trainings, so that patterns become
    /// denser in time.
    fn updates(&self) -> usize {
        let all = self.plan.steps / self.plan.ppo.samples().max(1) as u64;
        self.plan.updates.min((all / LEAST_PHASES) as usize).max(1)
    }

    /// Whether every parameter is finite: no update has diverged.
    pub fn is_finite(&self) -> bool {
        self.learner.parameters.iter().all(|p| p.is_finite())
    }

    /// Plays and learns for one phase. A stop request takes effect between two updates; a phase
    /// cut short by it cannot be resumed bit-exactly.
    ///
    /// # Errors
    /// Patterns that cannot be drawn.
    pub fn phase(&mut self, environment: &Environment) -> Result<Phase> {
        let seed = self
            .seed
            .wrapping_mul(PHASE_STRIDE)
            .wrapping_add(self.phase);
        let plan = &self.plan;
        let domain = &plan.domain;
        let courses = self.drawn(plan.courses, self.progress(), seed)?;
        let scenes = domain.scenes(&courses)?;
        let make = |first: usize| {
            let range = (first * GROUP, GROUP);
            Group::new(&scenes, self.layout, plan.reward, range, seed)
        };
        let groups = 0..plan.ppo.n_envs / GROUP;
        let mut groups: Vec<Group> = groups.map(make).collect::<Result<_>>()?;
        let mut rng = random_stream(seed, SHUFFLE);
        let mut terms = Terms::default();
        let mut ended: Vec<Figures> = Vec::new();
        for _ in 0..self.updates() {
            if environment.stopped() || self.steps >= plan.steps {
                break;
            }
            let (network, parameters) = (&self.learner.network, &self.learner.parameters);
            groups
                .par_iter_mut()
                .map(|group| group.collect(network, parameters, &plan.ppo))
                .collect::<Result<()>>()?;
            ended.extend(groups.iter().flat_map(|group| &group.episodes));
            let left = if plan.ppo.anneal {
                1.0 - self.steps as f32 / plan.steps as f32
            } else {
                1.0
            };
            let rate = plan.ppo.learning_rate * left;
            terms = self.learner.update(&groups, &plan.ppo, rate, &mut rng);
            self.steps += plan.ppo.samples() as u64;
            environment.progress.advance(plan.ppo.samples() as u64);
        }
        self.phase += 1;
        let mean = |of: &dyn Fn(&Figures) -> f64| {
            ended.iter().map(of).sum::<f64>() / ended.len().max(1) as f64
        };
        Ok(Phase {
            steps: self.steps,
            rate: mean(&Figures::picking_rate),
            picked_share: mean(&Figures::picked_share),
            entropy: terms.entropy,
            value_loss: terms.value,
            divergence: terms.divergence,
            clipped: terms.clipped,
        })
    }
}
