//! Training in phases: each draws patterns, plays and learns on them for a few updates.
//!
//! Everything random in a phase follows from the seed and the phase's number, so that a
//! training taken up from a checkpoint, written between two phases, goes on to the bit as
//! if it had never stopped, on any number of threads.

use super::imitation::{Answers, Pupil};
use super::nn::{Adam, Network};
use super::plan::{Plan, shape};
use super::ppo::{GROUP, Group, Learner, Terms};
use crate::decision::Figures;
use crate::decision::observation::Layout;
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::pattern::random_stream;
use crate::sim::Scene;
use crate::station::{self, Station};
use crate::strategies::Blueprint;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Phases of neighbouring seeds draw from seeds this far apart.
const PHASE_STRIDE: u64 = 1_000_003;
/// A training has at least so many phases, if it has so many updates.
const LEAST_PHASES: u64 = 7;
/// Stream of the order of samples, past those of environments and patterns.
const SHUFFLE: u64 = u64::MAX - 1;

/// A training under way.
#[derive(Debug)]
pub struct Trainer {
    plan: Plan,
    layout: Layout,
    stations: Vec<Station>,
    seed: u64,
    learner: Learner,
    /// Rounds of imitation done.
    rounds: usize,
    phase: u64,
    steps: u64,
}

/// What a phase came to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// Decisions so far.
    pub steps: u64,
    /// Mean picking rate of the episodes that ended [1/min].
    pub rate: f64,
    /// Mean share of the items that they picked.
    pub picked_share: f64,
    /// Mean entropy of the policy in the last update.
    pub entropy: f64,
    /// Mean squared error of the value in the last update.
    pub value_loss: f64,
    /// Approximate divergence of the last update.
    pub divergence: f64,
    /// Share of the samples whose ratio was clipped in it.
    pub clipped: f64,
}

/// What a round of imitation came to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Answers learned from so far.
    pub answers: usize,
    /// Share of them that the network gives as well.
    pub agreement: f64,
}

/// What is needed to go on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    /// The plan.
    pub plan: Plan,
    /// Master seed.
    pub seed: u64,
    /// Fingerprints of the stations.
    pub stations: Vec<String>,
    /// Rounds of imitation done.
    pub rounds: usize,
    /// Phases done.
    pub phase: u64,
    /// Decisions done.
    pub steps: u64,
    /// The network's parameters.
    pub parameters: Vec<f32>,
    /// The optimiser.
    pub adam: Adam,
}

impl Trainer {
    /// A training from the beginning, on `stations` in turn.
    ///
    /// # Errors
    /// A plan that does not fit together, no station.
    pub fn new(plan: Plan, stations: Vec<Station>, seed: u64) -> Result<Self> {
        let layout = plan.layout()?;
        plan.check()?;
        if stations.is_empty() {
            let problem = "no station to train on";
            return Err(Error::input("the training", problem, "give one or more"));
        }
        // The belt must be slower than every arm at whatever speed is drawn.
        for (station, factor) in stations
            .iter()
            .flat_map(|s| [(s, plan.domain.speed.0), (s, plan.domain.speed.1)])
        {
            let speed = station.belt().speed * factor;
            let made = station.with_belt_speed(speed);
            made.map_err(|error| error.inside("the training plan: domain.speed"))?;
        }
        let network = Network::new(&plan.architecture, shape(&layout));
        let parameters = network.initial(&mut random_stream(seed, SHUFFLE));
        Ok(Self {
            learner: Learner::new(network, parameters),
            plan,
            layout,
            stations,
            seed,
            rounds: 0,
            phase: 0,
            steps: 0,
        })
    }

    /// A training taken up where `checkpoint` was written.
    ///
    /// # Errors
    /// As for [`Trainer::new`], or a checkpoint whose parts do not fit together.
    pub fn resume(checkpoint: Checkpoint, stations: Vec<Station>) -> Result<Self> {
        let planned = checkpoint.plan.imitation.as_ref().map_or(0, |i| i.rounds);
        if checkpoint.rounds < planned {
            return Err(Error::input(
                "the checkpoint",
                format!(
                    "its imitation was stopped after {} of {planned} rounds, and the answers are not kept",
                    checkpoint.rounds
                ),
                "begin again with --imitate; what was best so far stands in the policy",
            ));
        }
        let mut trainer = Self::new(checkpoint.plan, stations, checkpoint.seed)?;
        if trainer.station_hashes() != checkpoint.stations {
            return Err(Error::input(
                "the checkpoint",
                "its training was on other stations",
                "give the station files as they were then",
            ));
        }
        let expected = trainer.learner.parameters.len();
        let found = [checkpoint.parameters.len(), checkpoint.adam.parameters()];
        if found != [expected; 2] {
            return Err(Error::input(
                "the checkpoint",
                format!(
                    "it has {} parameters and moments of {}, where its plan has {expected}",
                    found[0], found[1]
                ),
                "use a checkpoint as it was written",
            ));
        }
        trainer.learner.parameters = checkpoint.parameters;
        trainer.learner.adam = checkpoint.adam;
        trainer.rounds = checkpoint.rounds;
        trainer.phase = checkpoint.phase;
        trainer.steps = checkpoint.steps;
        Ok(trainer)
    }

    /// What is needed to go on from here.
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

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Shape of observations and actions.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// The network.
    pub fn network(&self) -> &Network {
        &self.learner.network
    }

    /// Its parameters.
    pub fn parameters(&self) -> &[f32] {
        &self.learner.parameters
    }

    /// Master seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The stations trained on, in turn.
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }

    /// Fingerprints of the stations, as in result files.
    pub fn station_hashes(&self) -> Vec<String> {
        let hash = |station: &Station| crate::files::fingerprint(station::to_toml(station));
        self.stations.iter().map(hash).collect()
    }

    /// The numbers of robots trained on, each once.
    pub fn robots(&self) -> String {
        let counts = self.stations.iter().map(|station| station.robots().len());
        let counts: BTreeSet<usize> = counts.collect();
        let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
        counts.join(", ")
    }

    /// Rounds of imitation done.
    pub fn rounds(&self) -> usize {
        self.rounds
    }

    /// Trains up to so many decisions, whatever was planned.
    pub fn up_to(&mut self, steps: u64) {
        self.plan.steps = steps;
    }

    /// Decisions learned from.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Whether the planned steps are done.
    pub fn done(&self) -> bool {
        self.steps >= self.plan.steps
    }

    /// The share of the planned steps that is done.
    fn progress(&self) -> f64 {
        (self.steps as f64 / self.plan.steps.max(1) as f64).min(1.0)
    }

    /// Learns from an expert as the plan says; `expert` gives it for a number of robots.
    /// Tells `report` after every round. When asked to stop it ends with the last whole
    /// round.
    ///
    /// # Errors
    /// Patterns that cannot be drawn, an expert that acts illegally, what `report` says.
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
            let courses = plan
                .domain
                .draw(&self.stations, imitation.courses, 1.0, seed)?;
            let scenes = plan.domain.scenes(&courses)?;
            let pupil = match round {
                0 => Pupil::Expert,
                _ => Pupil::Network(&self.learner.network, &self.learner.parameters),
            };
            let ask = |scene: &Scene| {
                if environment.stopped() {
                    return Err(Error::Interrupted);
                }
                let mut expert = expert(scene.station().robots().len())?.make();
                let worth = (plan.reward, plan.ppo.gamma);
                let answers = Answers::collect(scene, expert.as_mut(), &pupil, self.layout, worth);
                environment.progress.advance(1);
                answers
            };
            let answers: Result<Vec<Answers>> = scenes.par_iter().map(ask).collect();
            let answers = match answers {
                Err(Error::Interrupted) => break,
                answers => answers?,
            };
            answers.into_iter().for_each(|answers| all.append(answers));
            let mut rng = random_stream(seed, SHUFFLE);
            let ppo = &plan.ppo;
            let how = (&imitation, ppo.batch_size, ppo.vf_coef, ppo.max_grad_norm);
            let terms = all.teach(&mut self.learner, how, &mut rng);
            let round = Round {
                answers: all.len(),
                agreement: terms.clipped,
            };
            self.rounds += 1;
            report(self, round)?;
        }
        environment.progress.end();
        // The moments of another loss would mislead the first updates.
        self.learner.adam = self.learner.network.adam(1e-5);
        Ok(())
    }

    /// Updates of a phase: as the plan says, and in short trainings fewer, so that patterns
    /// become denser in time.
    fn updates(&self) -> usize {
        let all = self.plan.steps / self.plan.ppo.samples().max(1) as u64;
        self.plan.updates.min((all / LEAST_PHASES) as usize).max(1)
    }

    /// Whether every parameter is a number: no update has gone astray.
    pub fn is_finite(&self) -> bool {
        self.learner.parameters.iter().all(|p| p.is_finite())
    }

    /// Plays and learns for one phase. When asked to stop it ends between two updates; what
    /// such a phase was cut to cannot be gone on with to the bit.
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
        let courses = domain.draw(&self.stations, plan.courses, self.progress(), seed)?;
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
