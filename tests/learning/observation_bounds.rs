//! No feature of an observation leaves its bounds, on any line, and the bounds say something.

#[path = "../common/real_lines.rs"]
mod real_lines;

use pickline::decision::observation::{Layout, View};
use pickline::pattern::{Attributes, Pattern, grid, random_stream};
use pickline::rl::{DispatchEnvironment, Reward};
use pickline::sim::{Conditions, Disturbances, Outage, Scene};
use pickline::station::{Station, built_in};
use proptest::prelude::*;
use rand::RngExt;

/// What was seen of every feature: its least and its greatest value.
type Seen = Vec<(f32, f32)>;

/// Plays an episode with random allowed actions and calls `look` with every observation. Returns the
/// bounds; `None` if there is nothing to decide.
fn play(
    (station, pattern): (&Station, &Pattern),
    conditions: Conditions,
    layout: Layout,
    mut look: impl FnMut(&[f32]),
) -> Option<Seen> {
    let scenes = [Scene::under(station, pattern, conditions).unwrap()];
    let mut line = DispatchEnvironment::new(&scenes, layout, Reward::PAPER, (1, 0)).ok()?;
    let bounds = line.bounds();
    let mut observation = vec![f32::NAN; layout.observation()];
    let mut mask = vec![false; layout.actions()];
    let mut rng = random_stream(7, 0);
    line.reset(&mut observation, &mut mask);
    for _ in 0..200 {
        look(&observation);
        let allowed: Vec<usize> = (0..mask.len()).filter(|action| mask[*action]).collect();
        let action = allowed[rng.random_range(0..allowed.len())];
        let step = line.advance(action, &mut observation, &mut mask).unwrap();
        if step.ended.is_some() {
            break;
        }
    }
    look(&observation);
    Some(bounds)
}

fn layouts() -> impl Strategy<Value = Layout> {
    let view = prop::sample::select(View::ALL.to_vec());
    (view, 1..12usize, any::<bool>()).prop_map(|(view, slots, wait)| Layout { view, slots, wait })
}

fn conditions() -> impl Strategy<Value = Conditions> {
    let noise = prop_oneof![Just(0.0), 0.0..0.2f64];
    (
        prop_oneof![Just(0.0), 0.5..20.0f64],
        prop::option::of(-2.0..1.0f64),
        noise,
        any::<bool>(),
        prop::option::of((0.0..20.0f64, 0.1..10.0f64)),
    )
        .prop_map(|(hz, camera_x, noise, failing, outage)| {
            let disturbances = Disturbances::default()
                .with_position_noise(noise)
                .with_grasp_failures(failing)
                .with_default_p_grasp(0.7)
                .with_seed(3);
            let conditions = Conditions::at_update_hz(hz)
                .with_camera_x(camera_x)
                .with_disturbances(disturbances);
            match outage {
                None => conditions,
                Some((from, length)) => {
                    conditions.with_outage(Outage::new("1", from, from + length))
                }
            }
        })
}

fn cases() -> impl Strategy<Value = (Station, Pattern)> {
    let stations = prop_oneof![crate::common::stations(), real_lines::stations()];
    stations.prop_flat_map(|station| {
        let width = station.belt().width;
        (Just(station), real_lines::patterns(width, 40))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn observations_are_within_their_bounds(
        (station, pattern) in cases(),
        conditions in conditions(),
        layout in layouts(),
    ) {
        let mut seen: Vec<Vec<f32>> = Vec::new();
        let bounds = play((&station, &pattern), conditions, layout, |o| seen.push(o.to_vec()));
        let Some(bounds) = bounds else {
            // No robot ever reaches anything.
            prop_assert!(seen.is_empty());
            return Ok(());
        };
        prop_assert_eq!(bounds.len(), layout.observation());
        for (low, high) in &bounds {
            prop_assert!(low.is_finite() && high.is_finite() && *low <= 0.0 && *high >= 0.0 && low < high);
        }
        for observation in &seen {
            for (place, (value, (low, high))) in observation.iter().zip(&bounds).enumerate() {
                prop_assert!(
                    (*low..=*high).contains(value),
                    "feature {} of {:?}: {} is not in {}..={}", place, layout, value, low, high
                );
            }
        }
    }
}

/// On the paper's line, what is measured in metres and seconds comes near its bounds.
#[test]
fn the_bounds_are_not_far_from_what_is_seen() {
    let station = built_in("paper").unwrap().station(Some(3)).unwrap();
    let pattern = grid(station.belt().width, 0.1, 400).unwrap();
    let layout = Layout {
        slots: 256,
        ..Layout::PAPER
    };
    let mut seen = vec![(0.0f32, 0.0f32); layout.observation()];
    let bounds = play((&station, &pattern), Conditions::default(), layout, |o| {
        for (range, value) in seen.iter_mut().zip(o) {
            *range = (range.0.min(*value), range.1.max(*value));
        }
    });
    let bounds = bounds.unwrap();
    for (feature, name, share) in [(0, "x", 0.7), (1, "y", 0.3), (2, "P", 0.5), (3, "r", 0.4)] {
        let of_slots = |all: &[(f32, f32)]| {
            let slots = all[layout.globals()..].chunks(layout.slot_features());
            let ranges = slots.map(|slot| slot[feature]);
            let (low, high) = ranges.fold((0.0f32, 0.0f32), |a, b| (a.0.min(b.0), a.1.max(b.1)));
            high - low
        };
        let (wide, used) = (of_slots(&bounds), of_slots(&seen));
        assert!(used >= share * wide, "{name}: {used} of {wide}");
    }
}

/// Environments of one station have one space, unless a pattern has heavier items than the station
/// gives.
#[test]
fn bounds_depend_on_the_station_and_on_weights_alone() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let width = station.belt().width;
    let layout = Layout::new(View::Full, 4, false).unwrap();
    let bounds = |pattern: &Pattern| {
        play((&station, pattern), Conditions::default(), layout, |_| ()).unwrap()
    };
    let (short, long) = (
        grid(width, 0.3, 10).unwrap(),
        grid(width, 0.15, 90).unwrap(),
    );
    assert_eq!(bounds(&short), bounds(&long));
    let attributes = Attributes::named(Some("const:80"), Some("const:0.5"), None, None).unwrap();
    let lighter = attributes
        .apply(short.clone(), &mut random_stream(1, 0))
        .unwrap();
    assert_eq!(bounds(&short), bounds(&lighter));
    let mut items = short.items().to_vec();
    items[3].weight = Some(7.5);
    let heavy = bounds(&Pattern::new(items).unwrap());
    let weights =
        (0..layout.slots).map(|slot| layout.globals() + slot * layout.slot_features() + 6);
    let mut due = bounds(&short);
    for place in weights {
        assert!((1.0..1.1).contains(&due[place].1) && (7.5..7.6).contains(&heavy[place].1));
        due[place] = heavy[place];
    }
    assert_eq!(heavy, due);
}
