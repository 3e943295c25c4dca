//! Purity and recovery: what truly went into the bins of a run, and what should have gone there.

use crate::decision::Pick;
use crate::sim::{Scene, TrueClass};
use crate::station::Station;
use crate::stats::{Interval, pooled_share_interval};

/// What was put into one or several bins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct BinContent {
    /// Number of items that were put into them.
    pub binned: usize,
    /// How many of those belong there: the robot would have put their true class into the same bin.
    pub rightly_binned: usize,
    /// Number of items on the belt that belong there, picked or not.
    pub due: usize,
}

impl BinContent {
    /// The share of what was put in that belongs there; `None` if nothing was put in.
    pub fn purity(&self) -> Option<f64> {
        (self.binned > 0).then(|| self.rightly_binned as f64 / self.binned as f64)
    }

    /// The share of what belongs there that was put in; `None` if nothing belongs there.
    pub fn recovery(&self) -> Option<f64> {
        (self.due > 0).then(|| self.rightly_binned as f64 / self.due as f64)
    }

    fn add(&mut self, other: &Self) {
        self.binned += other.binned;
        self.rightly_binned += other.rightly_binned;
        self.due += other.due;
    }
}

/// What the bins of a run contain.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct BinContents {
    /// All bins together.
    pub total: BinContent,
    /// The bins by name, in the order of the station. Bins of several robots with the same name are
    /// one. An item is due in every bin that some robot would put it into.
    pub bins: Vec<(String, BinContent)>,
}

/// The names of the bins of `station`, each once.
fn bin_names(station: &Station) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for bin in station.robots().iter().flat_map(|robot| &robot.bins) {
        if !names.contains(&bin.name.as_str()) {
            names.push(&bin.name);
        }
    }
    names
}

/// What `picks`, those of a run on `scene`, put into the bins. Takes O(n N) for n items and N robots.
pub fn bin_contents(scene: &Scene, picks: &[Pick]) -> BinContents {
    let (station, items) = (scene.station(), scene.pattern().items());
    let chance = &scene.conditions().disturbances;
    let names = bin_names(station);
    let mut total = BinContent::default();
    let mut bins = vec![BinContent::default(); names.len()];
    let mut due = vec![false; names.len()];
    for (item, index) in items.iter().zip(0u32..) {
        let TrueClass::Of(class) = chance.true_class(index, item) else {
            continue;
        };
        let class = station.class_id(class);
        if !station.takes(class) {
            continue;
        }
        total.due += 1;
        due.fill(false);
        for (place, robot) in station.robots().iter().enumerate() {
            let bin = station.bin_for(place, class);
            let bin = bin.map(|bin| robot.bins[usize::from(bin)].name.as_str());
            if let Some(name) = bin.and_then(|bin| names.iter().position(|name| *name == bin)) {
                due[name] = true;
            }
        }
        for (bin, due) in bins.iter_mut().zip(&due) {
            bin.due += usize::from(*due);
        }
    }
    for pick in picks {
        let bin = &station.robots()[pick.robot].bins[usize::from(pick.bin)];
        let item = &items[pick.item as usize];
        let belongs = match chance.true_class(pick.item, item) {
            TrueClass::Nothing => false,
            TrueClass::Of(class) => {
                let class = station.class_id(class);
                station.takes(class) && station.bin_for(pick.robot, class) == Some(pick.bin)
            }
        };
        let one = BinContent {
            binned: 1,
            rightly_binned: usize::from(belongs),
            due: 0,
        };
        total.add(&one);
        if let Some(place) = names.iter().position(|name| *name == bin.name) {
            bins[place].add(&one);
        }
    }
    let names = names.into_iter().map(str::to_owned);
    BinContents {
        total,
        bins: names.zip(bins).collect(),
    }
}

/// Purity and recovery over several runs: all their items together, with intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Purity {
    /// What all runs together put into the bins.
    pub content: BinContent,
    /// 95 % interval of the purity; `None` for a single run, as for the next.
    pub purity_interval: Option<Interval>,
    /// 95 % interval of the recovery.
    pub recovery_interval: Option<Interval>,
}

impl Purity {
    /// The figures of `runs`.
    fn of(runs: &[BinContent]) -> Self {
        let mut content = BinContent::default();
        runs.iter().for_each(|run| content.add(run));
        let interval = |trials: fn(&BinContent) -> usize| {
            let samples = runs.iter().map(|run| (run.rightly_binned, trials(run)));
            pooled_share_interval(&samples.collect::<Vec<_>>())
        };
        Self {
            content,
            purity_interval: interval(|run| run.binned),
            recovery_interval: interval(|run| run.due),
        }
    }

    /// The share of what was binned that belongs there; `None` if nothing was binned.
    pub fn purity(&self) -> Option<f64> {
        self.content.purity()
    }

    /// The share of what belongs into the bins that was put there; `None` if nothing does.
    pub fn recovery(&self) -> Option<f64> {
        self.content.recovery()
    }
}

/// Purity and recovery over several runs, in total and for each bin.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PurityByBin {
    /// All bins together.
    pub total: Purity,
    /// The bins by name, in the order of the station.
    pub bins: Vec<(String, Purity)>,
}

impl PurityByBin {
    /// The figures of `runs` of one station; `None` without runs.
    pub fn of(runs: &[&BinContents]) -> Option<Self> {
        let first = runs.first()?;
        let all = |of: &dyn Fn(&BinContents) -> BinContent| -> Purity {
            Purity::of(&runs.iter().map(|run| of(run)).collect::<Vec<_>>())
        };
        let bins = first.bins.iter().enumerate();
        let bins = bins.map(|(place, (name, _))| (name.clone(), all(&|run| run.bins[place].1)));
        Some(Self {
            total: all(&|run| run.total),
            bins: bins.collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Item, Pattern};
    use crate::sim::{Conditions, Disturbances, simulate_rules};
    use crate::station::{self, Overrides};

    /// A line that picks whatever it is offered: r1 has bins for pet and for two plastics that share
    /// one, r2 takes the rest.
    fn station() -> Station {
        let text = "\
            belt = { speed = 0.1, length = 3.0, width = 0.6 }\n\
            [[class]]\nname = \"wood\"\nwanted = false\n\
            [[robot]]\nname = \"r1\"\nbase = [0.7, -0.4]\nreach = 0.8\nspeed = 50.0\ngrasp_time = 0.0\nrelease_time = 0.0\n\
            [[robot.bin]]\nname = \"pet\"\nat = [0.7, -0.5]\nclasses = [\"pet\"]\n\
            [[robot.bin]]\nname = \"mixed\"\nat = [0.8, -0.5]\nclasses = [\"pp\", \"hdpe\"]\n\
            [[robot]]\nname = \"r2\"\nbase = [2.2, -0.4]\nreach = 0.7\nspeed = 50.0\ngrasp_time = 0.0\nrelease_time = 0.0\n\
            [[robot.bin]]\nname = \"rest\"\nat = [2.2, -0.5]\n\
            [[robot.bin]]\nname = \"pet\"\nat = [2.3, -0.5]\nclasses = [\"pet\"]\n";
        station::parse(text, "line.toml", Overrides::default()).unwrap()
    }

    fn pattern(items: &[(&str, &str)]) -> Pattern {
        let items = items.iter().enumerate().map(|(place, (class, truth))| {
            let some = |text: &str| (!text.is_empty()).then(|| text.to_owned());
            Item {
                class: some(class),
                true_class: some(truth),
                ..Item::at(place.to_string(), -0.5 * place as f64, 0.0)
            }
        });
        Pattern::new(items.collect()).unwrap()
    }

    fn contents(items: &[(&str, &str)], conditions: Conditions) -> BinContents {
        let (station, pattern) = (station(), pattern(items));
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let outcome = simulate_rules(&scene, &"FIFO,FIFO".parse().unwrap()).unwrap();
        bin_contents(&scene, &outcome.picks)
    }

    fn content(binned: usize, rightly_binned: usize, due: usize) -> BinContent {
        BinContent {
            binned,
            rightly_binned,
            due,
        }
    }

    /// By hand: what is in each bin, and what should be.
    #[test]
    fn every_item_counts_where_it_is_and_where_it_belongs() {
        let wrong = Disturbances::default().with_misdetections(true);
        let conditions = Conditions::default().with_disturbances(wrong);
        let items = [
            ("pet", "pet"),
            ("pet", "wood"),
            ("pet", "hdpe"),
            ("pet", "-"),
            // Mistaken for one another, but they share a bin.
            ("hdpe", "pp"),
            // Left on the belt as wood.
            ("wood", "pet"),
            ("wood", "wood"),
            ("glass", "glass"),
            // Both go to the rest.
            ("glass", "steel"),
            ("", ""),
        ];
        let found = contents(&items, conditions);
        let bins = [
            // Due are the first item and the one that was taken for wood.
            ("pet", content(4, 1, 2)),
            // Due are hdpe and pp.
            ("mixed", content(1, 1, 2)),
            // What r1 has bins for, r2 would put to the rest: hdpe, pp, glass, steel, unknown.
            ("rest", content(3, 3, 5)),
        ];
        let bins = bins.map(|(name, content)| (name.to_owned(), content));
        assert_eq!(found.bins, bins);
        assert_eq!(found.total, content(8, 5, 7));
        assert_eq!(found.total.purity(), Some(5.0 / 8.0));
        assert_eq!(found.total.recovery(), Some(5.0 / 7.0));
        // Without misdetections everything is what it is reported as.
        let plain = contents(&items, Conditions::default());
        assert_eq!(plain.total, content(8, 8, 8));
    }

    #[test]
    fn nothing_binned_has_no_purity_and_nothing_due_no_recovery() {
        let none = contents(&[("wood", ""), ("wood", "")], Conditions::default());
        assert_eq!(none.total, content(0, 0, 0));
        assert_eq!((none.total.purity(), none.total.recovery()), (None, None));
        let wrong = Disturbances::default().with_misdetections(true);
        let conditions = Conditions::default().with_disturbances(wrong);
        let foreign = contents(&[("pet", "wood")], conditions);
        assert_eq!(foreign.total, content(1, 0, 0));
        assert_eq!(foreign.total.purity(), Some(0.0));
        assert_eq!(foreign.total.recovery(), None);
    }

    #[test]
    fn runs_are_pooled() {
        let run = |total| BinContents {
            total,
            bins: vec![("pet".into(), total)],
        };
        let runs = [run(content(10, 9, 12)), run(content(30, 24, 40))];
        let pooled = PurityByBin::of(&[&runs[0], &runs[1]]).unwrap();
        assert_eq!(pooled.total.content, content(40, 33, 52));
        assert_eq!(pooled.total.purity(), Some(33.0 / 40.0));
        let expected = pooled_share_interval(&[(9, 10), (24, 30)]);
        assert_eq!(pooled.total.purity_interval, expected);
        let expected = pooled_share_interval(&[(9, 12), (24, 40)]);
        assert_eq!(pooled.total.recovery_interval, expected);
        assert_eq!(pooled.bins, [("pet".to_owned(), pooled.total)]);
        let one = PurityByBin::of(&[&runs[0]]).unwrap();
        assert_eq!(one.total.purity_interval, None);
        assert_eq!(PurityByBin::of(&[]), None);
    }
}
