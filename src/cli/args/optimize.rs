//! What `pickline optimize` is given.

use super::{Common, PatternSetArgs, Pictures, StationChoice, strategy_help};
use clap::{Args, ValueEnum};

/// Find the rule for each robot that picks best whatever the pattern
///
/// Scores assignments of the dispatching rules on the same set of patterns, ranks them with paired 95 % intervals, breaks ties by the highest belt
/// speed at which everything is picked, and scores the winner again on fresh patterns.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline optimize --robots 3
  pickline optimize --station my-line.toml --patterns recorded/ --objective picked-share
  pickline optimize --robots 6 --search grasp --risk cvar:0.1 --format json
  pickline optimize --robots 3 --strategy onnx --strategy lookahead --validate 100
  pickline optimize --robots 3 --html optimize.html --svg ranking.svg

Charts for --chart: difference (the main one), how far each of the first 20 assignments
falls short of the best; spread, their mean and worst pattern; ranking, the figures of all
assignments.")]
pub struct OptimizeArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
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
    /// Over the patterns: mean, worst, or cvar:A (mean of the worst share A)
    #[arg(
        long,
        value_name = "RISK",
        default_value = "mean",
        help_heading = "Search"
    )]
    pub risk: String,
    /// Resolution of speed limits [m/s]
    #[arg(
        long,
        value_name = "V",
        default_value_t = 0.001,
        help_heading = "Search",
        allow_negative_numbers = true
    )]
    pub speed_step: f64,
    /// auto enumerates all 6^N assignments while that costs less than GRASP; both
    /// states GRASP's gap to the optimum
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
    /// GRASP: width of the restricted candidate list, 0 greedy to 1 random
    #[arg(
        long,
        value_name = "A",
        default_value_t = 0.3,
        help_heading = "Search",
        allow_negative_numbers = true
    )]
    pub alpha: f64,
    /// Fresh patterns (another seed) to score the winner on; 0 for none
    #[arg(
        long,
        value_name = "K",
        default_value_t = 1000,
        help_heading = "Search",
        allow_negative_numbers = true
    )]
    pub validate: usize,
    #[arg(long, value_name = "STRATEGY", help_heading = "Search", help = strategy_help(
        "Also score this strategy on the patterns that the winner is validated on, as \
         `pickline simulate --help` lists them",
        "; may be given several times. With --format csv only strategies.csv of --out has them",
    ))]
    pub strategy: Vec<String>,
    /// Leave out how far the winner is at most from the best that any strategy can do
    #[arg(long, help_heading = "Search")]
    pub no_bound: bool,
    /// Lines of the ranking to print in the table
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        allow_negative_numbers = true
    )]
    pub top: usize,
    #[command(flatten)]
    pub pictures: Pictures,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SearchArg {
    Auto,
    Exhaustive,
    Grasp,
    Both,
}
