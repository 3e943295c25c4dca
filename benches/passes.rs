//! All assignments of a few lines, in one engine after the other: the part in Rust of
//! `tests/simpy/benchmark.py`, which runs the same lines in SimPy.
//!
//! `--write DIR` writes station, pattern and all picks of each line; `--time LINE` prints how long each
//! engine takes for one assignment [s], how many passes of a robot it makes for it, and how long the square
//! roots alone would take that rank every candidate of every decision of these passes [s]. Without either,
//! only what both engines return is compared.

use pickline::decision::{Figures, Strategy};
use pickline::dispatch::{Rule, RuleAssignment, RuleStrategy};
use pickline::pattern::{Pattern, grid, poisson_disk, random_stream, to_csv};
use pickline::sim::{AssignmentTree, Run, RunBuffers, Scene, simulate_rules};
use pickline::station::{Station, built_in, to_toml};
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// How long each engine is timed at least.
const LEAST: Duration = Duration::from_millis(400);

/// What one assignment costs.
struct Cost {
    engine: &'static str,
    seconds: f64,
    /// Passes of one robot.
    passes: f64,
    /// Time of its square roots alone [s].
    roots: f64,
}

/// Time [s] for which this thread has had a processor, so that others on the machine count less; without
/// Linux, just the time.
fn processor_time() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let read = || -> Option<f64> {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        text.split_whitespace().next()?.parse().ok()
    };
    read().map_or_else(|| START.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

/// How long `work` takes [s]: the mean of as many rounds as fit into [`LEAST`].
fn seconds(work: impl Fn() -> usize) -> f64 {
    let (start, began) = (Instant::now(), processor_time());
    let mut rounds = 0;
    while start.elapsed() < LEAST {
        black_box(work());
        rounds += 1;
    }
    (processor_time() - began) / f64::from(rounds)
}

/// How long a square root takes [s] among many, which vector instructions compute.
fn root_seconds() -> f64 {
    let roots = || {
        let mut numbers = black_box([2.0_f64; 4096]);
        for number in &mut numbers {
            *number = number.sqrt();
        }
        black_box(numbers).len()
    };
    seconds(roots) / 4096.0
}

struct Line {
    name: String,
    station: Station,
    pattern: Pattern,
    tree: AssignmentTree,
}

fn lines() -> Vec<Line> {
    let mut lines = Vec::new();
    for robots in [2, 4] {
        let station = built_in("paper").unwrap().station(Some(robots)).unwrap();
        let width = station.belt().width;
        let random = poisson_disk(width, 0.15, 150, &mut random_stream(1, 0)).unwrap();
        for (kind, pattern) in [
            ("grid", grid(width, 0.15, 150).unwrap()),
            ("poisson", random),
        ] {
            lines.push(Line {
                name: format!("{kind}-{robots}"),
                station: station.clone(),
                pattern,
                tree: AssignmentTree::all(robots),
            });
        }
    }
    lines
}

impl Line {
    fn scene(&self) -> Scene<'_> {
        Scene::new(&self.station, &self.pattern).unwrap()
    }

    /// Items that all assignments pick, by the tree, and the passes that it took.
    fn by_tree(&self, scene: &Scene) -> (usize, u64) {
        let mut picked = 0;
        let visit = |_, figures: Figures, _: &[usize]| picked += figures.picked;
        let passes = self.tree.evaluate_passes(scene, || true, visit).unwrap();
        (picked, passes.unwrap())
    }

    /// The same by the event loop, one by one.
    fn one_by_one(&self, scene: &Scene) -> usize {
        let mut picked = 0;
        let mut buffers = RunBuffers::default();
        for rules in self.tree.assignments() {
            let mut run = Run::with_buffers(scene, buffers);
            run.play(&mut RuleStrategy(rules.clone())).unwrap();
            picked += run.figures().picked;
            buffers = run.into_buffers();
        }
        picked
    }

    /// The same with the windows computed anew for each assignment.
    fn with_windows_anew(&self) -> usize {
        let run = |rules: &RuleAssignment| {
            let outcome = simulate_rules(&self.scene(), rules).unwrap();
            outcome.figures.picked
        };
        self.tree.assignments().iter().map(run).sum()
    }

    /// Candidates over all decisions of all assignments: in the passes of the tree, and one by one.
    fn candidates(&self, scene: &Scene) -> (usize, usize) {
        let (mut shared, mut all) = (0, 0);
        for assignment in self.tree.assignments() {
            let mut strategy = RuleStrategy(assignment.clone());
            let mut run = Run::new(scene);
            while let Some(snapshot) = run.next_decision() {
                let count = snapshot.candidates.len();
                all += count;
                // The first assignment that begins like this one up to this robot.
                let rest = &assignment.rules()[snapshot.robot + 1..];
                if rest.iter().all(|rule| *rule == Rule::FIFO) {
                    shared += count;
                }
                let action = strategy.decide(&snapshot);
                run.act(action).unwrap();
            }
        }
        (shared, all)
    }

    /// What one assignment costs, by each engine.
    fn costs(&self) -> [Cost; 3] {
        let scene = self.scene();
        let assignments = self.tree.assignments().len() as f64;
        let robots = self.station.robots().len() as f64;
        let shared = self.by_tree(&scene).1 as f64 / assignments;
        let (in_tree, one_by_one) = self.candidates(&scene);
        let root = root_seconds();
        let cost = |engine, passes, candidates: usize, work: &dyn Fn() -> usize| Cost {
            engine,
            seconds: seconds(work) / assignments,
            passes,
            roots: candidates as f64 * root / assignments,
        };
        [
            cost("tree", shared, in_tree, &|| self.by_tree(&scene).0),
            cost("event loop", robots, one_by_one, &|| {
                self.one_by_one(&scene)
            }),
            cost("event loop and windows", robots, one_by_one, &|| {
                self.with_windows_anew()
            }),
        ]
    }

    /// All picks of the event loop, after comparing the figures of both engines.
    fn picks(&self) -> String {
        let scene = self.scene();
        let mut text = String::from("assignment,robot,item,decide_s,grasp_s,release_s\n");
        let compare = |place: usize, figures| {
            let rules = &self.tree.assignments()[place];
            let outcome = simulate_rules(&scene, rules).unwrap();
            assert_eq!(outcome.figures, figures, "{} {rules}", self.name);
            for pick in outcome.picks {
                let (robot, item) = (pick.robot, pick.item);
                let (decide, grasp, release) = (pick.decide, pick.grasp, pick.release);
                let names = rules.names().join(" ");
                writeln!(text, "{names},{robot},{item},{decide},{grasp},{release}").unwrap();
            }
        };
        self.tree.evaluate(&scene, compare).unwrap();
        text
    }

    fn write(&self, folder: &Path) {
        let path = |kind: &str| folder.join(format!("{}{kind}", self.name));
        std::fs::write(path(".toml"), to_toml(&self.station)).unwrap();
        std::fs::write(path(".csv"), to_csv(&self.pattern)).unwrap();
        std::fs::write(path("-picks.csv"), self.picks()).unwrap();
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |flag: &str| {
        let place = arguments.iter().position(|argument| argument == flag)?;
        arguments.get(place + 1)
    };
    for line in lines() {
        if let Some(folder) = value("--write") {
            line.write(Path::new(folder));
        } else if let Some(name) = value("--time") {
            if *name == line.name {
                for cost in line.costs() {
                    let Cost {
                        engine,
                        seconds,
                        passes,
                        roots,
                    } = cost;
                    println!("{engine},{seconds},{passes},{roots}");
                }
            }
        } else {
            assert_eq!(line.by_tree(&line.scene()).0, line.with_windows_anew());
            line.picks();
        }
    }
}
