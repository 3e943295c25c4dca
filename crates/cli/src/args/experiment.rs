//! The arguments of `pickline compare` and `pickline sweep`.

use super::conditions::{ConditionArgs, DetectionArgs, OutageArgs};
use super::shards::ShardArgs;
use super::shared::{AttributeArgs, Common, FeedArgs, Pictures, StationChoice, strategy_help};
use clap::Args;

/// Texts before and after the list of strategy forms.
const FURTHER: &str = "An additional strategy (see `pickline simulate --help`)";
const AGAIN: &str = ". May be given several times";

/// Compare strategies on the paper's cases or your own
///
/// Robust GT (game theory) is the assignment that is best over a training set: by default
/// patterns like those of the cases but with other seeds, with --paper the paper's balanced
/// set. Greedy GT is the best assignment for each single pattern. The third column is the
/// trained policy that ships with the program. Differences from robust GT are paired over
/// patterns, with 95 % intervals. --out DIR writes throughput.csv (the steady state),
/// picked_time.csv and picking_rate.csv (the paper's Tables 2 and 3), runs.csv (every run)
/// and compare.json; with --misdetections also purity.csv.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline compare --paper
  pickline compare --cases dense --strategy rules:SPT,SPT --out results/
  pickline compare --station my-line.toml --cases my-cases.toml
  pickline compare --paper --html compare.html --svg rates.svg
  pickline compare --grasp-success 0.9 --position-noise 0.005
  pickline compare --cases dense --outages 300,20

Charts for --chart: rate (the main one), the picking rate of every method on every case;
difference, how much more each picks than robust GT; throughput, the picks per minute in
the steady state; picked, the picked share.

A case file is TOML with one [[case]] table per case:
  [[case]]
  name = \"dense\"
  poisson = 0.12        # radius [m]; or grid = SPACING, or pattern = \"FILE.csv\"
  items = 150
or, given by its flow:
  [[case]]
  name = \"random\"
  feed = \"random\"       # or grid, poisson, clustered, gaps; or profile = \"FILE.csv\"
  flow = 60             # [items/min] at the station's belt speed; a profile needs none
  items = 150           # a profile needs none")]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    #[command(flatten)]
    pub detections: DetectionArgs,
    #[command(flatten)]
    pub outages: OutageArgs,
    /// Cases: paper, dense, all, or a TOML file
    #[arg(long, value_name = "SET|FILE", default_value = "paper")]
    pub cases: String,
    #[command(flatten)]
    pub attributes: AttributeArgs,
    #[arg(long, value_name = "STRATEGY", help = strategy_help(FURTHER, AGAIN))]
    pub strategy: Vec<String>,
    #[command(flatten)]
    pub training: TrainingArgs,
    /// Leave out greedy GT; it is always left out if it would take minutes
    #[arg(long)]
    pub no_greedy: bool,
    /// Leave out the trained policy that ships with the program
    #[arg(long)]
    pub no_policy: bool,
    /// Add the best of what line software ships (shares, every n-th item, zones, FIFO for all), tuned
    /// on training patterns; its name is rival
    #[arg(long)]
    pub tune: bool,
    /// Compare the others against this method, by its name in files, such as greedy_gt
    #[arg(long, value_name = "METHOD", default_value = "robust_gt")]
    pub reference: String,
    /// Leave out the certified bound, which no strategy can exceed
    #[arg(long)]
    pub no_bound: bool,
    /// Number of patterns per random case; if something can go wrong, of runs per case
    #[arg(
        long,
        value_name = "N",
        default_value_t = 100,
        allow_negative_numbers = true
    )]
    pub replicates: usize,
    /// Also print the paper's results, and find robust GT on its balanced set
    #[arg(long)]
    pub paper: bool,
    #[command(flatten)]
    pub shards: ShardArgs,
    #[command(flatten)]
    pub pictures: Pictures,
}

/// How robust GT (game theory) is found.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Robust GT (game theory)")]
pub(crate) struct TrainingArgs {
    /// Use this assignment instead of the best on the training set
    #[arg(long, value_name = "R1,R2,...")]
    pub robust: Option<String>,
    /// Training set, as for `optimize --patterns` [default: patterns like those scored, but
    /// with another seed; next to the paper's results, its balanced set]
    #[arg(long, value_name = "SET")]
    pub train_patterns: Option<String>,
    /// Items in each pattern of the training set [default: as many as in the scored patterns;
    /// 150 in a named set]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub train_items: Option<usize>,
}

/// Vary belt speed, robots, spacing, reach or the threshold of detections
///
/// Finds up to where everything is picked: how fast the belt may run, and whether another robot or a slower belt is the better
/// choice. Prints throughput, picked share and picking rate at every value. For each strategy
/// it also prints the highest value up to which everything is picked, the first value that
/// misses an item, and any values above it at which everything is picked again. A sweep of
/// the belt speed finds that limit first and places its values around it. Sweeps of robots,
/// spacing and reach recommend the lowest value with the highest throughput, among those at
/// which arms stay 5 cm apart.
///
/// --sweep min-detection varies the p_detection below which items are left on the belt, with
/// --misdetections: the more are left, the purer the bins, and usually the lower the recovery.
/// It draws that curve, and --purity P chooses a point on it.
///
/// --sweep robots-down shows what the line still does while one of its robots is down for the
/// whole run, for each robot, with the loss against all robots (paired over patterns, with 95 %
/// intervals); rules and strategies are those of the whole line.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline sweep
  pickline sweep --patterns poisson:0.15:100 --items 150 --strategy SPT,SPT --out results/
  pickline sweep --sweep robots --patterns poisson:0.12:10
  pickline sweep --sweep robots --patterns random:20 --flow 80
  pickline sweep --sweep robots-down --robots 3 --patterns random:20 --flow 80
  pickline sweep --patterns poisson:0.15:100 --html sweep.html --svg limits.svg --chart limits
  pickline sweep --sweep min-detection --p-detection beta:8,2 --purity 0.9 --svg purity.svg

Charts for --chart: picked (the main one), the picked share over the sweep with the
limits; throughput, the picks per minute in the steady state; rate, the picking rate;
limits, the share of patterns that are picked completely (needs several patterns and a
sweep of speed or spacing); purity, the purity over the recovery, which is the main one of a
sweep of min-detection. With robots-down: picked, loss (fewer picks than with all robots),
throughput, rate.")]
pub(crate) struct SweepArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    #[command(flatten)]
    pub detections: DetectionArgs,
    #[command(flatten)]
    pub outages: OutageArgs,
    /// What to vary: speed, robots, spacing, reach, min-detection; robots-down halts every robot in
    /// turn
    #[arg(long, value_name = "NAME", default_value = "speed")]
    pub sweep: String,
    /// With --sweep min-detection: name for each strategy the threshold with the highest recovery
    /// at a purity of at least P, chosen on training patterns (--train-patterns) and reported on
    /// fresh ones
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub purity: Option<f64>,
    /// First value [default: half the limit for the speed, otherwise from the station]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Last value [default: 1.5 times the limit for the speed, otherwise from the station]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Step between values [default: a round number that gives up to 30 rows]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub step: Option<f64>,
    /// Patterns, as for `optimize --patterns`
    #[arg(long, value_name = "SET", default_value = "grid:0.15")]
    pub patterns: String,
    /// Items in each generated pattern [default: 50 for a sweep of the speed, otherwise as
    /// many as a steady state needs; for a profile, all its items]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub items: Option<usize>,
    #[command(flatten)]
    pub attributes: AttributeArgs,
    #[command(flatten)]
    pub feed: FeedArgs,
    #[arg(long, value_name = "STRATEGY", help = strategy_help(FURTHER, AGAIN))]
    pub strategy: Vec<String>,
    /// Add greedy GT (game theory), the assignment with the highest picking rate at each value
    #[arg(long)]
    pub greedy: bool,
    /// Add the best of what line software ships (shares, every n-th item, zones, FIFO for all), tuned
    /// on training patterns for every line, with robots-down for the whole line; its name is rival
    #[arg(long)]
    pub tune: bool,
    /// Leave out the certified bound, which no strategy can exceed; with robots-down there is none
    #[arg(long)]
    pub no_bound: bool,
    #[command(flatten)]
    pub training: TrainingArgs,
    #[command(flatten)]
    pub shards: ShardArgs,
    #[command(flatten)]
    pub pictures: Pictures,
}
