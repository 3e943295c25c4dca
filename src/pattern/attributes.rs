//! Item areas and probabilities drawn from given distributions.

use super::class_shares::ClassShares;
use super::item::{Item, Pattern, is_amount, is_share};
use crate::error::{Error, Result, known_names, shown, shown_number};
use crate::setters::setters;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Beta, Distribution as _, LogNormal};
use std::fmt;
use std::str::FromStr;

/// A distribution, parsed from a text such as `lognormal:80,0.5`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distribution {
    /// `const:V`: always V.
    Constant(f64),
    /// `uniform:A,B`: uniform from A to B.
    Uniform(f64, f64),
    /// `lognormal:M,S`: median M, standard deviation S of the logarithm.
    LogNormal(f64, f64),
    /// `beta:A,B`: on 0 to 1, with shape parameters A and B.
    Beta(f64, f64),
}

/// The form of every distribution, for help texts and messages.
const FORMS: &[(&str, &str)] = &[
    ("const", "const:V"),
    ("uniform", "uniform:LOW,HIGH"),
    ("lognormal", "lognormal:MEDIAN,SIGMA"),
    ("beta", "beta:A,B"),
];

impl FromStr for Distribution {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let forms = || FORMS.iter().map(|f| f.1).collect::<Vec<_>>().join(", ");
        let wrong = |problem: String| {
            Error::usage(
                format!("distribution `{}`", shown(text)),
                problem,
                format!("write one of {}", forms()),
            )
        };
        let (name, rest) = text
            .split_once(':')
            .ok_or_else(|| wrong("no `:` between name and numbers".into()))?;
        let numbers: Vec<f64> = rest
            .split(',')
            .map(|part| part.trim().parse().ok().filter(|n: &f64| n.is_finite()))
            .collect::<Option<_>>()
            .ok_or_else(|| wrong(format!("`{}` is not a list of numbers", shown(rest))))?;
        match (name, numbers.as_slice()) {
            ("const", &[v]) => Ok(Self::Constant(v)),
            ("uniform", &[a, b]) if a <= b => Ok(Self::Uniform(a, b)),
            ("uniform", &[a, b]) => Err(wrong(format!("{a} is greater than {b}"))),
            ("lognormal", &[m, s]) if m > 0.0 && s >= 0.0 => Ok(Self::LogNormal(m, s)),
            ("beta", &[a, b]) if a > 0.0 && b > 0.0 => Ok(Self::Beta(a, b)),
            (known, _) if FORMS.iter().any(|f| f.0 == known) => Err(wrong(
                "wrong number of parameters, or a parameter out of range".into(),
            )),
            _ => {
                let names: Vec<_> = FORMS.iter().map(|f| f.0).collect();
                Err(wrong(format!(
                    "unknown name; {}",
                    known_names(name, &names)
                )))
            }
        }
    }
}

impl fmt::Display for Distribution {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Constant(v) => write!(f, "const:{}", shown_number(*v)),
            Self::Uniform(a, b) => write!(f, "uniform:{},{}", shown_number(*a), shown_number(*b)),
            Self::LogNormal(m, s) => {
                write!(f, "lognormal:{},{}", shown_number(*m), shown_number(*s))
            }
            Self::Beta(a, b) => write!(f, "beta:{},{}", shown_number(*a), shown_number(*b)),
        }
    }
}

impl Distribution {
    /// Draws one value.
    fn draw(&self, rng: &mut ChaCha8Rng) -> f64 {
        // The parameters were checked when the text was parsed, so the fallbacks of the two library
        // distributions are never used.
        match *self {
            Self::Constant(v) => v,
            Self::Uniform(a, b) => a + (b - a) * rng.random::<f64>(),
            Self::LogNormal(m, s) => {
                LogNormal::new(m.ln(), s).map_or(m, |distribution| distribution.sample(rng))
            }
            Self::Beta(a, b) => {
                Beta::new(a, b).map_or(a / (a + b), |distribution| distribution.sample(rng))
            }
        }
    }
}

/// The valid range of drawn values.
struct ValueRange {
    holds: fn(f64) -> bool,
    name: &'static str,
    cure: &'static str,
}

const AREA: ValueRange = ValueRange {
    holds: is_amount,
    name: "an area",
    cure: "choose a distribution within 0 to 1e12 cm^2",
};
const SHARE: ValueRange = ValueRange {
    holds: is_share,
    name: "a probability",
    cure: "choose a distribution within 0 to 1: beta, or uniform between these limits",
};

impl ValueRange {
    fn checked(&self, setting: &str, distribution: &Distribution, value: f64) -> Result<f64> {
        if (self.holds)(value) {
            return Ok(value);
        }
        Err(Error::usage(
            format!("{setting} {distribution}"),
            format!("drew {}, which is not {}", shown_number(value), self.name),
            self.cure,
        ))
    }
}

/// What generated items have besides their position; `None` leaves the field empty.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Attributes {
    /// Area of an item [cm^2].
    pub area_cm2: Option<Distribution>,
    /// Probability that the detection is a real item.
    pub p_detection: Option<Distribution>,
    /// Probability that a grasp succeeds.
    pub p_grasp: Option<Distribution>,
    /// Classes and their shares.
    pub classes: Option<ClassShares>,
}

setters!(Attributes {
    /// With areas [cm^2] from this distribution.
    fn with_area_cm2(area_cm2: impl Into<Option<Distribution>>);
    /// With probabilities that the detection is a real item from this distribution.
    fn with_p_detection(p_detection: impl Into<Option<Distribution>>);
    /// With probabilities that a grasp succeeds from this distribution.
    fn with_p_grasp(p_grasp: impl Into<Option<Distribution>>);
    /// With classes in these shares.
    fn with_classes(classes: impl Into<Option<ClassShares>>);
});

impl Attributes {
    /// The attributes that these texts describe: areas [cm^2] and probabilities from distributions,
    /// and classes with their shares.
    ///
    /// # Errors
    /// A text that is not a distribution, or not a list of classes.
    pub fn named(
        area_cm2: Option<&str>,
        p_detection: Option<&str>,
        p_grasp: Option<&str>,
        classes: Option<&str>,
    ) -> Result<Self> {
        fn read<T: FromStr<Err = Error>>(setting: &str, text: Option<&str>) -> Result<Option<T>> {
            let read = |text: &str| {
                let place = format!("{setting} {}", shown(text));
                text.parse().map_err(|error: Error| error.at(&place))
            };
            text.map(read).transpose()
        }
        Ok(Self {
            area_cm2: read("'area_cm2'", area_cm2)?,
            p_detection: read("'p_detection'", p_detection)?,
            p_grasp: read("'p_grasp'", p_grasp)?,
            classes: read("'classes'", classes)?,
        })
    }

    /// The pattern with these attributes drawn for every item, in index order.
    ///
    /// # Errors
    /// If a distribution gives a value that is not a valid area or probability.
    pub fn apply(&self, pattern: Pattern, rng: &mut ChaCha8Rng) -> Result<Pattern> {
        if *self == Self::default() {
            return Ok(pattern);
        }
        let mut draw = |setting: &str, distribution: &Option<Distribution>, range: &ValueRange| {
            distribution
                .as_ref()
                .map(|d| range.checked(setting, d, d.draw(rng)))
                .transpose()
        };
        let with_attributes = |item: &Item| {
            Ok(Item {
                area_cm2: draw("'area_cm2'", &self.area_cm2, &AREA)?,
                p_detection: draw("'p_detection'", &self.p_detection, &SHARE)?,
                p_grasp: draw("'p_grasp'", &self.p_grasp, &SHARE)?,
                ..item.clone()
            })
        };
        let items = pattern.items().iter().map(with_attributes);
        let pattern = Pattern::new(items.collect::<Result<_>>()?)?;
        // Last, so that classes change nothing else.
        match &self.classes {
            Some(classes) => classes.apply(&pattern, rng),
            None => Ok(pattern),
        }
    }

    /// Description for provenance: `area lognormal:80,0.5, p_grasp beta:8,2`.
    pub fn describe(&self) -> String {
        let named = [
            ("area", &self.area_cm2),
            ("p_detection", &self.p_detection),
            ("p_grasp", &self.p_grasp),
        ];
        let parts: Vec<String> = named
            .iter()
            .filter_map(|(name, d)| d.as_ref().map(|d| format!("{name} {d}")))
            .chain(
                self.classes
                    .iter()
                    .map(|shares| format!("classes {shares}")),
            )
            .collect();
        if parts.is_empty() {
            "no areas or probabilities".into()
        } else {
            parts.join(", ")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{grid, random_stream};

    #[test]
    fn text_and_back() {
        for text in ["const:3", "uniform:1,2", "lognormal:80,0.5", "beta:8,2"] {
            assert_eq!(text.parse::<Distribution>().unwrap().to_string(), text);
        }
        for (bad, problem) in [
            ("", "no `:` between name and numbers"),
            ("const", "no `:` between name and numbers"),
            ("const:x", "`x` is not a list of numbers"),
            ("uniform:2,1", "2 is greater than 1"),
            (
                "beta:0,1",
                "wrong number of parameters, or a parameter out of range",
            ),
            ("betta:1,2", "unknown name; did you mean `beta`"),
            ("const:nan", "`nan` is not a list of numbers"),
        ] {
            let message = bad.parse::<Distribution>().unwrap_err().to_string();
            assert!(message.contains(problem), "{bad}: {message}");
        }
    }

    #[test]
    fn draws_follow_the_stated_distribution() {
        let attributes = Attributes {
            area_cm2: Some("lognormal:80,0.5".parse().unwrap()),
            p_detection: Some("uniform:0.6,1".parse().unwrap()),
            p_grasp: Some("beta:8,2".parse().unwrap()),
            classes: Some("pet:0.6,wood:0.4".parse().unwrap()),
        };
        let plain = grid(1.0, 0.1, 20_000).unwrap();
        let drawn = attributes.apply(plain, &mut random_stream(1, 0)).unwrap();
        let n = drawn.len() as f64;
        let mean = |f: &dyn Fn(&Item) -> f64| drawn.items().iter().map(f).sum::<f64>() / n;
        let log_area = mean(&|i| i.area_cm2.unwrap().ln());
        assert!((log_area - 80f64.ln()).abs() < 0.02, "{log_area}");
        assert!((mean(&|i| i.p_detection.unwrap()) - 0.8).abs() < 0.01);
        assert!((mean(&|i| i.p_grasp.unwrap()) - 0.8).abs() < 0.01);
        let pet = |i: &Item| f64::from(i.class.as_deref() == Some("pet"));
        assert!((mean(&pet) - 0.6).abs() < 0.01);
        let same = Attributes {
            classes: None,
            ..attributes
        };
        let plain = grid(1.0, 0.1, 20_000).unwrap();
        let without = same.apply(plain, &mut random_stream(1, 0)).unwrap();
        let areas = |p: &Pattern| -> Vec<_> { p.items().iter().map(|i| i.area_cm2).collect() };
        assert_eq!(
            areas(&without),
            areas(&drawn),
            "classes change nothing else"
        );
    }

    #[test]
    fn a_distribution_that_leaves_its_range_is_an_error() {
        let attributes = Attributes {
            p_grasp: Some(Distribution::Uniform(0.5, 3.0)),
            ..Attributes::default()
        };
        let plain = grid(1.0, 0.1, 100).unwrap();
        let error = attributes.apply(plain, &mut random_stream(1, 0));
        let message = error.unwrap_err().to_string();
        assert!(
            message.starts_with("'p_grasp' uniform:0.5,3: "),
            "{message}"
        );
    }
}
