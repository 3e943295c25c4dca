//! What assignments score and how they are judged, worked out from single runs.

use pickline::decision::Figures;
use pickline::dispatch::RuleAssignment;
use pickline::optimize::{
    Environment, Evaluation, Evaluator, Grasp, Limits, MostRuns, Objective, Progress, Ranking,
    Risk, Search, SearchKind, Silent, SpeedScan, Stop, StopReason, TieBreak, ValidationOptions,
    find_optimum, rivals, validate,
};
use pickline::pattern::{Item, Pattern, grid, poisson_disk, random_stream};
use pickline::planning::bound::{BoundOptions, upper_bound};
use pickline::sim::{Conditions, Disturbances, Scene, simulate_rules};
use pickline::station::{Station, built_in};
use pickline::stats::{Bootstrap, Interval};
use pickline::strategies::read_alone;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

pub static GO_ON: AtomicBool = AtomicBool::new(false);

pub fn environment(stop: &dyn Stop) -> Environment<'_> {
    Environment {
        stop,
        progress: &Silent,
        ..Environment::QUIET
    }
}

pub fn station() -> Station {
    built_in("paper").unwrap().station(Some(2)).unwrap()
}

/// Dense patterns with weights, and a last one that misses nothing.
pub fn patterns() -> Vec<Pattern> {
    let weighed = |pattern: Pattern| {
        let items = pattern.items().iter().enumerate();
        let items = items.map(|(i, item)| Item {
            weight: Some(0.1 + 0.2 * (i * 7 % 5) as f64),
            ..item.clone()
        });
        Pattern::new(items.collect()).unwrap()
    };
    let mut all: Vec<Pattern> = [0.12, 0.14, 0.16, 0.18]
        .iter()
        .zip(1..)
        .map(|(&radius, seed)| poisson_disk(1.05, radius, 40, &mut random_stream(seed, 0)))
        .map(|pattern| weighed(pattern.unwrap()))
        .collect();
    all.push(weighed(grid(1.05, 0.35, 12).unwrap()));
    all
}

fn conditions() -> Conditions {
    Conditions::default()
        .with_update_hz(5.0)
        .with_camera_x(0.4)
        .with_disturbances(
            Disturbances::default()
                .with_grasp_failures(true)
                .with_default_p_grasp(0.8)
                .with_position_noise(0.02)
                .with_seed(5),
        )
}

pub fn figures(
    station: &Station,
    pattern: &Pattern,
    conditions: &Conditions,
    rules: &RuleAssignment,
) -> Figures {
    let scene = Scene::under(station, pattern, conditions.clone()).unwrap();
    simulate_rules(&scene, rules).unwrap().figures
}

pub fn rate(figures: &Figures) -> f64 {
    60.0 * figures.picked as f64 / figures.end
}

/// Of five values, whose t quantile is 2.776445.
fn interval(values: &[f64]) -> Interval {
    assert_eq!(values.len(), 5);
    let mean = values.iter().sum::<f64>() / 5.0;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let half = 2.776_445_105 * (squares / 4.0 / 5.0).sqrt();
    Interval {
        low: mean - half,
        high: mean + half,
    }
}

fn near(found: Interval, expected: Interval) -> bool {
    (found.low - expected.low).abs() < 1e-6 && (found.high - expected.high).abs() < 1e-6
}

fn all() -> Vec<RuleAssignment> {
    RuleAssignment::all(2).collect()
}

pub fn evaluate(evaluator: &Evaluator) -> Evaluation {
    evaluator.evaluate(all(), &environment(&GO_ON)).unwrap()
}

/// A pattern of which nothing is to be picked counts as picked completely in every search, as it does
/// where patterns are counted.
#[test]
fn a_pattern_without_wanted_items_is_picked_completely() {
    let station = built_in("sorting").unwrap().station(None).unwrap();
    let item = |id: u32, class: &str| Item {
        class: Some(class.into()),
        ..Item::at(id.to_string(), -0.1 * f64::from(id), 0.0)
    };
    let wanted = (0..40).map(|id| item(id, "pet")).collect();
    let patterns = [vec![item(0, "wood")], wanted].map(|items| Pattern::new(items).unwrap());
    let objective = Objective::PickedShare;
    let conditions = Conditions::default();
    let evaluator = Evaluator::new(&station, &patterns, objective, &conditions).unwrap();
    let rules: Vec<RuleAssignment> = ["FIFO", "SPT"]
        .map(|rule| RuleAssignment::new(vec![rule.parse().unwrap(); station.robots().len()]))
        .into();
    let found = evaluator
        .evaluate(rules.clone(), &environment(&GO_ON))
        .unwrap();
    for (rules, score) in rules.iter().zip(&found.scores) {
        let run = figures(&station, &patterns[1], &conditions, rules);
        let share = run.picked as f64 / 40.0;
        assert_eq!(score.values, [1.0, share]);
        assert!((score.picked_share - 0.5 * (1.0 + share)).abs() < 1e-12);
    }
}

/// Every score is the figure of a run of its own, under the conditions with the luck of the
/// pattern's place.
#[test]
fn scores_are_the_figures_of_single_runs() {
    let (station, patterns) = (station(), patterns());
    for conditions in [Conditions::default(), conditions()] {
        for objective in [
            Objective::PickingRate,
            Objective::PickedShare,
            Objective::WeightedRate,
        ] {
            let evaluator = Evaluator::new(&station, &patterns, objective, &conditions).unwrap();
            let found = evaluate(&evaluator);
            assert_eq!(found.patterns, [0, 1, 2, 3, 4]);
            assert_eq!(found.assignments, all());
            assert_eq!(evaluator.runs(), 5 * 36);
            for (rules, score) in found.assignments.iter().zip(&found.scores) {
                let mut shares = 0.0;
                for (place, pattern) in patterns.iter().enumerate() {
                    let luck = conditions
                        .disturbances
                        .with_seed(conditions.disturbances.seed + place as u64);
                    let own = conditions.clone().with_disturbances(luck);
                    let run = figures(&station, pattern, &own, rules);
                    let share = run.picked as f64 / pattern.len() as f64;
                    let expected = match objective {
                        Objective::PickingRate => rate(&run),
                        Objective::PickedShare => share,
                        _ => 60.0 * run.weight / run.end,
                    };
                    assert!(
                        (score.values[place] - expected).abs() < 1e-12,
                        "{rules} {place}"
                    );
                    shares += share / 5.0;
                }
                assert!((score.picked_share - shares).abs() < 1e-12);
            }
        }
    }
}

/// A strategy of any kind scores what the same rules score, speed limits too.
#[test]
fn a_strategy_scores_as_an_assignment_does() {
    let (station, patterns) = (station(), patterns());
    let strategy = read_alone("SPT,LD", 2).unwrap();
    let rules = vec!["SPT,LD".parse().unwrap()];
    let scan = SpeedScan::new(0.02, &station).unwrap();
    for conditions in [Conditions::default(), conditions()] {
        for objective in [Objective::WeightedRate, Objective::MaxSpeed(scan)] {
            let evaluator = Evaluator::new(&station, &patterns, objective, &conditions).unwrap();
            let found = evaluator
                .evaluate(rules.clone(), &environment(&GO_ON))
                .unwrap();
            let score = evaluator.score(&strategy, &environment(&GO_ON)).unwrap();
            assert_eq!(score.as_ref(), found.scores.first());
        }
        let stopped = AtomicBool::new(true);
        let evaluator =
            Evaluator::new(&station, &patterns, Objective::PickingRate, &conditions).unwrap();
        assert_eq!(
            evaluator.score(&strategy, &environment(&stopped)).unwrap(),
            None
        );
    }
}

/// Runs that are not enough for all patterns are used on as many whole ones as they are
/// enough for: part of a sample that is the same for every count.
#[test]
fn runs_are_counted_pattern_by_pattern() {
    let (station, patterns) = (station(), patterns());
    let plain = Conditions::default();
    let new = || Evaluator::new(&station, &patterns, Objective::PickingRate, &plain).unwrap();
    let whole = evaluate(&new());
    let mut before: Vec<usize> = Vec::new();
    for (most, count) in [
        (0, 0),
        (35, 0),
        (36, 1),
        (71, 1),
        (72, 2),
        (179, 4),
        (180, 5),
        (999, 5),
    ] {
        let evaluator = new();
        let found = evaluator
            .evaluate_within(all(), most, &environment(&GO_ON))
            .unwrap();
        assert_eq!(found.patterns.len(), count, "{most}");
        assert_eq!(evaluator.runs(), 36 * count as u64);
        assert_eq!(found.is_whole(&evaluator), count == 5);
        assert!(found.patterns.is_sorted() && before.iter().all(|p| found.patterns.contains(p)));
        for (score, of_all) in found.scores.iter().zip(&whole.scores) {
            for (value, place) in score.values.iter().zip(&found.patterns) {
                assert_eq!(*value, of_all.values[*place]);
            }
        }
        let sample = new().sample(count);
        assert_eq!(sample.pattern_count(), count);
        assert_eq!(evaluate(&sample).patterns, found.patterns);
        before = found.patterns;
    }
    assert_eq!(new().sample(9).pattern_count(), 5);
    assert_eq!(new().independent_patterns(), 5);
    let disturbed = Evaluator::new(&station, &patterns, Objective::PickingRate, &conditions());
    assert_eq!(disturbed.unwrap().independent_patterns(), 0);
    // By speed, a pattern that takes more than its part waits until there is more for it.
    let scan = SpeedScan::new(0.01, &station).unwrap();
    let by_speed = Objective::MaxSpeed(scan);
    let whole = {
        let evaluator = Evaluator::new(&station, &patterns, by_speed, &plain).unwrap();
        (evaluate(&evaluator), evaluator.runs())
    };
    let mut counts = Vec::new();
    for most in [30, 36, 200, 500, 800, whole.1, 10 * whole.1] {
        let evaluator = Evaluator::new(&station, &patterns, by_speed, &plain).unwrap();
        let found = evaluator
            .evaluate_within(all(), most, &environment(&GO_ON))
            .unwrap();
        assert!(evaluator.runs() <= most, "{} of {most}", evaluator.runs());
        for (score, of_all) in found.scores.iter().zip(&whole.0.scores) {
            for (value, place) in score.values.iter().zip(&found.patterns) {
                assert_eq!(*value, of_all.values[*place]);
            }
        }
        counts.push(found.patterns.len());
    }
    assert!(
        counts.is_sorted() && counts[0] == 0 && counts[6] == 5,
        "{counts:?}"
    );
}

/// The whole ranking from the definitions of docs/model.md.
#[test]
fn the_ranking_follows_from_the_values() {
    let (station, patterns) = (station(), patterns());
    let scan = SpeedScan::new(0.02, &station).unwrap();
    let plain = Conditions::default();
    let evaluator = Evaluator::new(&station, &patterns, Objective::PickingRate, &plain).unwrap();
    let evaluation = evaluate(&evaluator);
    let values = |place: usize| &evaluation.scores[place].values;
    let mean = |place: usize| values(place).iter().sum::<f64>() / 5.0;
    let worst = |place: usize| values(place).iter().copied().fold(f64::INFINITY, f64::min);
    let between = |a: usize, b: usize| {
        let pairs = values(a).iter().zip(values(b));
        interval(&pairs.map(|(a, b)| a - b).collect::<Vec<f64>>())
    };
    // None of the 16 highest is proven better.
    let mut by_mean: Vec<usize> = (0..36).collect();
    by_mean.sort_by(|&a, &b| mean(b).total_cmp(&mean(a)));
    let contends = |place: usize| {
        by_mean[..16]
            .iter()
            .all(|&front| between(front, place).low <= 0.0)
    };
    let contenders: Vec<usize> = (0..36).filter(|&place| contends(place)).collect();
    assert!((2..30).contains(&contenders.len()), "{contenders:?}");
    let limit = |place: usize| {
        let rules = &evaluation.assignments[place];
        let limits = patterns.iter().map(|pattern| {
            let run = |scene: &Scene| Ok(simulate_rules(scene, rules)?.figures);
            scan.limit(&station, pattern, &plain, run).unwrap()
        });
        limits.sum::<f64>() / 5.0
    };
    for (runs, with_speed) in [(u64::MAX, true), (0, false)] {
        let tie_break = TieBreak {
            scan: Some(scan),
            runs,
        };
        let ranking = Ranking::new(
            &evaluation,
            &evaluator,
            Risk::Mean,
            tie_break,
            &environment(&GO_ON),
        );
        let ranking = ranking.unwrap().unwrap();
        let speed = |place: usize| if with_speed { limit(place) } else { 0.0 };
        let mut order = contenders.clone();
        order.sort_by(|&a, &b| {
            let by_speed = speed(b).total_cmp(&speed(a));
            let by_worst = worst(b).total_cmp(&worst(a));
            by_speed.then(by_worst).then(mean(b).total_cmp(&mean(a)))
        });
        let best = order[0];
        order.extend(by_mean.iter().filter(|place| !contenders.contains(place)));
        assert_eq!(ranking.contenders, contenders.len());
        assert_eq!(ranking.leader, evaluation.assignments[by_mean[0]]);
        assert_eq!(
            ranking.by_speed,
            with_speed.then_some((contenders.len(), 5))
        );
        assert_eq!(ranking.cut, !with_speed);
        assert_eq!(ranking.method, "paired t interval over 5 patterns");
        assert_eq!(ranking.best(), &ranking.entries[0]);
        for (entry, &place) in ranking.entries.iter().zip(&order) {
            let rules = &evaluation.assignments[place];
            assert_eq!(&entry.assignment, rules);
            assert!((entry.mean - mean(place)).abs() < 1e-12 && entry.value == entry.mean);
            assert_eq!(entry.worst, worst(place), "{rules}");
            assert_eq!(values(place)[entry.worst_pattern], entry.worst);
            assert_eq!(entry.picked_share, evaluation.scores[place].picked_share);
            let difference = between(best, place);
            assert!(
                near(entry.difference.unwrap(), difference),
                "{rules}: {entry:?}"
            );
            assert_eq!(entry.tied, difference.low <= 0.0 && 0.0 <= difference.high);
            let limit = (with_speed && contenders.contains(&place)).then(|| limit(place));
            match (entry.max_speed, limit) {
                (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-12),
                (found, expected) => assert_eq!(found, expected, "{rules}"),
            }
        }
    }
}

/// Of a single pattern the difference is the whole, and only equal ones are tied; under risk
/// intervals are those of a bootstrap.
#[test]
fn one_pattern_and_risk_have_their_own_intervals() {
    let (station, patterns) = (station(), patterns());
    let plain = Conditions::default();
    let without = TieBreak {
        scan: None,
        runs: u64::MAX,
    };
    let ranked = |patterns: &[Pattern], risk: Risk| {
        let evaluator = Evaluator::new(&station, patterns, Objective::PickingRate, &plain).unwrap();
        let evaluation = evaluate(&evaluator);
        Ranking::new(&evaluation, &evaluator, risk, without, &environment(&GO_ON))
            .unwrap()
            .unwrap()
    };
    let one = ranked(&patterns[..1], Risk::Worst);
    assert_eq!(
        one.method,
        "a single pattern: differences without intervals"
    );
    let best = one.best().value;
    for entry in &one.entries {
        assert_eq!((entry.difference, entry.tied), (None, entry.value == best));
    }
    assert!(one.entries.iter().any(|entry| !entry.tied));
    assert!(!one.cut && one.by_speed.is_none());
    let risky = ranked(&patterns, Risk::Worst);
    assert_eq!(risky.method, "paired bootstrap, 2000 resamples");
    let best = risky.best().clone();
    let resamples = Bootstrap::new(5, 2000, 0);
    let values = |rules: &RuleAssignment| -> Vec<f64> {
        let rate = |pattern| rate(&figures(&station, pattern, &plain, rules));
        patterns.iter().map(rate).collect()
    };
    let of_best = values(&best.assignment);
    for entry in &risky.entries {
        assert_eq!(entry.value, entry.worst);
        let own = values(&entry.assignment);
        let least = |values: &mut [f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        let expected = resamples.difference(&of_best, &own, least);
        let difference = entry.difference.unwrap();
        assert!(near(difference, expected), "{entry:?}");
        assert_eq!(entry.tied, difference.low <= 0.0 && 0.0 <= difference.high);
    }
    assert_eq!(best.difference, Some(Interval::point(0.0)));
}

/// Figures of a strategy beside the winner, each minus the winner's on the same pattern.
#[test]
fn rivals_are_compared_with_the_winner_pattern_by_pattern() {
    let (station, patterns) = (station(), patterns());
    let evaluator =
        Evaluator::new(&station, &patterns, Objective::PickingRate, &conditions()).unwrap();
    let (winner, rival) = ("LD,LD", "SPT,FIFO");
    let strategies = [read_alone(rival, 2).unwrap()];
    let judged = |risk, stop: &dyn Stop| {
        let winner = winner.parse().unwrap();
        rivals(&evaluator, &winner, &strategies, risk, &environment(stop)).unwrap()
    };
    let found = judged(Risk::Cvar(0.4), &GO_ON).unwrap();
    let of = |rules: &str| -> Vec<f64> {
        let places = patterns.iter().enumerate();
        places
            .map(|(place, pattern)| {
                let own = conditions().of_place(place);
                rate(&figures(&station, pattern, &own, &rules.parse().unwrap()))
            })
            .collect()
    };
    let (first, second) = (of(winner), of(rival));
    for (found, values) in found.iter().zip([&first, &second]) {
        assert!((found.mean - values.iter().sum::<f64>() / 5.0).abs() < 1e-12);
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        assert_eq!(found.worst, sorted[0]);
        assert!((found.at_risk - (sorted[0] + sorted[1]) / 2.0).abs() < 1e-12);
    }
    assert_eq!(found[0].difference, Some(Interval::point(0.0)));
    let differences: Vec<f64> = second.iter().zip(&first).map(|(a, b)| a - b).collect();
    assert!(near(found[1].difference.unwrap(), interval(&differences)));
    assert!(judged(Risk::Mean, &AtomicBool::new(true)).is_none());
}

/// A pattern is complete when all of its items are picked, not when nearly all are, at the
/// speed that is asked about.
#[test]
fn the_winner_is_judged_on_fresh_patterns() {
    let station = station();
    let mut patterns = patterns();
    // 149 of 150 items, as the last one is past every robot's reach.
    let sparse = |i: usize| Item::at(i.to_string(), -(i as f64), 0.0);
    let mut nearly: Vec<Item> = (0..149).map(sparse).collect();
    nearly.push(Item::at("far", -1e5, 0.5));
    patterns[3] = Pattern::new(nearly).unwrap();
    // All of them.
    patterns[4] = Pattern::new((0..20).map(sparse).collect()).unwrap();
    let narrow = Station::new(*station.belt(), station.robots()[..1].to_vec()).unwrap();
    let rules: RuleAssignment = "SPT".parse().unwrap();
    for conditions in [Conditions::default(), conditions()] {
        for flow in [None, Some(0.02)] {
            let evaluator =
                Evaluator::new(&narrow, &patterns, Objective::PickingRate, &conditions).unwrap();
            let judged = |certify| {
                let environment = environment(&GO_ON);
                let options = ValidationOptions::new(Risk::Worst, conditions.clone())
                    .with_flow(flow)
                    .with_certify(certify);
                validate(&evaluator, &rules, &options, &environment)
            };
            let found = judged(true).unwrap().unwrap();
            let speed = flow.unwrap_or(0.05);
            let at_speed = narrow.with_belt_speed(speed).unwrap();
            let places = patterns.iter().enumerate();
            let (mut values, mut complete, mut picked, mut most) = (Vec::new(), 0, 0, 0.0);
            for (place, pattern) in places {
                let own = conditions.of_place(place);
                let run = figures(&narrow, pattern, &own, &rules);
                values.push(rate(&run));
                let run = figures(&at_speed, pattern, &own, &rules);
                assert!(place != 3 || conditions != Conditions::default() || run.picked == 149);
                complete += usize::from(run.picked == pattern.len());
                picked += run.picked;
                let scene = Scene::under(&at_speed, pattern, own).unwrap();
                let options = BoundOptions::beside(run.picked, pattern.len());
                most += upper_bound(&scene, &options, &mut |_, _| true)
                    .unwrap()
                    .value;
            }
            assert!(complete == 1 || conditions != Conditions::default());
            assert_eq!((found.patterns, found.speed), (5, speed));
            assert_eq!(found.complete, complete);
            assert_eq!(found.complete_share(), complete as f64 / 5.0);
            let wilson = found.complete_interval;
            assert!(wilson.low <= found.complete_share() && found.complete_share() <= wilson.high);
            assert!((found.value - values.iter().sum::<f64>() / 5.0).abs() < 1e-12);
            assert!(near(found.interval.unwrap(), interval(&values)));
            let worst = values.iter().copied().fold(f64::INFINITY, f64::min);
            assert_eq!((found.worst, found.at_risk), (worst, worst));
            let certificate = found.certificate.unwrap();
            let items: usize = patterns.iter().map(Pattern::len).sum();
            assert_eq!(certificate.patterns, 5);
            assert!((certificate.picked_share - most / items as f64).abs() < 1e-12);
            let share = 1000.0 * picked as f64 / most;
            assert_eq!(certificate.percent, (share + 1e-9).floor() / 10.0);
            assert!(judged(false).unwrap().unwrap().certificate.is_none());
        }
    }
    let evaluator = Evaluator::new(
        &narrow,
        &patterns,
        Objective::PickingRate,
        &Conditions::default(),
    )
    .unwrap();
    let stopped = AtomicBool::new(true);
    let plain = Conditions::default();
    let environment = environment(&stopped);
    let options = ValidationOptions::new(Risk::Mean, plain).with_certify(true);
    let found = validate(&evaluator, &rules, &options, &environment);
    assert!(found.unwrap().is_none());
}

/// The first hundred of the fresh patterns are bounded.
#[test]
fn a_certificate_is_of_the_first_patterns() {
    let station = station();
    let patterns = vec![Pattern::new(vec![Item::at("0", 0.0, 0.0)]).unwrap(); 120];
    let plain = Conditions::default();
    let evaluator = Evaluator::new(&station, &patterns, Objective::PickingRate, &plain).unwrap();
    let rules = "SPT,SPT".parse().unwrap();
    let environment = environment(&GO_ON);
    let options = ValidationOptions::new(Risk::Mean, plain).with_certify(true);
    let found = validate(&evaluator, &rules, &options, &environment);
    let certificate = found.unwrap().unwrap().certificate.unwrap();
    assert_eq!(certificate.patterns, 100);
    assert_eq!(
        (certificate.picked_share, certificate.percent),
        (1.0, 100.0)
    );
}

/// Says stop after so many questions.
struct After(AtomicUsize);

impl Stop for After {
    fn is_set(&self) -> bool {
        let before = |left: usize| left.checked_sub(1);
        self.0
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, before)
            .is_err()
    }
}

/// Every assignment, without speed limits to break ties.
pub fn enumeration() -> Search {
    Search::default()
        .with_kind(SearchKind::Exhaustive)
        .with_grasp(Grasp::default().with_starts(3))
        .with_scan(None)
        .with_limits(Limits::NONE)
}

/// A search that is stopped has the best so far, or says that there is nothing.
#[test]
fn a_search_says_why_it_ended() {
    let (station, patterns) = (station(), patterns());
    let plain = Conditions::default();
    let run = |how: &Search, stop: &dyn Stop| {
        let evaluator = Evaluator::new(&station, &patterns, Objective::PickingRate, &plain);
        find_optimum(&evaluator.unwrap(), how, &environment(stop))
    };
    let whole = run(&enumeration(), &GO_ON).unwrap();
    assert_eq!(
        (whole.stop, whole.patterns, whole.runs),
        (StopReason::Enumerated, 5, 180)
    );
    assert_eq!((whole.max_runs, whole.grasp_gap), (None, None));
    let told = run(&enumeration(), &After(AtomicUsize::new(0)))
        .unwrap_err()
        .to_string();
    assert!(told.contains("interrupted"), "{told}");
    let mut partly = 0;
    for questions in [5, 20, 60, 120, 170] {
        match run(&enumeration(), &After(AtomicUsize::new(questions))) {
            Ok(found) => {
                assert_eq!(found.stop, StopReason::Interrupted);
                partly += usize::from(found.patterns < 5);
            }
            Err(error) => assert!(error.to_string().contains("interrupted")),
        }
    }
    assert!(partly > 0);
    // Time that is over before anything was scored.
    let mut hurry = enumeration();
    hurry.limits.until = Some(std::time::Instant::now());
    let told = run(&hurry, &GO_ON).unwrap_err().to_string();
    assert!(
        told.contains("'until'") && told.contains("before any assignment"),
        "{told}"
    );
    // Runs: too few, for some of the patterns, for all.
    let within = |kind: SearchKind, runs: u64| {
        enumeration()
            .with_kind(kind)
            .with_limits(Limits::default().with_runs(MostRuns::Of(runs)))
    };
    let told = run(&within(SearchKind::Exhaustive, 35), &GO_ON).unwrap_err();
    let told = told.to_string();
    assert!(
        told.contains("35 runs are too few for 36 assignments on one pattern"),
        "{told}"
    );
    for (runs, count, stop) in [
        (36, 1, StopReason::Budget),
        (179, 4, StopReason::Budget),
        (180, 5, StopReason::Enumerated),
    ] {
        let found = run(&within(SearchKind::Exhaustive, runs), &GO_ON).unwrap();
        assert_eq!(
            (found.patterns, found.stop, found.runs),
            (count, stop, 36 * count as u64)
        );
        assert_eq!(found.max_runs, Some(runs));
    }
    let both = run(&within(SearchKind::Both, 10_000), &GO_ON).unwrap();
    assert_eq!(both.stop, StopReason::Enumerated);
    let (grasp, gap) = (both.grasp.unwrap(), both.grasp_gap.unwrap());
    let best = both
        .ranking
        .entries
        .iter()
        .map(|e| e.value)
        .fold(0.0, f64::max);
    assert!((gap - (best - grasp.value)).abs() < 1e-12 && gap >= 0.0);
    let alone = run(&within(SearchKind::Grasp, 10_000), &GO_ON).unwrap();
    assert_eq!(
        (alone.stop, alone.grasp_gap),
        (StopReason::LocalOptima, None)
    );
    assert_eq!(alone.grasp.unwrap().starts, 3);
    // Too few for all six uniform assignments on all patterns, so on some.
    let few = run(&within(SearchKind::Grasp, 13), &GO_ON).unwrap();
    assert_eq!((few.stop, few.patterns), (StopReason::Budget, 2));
    // Of 13 runs three quarters go to GRASP, which do for four of the six.
    assert_eq!((few.runs, few.ranking.entries.len()), (8, 4));
}

/// The stages that are told.
#[derive(Default)]
struct Stages(Mutex<Vec<(String, u64, u64, bool)>>);

impl Progress for Stages {
    fn begin(&self, stage: &str, total: u64, unit: &str) {
        let mut stages = self.0.lock().unwrap();
        stages.push((format!("{stage} {unit}"), total, 0, false));
    }
    fn advance(&self, steps: u64) {
        self.0.lock().unwrap().last_mut().unwrap().2 += steps;
    }
    fn doing(&self, _: &str) {}
    fn incumbent(&self, _: &str) {}
    fn end(&self) {
        self.0.lock().unwrap().last_mut().unwrap().3 = true;
    }
}

/// Each stage is told from its beginning to its end, step by step.
#[test]
fn progress_comes_to_the_end_of_every_stage() {
    let (station, patterns) = (station(), patterns());
    let plain = Conditions::default();
    let evaluator = Evaluator::new(&station, &patterns, Objective::PickingRate, &plain).unwrap();
    let stages = Stages::default();
    let environment = Environment {
        stop: &GO_ON,
        progress: &stages,
        ..Environment::QUIET
    };
    let how = enumeration()
        .with_kind(SearchKind::Both)
        .with_scan(SpeedScan::new(0.02, &station).unwrap());
    let found = find_optimum(&evaluator, &how, &environment).unwrap();
    assert!(found.ranking.contenders > 1);
    let winner = &found.ranking.best().assignment;
    let strategies = [
        read_alone("SPT,FIFO", 2).unwrap(),
        read_alone("LD,LD", 2).unwrap(),
    ];
    let options = ValidationOptions::new(Risk::Mean, plain).with_certify(true);
    validate(&evaluator, winner, &options, &environment).unwrap();
    rivals(&evaluator, winner, &strategies, Risk::Mean, &environment).unwrap();
    let told = stages.0.into_inner().unwrap();
    let expected = [
        ("enumerating patterns", 5, 5),
        ("GRASP starts", 3, 3),
        ("breaking ties patterns", 5, 5),
        ("validating patterns", 5, 5),
        ("bounding patterns", 5, 5),
        ("other strategies runs", 15, 15),
    ];
    assert_eq!(told.len(), expected.len(), "{told:?}");
    for ((stage, total, steps, ended), expected) in told.iter().zip(expected) {
        assert_eq!((stage.as_str(), *total), (expected.0, expected.1));
        assert!(*ended, "{stage}");
        // Completion is counted without a stage of its own, which adds its patterns.
        let extra = if stage.starts_with("validating") {
            5
        } else {
            0
        };
        assert!(
            *steps == expected.2 || *steps == expected.2 + extra,
            "{told:?}"
        );
    }
}

/// GRASP without chance, step by step: each robot gets the rule that is best with the robots
/// behind it idle, and then the best of all neighbours is taken until none is better.
#[test]
fn a_greedy_start_climbs_to_a_local_optimum() {
    let (line, patterns) = (
        built_in("paper").unwrap().station(Some(3)).unwrap(),
        patterns(),
    );
    let plain = Conditions::default();
    let evaluator = Evaluator::new(&line, &patterns, Objective::WeightedRate, &plain).unwrap();
    let how = enumeration()
        .with_kind(SearchKind::Grasp)
        .with_grasp(Grasp::default().with_starts(2).with_alpha(0.0));
    let found = find_optimum(&evaluator, &how, &environment(&GO_ON)).unwrap();
    let value = |rules: &RuleAssignment| {
        let robots = line.robots()[..rules.rules().len()].to_vec();
        let part = Station::new(*line.belt(), robots).unwrap();
        let rate = |pattern| {
            let run = figures(&part, pattern, &plain, rules);
            60.0 * run.weight / run.end
        };
        patterns.iter().map(rate).sum::<f64>() / 5.0
    };
    // Those of the highest value, among which chance decides.
    let best_of = |of: &[RuleAssignment]| -> Vec<RuleAssignment> {
        let values: Vec<f64> = of.iter().map(value).collect();
        let most = values.iter().copied().fold(0.0, f64::max);
        let best = of.iter().zip(&values).filter(|(_, value)| **value == most);
        best.map(|(rules, _)| rules.clone()).collect()
    };
    let names = ["FIFO", "SPT", "LPT", "SD", "LD", "PP"];
    let mut starts = vec![RuleAssignment::new(Vec::new())];
    for _ in 0..3 {
        let longer = |before: &RuleAssignment| {
            let before = before.names().join(",");
            best_of(&names.map(|name| {
                let all = format!("{before},{name}");
                all.trim_start_matches(',').parse().unwrap()
            }))
        };
        starts = starts.iter().flat_map(longer).collect();
    }
    let climb = |start: &RuleAssignment| {
        let (mut at, mut best, mut moves) = (start.clone(), value(start), 0);
        loop {
            let rules = at.rules().to_vec();
            let near = |other: &RuleAssignment| {
                let other = other.rules();
                let changed: Vec<usize> = (0..3).filter(|&i| other[i] != rules[i]).collect();
                match changed[..] {
                    [_] => true,
                    [a, b] => other[a] == rules[b] && other[b] == rules[a],
                    _ => false,
                }
            };
            let neighbours = RuleAssignment::all(3).filter(near);
            let next = neighbours
                .map(|rules| (value(&rules), rules))
                .reduce(|a, b| if b.0 > a.0 { b } else { a })
                .unwrap();
            if next.0 <= best {
                return (at, best, moves);
            }
            ((best, at), moves) = (next, moves + 1);
        }
    };
    let ends: Vec<(RuleAssignment, f64, usize)> = starts.iter().map(climb).collect();
    let grasp = found.grasp.unwrap();
    let best = grasp.best.unwrap();
    let end = ends.iter().find(|(rules, ..)| *rules == best);
    let (_, expected, _) = end.unwrap_or_else(|| panic!("{best} is none of {ends:?}"));
    assert!(
        (grasp.value - expected).abs() < 1e-9,
        "{} {expected}",
        grasp.value
    );
    let moves = || ends.iter().map(|(_, _, moves)| 2 * moves);
    let range = moves().min().unwrap()..=moves().max().unwrap();
    assert!(
        range.contains(&grasp.moves),
        "{} not in {range:?}",
        grasp.moves
    );
    assert_eq!((grasp.starts, grasp.cut), (2, false));
    assert!(ends.len() > 1 || grasp.hits == 2);
}
