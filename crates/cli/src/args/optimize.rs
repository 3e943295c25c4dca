//! The arguments of `pickline optimize`.

use super::conditions::ConditionArgs;
use super::shards::ShardArgs;
use super::shared::{Common, PatternSetArgs, Pictures, StationChoice, strategy_help};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Find the rule for each robot that picks best across a set of patterns
///
/// Scores assignments of dispatching rules on the same set of patterns, ranks them with
/// paired 95 % intervals, breaks ties by the highest belt speed at which everything is
/// picked, and scores the winner again on fresh patterns.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline optimize --robots 3
  pickline optimize --station my-line.toml --patterns recorded/ --objective picked-share
  pickline optimize --station my-line.toml --save
  pickline optimize --robots 3 --save my-line.toml
  pickline optimize --robots 6 --search grasp --risk cvar:0.1 --format json
  pickline optimize --robots 3 --strategy onnx --strategy lookahead --validate 100
  pickline optimize --camera-x 0.5 --grasp-success 0.9 --position-noise 0.005
  pickline optimize --robots 12 --time-limit 20
  pickline optimize --robots 3 --race 0.1 --confidence 0.99
  pickline optimize --robots 3 --html optimize.html --svg ranking.svg

Charts for --chart: difference (the main one), how far each of the first 20 assignments
falls short of the best; spread, their mean and their worst pattern; ranking, the results
of all assignments.")]
pub(crate) struct OptimizeArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    #[command(flatten)]
    pub set: PatternSetArgs,
    /// What to maximise: picking-rate, picked-share, weighted-rate, max-speed
    #[arg(
        long,
        value_name = "NAME",
        default_value = "picking-rate",
        help_heading = "Search"
    )]
    pub objective: String,
    /// How to combine patterns: mean, worst, or cvar:A (mean of the worst share A)
    #[arg(
        long,
        value_name = "RISK",
        default_value = "mean",
        help_heading = "Search"
    )]
    pub risk: String,
    /// Resolution of the speed limits [m/s]
    #[arg(
        long,
        value_name = "V",
        default_value_t = 0.001,
        help_heading = "Search",
        allow_negative_numbers = true
    )]
    pub speed_step: f64,
    /// `auto` enumerates all 6^N assignments if that costs less than GRASP, and also runs
    /// GRASP if that adds less than a tenth; longer lines are searched by `exact` where robots pick
    /// independently, otherwise by `grasp`. `exact` runs GRASP, then proves by branch and bound which
    /// assignment is best, or how far the best can be from it; `both` reports GRASP's gap to the
    /// optimum
    #[arg(long, value_enum, default_value_t = SearchArg::Auto, help_heading = "Search")]
    pub search: SearchArg,
    /// GRASP: number of starts
    #[arg(
        long,
        value_name = "N",
        default_value_t = 8,
        help_heading = "Search",
        allow_negative_numbers = true
    )]
    pub starts: usize,
    /// GRASP: width of the restricted candidate list, from 0 (greedy) to 1 (random)
    #[arg(
        long,
        value_name = "A",
        default_value_t = 0.3,
        help_heading = "Search",
        allow_negative_numbers = true
    )]
    pub alpha: f64,
    #[command(flatten)]
    pub limits: LimitArgs,
    #[command(flatten)]
    pub race: RaceArgs,
    /// Number of fresh patterns (another seed) to score the winner on; 0 for none
    /// [default: 1000; proportionally fewer for patterns of more than 150 items, at least 10]
    #[arg(
        long,
        value_name = "K",
        help_heading = "Search",
        allow_negative_numbers = true
    )]
    pub validate: Option<usize>,
    #[arg(long, value_name = "STRATEGY", help_heading = "Search", help = strategy_help(
        "Also score this strategy on the patterns used to validate the winner (see \
         `pickline simulate --help`)",
        ". May be given several times. With --format csv, only strategies.csv in --out lists them",
    ))]
    pub strategy: Vec<String>,
    /// Save the winner as the strategy in the station file, which the other verbs then use;
    /// with FILE, write a new station file, as a built-in station requires
    #[arg(
        long,
        value_name = "FILE",
        num_args = 0..=1,
        help_heading = "Search"
    )]
    pub save: Option<Option<PathBuf>>,
    /// Do not bound how far the winner is from the best that any strategy can do
    #[arg(long, help_heading = "Search")]
    pub no_bound: bool,
    /// Number of lines of the ranking to print in the table
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        allow_negative_numbers = true
    )]
    pub top: usize,
    #[command(flatten)]
    pub pictures: Pictures,
    #[command(flatten)]
    pub shards: ShardArgs,
}

/// Limits on the length of a search.
#[derive(Debug, Clone, Args)]
pub(crate) struct LimitArgs {
    /// Maximum number of simulated runs in the search, tie-breaking included; a run is one
    /// assignment on one pattern at one belt speed. 0 for no limit. The result is the best so
    /// far, the same on any machine [default: 36000000 divided by the number of robots, or
    /// 4000000 if extended workspaces overlap or something can go wrong; proportionally fewer
    /// on patterns of more than 150 items]
    #[arg(
        long,
        value_name = "N",
        help_heading = "Search",
        allow_negative_numbers = true
    )]
    pub max_runs: Option<u64>,
    /// Stop the search after this time [s] with the best so far, which then depends on the
    /// machine; the winner is then validated on only a few patterns and not bounded
    #[arg(
        long,
        value_name = "S",
        help_heading = "Search",
        allow_negative_numbers = true
    )]
    pub time_limit: Option<f64>,
}

/// A race of all assignments.
#[derive(Debug, Clone, Args)]
pub(crate) struct RaceArgs {
    /// Race all assignments on patterns drawn one batch after another, as --patterns says: each
    /// is dropped as soon as it is not the best, and patterns are added until a single one is
    /// left, or several that score the same. Selects the best with the probability of --confidence
    /// if it is better than every other by DELTA, in units of the objective. For up to 6 robots
    #[arg(
        long,
        value_name = "DELTA",
        help_heading = "Race",
        allow_negative_numbers = true,
        conflicts_with_all = ["risk", "search", "starts", "alpha", "max_runs", "validate",
            "strategy", "no_bound", "html", "svg"]
    )]
    pub race: Option<f64>,
    /// Least probability that the best is selected [default: 0.95]
    #[arg(
        long,
        value_name = "P",
        help_heading = "Race",
        requires = "race",
        allow_negative_numbers = true
    )]
    pub confidence: Option<f64>,
    /// End after this number of patterns with the best so far, of which nothing is then
    /// guaranteed [default: 100000]
    #[arg(
        long,
        value_name = "N",
        help_heading = "Race",
        requires = "race",
        allow_negative_numbers = true
    )]
    pub max_patterns: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SearchArg {
    Auto,
    Exhaustive,
    Grasp,
    Both,
    Exact,
}
