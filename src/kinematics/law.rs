//! How long an arm takes for a path of a given length.

/// The travel-time law T(l) of an arm: the time [s] for a path of length l [m], from rest to rest.
#[derive(Debug, Clone, PartialEq)]
pub enum TravelLaw {
    /// Always at the same speed, the paper's arm: `l / u`.
    Constant {
        /// Speed u [m/s].
        speed: f64,
    },
    /// The trapezoidal velocity profile: accelerates, travels at top speed, decelerates. With
    /// `c = 1/a + 1/b` it takes `sqrt(2 l c)` up to the length `u^2 c / 2`, from which on top speed
    /// is reached, and `l / u + u c / 2` beyond (Biagiotti and Melchiorri, Trajectory Planning for
    /// Automatic Machines and Robots, 2008, DOI 10.1007/978-3-540-85629-0, section 3.2). That the
    /// arm ends with the velocity of the belt is neglected (`docs/model.md`).
    Trapezoid {
        /// Top speed u [m/s].
        speed: f64,
        /// Acceleration a [m/s^2].
        acceleration: f64,
        /// Deceleration b [m/s^2].
        deceleration: f64,
    },
    /// Measured points (l [m], t [s]), linear in between and with the last slope beyond the last
    /// point. At least two points; the first l is 0, l increases strictly, and t never decreases.
    Table(Vec<(f64, f64)>),
}

impl TravelLaw {
    /// Time [s] for a path of this length [m].
    #[inline]
    pub fn time(&self, length: f64) -> f64 {
        match self {
            Self::Constant { speed } => length / speed,
            Self::Trapezoid { speed, .. } => trapezoid_time(length, *speed, self.ramp()),
            Self::Table(points) => {
                let segment = segment_at(points, length);
                segment.start.1 + (length - segment.start.0) * segment.slope
            }
        }
    }

    /// The top speed u [m/s]; `None` for a table.
    pub fn top_speed(&self) -> Option<f64> {
        match self {
            Self::Constant { speed } | Self::Trapezoid { speed, .. } => Some(*speed),
            Self::Table(_) => None,
        }
    }

    /// `c = 1/a + 1/b` [s^2/m] of a trapezoidal profile: how much time per speed its ramps take.
    /// 0 for other laws.
    #[inline]
    pub(crate) fn ramp(&self) -> f64 {
        match self {
            Self::Trapezoid {
                acceleration,
                deceleration,
                ..
            } => 1.0 / acceleration + 1.0 / deceleration,
            _ => 0.0,
        }
    }

    /// The derivative of T at this length [s/m]; at a corner of a table, the one to its right.
    #[inline]
    pub(super) fn slope(&self, length: f64) -> f64 {
        match self {
            Self::Constant { speed } => 1.0 / speed,
            Self::Trapezoid { speed, .. } => {
                let c = self.ramp();
                if length < speed * speed * c / 2.0 {
                    (c / (2.0 * length)).sqrt()
                } else {
                    1.0 / speed
                }
            }
            Self::Table(points) => segment_at(points, length).slope,
        }
    }

    /// The steepest slope of T over all paths of at least this length [s/m]; infinite for a
    /// trapezoidal profile at length 0.
    pub fn steepest(&self, length: f64) -> f64 {
        match self {
            // The slope never increases with the length.
            Self::Constant { .. } | Self::Trapezoid { .. } => self.slope(length),
            Self::Table(points) => points
                .windows(2)
                .enumerate()
                .filter(|(i, pair)| pair[1].0 > length || i + 2 == points.len())
                .map(|(_, pair)| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0))
                .fold(0.0, f64::max),
        }
    }
}

/// Time [s] for a path of this length [m] with the top speed u [m/s] and `c = 1/a + 1/b` [s^2/m].
#[inline(always)]
pub(super) fn trapezoid_time(length: f64, speed: f64, c: f64) -> f64 {
    if length <= speed * speed * c / 2.0 {
        (2.0 * length * c).sqrt()
    } else {
        length / speed + speed * c / 2.0
    }
}

/// One linear piece of a table.
struct Piece {
    start: (f64, f64),
    slope: f64,
}

/// The piece of the table that contains this length; the last one beyond its end.
fn segment_at(points: &[(f64, f64)], length: f64) -> Piece {
    let after = points.partition_point(|point| point.0 <= length);
    let end = after.clamp(1, points.len() - 1);
    let (start, end) = (points[end - 1], points[end]);
    Piece {
        start,
        slope: (end.1 - start.1) / (end.0 - start.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delta_arm_takes_more_than_its_top_speed_suggests() {
        let law = TravelLaw::Trapezoid {
            speed: 10.0,
            acceleration: 100.0,
            deceleration: 100.0,
        };
        assert!((law.time(0.305) - 0.110_453_6).abs() < 1e-6);
        // Top speed is reached after 1 m; both forms agree there.
        assert!((law.time(1.0) - 0.2).abs() < 1e-15);
        assert!((law.time(2.0) - 0.3).abs() < 1e-15);
        assert_eq!(law.time(0.0), 0.0);
        assert_eq!(law.steepest(0.0), f64::INFINITY);
        assert!((law.steepest(0.02) - (0.02f64 / 0.04).sqrt()).abs() < 1e-15);
        assert_eq!(law.steepest(3.0), 0.1);
    }

    #[test]
    fn unlike_ramps_add_up() {
        let law = TravelLaw::Trapezoid {
            speed: 2.0,
            acceleration: 10.0,
            deceleration: 5.0,
        };
        // Ramps of 0.2 s and 0.4 s over 0.6 m, then 1 m at 2 m/s.
        assert!((law.time(0.6) - 0.6).abs() < 1e-15);
        assert!((law.time(1.6) - 1.1).abs() < 1e-15);
    }

    #[test]
    fn a_table_is_linear_between_its_points_and_beyond() {
        let law = TravelLaw::Table(vec![(0.0, 0.08), (0.1, 0.15), (0.3, 0.15), (0.5, 0.25)]);
        for (length, time) in [
            (0.0, 0.08),
            (0.05, 0.115),
            (0.1, 0.15),
            (0.2, 0.15),
            (0.4, 0.2),
            (0.7, 0.35),
        ] {
            assert!((law.time(length) - time).abs() < 1e-12, "{length}");
        }
        for (from, slope) in [(0.0, 0.7), (0.09, 0.7), (0.1, 0.5), (0.4, 0.5), (9.0, 0.5)] {
            assert!((law.steepest(from) - slope).abs() < 1e-12, "{from}");
        }
    }
}
