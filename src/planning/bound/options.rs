//! Options of a bound: the objective, and how hard the search tries.

use super::network::{SlotNetwork, Slots, latest_release, picks};
use crate::decision::Moment;
use crate::error::{Error, Result, shown_number};
use crate::setters::setters;
use crate::sim::Scene;

/// What a bound limits from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoundObjective {
    /// The number of items picked.
    Picks,
    /// The sum of the weights of the items picked.
    Weight,
}

/// How hard the search tries. The same options give the same bound on every machine.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct BoundOptions {
    /// What the bound limits from above.
    pub objective: BoundObjective,
    /// Length of the slots [s]; chosen from the processing times if `None`.
    pub slot_s: Option<f64>,
    /// Maximum number of steps of the prices; the bounds of end and rate may take as many
    /// again with each of the slot lengths that are tried, at most three.
    pub iterations: usize,
    /// Whether end and rate are bounded as well; otherwise their bounds are trivial.
    pub ends: bool,
    /// Whether to look for a schedule to compare with the bound.
    pub schedule: bool,
    /// What some schedule is known to earn; the search ends when the bound reaches it.
    pub known: f64,
    /// Maximum number of picks in slots; slots are made long enough for that.
    pub arcs: usize,
    /// For each item of the pattern, whether picking it counts, such as the items of one class;
    /// all count if `None`. The others may be picked, but are worth nothing. There is no schedule
    /// then.
    pub counted: Option<Vec<bool>>,
}

impl Default for BoundOptions {
    fn default() -> Self {
        Self {
            objective: BoundObjective::Picks,
            slot_s: None,
            iterations: 200,
            ends: true,
            schedule: true,
            known: 0.0,
            arcs: 2_000_000,
            counted: None,
        }
    }
}

setters!(BoundOptions {
    /// With this quantity bounded.
    fn with_objective(objective: BoundObjective);
    /// With slots of this length [s], or of one that fits the processing times.
    fn with_slot_s(slot_s: impl Into<Option<f64>>);
    /// With this maximum number of steps of the prices.
    fn with_iterations(iterations: usize);
    /// With end and rate bounded as well, or not.
    fn with_ends(ends: bool);
    /// With a schedule to compare with the bound, or without one.
    fn with_schedule(schedule: bool);
    /// With this known to be earned by some schedule.
    fn with_known(known: f64);
    /// With this maximum number of picks in slots.
    fn with_arcs(arcs: usize);
    /// With only these items worth anything, one entry for each, or all of them.
    fn with_counted(counted: impl Into<Option<Vec<bool>>>);
});

impl BoundOptions {
    /// For a pattern of `items` items if only the bound is wanted: time and memory grow in
    /// proportion, so that slots of long patterns are no longer than those of short ones, up to a
    /// limit.
    pub fn in_full(objective: BoundObjective, items: usize) -> Self {
        let usual = Self::default();
        // Twice as many as beside runs.
        let short = in_proportion(usual.arcs, items, 2 * MOST_BESIDE);
        let long = items.saturating_mul(ARCS_PER_ITEM).min(MOST_IN_FULL);
        Self {
            objective,
            arcs: short.max(long),
            ..usual
        }
    }

    /// For bounds as a by-product of reports: less than half a second on a typical pattern.
    pub fn quick(objective: BoundObjective) -> Self {
        Self {
            objective,
            schedule: false,
            arcs: QUICK_ARCS,
            iterations: QUICK_ITERATIONS,
            ..Self::default()
        }
    }

    /// The same for comparing runs on a pattern of `items` items, the best of which picks
    /// `picked`: a bound that a run reaches cannot be improved. A longer pattern gets
    /// proportionally more time; otherwise its slots would be too long to prove anything.
    pub fn beside(picked: usize, items: usize) -> Self {
        Self {
            known: picked as f64,
            arcs: in_proportion(QUICK_ARCS, items, MOST_BESIDE),
            ..Self::quick(BoundObjective::Picks)
        }
    }
}

/// `arcs` for a pattern of typical length, proportionally more for one of more than that many
/// `items`, up to `most`.
fn in_proportion(arcs: usize, items: usize, most: usize) -> usize {
    let share = (items as f64 / USUAL_ITEMS as f64).max(1.0);
    (arcs as f64 * share).min(most as f64) as usize
}

/// Maximum number of picks in slots for bounds in reports, on a pattern of typical length.
const QUICK_ARCS: usize = 600_000;
/// Steps of the prices for bounds in reports.
const QUICK_ITERATIONS: usize = 100;
const USUAL_ITEMS: usize = 150;
/// Maximum number of picks in slots for a pattern of any length: several patterns are bounded
/// at the same time, and this many picks take about 100 MB.
const MOST_BESIDE: usize = 4_000_000;
/// Picks in slots per item if only the bound of a long pattern is wanted, and their maximum in
/// total; these take about 500 MB.
const ARCS_PER_ITEM: usize = 2000;
const MOST_IN_FULL: usize = 20_000_000;
/// Slots are coarse if they are longer than this share of a mean pick.
const COARSE: f64 = 0.05;

/// How many times longer the slots are with which the search for prices begins.
const LONGER: [f64; 2] = [10.0, 3.0];
/// The longest of them, as a share of a mean pick.
const LONGEST: f64 = 0.25;

/// Shortest and longest allowed slot [s].
const SLOT_RANGE: (f64, f64) = (1e-6, 1e6);
/// Maximum number of picks in slots that fit into memory.
const MOST_ARCS: f64 = 5e7;
/// With more slots than this in a day, their times are no longer distinct.
const MOST_SLOTS: f64 = 1e14;
/// Slots per mean processing time, unless there would be too many in total.
const SLOTS_PER_PICK: f64 = 200.0;

/// The chosen slots, and whether limits on memory or time make them so long that the bound is
/// weak.
pub(super) struct Chosen {
    /// The slots of the bound, after longer ones with which prices are found sooner.
    pub levels: Vec<Slots>,
    pub coarse: bool,
}

/// The slots for `scene`; `None` if there are too many items for useful slots.
///
/// # Errors
/// An invalid length, or one so short that the picks do not fit into memory.
pub(super) fn choose_slots(scene: &Scene, options: &BoundOptions) -> Result<Option<Chosen>> {
    let robots = 0..scene.station().robots().len();
    let size = |slots: Slots| -> f64 {
        let sizes = robots
            .clone()
            .map(|r| SlotNetwork::size(picks(scene, r), slots));
        sizes.sum()
    };
    let queued: usize = robots.clone().map(|robot| scene.queue(robot).len()).sum();
    if options.slot_s.is_none() && queued > options.arcs {
        return Ok(None);
    }
    let last = robots.clone().flat_map(|robot| {
        picks(scene, robot)
            .map(move |(c, place)| latest_release(scene.station(), robot, (&c, place)))
    });
    let last = last.fold(0.0, f64::max);
    let (mut sum, mut count) = (0.0, 0.0);
    for robot in robots.clone() {
        for (candidate, place) in picks(scene, robot) {
            let middle = 0.5 * (candidate.open + candidate.close);
            let moment = Moment::new(scene.station(), robot, place, middle);
            sum += moment.processing_time(&candidate);
            count += 1.0;
        }
    }
    let mean = if count > 0.0 { sum / count } else { 0.0 };
    if let Some(length) = options.slot_s {
        let slots = Slots { length };
        check_slot(length, &|| size(slots), last)?;
        let coarse = false;
        let levels = levels(length, mean);
        return Ok(Some(Chosen { levels, coarse }));
    }
    // A mean of 0 is a line whose picks take no time; any slot is suitable.
    let wanted = (mean / SLOTS_PER_PICK).clamp(SLOT_RANGE.0, SLOT_RANGE.1);
    let fits =
        |length: f64| size(Slots { length }) <= options.arcs as f64 && last / length <= MOST_SLOTS;
    // Lengths that a user would write: 1, 2, 5, 10, ... times a power of ten.
    let exponent = wanted.log10().floor() as i32;
    let lengths = (exponent..exponent + 14).flat_map(|exponent| {
        let power = 10f64.powi(exponent.abs());
        [1.0, 2.0, 5.0].map(|digit| {
            if exponent < 0 {
                digit / power
            } else {
                digit * power
            }
        })
    });
    let mut lengths = lengths.skip_while(|length| *length * 1.999 < wanted);
    let length = lengths.find(|&length| fits(length));
    // With slots longer than a pick, the bound proves almost nothing.
    Ok(length
        .filter(|&length| count == 0.0 || length <= mean.max(wanted))
        .map(|length| Chosen {
            levels: levels(length, mean),
            coarse: length > COARSE * mean.max(SLOTS_PER_PICK * wanted),
        }))
}

/// Slots of `length` [s] after longer ones, where a pick takes `mean` [s].
fn levels(length: f64, mean: f64) -> Vec<Slots> {
    let longer = LONGER.map(|factor| length * factor);
    let useful = longer
        .into_iter()
        .filter(|longer| *longer <= mean * LONGEST);
    useful
        .chain([length])
        .map(|length| Slots { length })
        .collect()
}

/// Checks a slot of this length [s] that the user asks for: `arcs` is the number of picks in slots,
/// and `last` [s] the end of the last one.
fn check_slot(length: f64, arcs: &dyn Fn() -> f64, last: f64) -> Result<()> {
    if !(SLOT_RANGE.0..=SLOT_RANGE.1).contains(&length) {
        let (low, high) = SLOT_RANGE;
        return Err(Error::usage(
            "'slot'",
            format!("{} is not a valid slot length", shown_number(length)),
            format!("give seconds, from {low:e} to {high:e}, such as 0.05"),
        ));
    }
    let arcs = arcs();
    if arcs > MOST_ARCS || last / length > MOST_SLOTS {
        return Err(Error::usage(
            "'slot'",
            format!(
                "{} s is too short for this pattern: {arcs:.1e} picks in slots, at most \
                 {MOST_ARCS:.0e} fit",
                shown_number(length)
            ),
            "give a longer slot, or omit 'slot' to choose one automatically",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Item, Pattern, grid};
    use crate::station::{Belt, Station, built_in};

    /// A line with one robot whose picks take `pick` seconds, and one item.
    fn line(pick: f64) -> (Station, Pattern) {
        let plain = built_in("paper").unwrap().station(Some(1)).unwrap();
        let pattern = Pattern::new(vec![Item::at("0", 0.0, -0.5)]).unwrap();
        let with = |grasp_time: f64| {
            let robot = plain.robots()[0].clone().with_dwell(grasp_time, 0.0);
            Station::new(*plain.belt(), vec![robot]).unwrap()
        };
        let station = with(0.0);
        let scene = Scene::new(&station, &pattern).unwrap();
        let item = &scene.queue(0)[0];
        let middle = 0.5 * (item.open + item.close);
        let way = Moment::new(&station, 0, 0, middle).processing_time(item);
        (with(pick - way), pattern)
    }

    fn finest(chosen: &Chosen) -> f64 {
        chosen.levels.last().unwrap().length
    }

    fn chosen(scene: &Scene, options: &BoundOptions) -> Option<(f64, bool)> {
        let chosen = choose_slots(scene, options).unwrap();
        chosen.map(|chosen| (finest(&chosen), chosen.coarse))
    }

    #[test]
    fn options_grow_with_the_pattern_as_documented() {
        use BoundObjective::{Picks, Weight};
        for (items, arcs) in [
            (0, 2_000_000),
            (150, 2_000_000),
            (300, 4_000_000),
            (601, 8_000_000),
            (4000, 8_000_000),
            (4001, 8_002_000),
            (9999, 19_998_000),
            (usize::MAX, 20_000_000),
        ] {
            let options = BoundOptions::in_full(Weight, items);
            assert_eq!((options.arcs, options.objective), (arcs, Weight), "{items}");
            assert!(options.schedule && options.ends && options.slot_s.is_none());
            assert_eq!((options.iterations, options.known), (200, 0.0));
        }
        let quick = BoundOptions::quick(Weight);
        assert_eq!(
            (quick.arcs, quick.objective, quick.schedule),
            (600_000, Weight, false)
        );
        assert!(quick.ends && quick.iterations == 100 && quick.known == 0.0);
        for (items, arcs) in [
            (1, 600_000),
            (150, 600_000),
            (300, 1_200_000),
            (10_000_000, 4_000_000),
        ] {
            let options = BoundOptions::beside(7, items);
            assert_eq!((options.arcs, options.known), (arcs, 7.0), "{items}");
            assert_eq!((options.objective, options.schedule), (Picks, false));
        }
        assert_eq!(BoundOptions::default().arcs, 2_000_000);
    }

    /// The smallest of 1, 2 and 5 times a power of ten that is at least half of a two-hundredth of
    /// a mean pick.
    #[test]
    fn slots_are_a_two_hundredth_of_a_pick() {
        for (pick, length) in [
            (3.99, 0.01),
            (4.01, 0.02),
            (7.99, 0.02),
            (8.01, 0.05),
            (19.98, 0.05),
            (20.01, 0.1),
            (39.9, 0.1),
            (40.1, 0.2),
            (79.9, 0.2),
            (80.1, 0.5),
            (199.9, 0.5),
            (201.0, 1.0),
            (1001.0, 5.0),
            (3000.0, 10.0),
        ] {
            let (station, pattern) = line(pick);
            let scene = Scene::new(&station, &pattern).unwrap();
            let found = chosen(&scene, &BoundOptions::default());
            assert_eq!(found, Some((length, false)), "{pick}");
        }
    }

    /// Longer slots if there would be too many picks in slots; none if they would be longer
    /// than a pick.
    #[test]
    fn slots_grow_with_what_they_cost() {
        let (station, pattern) = line(10.01);
        let scene = Scene::new(&station, &pattern).unwrap();
        let item = &scene.queue(0)[0];
        let lasts = item.close - item.open;
        // As many as a window has with slots of this length.
        let with = |length: f64, fewer: usize| BoundOptions {
            arcs: (lasts / length + 2.0).ceil() as usize - fewer,
            ..BoundOptions::default()
        };
        assert_eq!(chosen(&scene, &with(0.05, 0)), Some((0.05, false)));
        assert_eq!(chosen(&scene, &with(0.05, 1)), Some((0.1, false)));
        assert_eq!(chosen(&scene, &with(0.5, 0)), Some((0.5, false)));
        // More than a twentieth of a pick.
        assert_eq!(chosen(&scene, &with(0.5, 1)), Some((1.0, true)));
        assert_eq!(chosen(&scene, &with(2.0, 0)), Some((2.0, true)));
        // Longer than a pick.
        assert_eq!(chosen(&scene, &with(20.0, 0)), None);
        let too_few = BoundOptions {
            arcs: 2,
            ..BoundOptions::default()
        };
        assert_eq!(chosen(&scene, &too_few), None);
        // One arc per window is the minimum.
        let none = BoundOptions {
            arcs: 0,
            ..BoundOptions::default()
        };
        assert_eq!(chosen(&scene, &none), None);
    }

    /// Ten and three times as long, but not longer than a quarter of a pick.
    #[test]
    fn longer_slots_come_first() {
        let (station, pattern) = line(10.0);
        let scene = Scene::new(&station, &pattern).unwrap();
        for (length, longer) in [
            (0.05, &[0.5, 0.15][..]),
            (0.24, &[2.4, 0.72]),
            (0.26, &[0.78]),
            (0.83, &[2.49]),
            (0.84, &[]),
            (5.0, &[]),
        ] {
            let options = BoundOptions::default().with_slot_s(length);
            let chosen = choose_slots(&scene, &options).unwrap().unwrap();
            let lengths: Vec<f64> = chosen.levels.iter().map(|slots| slots.length).collect();
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
            assert_eq!(lengths.len(), longer.len() + 1, "{length}");
            assert!(lengths.iter().zip(longer.iter().chain([&length])).all(near));
        }
    }

    /// A requested length is used if length and memory allow it.
    #[test]
    fn given_slots_are_used_or_refused() {
        let (station, pattern) = line(10.0);
        let scene = Scene::new(&station, &pattern).unwrap();
        let asked = |scene: &Scene, length: f64| {
            let options = BoundOptions {
                slot_s: Some(length),
                arcs: 1,
                ..BoundOptions::default()
            };
            choose_slots(scene, &options)
                .map(|chosen| chosen.map(|chosen| (finest(&chosen), chosen.coarse)))
                .map_err(|error| error.to_string())
        };
        for length in [1e-6, 0.013, 5.0, 1e6] {
            assert_eq!(asked(&scene, length), Ok(Some((length, false))));
        }
        for length in [0.99e-6, 1.01e6, 0.0, -1.0, f64::NAN, f64::INFINITY] {
            let told = asked(&scene, length).unwrap_err();
            assert!(told.contains("is not a valid slot length"), "{told}");
            assert!(told.contains("from 1e-6 to 1e6, such as 0.05"), "{told}");
        }
        // Windows of several seconds have too many slots of one microsecond.
        let station = built_in("paper").unwrap().station(Some(1)).unwrap();
        let pattern = grid(station.belt().width, 0.15, 100).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let told = asked(&scene, 1e-6).unwrap_err();
        for words in ["1e-6 s is too short", "picks in slots, at most 5e7 fit"] {
            assert!(told.contains(words), "{told}");
        }
        assert!(asked(&scene, 1e-3).is_ok());
    }

    /// Slots must have distinct times, however few picks there are: an item that takes 1e9 s to
    /// arrive and is within reach for a moment.
    #[test]
    fn there_are_no_more_slots_than_times() {
        let plain = built_in("paper").unwrap().station(Some(1)).unwrap();
        let base = plain.robots()[0].base;
        let robot = plain.robots()[0]
            .clone()
            .with_only_bin([base.x, base.y + 0.8].into())
            .with_dwell(1e-4, 0.0);
        let belt = Belt {
            speed: 1e-3,
            ..*plain.belt()
        };
        let y = base.y + 0.8 - 1e-13;
        let station = Station::new(belt, vec![robot]).unwrap();
        let pattern = Pattern::new(vec![Item::at("0", -1e6, y)]).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let lasts = scene.queue(0)[0].close - scene.queue(0)[0].open;
        assert!(0.0 < lasts && lasts < 0.01, "{lasts}");
        let asked = |length| {
            let options = BoundOptions {
                slot_s: Some(length),
                ..BoundOptions::default()
            };
            choose_slots(&scene, &options).map(|chosen| chosen.is_some())
        };
        let told = asked(5e-6).unwrap_err().to_string();
        assert!(told.contains("is too short for this pattern"), "{told}");
        assert!(asked(2e-5).unwrap());
        // A two-hundredth of a pick would be 5e-7 s or a little more.
        assert_eq!(chosen(&scene, &BoundOptions::default()), Some((2e-5, true)));
    }

    /// If nothing is within reach, any slot is suitable.
    #[test]
    fn a_line_that_reaches_nothing_has_slots() {
        let (station, _) = line(10.0);
        let pattern = Pattern::new(vec![Item::at("0", 0.0, 0.5)]).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        assert_eq!(
            chosen(&scene, &BoundOptions::default()),
            Some((1e-6, false))
        );
    }
}
