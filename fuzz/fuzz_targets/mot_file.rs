#![no_main]
//! A tracker's file of any form: whatever is accepted is a pattern that reads back.

use libfuzzer_sys::fuzz_target;
use pickline::pattern::tracking::{ImageAxis, ImportOptions, Recording, import};
use pickline::pattern::{parse, to_csv};

fuzz_target!(|text: &str| {
    let recording = Recording::Text(text.to_owned());
    for (axis, min_frames) in [(ImageAxis::X, 1), (ImageAxis::Y, 2)] {
        let mut options = ImportOptions::new(10.0, 0.001, axis, 0.1);
        options.min_frames = min_frames;
        let Ok(import) = import(&recording, "m", &options) else {
            continue;
        };
        import.report.lines();
        let again = parse(&to_csv(&import.pattern), "t").unwrap();
        assert_eq!(again, import.pattern);
    }
});
