//! What a study has to say about its result besides figures.

use crate::dispatch::RULES;
use crate::pattern::{Item, PatternSet};
use crate::sim::{Conditions, Scene};
use crate::station::Station;
use std::fmt;

/// A remark that belongs to a result. Its text names settings in single quotes, as
/// errors do ([`spell_settings`](crate::error::spell_settings)).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Where robust GT (game theory) comes from.
    Robust(RobustNote),
    /// This strategy is the one of the station file.
    StationStrategy(String),
    /// The built-in policy is not among the methods, because the line is far from its training.
    PolicyLeftOut {
        /// How the line differs from the training, in words.
        distance: String,
        /// How the policy is written as a strategy.
        policy: &'static str,
    },
    /// Greedy GT is not among the methods, because it would take minutes.
    GreedyLeftOut {
        /// Number of robots of the line.
        robots: usize,
        /// Number of patterns per case with which it is affordable; 0 if there is none.
        replicates: usize,
    },
    /// The full form of a strategy whose name is short for it.
    FullName {
        /// Its name in tables and files.
        name: String,
        /// The strategy with all its settings, as it is written.
        full: String,
    },
    /// What the best of the strategies that line software ships is, and how it was tuned.
    Rival(String),
    /// How the line differs from a policy's training.
    Distance(String),
    /// The same, for some values of a sweep.
    DistanceAtValues {
        /// Number of values at which the line differs.
        count: usize,
        /// Number of all values of the sweep.
        all: usize,
        /// The first value at which the line differs, in the unit of the quantity.
        first: f64,
        /// How the line at that value differs from the training, in words.
        distance: String,
    },
    /// Grasps may fail, but no item has a probability below 1.
    NothingFails,
    /// Detections may be wrong, but every item is certainly what it is reported as.
    NothingMisdetected,
    /// There is a threshold of detections, but no item is below it.
    NothingUncertain,
    /// All items weigh the same, so that PP and FIFO are one rule.
    EqualWeights,
    /// Something can go wrong, so the event loop simulates each assignment by itself, all of them
    /// under common random numbers.
    CommonRandomNumbers,
    /// Extended workspaces overlap on some patterns.
    Overlapping {
        /// Number of patterns with such items.
        overlapping: usize,
        /// Number of all patterns of the set.
        patterns: usize,
    },
    /// The flow that a search for the highest speed recommends [m/s].
    ChosenFlow(f64),
    /// No flow can be recommended: some pattern is picked completely at no speed.
    NoFlow,
    /// No flow can be recommended: not all patterns were evaluated.
    NoFlowYet,
    /// The time limit was reached before the winner was validated.
    TimeLimit {
        /// Maximum number of fresh patterns used nevertheless.
        fresh: usize,
    },
    /// The bound is that of the line on which nothing goes wrong.
    UndisturbedBound {
        /// Whether the camera's errors and its place do not matter, either.
        camera: bool,
    },
    /// The bound is that of the line on which no robot is ever down.
    BoundWithoutOutages,
    /// The time slots of the bound are long.
    CoarseBound,
    /// The user stopped the work.
    Interrupted,
    /// There are no fresh patterns like those of this source.
    NotValidated(String),
}

/// The text of [`Note::NothingFails`].
const NOTHING_FAILS: &str = "no item has a p_grasp below 1, so no grasp fails; give 'default_p_grasp' P for \
     items without one";

/// The text of [`Note::NothingMisdetected`].
const NOTHING_MISDETECTED: &str = "no item has a p_detection below 1 or another true_class, so every detection \
     is right and every purity 1; give items a p_detection ('p_detection') or a true_class";

/// The text of [`Note::NothingUncertain`].
const NOTHING_UNCERTAIN: &str =
    "no item has a p_detection below 'min_detection', so none is left for it";

/// The text of [`Note::EqualWeights`].
const EQUAL_WEIGHTS: &str = "all items weigh the same, so PP picks like FIFO; give areas or probabilities \
     ('area_cm2', 'p_grasp') to tell them apart";

/// The text of [`Note::CommonRandomNumbers`].
const COMMON_RANDOM_NUMBERS: &str = "all assignments are compared under common random numbers; as \
     something can go wrong, the general event loop simulates each assignment by itself";

/// The text of [`Note::CoarseBound`].
const COARSE_BOUND: &str = "the bound is coarse: the pattern is so long that the slots are long, too; a \
     shorter 'slot' gives a tighter bound, but takes more time and memory";

/// The text of [`Note::BoundWithoutOutages`].
const BOUND_WITHOUT_OUTAGES: &str = "the bound is that of the line without outages, which only cost time: \
     what can be picked in spite of them may be less";

/// The text of [`Note::NoFlow`].
const NO_FLOW: &str = "no flow can be chosen: for some pattern no belt speed picks everything";

/// The text of [`Note::Interrupted`].
const INTERRUPTED: &str = "interrupted: what is missing above (patterns, tie-breaking by max speed, \
     validation, other strategies) was not done; run again for a reliable result";

/// The text of [`Note::GreedyLeftOut`].
fn left_out(robots: usize, replicates: usize) -> String {
    let cure = match replicates {
        0 => String::new(),
        replicates => format!("; 'replicates' {replicates} includes it"),
    };
    format!(
        "greedy GT (game theory) is left out: trying {}^{robots} assignments on every pattern \
         would take minutes{cure}",
        RULES.len()
    )
}

/// The text of [`Note::UndisturbedBound`].
fn undisturbed_bound(camera: bool) -> String {
    let camera = match camera {
        true => ", whatever the camera reports and when",
        false => "",
    };
    format!(
        "proven for every outcome of the random events: failures only cost time, so this is the \
         bound of the line without failures{camera}; there is no schedule to compare it with"
    )
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Robust(note) => note.fmt(f),
            Self::StationStrategy(text) => write!(f, "{text} is the strategy of the station file"),
            Self::PolicyLeftOut { distance, policy } => write!(
                f,
                "the built-in policy is left out: {distance}; 'strategy' {policy} runs it anyway"
            ),
            Self::GreedyLeftOut { robots, replicates } => {
                f.write_str(&left_out(*robots, *replicates))
            }
            Self::FullName { name, full } => write!(f, "{name} is {full}"),
            Self::Rival(text) | Self::Distance(text) => f.write_str(text),
            Self::DistanceAtValues {
                count,
                all,
                first,
                distance,
            } => write!(
                f,
                "at {count} of {all} values, first at {first}: {distance}"
            ),
            Self::NothingFails => f.write_str(NOTHING_FAILS),
            Self::NothingMisdetected => f.write_str(NOTHING_MISDETECTED),
            Self::NothingUncertain => f.write_str(NOTHING_UNCERTAIN),
            Self::EqualWeights => f.write_str(EQUAL_WEIGHTS),
            Self::CommonRandomNumbers => f.write_str(COMMON_RANDOM_NUMBERS),
            Self::Overlapping {
                overlapping,
                patterns,
            } => write!(
                f,
                "extended workspaces overlap on {overlapping} of {patterns} patterns; there, the \
                 general event loop simulated each assignment by itself"
            ),
            Self::ChosenFlow(flow) => write!(
                f,
                "chosen flow: {flow} m/s, the smallest speed limit of these patterns"
            ),
            Self::NoFlow => f.write_str(NO_FLOW),
            Self::NoFlowYet => f.write_str("no flow is chosen: not all patterns were evaluated"),
            Self::TimeLimit { fresh } => write!(
                f,
                "'until' was reached: validated on at most {fresh} fresh patterns, without a \
                 bound"
            ),
            Self::UndisturbedBound { camera } => f.write_str(&undisturbed_bound(*camera)),
            Self::BoundWithoutOutages => f.write_str(BOUND_WITHOUT_OUTAGES),
            Self::CoarseBound => f.write_str(COARSE_BOUND),
            Self::Interrupted => f.write_str(INTERRUPTED),
            Self::NotValidated(source) => {
                write!(f, "no validation: cannot draw fresh patterns like {source}")
            }
        }
    }
}

/// Where robust GT (game theory) comes from.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct RobustNote {
    /// How the assignment was found.
    pub basis: RobustBasis,
    /// For which lines of a sweep it was found.
    pub scope: Option<RobustScope>,
}

/// By what robust GT was chosen.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub enum RobustBasis {
    /// The caller gave it.
    Given,
    /// It is the best on a training set.
    Best {
        /// Description of the patterns that it was found on.
        on: String,
    },
    /// It is the best on the paper's training set.
    PaperBest {
        /// Description of the patterns that it was found on.
        on: String,
        /// Whether the study itself has other conditions, which were left out.
        undisturbed: bool,
    },
    /// It has the highest mean on patterns like those scored.
    HighestMean {
        /// The figure whose mean is the highest.
        figure: String,
        /// The training set; `None` if it is the scored patterns themselves.
        on: Option<String>,
    },
}

/// For which lines of a sweep robust GT was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RobustScope {
    /// Once, at the station's own belt speed.
    OwnSpeed,
    /// For each line separately.
    EveryLine,
    /// For the line with all its robots, although one is halted.
    WholeLine,
    /// For each threshold of detections; the patterns are described with the last one.
    EveryThreshold,
}

impl fmt::Display for RobustNote {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.basis {
            RobustBasis::Given => f.write_str("robust GT as given ('robust')")?,
            RobustBasis::Best { on } => write!(f, "robust GT is the best on {on}")?,
            RobustBasis::PaperBest { on, undisturbed } => {
                let plain = match undisturbed {
                    true => ", with every item known and nothing going wrong",
                    false => "",
                };
                write!(
                    f,
                    "robust GT is the best on {on}, as in the paper{plain}; 'training' names \
                     another set"
                )?;
            }
            RobustBasis::HighestMean { figure, on } => {
                write!(f, "robust GT has the highest mean {figure} on ")?;
                match on {
                    Some(on) => f.write_str(on)?,
                    None => f.write_str(
                        "the very patterns used here, which favours it; 'training' names others",
                    )?,
                }
            }
        }
        f.write_str(match self.scope {
            None => "",
            Some(RobustScope::OwnSpeed) => ", found at the station's own belt speed",
            Some(RobustScope::EveryLine) => ", found for every line",
            Some(RobustScope::WholeLine) => {
                ", found for the line with all robots, which is what runs when one halts"
            }
            Some(RobustScope::EveryThreshold) => {
                ", found for every threshold, of which this is the last"
            }
        })
    }
}

/// Notes for a comparison under `conditions`. `without_own` means that no item has a `p_grasp` of its
/// own, `bounded` that there is a bound.
pub(crate) fn condition_notes(
    conditions: &Conditions,
    without_own: bool,
    bounded: bool,
) -> Vec<Note> {
    let nothing = without_own && conditions.disturbances.never_fails(&[]);
    let nothing = nothing.then_some(Note::NothingFails);
    let outages = outage_note(conditions, bounded);
    nothing.into_iter().chain(outages).collect()
}

/// The note on the bound of a line with outages, if there is a bound.
pub(super) fn outage_note(conditions: &Conditions, bounded: bool) -> Option<Note> {
    (bounded && conditions.has_outages()).then_some(Note::BoundWithoutOutages)
}

/// Notes that detections cannot be wrong, or that none is below the threshold, although this is
/// asked for; `patterns` are the items of each pattern.
pub(super) fn detection_notes<'i>(
    conditions: &Conditions,
    patterns: impl Iterator<Item = &'i [Item]> + Clone,
) -> Vec<Note> {
    let chance = &conditions.disturbances;
    let certain = |items: &[Item]| chance.never_misdetects(items);
    let mut notes = Vec::new();
    if chance.misdetections && patterns.clone().all(certain) {
        notes.push(Note::NothingMisdetected);
    }
    let mut items = patterns.flatten();
    if conditions.min_detection > 0.0 && !items.any(|item| conditions.is_too_uncertain(item)) {
        notes.push(Note::NothingUncertain);
    }
    notes
}

/// The note that nothing can fail on `scene`, although failures are asked for.
pub(super) fn failure_note(scene: &Scene) -> Option<Note> {
    let disturbances = &scene.conditions().disturbances;
    disturbances
        .never_fails(scene.pattern().items())
        .then_some(Note::NothingFails)
}

/// Notes for any result on `station` with `set` under `conditions`, of which `patterns` patterns were used.
/// `independent` is the number of patterns on which the cascade could be used.
pub fn set_notes(
    station: &Station,
    set: &PatternSet,
    conditions: &Conditions,
    independent: usize,
    patterns: usize,
) -> Vec<Note> {
    let items = set.patterns.iter().map(|pattern| pattern.items());
    let mut notes = detection_notes(conditions, items);
    let mut weights = set
        .patterns
        .iter()
        .flat_map(|p| p.items())
        .filter(|item| station.takes(item.class_on(station)))
        .map(|item| item.weight_on(station));
    let first = weights.next();
    if first.is_some_and(|first| weights.all(|weight| weight == first)) {
        notes.push(Note::EqualWeights);
    }
    let overlapping = patterns.saturating_sub(independent);
    if conditions.disturbances.may_fail() {
        let mut items = set.patterns.iter().map(|pattern| pattern.items());
        if items.all(|items| conditions.disturbances.never_fails(items)) {
            notes.push(Note::NothingFails);
        }
        notes.push(Note::CommonRandomNumbers);
    } else if overlapping > 0 {
        notes.push(Note::Overlapping {
            overlapping,
            patterns,
        });
    }
    notes
}
