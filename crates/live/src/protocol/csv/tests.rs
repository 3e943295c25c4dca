//! Tests of the dialect as a whole.

use super::super::{
    Ack, BeltPoint, BeltState, Cancel, Detection, Due, FoundPlace, Incoming, Order, Outgoing,
    ResultMessage, RobotState, RobotStatus, Status, Task, Verdict, decode,
};
use super::fields;
use super::frame::{checksum, framed, opened};
use super::table::{FROM_NODE, FieldKind, Form, TO_NODE};
use super::*;
use proptest::prelude::*;
use serde_json::{Map, Value};

const NOW: f64 = 1_795_656_426.0;

/// The value with the precision of the dialect: `parts` steps per unit.
fn to(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts
}

fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= 1e-6
}

fn incoming() -> impl Strategy<Value = Incoming> {
    let stamp = (-4e8..4e8f64).prop_map(|ms| NOW + to(ms / 1e3, 1e3));
    let place = (-99.0..99.0f64).prop_map(|x| to(x, 1e4));
    let text = |most: usize| {
        let characters = format!("[!-)+-:<-~]{{1,{most}}}");
        proptest::string::string_regex(&characters).unwrap()
    };
    let name = text(8).prop_map(|name| name.replace(',', "."));
    let id = text(12).prop_map(|name| name.replace(',', "."));
    let after = prop::option::of(0..100_000u32);
    let detection = (
        place.clone(),
        -9.9..9.9f64,
        prop::option::of(id),
        prop::option::of(0.0..5000.0f64),
        prop::option::of(0.0..9.0f64),
        prop::option::of(-179..180i32),
    );
    let body = prop_oneof![
        detection.prop_map(
            |(x, y, id, area, weight, angle)| Incoming::Detection(Detection {
                stamp: 0.0,
                id,
                x,
                y: to(y, 1e4),
                area_cm2: area.map(|area| to(area, 1e3)),
                weight: weight.map(|weight| to(weight, 1e3)),
                class: Some("PET".into()),
                angle: angle.map(|degrees| f64::from(degrees).to_radians()),
                height: Some(0.0335),
                ..Detection::default()
            })
        ),
        (-10.0..10.0f64, prop::option::of(place)).prop_map(|(speed, position)| {
            Incoming::Belt(BeltState {
                stamp: 0.0,
                speed: to(speed, 1e4),
                position,
                source: None,
            })
        }),
        (
            name,
            0..3usize,
            after.clone(),
            prop::option::of(0..99_999_999u64)
        )
            .prop_map(|(name, state, after, task)| Incoming::Robot(RobotStatus {
                task,
                stamp: 0.0,
                name,
                state: [RobotState::Idle, RobotState::Busy, RobotState::Fault][state],
                available_at: after.map(f64::from),
            })),
        any::<u32>().prop_map(|task| Incoming::Ack(Ack {
            stamp: 0.0,
            task: task.into()
        })),
        (any::<u32>(), 0..5usize, after).prop_map(|(task, result, after)| {
            let results = [
                Verdict::Picked,
                Verdict::GraspFail,
                Verdict::Missed,
                Verdict::Rejected,
                Verdict::Cancelled,
            ];
            Incoming::Result(ResultMessage {
                stamp: 0.0,
                task: task.into(),
                result: results[result],
                available_at: after.map(f64::from),
                found: task.is_multiple_of(2).then_some(FoundPlace {
                    x: 1.2345,
                    y: -0.25,
                }),
            })
        }),
        proptest::option::of("[a-z0-9]{1,8}")
            .prop_map(|robot| Incoming::Pause(Order { stamp: 0.0, robot })),
        Just(Incoming::Stop(Order {
            stamp: 0.0,
            robot: None,
        })),
        Just(Incoming::Tick { stamp: 0.0 }),
    ];
    (stamp, body).prop_map(|(at, mut message)| {
        let after = |ms: &mut Option<f64>| *ms = ms.map(|ms| at + ms / 1e3);
        match &mut message {
            Incoming::Detection(message) => message.stamp = at,
            Incoming::Belt(message) => message.stamp = at,
            Incoming::Robot(message) => {
                message.stamp = at;
                after(&mut message.available_at);
            }
            Incoming::Ack(message) => message.stamp = at,
            Incoming::Result(message) => {
                message.stamp = at;
                after(&mut message.available_at);
            }
            Incoming::Pause(order)
            | Incoming::Resume(order)
            | Incoming::Drain(order)
            | Incoming::Stop(order) => order.stamp = at,
            Incoming::Tick { stamp } => *stamp = at,
        }
        message
    })
}

/// Whether two values are equal, numbers to a millionth.
fn alike(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Number(a), Value::Number(b)) => same(
            a.as_f64().unwrap_or(f64::NAN),
            b.as_f64().unwrap_or(f64::NAN),
        ),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len()
                && a.iter()
                    .all(|(key, value)| b.get(key).is_some_and(|other| alike(value, other)))
        }
        _ => one == other,
    }
}

fn task(revision: u32, id: u64, after: [f64; 3], meet: (f64, f64)) -> Task {
    Task {
        id,
        revision,
        robot: "scara-12".into(),
        item: "camera,7*é".into(),
        decided_at: NOW,
        start: NOW + after[0],
        earliest_start: NOW,
        latest_start: NOW + after[1],
        meet_at: NOW + after[2],
        meet: BeltPoint {
            x: meet.0,
            y: meet.1,
        },
        bin: BeltPoint { x: 1.3, y: -0.5 },
        bin_name: None,
        free_at: NOW + 2.0,
        priority: 0.5,
        strategy: "rules:SPT,FIFO".into(),
        class: Some("PET".into()),
        angle: Some(std::f64::consts::FRAC_PI_6),
        height: Some(0.0335),
        size: Some([0.2, 0.07]),
        data: None,
    }
}

/// Reads the fields of a line of `forms` back into a message.
fn read_back(line: &str, forms: &[Form], near: f64) -> Map<String, Value> {
    let texts = opened(line.as_bytes()).unwrap();
    let form = forms.iter().find(|form| form.letter == texts[0]).unwrap();
    let mut stamp = near;
    let mut message = Map::new();
    for (field, text) in form.fields.iter().zip(&texts[2..]) {
        if text.is_empty() || matches!(field.kind, FieldKind::Sum) {
            continue;
        }
        let value = fields::read(field, text, stamp).unwrap();
        if matches!(field.kind, FieldKind::Stamp) {
            stamp = value.as_f64().unwrap();
        }
        message.insert(field.path.into(), value);
    }
    message
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn what_is_written_to_the_node_reads_back(messages in prop::collection::vec(incoming(), 1..9)) {
        let (mut writer, mut reader) = (CsvWriter::to_node(), CsvReader::default());
        for message in messages {
            let line = writer.write(&message).unwrap();
            prop_assert!(line.len() <= LONGEST_CSV_LINE && line.ends_with("\r\n"), "{line}");
            let reading = reader.read(line.trim_end_matches('\n').as_bytes(), Some(NOW));
            prop_assert_eq!(&reading.gap, &None);
            let found = decode(&reading.message.unwrap());
            let found = found.map_err(|rejected| TestCaseError::fail(rejected.message))?;
            let (one, other) = (
                serde_json::to_value(&message).unwrap(),
                serde_json::to_value(&found).unwrap(),
            );
            prop_assert!(alike(&one, &other), "{line}{one}\n{other}");
        }
    }

    #[test]
    fn tasks_are_told_to_a_tenth_of_a_millimetre_and_a_millisecond(
        id in 0..100_000_000u64,
        revision in 0..1000u32,
        after in prop::array::uniform3(0.0..99.0f64),
        meet in (-9.0..99.0f64, -9.0..9.0f64),
    ) {
        let task = task(revision, id, after, meet);
        let lines = CsvWriter::default().write(&Outgoing::Task(task.clone())).unwrap();
        let lines: Vec<&str> = lines.lines().collect();
        prop_assert_eq!(lines.len(), 2);
        prop_assert!(lines.iter().all(|line| line.len() + 2 <= LONGEST_CSV_LINE));
        let item = read_back(lines[0], FROM_NODE, NOW);
        prop_assert_eq!(&item["item"], "camera_7__");
        let told = read_back(lines[1], FROM_NODE, NOW);
        let number = |path: &str| told[path].as_f64().unwrap();
        prop_assert_eq!(number("id"), id as f64);
        prop_assert_eq!(number("revision"), f64::from(revision));
        for (path, value, off) in [
            ("start", task.start, 5.1e-4),
            ("latest_start", task.latest_start, 5.1e-4),
            ("meet_at", task.meet_at, 5.1e-4),
            ("meet/x", task.meet.x, 5.1e-5),
            ("meet/y", task.meet.y, 5.1e-5),
        ] {
            prop_assert!((number(path) - value).abs() <= off, "{path}: {}", lines[1]);
        }
    }

    #[test]
    fn whatever_comes_is_a_message_or_named(line in prop::collection::vec(any::<u8>(), 0..100)) {
        let reading = CsvReader::default().read(&line, Some(NOW));
        if let Err(rejected) = reading.message {
            let is_plain = !rejected.message.contains(char::is_control);
            prop_assert!(is_plain, "{:?}", rejected.message);
        }
        // The same with a correct checksum.
        let text: String = line.iter().map(|byte| char::from(byte % 95 + 32)).collect();
        let framed = framed(text.get(..70).unwrap_or(&text));
        let _ = CsvReader::default().read(framed.trim_end().as_bytes(), None);
    }

    #[test]
    fn one_wrong_or_swapped_character_is_found(
        message in incoming(), at in 0..60usize, other in 33..126u8,
    ) {
        let line = CsvWriter::to_node().write(&message).unwrap();
        let end = line.rfind('*').unwrap();
        let at = at % end;
        let mut wrong = line.clone().into_bytes();
        prop_assume!(wrong[at] != other && other != b'*');
        wrong[at] = other;
        prop_assert!(opened(&wrong).is_err());
        let mut swapped = line.into_bytes();
        if at + 1 < end && swapped[at] != swapped[at + 1] {
            swapped.swap(at, at + 1);
            prop_assert!(opened(&swapped).is_err());
        }
    }
}

#[test]
fn the_checksum_is_fletchers() {
    // Examples from the literature, modulo 255.
    for (text, sum) in [
        ("abcde", 51_440),
        ("abcdef", 8_279),
        ("abcdefgh", 1_575),
        ("", 0),
    ] {
        assert_eq!(checksum(text.as_bytes()), sum, "{text}");
    }
}

#[test]
fn what_is_wrong_is_named_and_counted() {
    let mut reader = CsvReader::default();
    let mut read = |text: &str, now: Option<f64>| {
        let line = framed(text);
        reader.read(line.trim_end().as_bytes(), now)
    };
    let reason = |reading: CsvLine| reading.message.map_err(|rejected| rejected.reason.name());
    for (text, expected) in [
        ("Q,0,1", "kind"),
        ("A,1,,x", "field"),
        ("A,2,,-1", "field"),
        ("R,3,,r1,X", "field"),
        ("K,4,1e10", "field"),
        ("K,5,nan", "field"),
        ("K,6,,1", "field"),
        ("A,1000,,1", "field"),
        ("R,7,,robot-123,I", "field"),
    ] {
        assert_eq!(reason(read(text, Some(NOW))), Err(expected), "{text}");
    }
    // The message still counts.
    let reading = read("A,11,,1", Some(NOW));
    assert_eq!(reading.gap.unwrap().reason.name(), "sequence");
    assert!(reading.message.is_ok());
    assert_eq!(read("A,12,,1", Some(NOW)).gap, None);
    assert_eq!(read("A,,,1", Some(NOW)).gap, None);
    let mut reader = CsvReader::default();
    let mut raw = |line: &[u8]| reason(reader.read(line, Some(NOW)));
    assert_eq!(raw(b"A,0,,1*00000"), Err("checksum"));
    assert_eq!(raw(b"A,0,,1"), Err("syntax"));
    assert_eq!(raw(&[0xff, 0x00]), Err("syntax"));
    assert_eq!(raw(&[b'x'; 90]), Err("too_long"));
    // Spaces around numbers, as controllers write them, are ignored.
    let padded = framed("B,  8, 123 ,  300.00, ");
    assert!(raw(padded.trim_end().as_bytes()).is_ok());
}

#[test]
fn times_are_near_to_now_or_to_the_line_before() {
    let stamp = |reading: CsvLine| decode(&reading.message.unwrap()).unwrap().stamp();
    let mut reader = CsvReader::default();
    let mut read = |text: &str, now: Option<f64>| {
        let line = framed(text);
        stamp(reader.read(line.trim_end().as_bytes(), now))
    };
    // 1,795,656,426 s are 1,795 turns and 656,426,000 ms.
    assert_eq!(read("K,0,656426123", Some(NOW)), NOW + 0.123);
    assert_eq!(read("K,1,656425000", Some(NOW)), NOW - 1.0);
    assert_eq!(read("K,2", Some(NOW)), NOW);
    // Around the end of a turn.
    let end = 1_796_000_000.0;
    assert_eq!(read("K,3,999999500", Some(end)), end - 0.5);
    assert_eq!(read("K,4,500", Some(end - 1.0)), end + 0.5);
    let mut reader = CsvReader::default();
    let mut read = |text: &str| {
        let line = framed(text);
        stamp(reader.read(line.trim_end().as_bytes(), None))
    };
    assert_eq!(read("K,0,100500"), 100.5);
    assert_eq!(read("K,1,999999999"), 0.999_999_999e6);
    assert_eq!(read("K,2,1"), 1e6 + 0.001);
}

#[test]
fn what_the_node_says_fits_on_its_lines() {
    let mut writer = CsvWriter::default();
    let mut write = |message: Outgoing| writer.write(&message).unwrap();
    let text = |line: &str| line.split('*').next().unwrap().to_owned();
    let cancel = Cancel {
        stamp: NOW,
        task: 7,
        robot: "r1".into(),
        reason: "the belt stopped, and then some more, far more than fits".into(),
    };
    let line = write(Outgoing::Cancel(cancel));
    assert_eq!(
        text(&line),
        "C,0,656426000,r1,7,the belt stopped_ and then some"
    );
    let mut status = Status {
        stamp: NOW + 0.0004,
        last: true,
        seen: 9,
        picked: 5,
        ..Status::default()
    };
    (status.missed.busy, status.missed.no_result) = (1, 2);
    let line = write(Outgoing::Status(Box::new(status)));
    assert_eq!(text(&line), "S,1,656426000,9,5,3,0,0,1");
    // One more line on a line that leaves items, with the next number.
    let leaving = Status {
        stamp: NOW,
        unwanted: Some(4),
        ..Status::default()
    };
    let lines = write(Outgoing::Status(Box::new(leaving)));
    let lines: Vec<String> = lines.lines().map(text).collect();
    assert_eq!(lines, ["S,2,656426000,0,0,0,0,0,0", "L,3,656426000,4"]);
    let due = Due {
        stamp: 100.5,
        next: None,
    };
    assert_eq!(text(&write(Outgoing::Due(due))), "U,4,100500,");
    let lines = write(Outgoing::Task(task(
        0,
        17,
        [0.25, 1.5, 0.75],
        (1.234, -0.0001),
    )));
    let lines: Vec<String> = lines.lines().map(text).collect();
    assert_eq!(lines[0], "I,5,17,camera_7__,PET,0.5,1300,-500,30,33.5");
    assert_eq!(
        lines[1],
        "T,6,656426000,scara-12,17,0,250,1500,750,1234,-0.1"
    );
    // What does not fit is not sent in part.
    let far = task(0, 17, [1e9, 1e9, 1e9], (1.0, 0.0));
    assert!(CsvWriter::default().write(&Outgoing::Task(far)).is_err());
}

#[test]
fn stations_fit_or_are_refused() {
    let station = |name: &str, length: f64| {
        let station = pickline::station::built_in("paper").unwrap();
        let station = station.station(Some(1)).unwrap();
        let (mut belt, mut robots) = (*station.belt(), station.robots().to_vec());
        (belt.length, robots[0].name) = (length, name.into());
        check_station(&Station::new(belt, robots).unwrap())
    };
    assert!(station("scara-12", 4.0).is_ok());
    for (name, length) in [
        ("scara-123", 4.0),
        ("a,b", 4.0),
        ("a*b", 4.0),
        ("\u{e9}", 4.0),
        ("a", 120.0),
    ] {
        let error = station(name, length).unwrap_err().to_string();
        assert!(
            error.starts_with("'dialect': ") && error.contains("cure: "),
            "{error}"
        );
    }
}

/// The tables of the documentation equal the one that reads and writes.
#[test]
fn the_page_has_the_fields_as_they_are() {
    let page = include_str!("../../../../../docs/dialect-csv.md");
    for form in TO_NODE.iter().chain(FROM_NODE) {
        let names = form.fields.iter().map(|field| field.name);
        let names: Vec<&str> = [form.letter, "n"].into_iter().chain(names).collect();
        let row = format!("| `{}` | {} |", names.join(","), form.about);
        assert!(page.contains(&row), "docs/dialect-csv.md lacks {row}");
        for field in form.fields {
            if let FieldKind::Choice(choices) = field.kind {
                for (letter, name) in choices {
                    let choice = format!("`{letter}` {name}");
                    assert!(page.contains(&choice), "docs/dialect-csv.md lacks {choice}");
                }
            }
        }
    }
    let mut examples = 0;
    for line in page
        .lines()
        .filter(|line| line.contains('*') && line.starts_with("    "))
    {
        let line = line.trim().trim_start_matches(['<', '>', ' ']);
        if let Some(text) = line
            .rsplit_once('*')
            .filter(|(_, sum)| sum.parse::<u16>().is_ok())
        {
            assert_eq!(framed(text.0).trim_end(), line);
            examples += 1;
        }
    }
    assert!(examples >= 6, "{examples}");
}
