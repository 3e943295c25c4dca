//! A stream for tests.

use std::io::Write;
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

/// Longer than anything takes on a slow machine.
const WRITE_TIMEOUT: Duration = Duration::from_secs(300);

/// A stream that blocks writes until it is opened.
#[derive(Clone, Default)]
pub struct Gate(Arc<(Mutex<Taken>, Condvar)>);

#[derive(Default)]
struct Taken {
    open: bool,
    bytes: Vec<u8>,
}

impl Gate {
    /// Opens it for all writes.
    pub fn open(&self) {
        self.0.0.lock().unwrap().open = true;
        self.0.1.notify_all();
    }

    /// The bytes written so far.
    pub fn bytes(&self) -> Vec<u8> {
        self.0.0.lock().unwrap().bytes.clone()
    }

    /// The same as text.
    pub fn text(&self) -> String {
        String::from_utf8(self.bytes()).unwrap()
    }

    /// Waits until `words` have been written.
    pub fn wait_for(&self, words: &str) {
        let state = self.0.0.lock().unwrap();
        let lacks = |taken: &mut Taken| !String::from_utf8_lossy(&taken.bytes).contains(words);
        let waited = self.0.1.wait_timeout_while(state, WRITE_TIMEOUT, lacks);
        assert!(
            !waited.unwrap().1.timed_out(),
            "timed out waiting for {words}"
        );
    }
}

impl Write for Gate {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let state = self.0.0.lock().unwrap();
        let mut state = self.0.1.wait_while(state, |state| !state.open).unwrap();
        state.bytes.extend_from_slice(bytes);
        self.0.1.notify_all();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
