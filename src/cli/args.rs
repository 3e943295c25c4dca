//! The arguments as they are typed. Nothing below the command line ever sees clap.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Decides which robot picks what from a moving belt: finds the robust dispatching
/// rule for each robot of a line, and simulates any strategy exactly.
#[derive(Debug, Parser)]
#[command(
    version,
    arg_required_else_help = true,
    after_long_help = "\
Every verb runs without arguments on built-in defaults: the station `paper` with two
robots and, where one pattern is needed, the grid of 0.15 m with 50 items.

Exit codes: 0 done, 1 failed, 2 wrong usage or input, 130 interrupted (with the best
found so far printed)."
)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Optimize(Box<OptimizeArgs>),
    Compare(Box<CompareArgs>),
    Sweep(Box<SweepArgs>),
    Game(Box<GameArgs>),
    Simulate(Box<SimulateArgs>),
    Pattern(PatternArgs),
    Station(StationArgs),
    /// Print a completion script for a shell
    #[command(after_help = "Example: pickline completions bash > /etc/bash_completion.d/pickline")]
    Completions {
        /// The shell; found out from the environment when not given
        shell: Option<clap_complete::Shell>,
    },
}

/// How results are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people
    Table,
    /// Everything, one object
    Json,
    /// The main table, for other programs
    Csv,
}

/// The line that a verb works on.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Station")]
pub struct StationChoice {
    /// Station file (TOML), or a built-in: paper, paper-narrow
    #[arg(long, value_name = "FILE|NAME", default_value = "paper")]
    pub station: String,
    /// Number of robots; needs a built-in station or a file with a [line]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub robots: Option<usize>,
    /// Belt speed [m/s] instead of the station's
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub belt_speed: Option<f64>,
}

/// What every verb that computes has in common.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Common")]
pub struct Common {
    /// Master seed of everything random
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// Threads; all cores when not given. Results do not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// How the result is printed on stdout
    #[arg(long, value_enum, default_value_t = Format::Table)]
    pub format: Format,
    /// Also write the result files into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// No progress and no remarks on stderr
    #[arg(short, long)]
    pub quiet: bool,
}

/// What generated items carry besides their position.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Item attributes")]
pub struct AttributeArgs {
    /// Item areas [cm^2]: const:V, uniform:LOW,HIGH, lognormal:MEDIAN,SIGMA, beta:A,B
    #[arg(long, value_name = "DIST")]
    pub area: Option<String>,
    /// Detection probabilities, a distribution as for --area
    #[arg(long, value_name = "DIST")]
    pub p_detection: Option<String>,
    /// Grasp probabilities, a distribution as for --area
    #[arg(long, value_name = "DIST")]
    pub p_grasp: Option<String>,
}

/// Find the rule for each robot that picks best whatever the pattern
///
/// Scores assignments of the dispatching rules on the same set of patterns, ranks them with paired 95 % intervals, breaks ties by the highest belt
/// speed at which everything is picked, and scores the winner again on fresh patterns.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline optimize --robots 3
  pickline optimize --station my-line.toml --patterns recorded/ --objective picked-share
  pickline optimize --robots 6 --search grasp --risk cvar:0.1 --format json")]
pub struct OptimizeArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    /// Patterns: balanced[:N] (N grids and N Poisson disk patterns over 0.15 to 0.4 m),
    /// grid:SPACING, poisson:RADIUS[:N], a CSV file or a folder of them
    #[arg(long, value_name = "SET", default_value = "balanced:120")]
    pub patterns: String,
    /// Items in each generated pattern [default: 150]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub items: Option<usize>,
    #[command(flatten)]
    pub attributes: AttributeArgs,
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
    /// Decisions at multiples of 1/HZ seconds only; 0 is exact
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub update_hz: f64,
    /// Lines of the ranking to print in the table
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        allow_negative_numbers = true
    )]
    pub top: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SearchArg {
    Auto,
    Exhaustive,
    Grasp,
    Both,
}

/// Set strategies side by side on the paper's cases or your own
///
/// Robust GT is the assignment that is best over a training set, greedy GT the best for
/// every single pattern. Differences to robust GT are paired over patterns, with 95 %
/// intervals. With --out DIR writes picked_time.csv, picking_rate.csv (the paper's Tables
/// 2 and 3), runs.csv (every run) and compare.json.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline compare --paper
  pickline compare --cases dense --strategy rules:SPT,SPT --out results/
  pickline compare --station my-line.toml --cases my-cases.toml

A case file is TOML, one [[case]] each:
  [[case]]
  name = \"dense\"
  poisson = 0.12        # radius [m]; or grid = SPACING, or pattern = \"FILE.csv\"
  items = 150")]
pub struct CompareArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    /// Cases: paper, dense, all, or a TOML file
    #[arg(long, value_name = "SET|FILE", default_value = "paper")]
    pub cases: String,
    /// A further strategy, written as for simulate; may be given several times
    #[arg(long, value_name = "STRATEGY")]
    pub strategy: Vec<String>,
    #[command(flatten)]
    pub training: TrainingArgs,
    /// Leave greedy GT out
    #[arg(long)]
    pub no_greedy: bool,
    /// Patterns of each random case
    #[arg(
        long,
        value_name = "N",
        default_value_t = 100,
        allow_negative_numbers = true
    )]
    pub replicates: usize,
    /// Print the paper's own figures beside ours
    #[arg(long)]
    pub paper: bool,
    /// Decisions at multiples of 1/HZ seconds only; 0 is exact
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub update_hz: f64,
}

/// Where robust GT comes from.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Robust GT")]
pub struct TrainingArgs {
    /// Its assignment instead of the best on the training set, the balanced set of
    /// `optimize`
    #[arg(long, value_name = "R1,R2,...")]
    pub robust: Option<String>,
    /// Items in each pattern of the training set
    #[arg(
        long,
        value_name = "N",
        default_value_t = 150,
        allow_negative_numbers = true
    )]
    pub train_items: usize,
}

/// Vary belt speed, robots, spacing or reach, and say how far up everything is picked
///
/// Answers how fast the belt may run, and whether one more robot or a slower belt is the
/// better buy. Prints picked share and rates at every value and, for each strategy, the
/// highest value up to which everything is picked, the first that misses an item and the
/// values above it at which everything is picked again.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline sweep
  pickline sweep --patterns poisson:0.15:100 --items 150 --strategy SPT,SPT --out results/
  pickline sweep --sweep robots --patterns balanced:20 --items 150")]
pub struct SweepArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    /// What is varied: speed, robots, spacing, reach
    #[arg(long, value_name = "NAME", default_value = "speed")]
    pub sweep: String,
    /// First value [default: from the station]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Last value [default: from the station]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Between two values [default: from the station]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub step: Option<f64>,
    /// Patterns, written as for optimize
    #[arg(long, value_name = "SET", default_value = "grid:0.15")]
    pub patterns: String,
    /// Items in each generated pattern [default: 50]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub items: Option<usize>,
    /// A further strategy, written as for simulate; may be given several times
    #[arg(long, value_name = "STRATEGY")]
    pub strategy: Vec<String>,
    /// With greedy GT, the assignment of the highest picking rate at every value
    #[arg(long)]
    pub greedy: bool,
    #[command(flatten)]
    pub training: TrainingArgs,
    /// Decisions at multiples of 1/HZ seconds only; 0 is exact
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub update_hz: f64,
}

/// Run one strategy on one pattern, exactly
///
/// Jumps from decision to decision; there is no time step. Says for every item that
/// was not picked why: unreachable, passed_over or busy.
#[derive(Debug, Args)]
#[command(after_long_help = simulate_help())]
pub struct SimulateArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    /// Pattern file (CSV), `-` for stdin; the grid of 0.15 m with 50 items when not given
    #[arg(long, value_name = "FILE")]
    pub pattern: Option<String>,
    /// Strategy: rules:R1,R2,... with one rule for each robot, upstream first
    /// [default: SPT for all but the last, FIFO for the last]
    #[arg(long, value_name = "STRATEGY")]
    pub strategy: Option<String>,
    /// Decisions at multiples of 1/HZ seconds only; 0 is exact
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub update_hz: f64,
    /// Have the independent checker verify the run; exit code 1 if it refutes it
    #[arg(long)]
    pub check: bool,
    /// Write every event of the run into this CSV file
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Write a replay of the run into this HTML file, to be opened in any browser
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// Generate, describe or import patterns
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline pattern generate poisson --radius 0.2 --count 29 --output p.csv
  pickline pattern describe p.csv
  pickline pattern import mot tracks.txt --fps 30 --scale 0.0015 --axis x --belt-speed 0.1")]
pub struct PatternArgs {
    #[command(subcommand)]
    pub command: Option<PatternCommand>,
}

#[derive(Debug, Subcommand)]
pub enum PatternCommand {
    /// Write a generated pattern as CSV
    #[command(after_long_help = "\
Example:
  pickline pattern generate poisson --radius 0.2 --count 29 --area lognormal:80,0.5")]
    Generate(Box<GenerateArgs>),
    /// Print the figures of a pattern
    #[command(after_long_help = "Example:\n  pickline pattern describe items.csv --format json")]
    Describe(DescribeArgs),
    /// Turn a recording of another program into a pattern
    #[command(subcommand)]
    Import(ImportCommand),
}

impl Default for PatternCommand {
    /// What `pickline pattern` alone does.
    fn default() -> Self {
        Self::Describe(DescribeArgs {
            file: None,
            belt_speed: 0.05,
            format: Format::Table,
        })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PatternKind {
    /// A square lattice
    Grid,
    /// A maximal Poisson disk sample
    Poisson,
}

#[derive(Debug, Args)]
pub struct GenerateArgs {
    /// Which kind
    #[arg(value_enum, default_value_t = PatternKind::Grid)]
    pub kind: PatternKind,
    /// Number of items [default: 50 for a grid, 29 for Poisson disk]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub count: Option<usize>,
    /// Grid: spacing [m] [default: 0.15]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub spacing: Option<f64>,
    /// Poisson disk: least distance between two items [m] [default: 0.2]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub radius: Option<f64>,
    /// Belt width [m] [default: the station's]
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub width: Option<f64>,
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub attributes: AttributeArgs,
    /// Seed of everything random
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// Write to this file instead of stdout
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct DescribeArgs {
    /// Pattern file (CSV), `-` for stdin; the grid of 0.15 m with 50 items when not given
    pub file: Option<String>,
    /// Belt speed [m/s] for the arrival rate
    #[arg(
        long,
        value_name = "V",
        default_value_t = 0.05,
        allow_negative_numbers = true
    )]
    pub belt_speed: f64,
    /// How the figures are printed
    #[arg(long, value_enum, default_value_t = Format::Table)]
    pub format: Format,
}

#[derive(Debug, Subcommand)]
pub enum ImportCommand {
    /// From a tracker's MOTChallenge text file
    ///
    /// One item a track: its belt position from all its frames, its area from the
    /// box, its detection probability from the confidence. What was dropped and why is
    /// told on stderr.
    #[command(after_long_help = "\
Example:
  pickline pattern import mot tracks.txt --fps 30 --scale 0.0015 --axis x \\
      --belt-speed 0.1 --output p.csv")]
    Mot(Box<MotArgs>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AxisArg {
    /// The belt travels along the image's x axis
    X,
    /// The belt travels along the image's y axis
    Y,
}

#[derive(Debug, Args)]
pub struct MotArgs {
    /// The tracker's file: frame,id,left,top,width,height,conf,...
    pub file: PathBuf,
    /// Frames per second of the recording
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub fps: f64,
    /// Metres per pixel on the belt
    #[arg(long, value_name = "M_PER_PX", allow_negative_numbers = true)]
    pub scale: f64,
    /// The image axis along which the belt travels
    #[arg(long, value_enum)]
    pub axis: AxisArg,
    /// The belt travels towards smaller pixel values
    #[arg(long)]
    pub reverse: bool,
    /// Belt speed during the recording [m/s]
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub belt_speed: f64,
    /// Pixel of the belt's centre line across the travel [default: midway between the
    /// outermost items]
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    pub centre_px: Option<f64>,
    /// Tracks seen in fewer frames are dropped
    #[arg(
        long,
        value_name = "N",
        default_value_t = 2,
        allow_negative_numbers = true
    )]
    pub min_frames: usize,
    /// An id that jumps by more along the belt is another item [m]
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.1,
        allow_negative_numbers = true
    )]
    pub split_distance: f64,
    /// Tracks one after the other that agree this well are one item [m]
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.02,
        allow_negative_numbers = true
    )]
    pub merge_distance: f64,
    /// Write to this file instead of stdout
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Also write what was dropped, split and merged, and why, into this JSON file
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Do not tell on stderr what was dropped
    #[arg(short, long)]
    pub quiet: bool,
}

/// Show, check or start a station file
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline station show --robots 3
  pickline station init my-line.toml && pickline station check my-line.toml")]
pub struct StationArgs {
    #[command(subcommand)]
    pub command: Option<StationCommand>,
}

#[derive(Debug, Subcommand)]
pub enum StationCommand {
    /// Print the resolved station as TOML
    #[command(after_long_help = "Example:\n  pickline station show --robots 3 --svg station.svg")]
    Show {
        #[command(flatten)]
        station: StationChoice,
        /// Also draw the station into this SVG file
        #[arg(long, value_name = "FILE")]
        svg: Option<PathBuf>,
        /// With the items of this pattern file (CSV) on the belt instead of random ones
        #[arg(long, value_name = "FILE", requires = "svg")]
        pattern: Option<String>,
    },
    /// Check a station file and say what it amounts to
    #[command(after_long_help = "Example:\n  pickline station check my-line.toml")]
    Check {
        /// The file, or a built-in station
        #[arg(default_value = "paper")]
        file: String,
    },
    /// Write a commented station file to start from
    #[command(after_long_help = "Example:\n  pickline station init my-line.toml")]
    Init {
        /// Where to; stdout when not given
        file: Option<PathBuf>,
        /// Overwrite the file if it exists
        #[arg(long)]
        force: bool,
    },
}

impl Default for StationCommand {
    /// What `pickline station` alone does.
    fn default() -> Self {
        Self::Show {
            station: StationChoice {
                station: "paper".into(),
                robots: None,
                belt_speed: None,
            },
            svg: None,
            pattern: None,
        }
    }
}

/// What can be simulated, from the registries, and examples.
fn simulate_help() -> String {
    let mut help = "Strategies:\n".to_owned();
    for kind in crate::strategies::STRATEGIES {
        help += &format!("  {:<18}{}\n", kind.form, kind.summary);
    }
    help += "\nRules, each picking the candidate with the smallest key:\n";
    for rule in crate::dispatch::RULES {
        help += &format!(
            "  {:<6}{:<26}{}\n",
            rule.name(),
            rule.title(),
            rule.key_text()
        );
    }
    help += "\nBuilt-in stations:\n";
    for built_in in crate::station::BUILT_INS {
        help += &format!("  {:<14}{}\n", built_in.name, built_in.summary);
    }
    help + "\n\
Examples:
  pickline simulate --strategy rules:SPT,FIFO --format json
  pickline pattern generate poisson | pickline simulate --pattern - --check
  pickline simulate --station my-line.toml --pattern items.csv --trace events.csv
  pickline simulate --robots 3 --html replay.html"
}

/// Solve the line as a game: robots are players, rules their actions
///
/// Finds all pure Nash equilibria of a line of up to four robots, the social optimum,
/// the prices of anarchy and of stability, where iterated best response ends from every
/// start, and the rules that are dominated. `--nfg` writes the game for Gambit.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline game --robots 3 --payoff total
  pickline game --station my-line.toml --patterns recorded/ --out game/
  pickline game --format csv --nfg line.nfg")]
pub struct GameArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    /// Patterns: balanced[:N] (N grids and N Poisson disk patterns over 0.15 to 0.4 m),
    /// grid:SPACING, poisson:RADIUS[:N], a CSV file or a folder of them
    #[arg(long, value_name = "SET", default_value = "balanced:120")]
    pub patterns: String,
    /// Items in each generated pattern [default: 150]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub items: Option<usize>,
    #[command(flatten)]
    pub attributes: AttributeArgs,
    /// What each robot is paid
    #[arg(long, value_enum, default_value_t = PayoffArg::Own, help_heading = "Game")]
    pub payoff: PayoffArg,
    /// Write the game into this file, in Gambit's strategic game format; `-` prints it
    /// instead of the result
    #[arg(long, value_name = "FILE", help_heading = "Game")]
    pub nfg: Option<PathBuf>,
    /// Decisions at multiples of 1/HZ seconds only; 0 is exact
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub update_hz: f64,
    /// Equilibria and cycles to print in the table
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        allow_negative_numbers = true
    )]
    pub top: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PayoffArg {
    /// Its own picks per minute
    Own,
    /// The line's picks per minute
    Total,
}
