//! What `pickline compare` and `pickline sweep` are given.

use super::{Common, ConditionArgs, FeedArgs, Pictures, StationChoice, strategy_help};
use clap::Args;

/// What stands before and behind the forms of a strategy.
const FURTHER: &str = "A further strategy, as `pickline simulate --help` lists them";
const AGAIN: &str = "; may be given several times";

/// Set strategies side by side on the paper's cases or your own
///
/// Robust GT is the assignment that is best over a training set, by default patterns of the
/// cases' kinds under other seeds, with --paper the paper's balanced set; greedy GT the best for
/// every single pattern; the third column is the trained policy that ships with the
/// program. Differences to robust GT are paired over patterns, with 95 % intervals. With
/// --out DIR writes throughput.csv (the steady state), picked_time.csv and picking_rate.csv
/// (the paper's Tables 2 and 3), runs.csv (every run) and compare.json.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline compare --paper
  pickline compare --cases dense --strategy rules:SPT,SPT --out results/
  pickline compare --station my-line.toml --cases my-cases.toml
  pickline compare --paper --html compare.html --svg rates.svg
  pickline compare --grasp-success 0.9 --position-noise 0.005

Charts for --chart: rate (the main one), the picking rate of every method on every case;
difference, how much more each picks than robust GT; throughput, the picks per minute in the steady
state; picked, the picked share.

A case file is TOML, one [[case]] each:
  [[case]]
  name = \"dense\"
  poisson = 0.12        # radius [m]; or grid = SPACING, or pattern = \"FILE.csv\"
  items = 150
or, by flow:
  [[case]]
  name = \"random\"
  feed = \"random\"       # or grid, poisson, clustered, gaps; or profile = \"FILE.csv\"
  flow = 60             # [items/min] at the station's belt speed; a profile needs none
  items = 150           # a profile needs none")]
pub struct CompareArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    /// Cases: paper, dense, all, or a TOML file
    #[arg(long, value_name = "SET|FILE", default_value = "paper")]
    pub cases: String,
    #[arg(long, value_name = "STRATEGY", help = strategy_help(FURTHER, AGAIN))]
    pub strategy: Vec<String>,
    #[command(flatten)]
    pub training: TrainingArgs,
    /// Leave greedy GT out, which is left out by itself where it would take minutes
    #[arg(long)]
    pub no_greedy: bool,
    /// Leave the trained policy out that ships with the program
    #[arg(long)]
    pub no_policy: bool,
    /// Measure the others against this method, by its name in files, such as greedy_gt
    #[arg(long, value_name = "METHOD", default_value = "robust_gt")]
    pub reference: String,
    /// Leave the certified bound out: what no strategy can do better
    #[arg(long)]
    pub no_bound: bool,
    /// Patterns of each random case; where something goes wrong, runs of every case
    #[arg(
        long,
        value_name = "N",
        default_value_t = 100,
        allow_negative_numbers = true
    )]
    pub replicates: usize,
    /// Print the paper's own figures beside ours, robust GT found on the balanced set as there
    #[arg(long)]
    pub paper: bool,
    #[command(flatten)]
    pub pictures: Pictures,
}

/// Where robust GT comes from.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Robust GT")]
pub struct TrainingArgs {
    /// Its assignment instead of the best on the training set
    #[arg(long, value_name = "R1,R2,...")]
    pub robust: Option<String>,
    /// Training set, written as --patterns of optimize [default: patterns of the kind that is
    /// judged under another seed; where the paper's own figures stand beside, its balanced set]
    #[arg(long, value_name = "SET", conflicts_with = "robust")]
    pub train_patterns: Option<String>,
    /// Items in each pattern of the training set [default: as many as are judged, 150 in a
    /// named set]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub train_items: Option<usize>,
}

/// Vary belt speed, robots, spacing or reach, and say how far up everything is picked
///
/// Answers how fast the belt may run, and whether one more robot or a slower belt is the
/// better buy. Prints throughput, picked share and picking rate at every value and, for each
/// strategy, the highest value up to which everything is picked, the first that misses an
/// item and the values above it at which everything is picked again. A sweep of the belt
/// speed finds that limit first and lays its values around it. Sweeps of robots, spacing and
/// reach recommend the least value with the highest throughput, of those at which arms
/// stay 5 cm apart.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline sweep
  pickline sweep --patterns poisson:0.15:100 --items 150 --strategy SPT,SPT --out results/
  pickline sweep --sweep robots --patterns poisson:0.12:10
  pickline sweep --sweep robots --patterns random:20 --flow 80
  pickline sweep --patterns poisson:0.15:100 --html sweep.html --svg limits.svg --chart limits

Charts for --chart: picked (the main one), the picked share over the sweep with the
limits; throughput, the picks per minute in the steady state; rate, the picking rate; limits, the share of the patterns of which everything is
picked (several patterns; speed or spacing).")]
pub struct SweepArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    /// What is varied: speed, robots, spacing, reach
    #[arg(long, value_name = "NAME", default_value = "speed")]
    pub sweep: String,
    /// First value [default: half of the limit found; from the station]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Last value [default: half above the limit found; from the station]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Between two values [default: a round step that makes up to 30 rows]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub step: Option<f64>,
    /// Patterns, written as for optimize
    #[arg(long, value_name = "SET", default_value = "grid:0.15")]
    pub patterns: String,
    /// Items in each generated pattern [default: 50 for the belt speed, otherwise as many as
    /// a steady state takes; of a profile all]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub items: Option<usize>,
    #[command(flatten)]
    pub feed: FeedArgs,
    #[arg(long, value_name = "STRATEGY", help = strategy_help(FURTHER, AGAIN))]
    pub strategy: Vec<String>,
    /// With greedy GT, the assignment of the highest picking rate at every value
    #[arg(long)]
    pub greedy: bool,
    /// Leave the certified bound out: what no strategy can do better
    #[arg(long)]
    pub no_bound: bool,
    #[command(flatten)]
    pub training: TrainingArgs,
    #[command(flatten)]
    pub pictures: Pictures,
}
