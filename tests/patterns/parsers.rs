//! Whatever the text, parsers answer; whatever they accept can be simulated.

use crate::common;
use pickline::checker;
use pickline::decision::Outcome;
use pickline::dispatch::{Rule, RuleAssignment};
use pickline::optimize::Risk;
use pickline::pattern::{self, Distribution, Pattern, PatternSource, grid, to_csv};
use pickline::sim::{Scene, simulate_rules};
use pickline::station::{self, Overrides, Station, built_in, to_toml};
use pickline_live::protocol::{decode, decode_outgoing, encode};
use pickline_live::{ClockKind, Config, Controller};
use proptest::prelude::*;
use proptest::sample::{Index, select};

const LISTED: &str = "[belt]\nspeed = 0.05 # m/s\nlength = 4.2\nwidth = 1.05\n\n\
    [[robot]]\nname = \"r1\"\nbase = [1.3, -0.625]\nbin = [1.3, -0.525]\nreach = 0.8\n\
    speed = 0.5\ngrasp_time = 0.1\nrelease_time = 0\n\n\
    [[robot]]\nname = \"r2\"\nbase = [2.1, 0.625]\nbin = [2.5, 0.525]\nreach = 0.9\n\
    speed = 0.7\ngrasp_time = 0.2\nrelease_time = 0.1\n";
const PATTERN: &str = "id,x,y,area_cm2,p_detection,p_grasp,weight,class\n\
    a,0,0.1,80,0.9,0.8,,PET\nb,-0.2,-0.1,,,,0.7,\n\"c,\"\"1\",-0.4,0,,,,,glass\n\
    d,-0.4,0.5,120,1,0.3,,\ne,-1.5,-0.5,,,,2,PET\n";

/// What a line is told; the tasks that are acknowledged and answered are given by then.
const LIVE: &str = r#"{"kind":"belt","stamp":1,"speed":0.05,"position":3.5}
{"kind":"robot","stamp":1,"name":"r1","state":"idle"}
{"kind":"robot","stamp":1,"name":"r2","state":"idle","available_at":2}
{"kind":"detection","stamp":1,"id":"a","x":0.9,"y":-0.2,"area_cm2":80,"p_detection":0.9,"p_grasp":0.8,"class":"PET"}
{"kind":"detection","stamp":2,"id":"b","x":2.5,"y":0.2,"weight":2}
{"kind":"detection","stamp":2,"x":1.4,"y":0,"covariance":[1e-5,0,1e-5]}
{"kind":"tick","stamp":2.5}
{"v":1,"kind":"ack","stamp":3,"task":1}
{"kind":"ack","stamp":3,"task":2}
{"kind":"belt","stamp":3.5,"speed":0}
{"kind":"result","stamp":5,"task":1,"result":"GRASP_FAIL","available_at":6}
{"kind":"belt","stamp":7,"speed":0.1}
{"kind":"robot","stamp":8,"name":"r2","state":"fault"}
{"kind":"result","stamp":12,"task":3,"result":"PICKED"}
{"kind":"robot","stamp":20,"name":"r2","state":"busy"}
{"kind":"tick","stamp":60}"#;

/// Numbers that parsers and closed forms like least.
const NUMBERS: [&str; 24] = [
    "nan",
    "inf",
    "-inf",
    "1e400",
    "-1e400",
    "-0",
    "-0.0",
    "0",
    "1e300",
    "-1e300",
    "1e6",
    "-1e6",
    "1000001",
    "1e-6",
    "1e-7",
    "5e-324",
    "0.05",
    "0.050000000000000003",
    "0.05000000000000001",
    "9223372036854775807",
    "99999999999999999999",
    "0x10",
    "1_0",
    "2",
];

/// One change of a text.
#[derive(Debug, Clone)]
enum Change {
    Delete(Index, usize),
    Insert(Index, char),
    Swap(Index, Index),
    Number(Index, &'static str),
    RepeatLine(Index),
    DropLine(Index),
}

fn change() -> impl Strategy<Value = Change> {
    let place = any::<Index>;
    let odd = select(vec![
        '"', '\'', '\n', '\r', ',', '=', '[', ']', '#', '\0', '\u{feff}', '-',
    ]);
    prop_oneof![
        2 => (place(), 1usize..6).prop_map(|(at, n)| Change::Delete(at, n)),
        2 => (place(), prop_oneof![any::<char>(), odd]).prop_map(|(at, c)| Change::Insert(at, c)),
        1 => (place(), place()).prop_map(|(a, b)| Change::Swap(a, b)),
        6 => (place(), select(&NUMBERS[..])).prop_map(|(at, n)| Change::Number(at, n)),
        1 => place().prop_map(Change::RepeatLine),
        1 => place().prop_map(Change::DropLine),
    ]
}

/// Where the numbers of `text` stand, from start to end.
fn numbers(text: &[char]) -> Vec<(usize, usize)> {
    let part = |c: char| c.is_ascii_digit() || "+-.".contains(c);
    let mut found = Vec::new();
    let mut start = None;
    for (i, &c) in text.iter().enumerate() {
        // The digits of a name are no number.
        let inside = start.is_some() || i == 0 || !text[i - 1].is_alphanumeric();
        match (part(c) && inside, start) {
            (true, None) => start = Some(i),
            (false, Some(first)) => {
                found.push((first, i));
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn changed(text: &str, changes: &[Change]) -> String {
    let mut text: Vec<char> = text.chars().collect();
    for change in changes {
        if text.is_empty() {
            break;
        }
        let length = text.len();
        match change {
            Change::Delete(at, n) => {
                let at = at.index(length);
                text.drain(at..(at + n).min(length));
            }
            Change::Insert(at, c) => text.insert(at.index(length), *c),
            Change::Swap(a, b) => text.swap(a.index(length), b.index(length)),
            Change::Number(at, number) => {
                let places = numbers(&text);
                if !places.is_empty() {
                    let (start, end) = places[at.index(places.len())];
                    text.splice(start..end, number.chars());
                }
            }
            Change::RepeatLine(at) | Change::DropLine(at) => {
                let whole: String = text.iter().collect();
                let mut lines: Vec<&str> = whole.split_inclusive('\n').collect();
                let at = at.index(lines.len());
                match change {
                    Change::RepeatLine(_) => lines.insert(at, lines[at]),
                    _ => drop(lines.remove(at)),
                }
                text = lines.concat().chars().collect();
            }
        }
    }
    text.into_iter().collect()
}

fn mutated(good: Vec<&'static str>) -> impl Strategy<Value = String> {
    (select(good), prop::collection::vec(change(), 1..4))
        .prop_map(|(text, changes)| changed(text, &changes))
}

fn rules(picks: &[Index], robots: usize) -> RuleAssignment {
    let all: Vec<Rule> = Rule::all().collect();
    let pick = |i: usize| picks.get(i % picks.len().max(1));
    let rule = |i: usize| all[pick(i).map_or(0, |pick| pick.index(all.len()))];
    RuleAssignment::new((0..robots).map(rule).collect())
}

/// Simulates and has the checker verify the run; none where an item lies beside the belt.
fn run(station: &Station, pattern: &Pattern, picks: &[Index], hz: f64) -> Option<Outcome> {
    let scene = Scene::new(station, pattern)
        .ok()?
        .with_update_hz(hz)
        .unwrap();
    let rules = rules(picks, station.robots().len());
    let outcome = simulate_rules(&scene, &rules).unwrap();
    let figures = &outcome.figures;
    for value in [
        figures.end,
        figures.weight,
        figures.picked_share(),
        figures.picking_rate(),
        figures.weighted_rate(),
    ] {
        assert!(value.is_finite() && value >= 0.0, "{figures:?}");
    }
    if let Err(error) = checker::check(station, pattern, &outcome) {
        panic!("{error}\n{}{}", to_toml(station), to_csv(pattern));
    }
    Some(outcome)
}

fn use_station(text: &str, picks: &[Index], hz: f64) {
    match station::parse(text, "s.toml", Overrides::default()) {
        Ok(station) => {
            let again = station::parse(&to_toml(&station), "t", Overrides::default());
            assert_eq!(again.unwrap(), station);
            let width = station.belt().width;
            let spacing = (width / 5.0).clamp(1e-4, 1e3);
            if let Ok(pattern) = grid(width, spacing, 60) {
                run(&station, &pattern, picks, hz);
            }
            let far = pattern::parse("id,x,y\na,-1e6,0\nb,-1e-9,0\nc,0,0\n", "p").unwrap();
            assert!(run(&station, &far, picks, hz).is_some());
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains("s.toml"), "{message}");
            assert!(message.contains("\n  cure: "), "{message}");
        }
    }
}

fn use_pattern(text: &str, picks: &[Index], hz: f64) {
    match pattern::parse(text, "p.csv") {
        Ok(pattern) => {
            assert_eq!(pattern::parse(&to_csv(&pattern), "t").unwrap(), pattern);
            pattern::describe(&pattern);
            for name in ["paper", "paper-narrow"] {
                run(
                    &built_in(name).unwrap().station(None).unwrap(),
                    &pattern,
                    picks,
                    hz,
                );
            }
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains("p.csv"), "{message}");
            assert!(message.contains("\n  cure: "), "{message}");
        }
    }
}

/// Has a line hear every message of `text`; it accounts for all items at all times.
fn use_messages(text: &str) {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    for clock in [ClockKind::Messages, ClockKind::System] {
        let config = Config::default().with_clock(clock);
        let strategy = pickline::strategies::read_alone("SPT,FIFO", 2).unwrap();
        let mut controller = Controller::new(station.clone(), strategy.make(), config).unwrap();
        controller.advance(0.0);
        for line in text.lines() {
            let _ = decode_outgoing(line.as_bytes());
            match decode(line.as_bytes()) {
                Ok(message) => {
                    let again = decode(encode(&message).trim_end().as_bytes());
                    assert_eq!(again.unwrap(), message);
                    let stamp = message.stamp();
                    let taken = controller.handle(message).is_ok();
                    if taken {
                        controller.advance(stamp);
                    }
                }
                Err(rejected) => {
                    assert!(!rejected.message.contains(char::is_control), "{rejected:?}");
                    assert!(rejected.message.len() < 4096, "{rejected:?}");
                }
            }
            let status = controller.status(false, 0);
            let sum = status.picked + status.missed.total() + status.on_belt + status.claimed;
            assert_eq!(status.seen, sum, "{status:?}");
            for message in controller.take_output() {
                let line = encode(&message);
                assert_eq!(
                    decode_outgoing(line.trim_end().as_bytes()).unwrap(),
                    message
                );
            }
        }
    }
}

fn hz() -> impl Strategy<Value = f64> {
    prop_oneof![4 => Just(0.0), 1 => Just(10.0), 1 => 0.01..100.0f64]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn mutated_stations(
        text in mutated(vec![LISTED, station::commented_example()]),
        picks in prop::collection::vec(any::<Index>(), 1..5),
        hz in hz(),
    ) {
        use_station(&text, &picks, hz);
    }

    #[test]
    fn mutated_messages(text in mutated(vec![LIVE])) {
        use_messages(&text);
    }

    #[test]
    fn mutated_patterns(
        text in mutated(vec![PATTERN]),
        picks in prop::collection::vec(any::<Index>(), 1..5),
        hz in hz(),
    ) {
        use_pattern(&text, &picks, hz);
    }

    /// Sizes over the whole range that a station may have, not only likely ones.
    #[test]
    fn stations_of_any_size(
        belt in [size(), size(), size()],
        robots in prop::collection::vec((size(), [place(), place(), place()], size(), size(), size()), 1..4),
        items in prop::collection::vec((-1e6..=0.0f64, -0.5..=0.5f64, size()), 1..20),
        picks in prop::collection::vec(any::<Index>(), 1..5),
        hz in hz(),
    ) {
        let [speed, length, width] = belt;
        let mut text = format!("[belt]\nspeed = {speed:?}\nlength = {length:?}\nwidth = {width:?}\n");
        let mut x = 0.0;
        for (i, (gap, [y, bin_x, bin_y], reach, faster, dwell)) in robots.iter().enumerate() {
            x += gap;
            let arm = speed * (1.0 + faster);
            text += &format!(
                "[[robot]]\nname = \"{i}\"\nbase = [{x:?}, {y:?}]\nbin = [{bin_x:?}, {bin_y:?}]\n\
                 reach = {reach:?}\nspeed = {arm:?}\ngrasp_time = {dwell:?}\nrelease_time = 0\n"
            );
        }
        let mut csv = "id,x,y\n".to_owned();
        for (i, (x, y, scale)) in items.iter().enumerate() {
            csv += &format!("{i},{:?},{:?}\n", (x * scale).max(-1e6), y * width);
        }
        if let Ok(station) = station::parse(&text, "s.toml", Overrides::default()) {
            let pattern = pattern::parse(&csv, "p.csv").unwrap();
            prop_assert!(run(&station, &pattern, &picks, hz).is_some());
        }
    }

    #[test]
    fn any_text(
        free in "\\PC{0,80}",
        toml in "([-0-9.e_ \"'\\[\\]{}=,#\n\r]|belt|line|robot|speed|inf|nan|x){0,60}",
        csv in "(id|x|y|weight|[-0-9.e,\"\n\r ]|nan|inf){0,60}",
        words in "(balanced|grid|poisson|const|uniform|lognormal|beta|cvar|mean|SPT|FIFO|[-:,;\\[\\]0-9.e ]|nan|inf){0,8}",
        robots in prop_oneof![Just(None), (0..10usize).prop_map(Some), Just(Some(usize::MAX))],
        belt_speed in prop_oneof![Just(None), any::<f64>().prop_map(Some)],
    ) {
        for text in [&free, &toml, &csv, &words] {
            let overrides = Overrides::default().with_robots(robots).with_belt_speed(belt_speed);
            let _ = station::parse(text, "s.toml", overrides);
            let _ = pattern::parse(text, "p.csv");
            let _ = pattern::parse(&format!("id,x,y\n{text}"), "p.csv");
            if let Ok(source) = text.parse::<PatternSource>() {
                prop_assert_eq!(source.to_string().parse::<PatternSource>().unwrap(), source);
            }
            if let Ok(distribution) = text.parse::<Distribution>() {
                prop_assert_eq!(distribution.to_string().parse::<Distribution>().unwrap(), distribution);
            }
            if let Ok(risk) = text.parse::<Risk>() {
                prop_assert_eq!(risk.to_string().parse::<Risk>().unwrap(), risk);
            }
            if let Ok(rules) = text.parse::<RuleAssignment>() {
                prop_assert_eq!(rules.to_string().parse::<RuleAssignment>().unwrap(), rules);
            }
        }
        for robots in robots.into_iter().chain([3]) {
            let _ = built_in("paper").unwrap().station(Some(robots));
        }
    }

    /// Whatever the parameters, drawing ends, in values that items may have or an error.
    #[test]
    fn any_distribution(
        name in select(vec!["const", "uniform", "lognormal", "beta"]),
        a in select(&NUMBERS[..]),
        b in prop_oneof![select(&NUMBERS[..]).prop_map(str::to_owned), (0.0..10.0f64).prop_map(|b| b.to_string())],
        seed: u64,
    ) {
        for text in [format!("{name}:{a}"), format!("{name}:{a},{b}"), format!("{name}:{b},{a}")] {
            if let Ok(distribution) = text.parse::<Distribution>() {
                let attributes = pattern::Attributes::default().with_area_cm2(distribution);
                let plain = grid(1.0, 0.1, 30).unwrap();
                match attributes.apply(plain, &mut pattern::random_stream(seed, 0)) {
                    Ok(pattern) => {
                        prop_assert_eq!(pattern.len(), 30);
                        for item in pattern.items() {
                            let area = item.area_cm2.unwrap();
                            prop_assert!(area.is_finite() && area >= 0.0, "{text}: {area}");
                        }
                    }
                    Err(error) => prop_assert!(error.to_string().contains("\n  cure: ")),
                }
            }
        }
    }

    #[test]
    fn random_stations_and_patterns_read_back(
        (station, pattern, _) in common::cases(common::stations(), 20),
    ) {
        let again = station::parse(&to_toml(&station), "t", Overrides::default());
        prop_assert_eq!(again.unwrap(), station);
        prop_assert_eq!(pattern::parse(&to_csv(&pattern), "t").unwrap(), pattern);
    }

    #[test]
    fn any_texts_in_fields_read_back(
        names in prop::collection::vec("\\PC{1,12}|(\"|'|\\\\|\n|\t|\u{7f}|,|#| ){1,6}", 2),
    ) {
        let line = built_in("paper").unwrap().station(None).unwrap();
        let mut robots = line.robots().to_vec();
        for (robot, name) in robots.iter_mut().zip(&names) {
            robot.name = name.clone();
        }
        if let Ok(station) = Station::new(*line.belt(), robots) {
            let again = station::parse(&to_toml(&station), "t", Overrides::default());
            prop_assert_eq!(again.unwrap(), station);
        }
        let item = |name: &String| pattern::Item {
            class: Some(name.clone()),
            true_class: Some(names[0].clone()),
            ..pattern::Item::at(name, 0.0, 0.0)
        };
        if let Ok(pattern) = Pattern::new(names.iter().map(item).collect()) {
            prop_assert_eq!(pattern::parse(&to_csv(&pattern), "t").unwrap(), pattern);
        }
    }
}

/// A size from the smallest to the largest that is allowed.
fn size() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-6.0..6.0f64).prop_map(|e| 10f64.powf(e)),
        4 => 0.01..5.0f64,
        1 => select(vec![1e-6, 1e6, 1.0]),
    ]
}

/// A coordinate of any size.
fn place() -> impl Strategy<Value = f64> {
    (size(), any::<bool>()).prop_map(|(size, left)| if left { -size } else { size })
}

/// An arm that is barely faster than the belt is refused or simulated, never simulated
/// wrongly: the closed forms divide by the difference of the squared speeds.
#[test]
fn arms_slightly_faster_than_the_belt() {
    let picks: [Index; 0] = [];
    for belt in [0.05, 0.078, 0.3, 1e-6, 1.0, 7.77e5] {
        let mut arm: f64 = belt;
        for _ in 0..60 {
            arm = (arm.next_up()).max(arm + (arm - belt) * 0.8);
            let text = LISTED
                .replace("speed = 0.05", &format!("speed = {belt:?}"))
                .replace("speed = 0.5", &format!("speed = {arm:?}"))
                .replace("speed = 0.7", &format!("speed = {arm:?}"));
            use_station(&text, &picks, 0.0);
        }
    }
}

/// The random cases above are worth something only if enough of them are accepted.
#[test]
fn mutations_are_refused_and_accepted() {
    use proptest::strategy::ValueTree as _;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let (mut stations, mut patterns) = (0, 0);
    for _ in 0..400 {
        let listed = mutated(vec![LISTED, station::commented_example()]);
        let text = listed.new_tree(&mut runner).unwrap().current();
        stations += usize::from(station::parse(&text, "s", Overrides::default()).is_ok());
        let text = mutated(vec![PATTERN])
            .new_tree(&mut runner)
            .unwrap()
            .current();
        patterns += usize::from(pattern::parse(&text, "p").is_ok());
    }
    for accepted in [stations, patterns] {
        assert!(
            (40..360).contains(&accepted),
            "{stations} and {patterns} of 400"
        );
    }
}
