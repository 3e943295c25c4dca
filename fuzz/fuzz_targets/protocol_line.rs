#![no_main]
//! A line of the live protocol: whatever is accepted is written back as the same message,
//! whatever is refused is refused in one short line.

use libfuzzer_sys::fuzz_target;
use pickline::live::protocol::{decode, decode_outgoing, encode};

fuzz_target!(|line: &[u8]| {
    match decode(line) {
        Ok(message) => {
            let written = encode(&message);
            assert_eq!(decode(written.trim_end().as_bytes()).unwrap(), message);
        }
        Err(rejected) => {
            assert!(!rejected.message.contains(char::is_control));
            assert!(rejected.message.len() < 4096);
        }
    }
    let _ = decode_outgoing(line);
});
