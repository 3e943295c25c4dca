//! Progress on stderr: a bar with rate and remaining time.

use crate::optimize::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Mutex;
use std::time::Duration;

/// A bar a stage; draws nothing when quiet or when stderr is not a terminal.
pub struct Bar {
    bar: Mutex<ProgressBar>,
    quiet: bool,
}

impl Bar {
    /// A sink that shows nothing until a stage begins.
    pub fn new(quiet: bool) -> Self {
        Self {
            bar: Mutex::new(ProgressBar::hidden()),
            quiet,
        }
    }

    fn with(&self, action: impl FnOnce(&mut ProgressBar)) {
        // A poisoned lock means that another thread panicked; progress is no reason
        // to panic too.
        if let Ok(mut bar) = self.bar.lock() {
            action(&mut bar);
        }
    }
}

impl Progress for Bar {
    fn begin(&self, stage: &str, total: u64, unit: &str) {
        if self.quiet {
            return;
        }
        let bar = ProgressBar::new(total);
        bar.set_draw_target(ProgressDrawTarget::stderr());
        let template = format!(
            "{{prefix:>13}} [{{bar:32}}] {{pos}}/{{len}} {unit}, {{per_sec}}, ETA {{eta}} {{msg}}"
        );
        // The template is valid; a mistake in it would only lose the style.
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_prefix(stage.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        self.with(|current| *current = bar);
    }

    fn advance(&self, steps: u64) {
        self.with(|bar| bar.inc(steps));
    }

    fn incumbent(&self, text: &str) {
        self.with(|bar| bar.set_message(format!("best {text}")));
    }

    fn end(&self) {
        self.with(|bar| bar.finish_and_clear());
    }
}
