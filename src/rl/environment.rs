//! One line as a decision process.
//!
//! | | |
//! |---|---|
//! | episode | one pattern, drawn from the scenes that the environment was given |
//! | step | one decision of one robot; robots with nothing to choose from are skipped |
//! | observation | [`crate::decision::observation`], f32 [observation] |
//! | action | the index of a slot that holds an item, or the last index to wait |
//! | reward | see [`Reward`] |
//! | end | all items picked, or the last one has left the belt |
//!
//! After the last step of an episode, the next episode has already begun: the observation is
//! its first, as in the vectorised environments of Gymnasium and Stable-Baselines3.

use super::reward::Reward;
use crate::decision::observation::{Encoder, Layout};
use crate::decision::{Action, Figures};
use crate::error::{Error, Result};
use crate::pattern::random_stream;
use crate::sim::{Run, RunBuffers, Scene};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// One line as a decision process; see the module.
#[derive(Debug)]
pub struct DispatchEnvironment<'a> {
    scenes: &'a [Scene<'a>],
    rng: ChaCha8Rng,
    encoder: Encoder,
    reward: Reward,
    /// `None` only while its buffers move into the next episode's run.
    run: Option<Run<'a>>,
    scene: usize,
}

/// The error for a step when nobody decides.
fn nothing_due() -> Error {
    Error::usage(
        "step",
        "no episode has begun, or it is over",
        "call reset before the first step, and after the last one of an episode",
    )
}

/// Whether there is a decision to make on a scene: of few items, all may be unwanted or out of reach.
/// The buffers are those of any run.
pub(super) fn is_playable(scene: &Scene, buffers: &mut RunBuffers) -> bool {
    let mut run = Run::with_buffers(scene, std::mem::take(buffers));
    run.look(false);
    let is_playable = run.next_decision().is_some();
    *buffers = run.into_buffers();
    is_playable
}

/// Checks that there is a decision to make on every scene.
///
/// # Errors
/// There is none on some scene, or there are no scenes.
pub(super) fn check_scenes(scenes: &[Scene]) -> Result<()> {
    let mut buffers = RunBuffers::default();
    if !scenes.is_empty() && scenes.iter().all(|scene| is_playable(scene, &mut buffers)) {
        return Ok(());
    }
    Err(Error::input(
        "the training patterns",
        "on some, no robot ever has an item to choose, or there are none",
        "use patterns on the station's belt, with items within reach of a robot while it is not down",
    ))
}

/// A reward that no item of `scene` exceeds: the highest that the station gives an item that does not
/// state its weight, so that scenes of a station agree unless one has heavier items.
fn most_weight(scene: &Scene) -> f64 {
    let station = scene.station();
    let valued = station.classes().iter().map(|class| class.value);
    let items = scene.pattern().items().iter();
    let weights = items.map(|item| item.weight_on(station));
    valued.chain(weights).fold(1.0, f64::max)
}

/// What an action leads to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The reward of the action; at the end of an episode also that of the episode.
    pub reward: f64,
    /// The figures of the episode, if it is over.
    pub ended: Option<Figures>,
}

impl<'a> DispatchEnvironment<'a> {
    /// Environment `index` of those under `seed`; each draws its own episodes. Call
    /// [`DispatchEnvironment::reset`] first.
    ///
    /// # Errors
    /// There is no scene, or some scene has no decision to make.
    pub fn new(
        scenes: &'a [Scene<'a>],
        layout: Layout,
        reward: Reward,
        (seed, index): (u64, u64),
    ) -> Result<Self> {
        check_scenes(scenes)?;
        Ok(Self::on_checked(scenes, layout, reward, (seed, index)))
    }

    /// Like [`DispatchEnvironment::new`], on scenes for which [`check_scenes`] has found no error.
    pub(super) fn on_checked(
        scenes: &'a [Scene<'a>],
        layout: Layout,
        reward: Reward,
        (seed, index): (u64, u64),
    ) -> Self {
        Self {
            scenes,
            rng: random_stream(seed, index),
            encoder: Encoder::new(layout),
            reward,
            run: None,
            scene: 0,
        }
    }

    /// Begins an episode on a randomly drawn scene and writes the first observation
    /// [observation] and mask [actions].
    pub fn reset(&mut self, observation: &mut [f32], mask: &mut [bool]) {
        self.scene = self.rng.random_range(0..self.scenes.len());
        let scene = &self.scenes[self.scene];
        let buffers = self.run.take().map(Run::into_buffers);
        let mut run = Run::with_buffers(scene, buffers.unwrap_or_default());
        if let Some(snapshot) = run.next_decision() {
            self.encoder.encode(&snapshot, observation, mask);
        }
        self.run = Some(run);
    }

    /// Takes `action` and writes the next observation and mask; if the episode is over, those
    /// of a new episode.
    ///
    /// # Errors
    /// The action's slot is empty, or no episode has begun; nothing has changed then.
    pub fn step(
        &mut self,
        action: usize,
        observation: &mut [f32],
        mask: &mut [bool],
    ) -> Result<Step> {
        let step = self.take(action, observation, mask)?;
        if step.ended.is_some() {
            self.reset(observation, mask);
        }
        Ok(step)
    }

    /// Like [`DispatchEnvironment::step`], but begins no new episode: at the end of one, nobody
    /// decides, so the observation is zero and the mask allows nothing.
    ///
    /// # Errors
    /// As for [`DispatchEnvironment::step`]; or the episode is over.
    pub fn advance(
        &mut self,
        action: usize,
        observation: &mut [f32],
        mask: &mut [bool],
    ) -> Result<Step> {
        let step = self.take(action, observation, mask)?;
        if step.ended.is_some() {
            observation.fill(0.0);
            mask.fill(false);
        }
        Ok(step)
    }

    /// Takes `action` and writes the next observation and mask, unless the episode is over.
    fn take(&mut self, action: usize, observation: &mut [f32], mask: &mut [bool]) -> Result<Step> {
        let due = self.run.as_mut().and_then(|run| run.next_decision());
        let snapshot = due.ok_or_else(nothing_due)?;
        let chosen = self.encoder.action(&snapshot, action)?;
        let weight = match chosen {
            Action::Pick(place) => snapshot.candidates[place].weight,
            Action::WaitUntil(_) | Action::WaitForNextWindow | Action::NoAnswer => 0.0,
        };
        let (mut reward, mut ended) = (0.0, None);
        if let Some(run) = &mut self.run {
            // A failed grasp has no reward.
            if run.act(chosen)?.is_some() {
                reward += self.reward.of_pick(weight);
            }
            match run.next_decision() {
                Some(next) => self.encoder.encode(&next, observation, mask),
                None => ended = Some(run.figures()),
            }
        }
        if let Some(figures) = &ended {
            reward += self.reward.of_end(figures);
        }
        Ok(Step { reward, ended })
    }

    /// Checks that `action` can be taken now.
    ///
    /// # Errors
    /// As for [`DispatchEnvironment::advance`].
    pub fn check_action(&mut self, action: usize) -> Result<()> {
        let due = self.run.as_mut().and_then(|run| run.next_decision());
        let snapshot = due.ok_or_else(nothing_due)?;
        self.encoder.action(&snapshot, action).map(|_| ())
    }

    /// Draws the episodes of environment `index` under `seed` from the next reset on.
    pub fn reseed(&mut self, (seed, index): (u64, u64)) {
        self.rng = random_stream(seed, index);
    }

    /// The current episode, for asking others what they would do.
    pub fn run(&mut self) -> Option<&mut Run<'a>> {
        self.run.as_mut()
    }

    /// The encoder in the state of the last observation.
    pub fn encoder(&self) -> &Encoder {
        &self.encoder
    }

    /// The items in the slots of the last observation, each by its index in the pattern; none if the
    /// episode is over.
    pub fn items(&mut self) -> Vec<u32> {
        let due = self.run.as_mut().and_then(|run| run.next_decision());
        let places = || self.encoder.slots().iter();
        due.map_or_else(Vec::new, |snapshot| {
            places()
                .map(|place| snapshot.candidates[*place].item)
                .collect()
        })
    }

    /// The least and the greatest value of each feature of an observation, on any of the scenes; see
    /// [`Layout::bounds`].
    pub fn bounds(&self) -> Vec<(f32, f32)> {
        let layout = self.encoder.layout();
        let of_scene = |scene: &Scene| {
            let camera_x = scene.conditions().camera_x;
            layout.bounds(scene.station(), camera_x, most_weight(scene))
        };
        let wider = |mut all: Vec<(f32, f32)>, other: Vec<(f32, f32)>| {
            for (range, other) in all.iter_mut().zip(other) {
                *range = (range.0.min(other.0), range.1.max(other.1));
            }
            all
        };
        let scenes = self.scenes.iter().map(of_scene);
        scenes.reduce(wider).unwrap_or_default()
    }

    /// Index of the scene of the current episode.
    pub fn scene(&self) -> usize {
        self.scene
    }
}
