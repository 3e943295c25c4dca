//! The text form of a source of patterns.

use super::feed::{FEEDS, Feed};
use super::feeder::check_flow;
use super::source::{BALANCED_EACH, PatternSource};
use crate::error::{Error, Result, counted, known_names, shown, shown_number};
use crate::files::is_path;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// The form of every source, for messages; keep in sync with the help of the command line.
const FORMS: &str = "balanced[:N], grid:SPACING, poisson:RADIUS[:N], a CSV file or a folder of \
     them; or by flow FEED[:F/min][:N], FEED being grid, poisson, random, clustered, gaps or \
     profile:FILE";
/// The suffix of a flow in the form of a source.
const PER_MINUTE: &str = "/min";

impl FromStr for PatternSource {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let source = SourceText(text);
        let parts: Vec<&str> = text.split(':').collect();
        if let ["profile", rest @ ..] = parts.as_slice() {
            return source.profile(rest);
        }
        if let [name, rest @ ..] = parts.as_slice()
            && let Some(feed) = Feed::named(name)
            && (!has_length(&feed) || rest.first().is_none_or(|p| p.ends_with(PER_MINUTE)))
        {
            return source.feed(feed, name, rest);
        }
        match parts.as_slice() {
            ["balanced"] => Ok(Self::Balanced(BALANCED_EACH)),
            ["balanced", n] => Ok(Self::Balanced(source.count(n)?)),
            ["grid", s] => Ok(Self::Grid(source.length(s)?)),
            ["poisson", r] => Ok(Self::Poisson(source.length(r)?, BALANCED_EACH)),
            ["poisson", r, n] => Ok(Self::Poisson(source.length(r)?, source.count(n)?)),
            _ if Path::new(text).exists() => Ok(Self::Files(text.into())),
            [name, ..] => {
                let known: Vec<&str> = FEEDS.iter().map(|f| f.0).chain(["balanced"]).collect();
                let place = source.place();
                let problem = "not a known kind of pattern, and no such file or folder exists";
                let cure = format!("write one of {FORMS}; {}", known_names(name, &known));
                Err(match is_path(name) {
                    true => Error::path(place, problem, cure),
                    false => Error::usage(place, problem, cure),
                })
            }
            [] => Err(source.wrong("empty")),
        }
    }
}

/// A source as it was given.
struct SourceText<'a>(&'a str);

impl SourceText<'_> {
    fn place(&self) -> String {
        format!("'patterns' {}", shown(self.0))
    }

    fn wrong(&self, problem: impl Into<String>) -> Error {
        Error::usage(self.place(), problem, format!("write one of {FORMS}"))
    }

    /// A length [m].
    fn length(&self, part: &str) -> Result<f64> {
        part.parse()
            .ok()
            .filter(|value: &f64| value.is_finite() && *value > 0.0)
            .ok_or_else(|| self.wrong(format!("`{}` is not a valid length [m]", shown(part))))
    }

    /// A number of patterns.
    fn count(&self, part: &str) -> Result<usize> {
        part.parse()
            .ok()
            .filter(|&n: &usize| (1..=1_000_000).contains(&n))
            .ok_or_else(|| self.wrong(format!("`{}` is not a valid count", shown(part))))
    }

    /// A flow [1/min] with its suffix.
    fn flow(&self, part: &str) -> Result<f64> {
        let number = part.strip_suffix(PER_MINUTE).map(str::parse);
        let flow = number
            .and_then(|n| n.ok())
            .filter(|&f| check_flow(f).is_ok());
        flow.ok_or_else(|| self.wrong(format!("`{}` is not a valid flow", shown(part))))
    }

    /// A profile from the parts after its name; the file's name may contain colons.
    fn profile(&self, rest: &[&str]) -> Result<PatternSource> {
        let (file, count) = match rest {
            [file @ .., last] if !file.is_empty() && last.parse::<u64>().is_ok() => {
                (file, self.count(last)?)
            }
            _ => (rest, BALANCED_EACH),
        };
        let (file, flow) = match file {
            [file @ .., last] if !file.is_empty() && last.ends_with(PER_MINUTE) => {
                (file, Some(self.flow(last)?))
            }
            _ => (file, None),
        };
        if file.iter().all(|part| part.is_empty()) {
            return Err(self.wrong("profile needs a file"));
        }
        let feed = Feed::Profile(file.join(":").into());
        Ok(PatternSource::Feed { feed, flow, count })
    }

    /// Another feed from the parts after its `name`.
    fn feed(&self, feed: Feed, name: &str, rest: &[&str]) -> Result<PatternSource> {
        let usual = if feed.is_random() { BALANCED_EACH } else { 1 };
        let (flow, count) = match rest {
            [] => (None, usual),
            [f] if f.ends_with(PER_MINUTE) => (Some(self.flow(f)?), usual),
            [n] if feed.is_random() => (None, self.count(n)?),
            [f, n] if feed.is_random() => (Some(self.flow(f)?), self.count(n)?),
            _ => return Err(self.wrong(format!("too many parts for {name}"))),
        };
        Ok(PatternSource::Feed { feed, flow, count })
    }
}

impl fmt::Display for PatternSource {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Balanced(n) => write!(f, "balanced:{n}"),
            Self::Grid(s) => write!(f, "grid:{}", shown_number(*s)),
            Self::Poisson(r, n) => write!(f, "poisson:{}:{n}", shown_number(*r)),
            Self::Feed { feed, flow, count } => {
                write!(f, "{feed}")?;
                if let Some(flow) = flow {
                    write!(f, ":{}{PER_MINUTE}", shown_number(*flow))?;
                }
                // `poisson:N` alone would be a radius.
                if feed.is_random() && (flow.is_some() || !has_length(feed)) {
                    write!(f, ":{count}")?;
                }
                Ok(())
            }
            Self::Files(path) => write!(f, "{}", path.display()),
            Self::Given(patterns) => f.write_str(&counted(patterns.len(), "given pattern")),
        }
    }
}

/// Whether the feed's name also denotes a pattern that is specified by a length.
fn has_length(feed: &Feed) -> bool {
    matches!(feed, Feed::Grid | Feed::PoissonDisk)
}
