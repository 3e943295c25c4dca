//! Options of the look-ahead, and how they are written.

use super::meter::{Allowance, Budget};
use crate::dispatch::RuleAssignment;
use crate::error::{Error, Result, known_names, shown};
use crate::setters::setters;

/// What plans maximise first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Goal {
    /// The number of items picked.
    #[default]
    Picks,
    /// The sum of the weights of the items picked.
    Weight,
}

/// Options of a [`super::Lookahead`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LookaheadOptions {
    /// What plans maximise first.
    pub goal: Goal,
    /// The budget of a decision.
    pub budget: Budget,
    /// Base assignments that every plan has to beat; empty for those that the caller knows to
    /// be good.
    pub bases: Vec<RuleAssignment>,
    /// How far ahead it plans [s]; items whose windows open later are ignored.
    pub horizon: f64,
    /// Number of decisions of the classical rollout at which every candidate is tried before
    /// the bases take over; 0 tries only the bases.
    pub depth: usize,
    /// Number of partial plans kept from one of these decisions to the next.
    pub width: usize,
    /// Whether plans are improved by neighbourhood search.
    pub improve: bool,
    /// Whether plans count what can fail: an attempt is worth its probability of success, and an
    /// item whose grasp failed can be tried again.
    pub foresee: bool,
    /// Seed of the neighbourhood search.
    pub seed: u64,
}

impl Default for LookaheadOptions {
    fn default() -> Self {
        Self {
            goal: Goal::Picks,
            budget: Budget::EXPERIMENT,
            bases: Vec::new(),
            horizon: f64::INFINITY,
            depth: 0,
            width: 1,
            improve: true,
            foresee: true,
            seed: 1,
        }
    }
}

setters!(LookaheadOptions {
    /// With this primary objective.
    fn with_goal(goal: Goal);
    /// With this budget of a decision.
    fn with_budget(budget: Budget);
    /// With these base assignments, which every plan has to beat.
    fn with_bases(bases: Vec<RuleAssignment>);
    /// With plans that reach this far ahead [s].
    fn with_horizon(horizon: f64);
    /// With this number of decisions at which every candidate is tried.
    fn with_depth(depth: usize);
    /// With this number of partial plans kept from one of these decisions to the next.
    fn with_width(width: usize);
    /// With neighbourhood search or without it.
    fn with_improve(improve: bool);
    /// With failures counted in what a plan is worth, or not.
    fn with_foresee(foresee: bool);
    /// With this seed of the neighbourhood search.
    fn with_seed(seed: u64);
});

/// Keys and their meanings, for help texts and errors.
pub(crate) const KEYS: [(&str, &str); 10] = [
    ("goal", "picks or weight: what is maximised [picks]"),
    ("budget", "simulated decisions per decision [4000]"),
    (
        "budget-ms",
        "time per decision instead [ms]; results then depend on the machine",
    ),
    (
        "bases",
        "assignments to beat, such as SPT+FIFO/SPT+SPT [the optimiser's best few]",
    ),
    ("horizon", "how far ahead to plan [s] [everything in view]"),
    (
        "depth",
        "decisions at which every candidate is tried, then the bases [0]",
    ),
    (
        "width",
        "partial plans kept from one of these to the next [1]",
    ),
    (
        "improve",
        "yes or no: improve plans by neighbourhood search [yes]",
    ),
    ("seed", "seed of that search [1]"),
    (
        "foresee",
        "yes or no: count the probabilities that grasps fail and detections are wrong [yes]",
    ),
];

impl LookaheadOptions {
    /// Reads `key=value,key=value` for a line of `robots` robots; `allowance` applies if no
    /// budget is given.
    ///
    /// # Errors
    /// An unknown key (the message suggests the nearest known one), or an invalid value (the
    /// message names the key and the allowed values).
    pub fn parse(text: &str, robots: usize, allowance: Allowance) -> Result<Self> {
        WrittenOptions::read(text)?.on(robots, allowance)
    }

    /// Checks that every base has one rule for each robot.
    ///
    /// # Errors
    /// A base for another number of robots.
    pub(crate) fn check_robots(&self, robots: usize) -> Result<()> {
        let mut bases = self.bases.iter();
        bases
            .try_for_each(|rules| rules.check_robots(robots))
            .map_err(|error| error.at(&place("bases")))
    }

    /// Sets the option `key`.
    fn set(&mut self, key: &str, value: &str) -> Result<()> {
        match key {
            "goal" => {
                self.goal = match value {
                    "picks" => Goal::Picks,
                    "weight" => Goal::Weight,
                    _ => return Err(not(key, value, "picks or weight")),
                }
            }
            "budget" => {
                self.budget = Budget::Decisions(whole(key, value, 1, 1_000_000_000)?);
            }
            "budget-ms" => {
                let read = value.parse().ok().and_then(Budget::milliseconds);
                let (least, most) = Budget::MILLISECONDS.into_inner();
                self.budget = read
                    .ok_or_else(|| not(key, value, &format!("a number from {least} to {most}")))?;
            }
            "bases" => {
                let read = |text: &str| text.replace('+', ",").parse();
                let bases: Result<Vec<RuleAssignment>> = value.split('/').map(read).collect();
                self.bases = bases.map_err(|error| error.at(&place(key)))?;
            }
            "horizon" => self.horizon = number(key, value, 1e-3, 1e9)?,
            // A usize can hold 1000 on every machine.
            "depth" => self.depth = whole(key, value, 0, 100)? as usize,
            "width" => self.width = whole(key, value, 1, 1000)? as usize,
            "improve" => self.improve = yes_or_no(key, value)?,
            "foresee" => self.foresee = yes_or_no(key, value)?,
            "seed" => self.seed = whole(key, value, 0, u64::MAX)?,
            _ => {
                let names = KEYS.map(|(name, _)| name);
                return Err(Error::usage(
                    "'strategy' lookahead",
                    format!("unknown option `{}`", shown(key)),
                    known_names(key, &names),
                ));
            }
        }
        Ok(())
    }

    /// How the strategy is written: `lookahead`, and the options that differ from the default.
    pub fn written(&self) -> String {
        let plain = Self::default();
        let mut parts = Vec::new();
        let mut part = |key: &str, value: String| parts.push(format!("{key}={value}"));
        if self.goal != plain.goal {
            part("goal", "weight".into());
        }
        match self.budget {
            budget if budget == plain.budget => {}
            Budget::Decisions(most) => part("budget", most.to_string()),
            Budget::Time(most) => part("budget-ms", (most.as_secs_f64() * 1e3).to_string()),
        }
        if !self.bases.is_empty() {
            let bases: Vec<_> = self.bases.iter().map(|b| b.names().join("+")).collect();
            part("bases", bases.join("/"));
        }
        if self.horizon != plain.horizon {
            part("horizon", self.horizon.to_string());
        }
        if self.depth != plain.depth {
            part("depth", self.depth.to_string());
        }
        if self.width != plain.width {
            part("width", self.width.to_string());
        }
        if !self.improve {
            part("improve", "no".into());
        }
        if !self.foresee {
            part("foresee", "no".into());
        }
        if self.seed != plain.seed {
            part("seed", self.seed.to_string());
        }
        if parts.is_empty() {
            "lookahead".into()
        } else {
            format!("lookahead:{}", parts.join(","))
        }
    }
}

/// Options as they were written, for a line that is not known yet.
#[derive(Debug)]
pub(crate) struct WrittenOptions {
    options: LookaheadOptions,
    /// The key that gives the budget, if one does.
    budget_key: Option<&'static str>,
}

impl From<LookaheadOptions> for WrittenOptions {
    /// The options as [`LookaheadOptions::written`] writes them: a default budget is not given.
    fn from(options: LookaheadOptions) -> Self {
        let budget_key = match options.budget {
            budget if budget == Budget::EXPERIMENT => None,
            Budget::Decisions(_) => Some("budget"),
            Budget::Time(_) => Some("budget-ms"),
        };
        Self {
            options,
            budget_key,
        }
    }
}

impl WrittenOptions {
    /// Reads `key=value,key=value`.
    ///
    /// # Errors
    /// As for [`LookaheadOptions::parse`], except for what depends on the line.
    pub(crate) fn read(text: &str) -> Result<Self> {
        let mut options = LookaheadOptions::default();
        let mut given: Vec<&str> = Vec::new();
        for part in text.split(',').filter(|part| !part.trim().is_empty()) {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let (key, value) = (key.trim(), value.trim());
            if given.contains(&key) {
                return Err(wrong(key, "is given twice".into(), "give it once"));
            }
            options.set(key, value)?;
            given.push(key);
        }
        let budget_key = match ["budget", "budget-ms"].map(|key| given.contains(&key)) {
            [true, true] => {
                let problem = "is given together with budget".to_owned();
                return Err(wrong("budget-ms", problem, "give only one of the two"));
            }
            [true, false] => Some("budget"),
            [false, true] => Some("budget-ms"),
            [false, false] => None,
        };
        Ok(Self {
            options,
            budget_key,
        })
    }

    /// The options for a line of `robots` robots; `allowance` applies if no budget was given.
    ///
    /// # Errors
    /// Bases for another number of robots, or a second budget.
    pub(crate) fn on(&self, robots: usize, allowance: Allowance) -> Result<LookaheadOptions> {
        self.options.check_robots(robots)?;
        let budget = match (self.budget_key, allowance.asked) {
            (Some(key), Some(_)) => {
                let problem = "is given together with 'budget_ms'".to_owned();
                return Err(wrong(key, problem, "give only one of the two"));
            }
            (Some(_), None) => self.options.budget,
            (None, asked) => asked.unwrap_or(allowance.otherwise),
        };
        Ok(LookaheadOptions {
            budget,
            ..self.options.clone()
        })
    }
}

fn place(key: &str) -> String {
    format!("'strategy' lookahead:{}", shown(key))
}

fn wrong(key: &str, problem: String, cure: &str) -> Error {
    Error::usage(place(key), problem, cure)
}

fn not(key: &str, value: &str, cure: &str) -> Error {
    let problem = format!("`{}` is not a valid value", shown(value));
    wrong(key, problem, &format!("give {cure}"))
}

fn yes_or_no(key: &str, value: &str) -> Result<bool> {
    match value {
        "yes" => Ok(true),
        "no" => Ok(false),
        _ => Err(not(key, value, "yes or no")),
    }
}

fn whole(key: &str, value: &str, least: u64, most: u64) -> Result<u64> {
    let read = value.parse().ok().filter(|n| (least..=most).contains(n));
    read.ok_or_else(|| {
        not(
            key,
            value,
            &format!("a whole number from {least} to {most}"),
        )
    })
}

fn number(key: &str, value: &str, least: f64, most: f64) -> Result<f64> {
    let read = value.parse().ok().filter(|n| (least..=most).contains(n));
    read.ok_or_else(|| not(key, value, &format!("a number from {least} to {most}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        for text in [
            "",
            "goal=weight",
            "budget=5",
            "budget-ms=2.5,horizon=30",
            "bases=SPT+FIFO/SPT+SPT,depth=1,width=3,improve=no,foresee=no,seed=7",
        ] {
            let options = LookaheadOptions::parse(text, 2, Allowance::default()).unwrap();
            let name = if text.is_empty() {
                "lookahead".to_owned()
            } else {
                format!("lookahead:{text}")
            };
            assert_eq!(options.written(), name);
        }
    }

    /// Explicit defaults, spaces and empty parts make no difference.
    #[test]
    fn defaults_can_be_written_out() {
        let read = |text: &str| LookaheadOptions::parse(text, 2, Allowance::default()).unwrap();
        let all = "goal=picks, budget = 4000,,depth=0,width=1,improve=yes,foresee=yes,seed=1";
        assert_eq!(read(all), LookaheadOptions::default());
        assert_eq!(read(all), read(""));
        let asked = Allowance {
            asked: Some(Budget::Decisions(7)),
            otherwise: Budget::LIVE,
        };
        let with = |allowance| {
            LookaheadOptions::parse("seed=3", 2, allowance)
                .unwrap()
                .budget
        };
        assert_eq!(with(asked), Budget::Decisions(7));
        let asked = None;
        let otherwise = Budget::LIVE;
        assert_eq!(with(Allowance { asked, otherwise }), otherwise);
    }

    #[test]
    fn wrong_options_name_key_and_cure() {
        for (text, words) in [
            ("budgte=3", &["unknown option", "did you mean `budget`"][..]),
            ("budget=0", &["lookahead:budget", "from 1 to"]),
            ("budget", &["lookahead:budget", "``"]),
            ("budget-ms=NaN", &["lookahead:budget-ms", "a number"]),
            ("budget=3,budget-ms=3", &["give only one of the two"]),
            ("seed=1,seed=2", &["given twice"]),
            ("bases=SPT", &["lookahead:bases", "1 rule for 2 robots"]),
            ("bases=SPT+FOO", &["lookahead:bases", "`FOO`"]),
            ("goal=money", &["picks or weight"]),
            ("improve=maybe", &["yes or no"]),
            ("foresee=1", &["lookahead:foresee", "yes or no"]),
            ("horizon=-1", &["lookahead:horizon"]),
        ] {
            let message = LookaheadOptions::parse(text, 2, Allowance::default())
                .unwrap_err()
                .to_string();
            for word in words {
                assert!(message.contains(word), "{text}: {word} not in {message}");
            }
        }
    }
}
