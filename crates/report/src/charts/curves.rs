//! Learning curves of several trainings in one chart.

use super::axis::ChartAxis;
use super::chart::{Chart, ChartMark, ChartPoint, Ink, Layer, LegendLine, PointStyle, Swatch};
use super::draw::for_paper;
use pickline::error::{Error, Result};

/// How good a policy was at each time of its training, whoever trained it.
#[derive(Debug, Clone, PartialEq)]
pub struct LearningCurve {
    /// The trainer. Curves of the same one are drawn alike and have one line in the legend.
    pub name: String,
    /// Number of decisions learned from, and then the picking rate as a share of that of the best rules
    /// for every single pattern (greedy GT).
    pub points: Vec<(f64, f64)>,
}

/// The curves as an SVG file.
///
/// # Errors
/// No curve, one without points, or a number that is NaN or infinite.
pub fn learning_curves_svg(curves: &[LearningCurve]) -> Result<String> {
    let wrong = |place: String, problem: &str, cure: &str| Err(Error::input(place, problem, cure));
    if curves.is_empty() {
        return wrong(
            "the learning curves".into(),
            "there are none",
            "give one or more",
        );
    }
    for curve in curves {
        let place = || format!("the learning curve of {}", curve.name);
        if curve.points.is_empty() {
            return wrong(place(), "it has no points", "give one or more");
        }
        let finite = |(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
        if !curve.points.iter().all(finite) {
            return wrong(
                place(),
                "it has NaN or infinite numbers",
                "give finite numbers",
            );
        }
    }
    Ok(for_paper(chart(curves), None))
}

fn chart(curves: &[LearningCurve]) -> Chart {
    let mut names: Vec<&str> = Vec::new();
    let mut layers = Vec::new();
    for curve in curves {
        let known = names.iter().position(|name| *name == curve.name);
        let series = known.unwrap_or_else(|| {
            names.push(&curve.name);
            names.len() - 1
        });
        let point = |(decisions, share): &(f64, f64)| ChartPoint {
            x: decisions / 1000.0,
            y: 100.0 * share,
            ..ChartPoint::default()
        };
        layers.push(Layer::Points {
            ink: Ink::Series(series),
            style: PointStyle::Bare,
            points: curve.points.iter().map(point).collect(),
        });
    }
    let legend = names.iter().enumerate().map(|(series, name)| LegendLine {
        label: (*name).to_owned(),
        ink: Ink::Series(series),
        swatch: Swatch::Bare,
    });
    let legend = legend.collect();
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let learned = points().map(|(decisions, _)| *decisions);
    let shares = points().map(|(_, share)| 100.0 * share);
    let title = "Learning curves";
    let caption = "Mean picking rate on the cases, as a share of that of the best rules for every \
                   single pattern (greedy GT, game theory), one line a training.";
    learning_chart(title, caption, learned, shares.collect(), layers, legend)
}

/// A chart of picking rates [%] as shares of greedy GT's, whose place is marked, over the number of
/// decisions `learned` from.
pub(super) fn learning_chart(
    title: &str,
    caption: &str,
    learned: impl Iterator<Item = f64>,
    shares: Vec<f64>,
    layers: Vec<Layer>,
    legend: Vec<LegendLine>,
) -> Chart {
    let greedy = 100.0;
    let thousands: Vec<f64> = learned.map(|decisions| decisions / 1000.0).collect();
    let last = thousands.iter().copied().fold(0.0, f64::max);
    let shares = shares.into_iter().chain([greedy]);
    Chart {
        title: title.into(),
        caption: caption.into(),
        // A training ends at a round number or just after it; the next tick may be far.
        x: ChartAxis::around("decisions learned from [1000]", thousands, true).up_to(last),
        y: ChartAxis::around("picking rate to greedy GT [%]", shares, false),
        layers,
        marks: vec![ChartMark {
            at: greedy,
            upright: false,
            ink: Ink::Text,
            shade_to: None,
            label: String::new(),
        }],
        legend,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(name: &str, points: &[(f64, f64)]) -> LearningCurve {
        LearningCurve {
            name: name.into(),
            points: points.to_vec(),
        }
    }

    #[test]
    fn trainings_of_one_trainer_share_their_ink_and_their_legend() {
        let points = [(0.0, 0.7), (2000.0, 0.9)];
        let chart = chart(&[
            curve("a", &points),
            curve("b", &points),
            curve("a", &points),
        ]);
        let inks = chart.layers.iter().map(|layer| match layer {
            Layer::Points { ink, points, .. } => {
                assert_eq!((points[1].x, points[1].y), (2.0, 90.0));
                *ink
            }
            other => panic!("{other:?}"),
        });
        let (a, b) = (Ink::Series(0), Ink::Series(1));
        assert_eq!(inks.collect::<Vec<_>>(), [a, b, a]);
        let labels: Vec<&str> = chart
            .legend
            .iter()
            .map(|line| line.label.as_str())
            .collect();
        assert_eq!(labels, ["a", "b"]);
    }

    #[test]
    fn what_cannot_be_drawn_is_told() {
        for (curves, problem) in [
            (vec![], "there are none"),
            (vec![curve("a", &[])], "curve of a: it has no points"),
            (vec![curve("a", &[(0.0, f64::NAN)])], "NaN"),
        ] {
            let error = learning_curves_svg(&curves).unwrap_err().to_string();
            assert!(error.contains(problem), "{error}");
        }
        assert!(
            learning_curves_svg(&[curve("a", &[(0.0, 1.0)])])
                .unwrap()
                .contains("<svg")
        );
    }
}
