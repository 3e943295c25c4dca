//! Progress on stderr: a bar with the rate and the remaining time.

use super::session::tell;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use pickline::error::grouped;
use pickline::optimize::Progress;
use std::fmt::Write;
use std::io::{self, IsTerminal};
use std::sync::Mutex;
use std::time::Duration;

/// One bar per stage; draws nothing if quiet or if stderr is not a terminal.
pub(crate) struct Bar {
    shown: Mutex<Shown>,
    quiet: bool,
    /// What is said when work begins and no bar can be drawn.
    otherwise: &'static str,
}

struct Shown {
    bar: ProgressBar,
    best: String,
    doing: String,
}

impl Bar {
    /// A bar that shows nothing until a stage begins.
    pub(crate) fn new(quiet: bool) -> Self {
        Self {
            shown: Mutex::new(Shown::new(ProgressBar::hidden())),
            quiet,
            otherwise: "",
        }
    }

    /// The bar of a search before a line starts. Where stderr is no terminal, it says what begins: its user
    /// may not expect the work.
    pub(crate) fn before_a_line(quiet: bool) -> Self {
        Self {
            otherwise: "searching for the assignments that the look-ahead starts from; a strategy with \
                        bases=... starts at once",
            ..Self::new(quiet)
        }
    }

    fn with(&self, action: impl FnOnce(&mut Shown)) {
        // A poisoned lock means that another thread panicked; progress is not worth
        // another panic.
        if let Ok(mut shown) = self.shown.lock() {
            action(&mut shown);
        }
    }
}

impl Shown {
    fn new(bar: ProgressBar) -> Self {
        Self {
            bar,
            best: String::new(),
            doing: String::new(),
        }
    }

    /// Updates the text after the bar.
    fn say(&self) {
        let words = [&self.doing, &self.best];
        let words: Vec<&str> = words.into_iter().map(String::as_str).collect();
        self.bar.set_message(words.join(" ").trim().to_owned());
    }
}

impl Progress for Bar {
    fn begin(&self, stage: &str, total: u64, unit: &str) {
        if self.quiet {
            return;
        }
        if !self.otherwise.is_empty() && !io::stderr().is_terminal() {
            tell(self.otherwise);
        }
        let bar = ProgressBar::new(total);
        bar.set_draw_target(ProgressDrawTarget::stderr());
        let template = format!(
            "{{prefix:>13}} [{{bar:32}}] {{pos}}/{{len}} {unit}, {{rate}}, ETA {{eta}} {{msg}}"
        );
        // The template is valid; an error in it would only lose the style.
        if let Ok(style) = ProgressStyle::with_template(&template) {
            let style = style.with_key("rate", |state: &ProgressState, to: &mut dyn Write| {
                let _ = to.write_str(&rate_text(state.per_sec()));
            });
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_prefix(stage.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        self.with(|shown| *shown = Shown::new(bar));
    }

    fn advance(&self, steps: u64) {
        self.with(|shown| shown.bar.inc(steps));
    }

    fn doing(&self, text: &str) {
        self.with(|shown| {
            text.clone_into(&mut shown.doing);
            shown.say();
        });
    }

    fn incumbent(&self, text: &str) {
        self.with(|shown| {
            shown.best = format!("best {text}");
            shown.say();
        });
    }

    fn end(&self) {
        self.with(|shown| shown.bar.finish_and_clear());
    }
}

/// A number of steps per second: a whole number, or with one decimal if it is small.
fn rate_text(per_second: f64) -> String {
    if per_second < 9.95 {
        return format!("{per_second:.1}/s");
    }
    grouped(per_second.round() as u64) + "/s"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_whole_numbers_where_that_says_enough() {
        for (rate, text) in [
            (0.0, "0.0/s"),
            (0.34, "0.3/s"),
            (9.94, "9.9/s"),
            (9.96, "10/s"),
            (999.6, "1,000/s"),
            (16_538.388_2, "16,538/s"),
            (1_234_567.9, "1,234,568/s"),
        ] {
            assert_eq!(rate_text(rate), text);
        }
    }
}
