//! `pickline bound`.

use super::args::{BoundArgs, ObjectiveArg};
use super::flags;
use super::outputs::{Outputs, WHOLE};
use super::progress::Bar;
use super::session::Session;
use super::settings::load_pattern;
use pickline::checker;
use pickline::error::{Error, Result};
use pickline::optimize::Progress as _;
use pickline::planning::bound::{Bound, BoundObjective, BoundOptions, upper_bound};
use pickline::plausible::SLOT;
use pickline::sim::{Conditions, Scene};
use pickline::study::Note;
use pickline_report::{BoundReport, Provenance};
use std::path::Path;

/// The highest accepted number of iterations; more are treated as a typing mistake.
const MOST_ITERATIONS: usize = 1_000_000;

pub fn run(args: &BoundArgs, session: &Session) -> Result<()> {
    session.catch_interrupts();
    let common = &args.common;
    common.check()?;
    if !(1..=MOST_ITERATIONS).contains(&args.iterations) {
        return Err(Error::usage(
            "--iterations",
            format!("{} iterations", args.iterations),
            format!("give 1 to {MOST_ITERATIONS}"),
        ));
    }
    let pattern = args.pattern.as_deref().map(Path::new);
    let read = [args.station.file(), ("--pattern", pattern)];
    common.check_outputs::<BoundReport>("bound", &read, &[])?;
    let conditions = args.conditions.resolve(common)?;
    let station = args.station.load()?;
    args.conditions
        .check_on(&args.station, &args.common, &station)?;
    let (pattern, pattern_name) = load_pattern(args.pattern.as_deref(), station.belt().width)?;
    let named = args.pattern.as_deref().unwrap_or(&pattern_name);
    args.station.check_pattern(named, &pattern)?;
    args.station.check_values(&[("--slot", &SLOT, args.slot)])?;
    if args.pattern.is_none() {
        common.remark(&format!(
            "bounding {pattern_name}, station {}",
            args.station.station
        ));
    }
    let scene = Scene::under(&station, &pattern, conditions)
        .map_err(|error| error.inside(args.pattern.as_deref().unwrap_or(&pattern_name)))?;
    if conditions.disturbances.never_fails(pattern.items()) {
        common.remark(&flags::in_note(&Note::NothingFails));
    }
    let picks = bound(args, session, &scene, BoundObjective::Picks)?;
    let weight = match args.objective {
        ObjectiveArg::Picks => None,
        ObjectiveArg::Weight => Some(bound(args, session, &scene, BoundObjective::Weight)?),
    };
    for found in [Some(&picks), weight.as_ref()].into_iter().flatten() {
        if let Some(schedule) = &found.schedule {
            checker::check(&station, &pattern, schedule)?;
        }
    }
    let made = Provenance::new(
        &session.command(),
        &args.station.station,
        &station,
        &pattern_name,
        common.seed,
    )
    .under(&conditions);
    let mut report = BoundReport::new(&pattern, &picks, weight.as_ref(), made);
    report.notes = notes(&conditions);
    if picks.coarse {
        report.notes.push(
            "the bound is coarse: the pattern is so long that the slots are long, too; a shorter \
             --slot gives a tighter bound, but takes more time and memory"
                .to_owned(),
        );
    }
    common.deliver(session, &report, &WHOLE, Outputs::default())
}

/// Notes for a bound under `conditions`.
fn notes(conditions: &Conditions) -> Vec<String> {
    if !conditions.disturbances.any() {
        return Vec::new();
    }
    let camera = match conditions.camera_x {
        Some(_) if conditions.disturbances.position_noise > 0.0 => {
            ", whatever the camera reports and when"
        }
        _ => "",
    };
    vec![format!(
        "proven for any luck: failures only cost time, so this is the bound of the line without \
         failures{camera}; there is no schedule to compare it with"
    )]
}

fn bound(
    args: &BoundArgs,
    session: &Session,
    scene: &Scene,
    objective: BoundObjective,
) -> Result<Bound> {
    let options = BoundOptions {
        slot_s: args.slot,
        iterations: args.iterations,
        // A schedule for the undisturbed line may fail on the disturbed one.
        schedule: !scene.conditions().disturbances.any(),
        ..BoundOptions::in_full(objective, scene.pattern().len())
    };
    let bar = Bar::new(args.common.quiet);
    let mut begun = false;
    let found = upper_bound(scene, &options, &mut |_, expected| {
        if !begun {
            bar.begin("bounding", expected as u64, "steps");
            begun = true;
        }
        bar.advance(1);
        !session.interrupted()
    });
    bar.end();
    found
}
