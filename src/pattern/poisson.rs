//! Maximal Poisson disk patterns.
//!
//! Bridson, "Fast Poisson disk sampling in arbitrary dimensions", SIGGRAPH 2007 sketches (DOI
//! 10.1145/1278780.1278807), followed by two steps that make the sample *maximal*: no further item
//! would fit. The first throws darts at the uncovered area, represented by squares that are
//! repeatedly subdivided (Ebeida et al., "A simple algorithm for maximal Poisson-disk sampling in
//! high dimensions", Computer Graphics Forum 31, 2012, DOI 10.1111/j.1467-8659.2012.03059.x), so
//! that the added items are as random as the others. The second is deterministic: an uncovered
//! region has a corner where two circles of radius r around items cross, or where such a circle
//! meets the border of the strip, and all these points are checked.

use super::grid::{check_count, check_length, check_spacing};
use super::item::{Item, MOST_ITEMS, Pattern};
use crate::error::{Error, Result, shown_number};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// Darts thrown around an active item before it is retired (Bridson's k).
const TRIES: usize = 30;
/// Darts thrown per uncovered square before the squares are quartered.
const DARTS: usize = 4;
/// How often the squares are quartered. What remains is smaller than a hundredth of the radius and
/// is left to the corners.
const QUARTERINGS: usize = 8;
/// Density of a maximal sample: the belt's width in radii, and the items per radius of belt.
/// Measured on samples of 60,000 items. A line of items has Renyi's parking constant, 0.7476. Wide
/// belts approach the jamming density of discs (Feder, "Random sequential adsorption", Journal of
/// Theoretical Biology 87, 1980, DOI 10.1016/0022-5193(80)90358-6), 0.547 of the plane, which is
/// 0.697 items per square radius.
const MEASURED: [(f64, f64); 19] = [
    (0.001, 0.7473),
    (0.2, 0.755),
    (0.4, 0.7746),
    (0.6, 0.8195),
    (0.8, 0.9026),
    (0.9, 0.9847),
    (0.95, 1.0476),
    (1.0, 1.1161),
    (1.05, 1.1899),
    (1.1, 1.2498),
    (1.25, 1.3834),
    (1.5, 1.5427),
    (2.0, 1.8305),
    (3.0, 2.5349),
    (4.0, 3.2105),
    (6.0, 4.5934),
    (10.0, 7.3428),
    (20.0, 14.1827),
    (50.0, 34.8223),
];
/// Items keep this multiple of the radius, so that rounding cannot bring a distance below the
/// radius when the pattern is shifted.
const MARGIN: f64 = 1.0 + 1e-9;
/// Maximum number of background cells, enough for the largest pattern, to limit memory use.
const MOST_CELLS: f64 = 5.0 * MOST_ITEMS as f64;

/// `count` items on a belt of `width` [m], no two closer than `radius` [m], so dense that no
/// further item would fit between them. The first item is at x0 = 0.
///
/// # Errors
/// If the radius is not a positive length, or there are no items or too many.
pub fn poisson_disk(
    width: f64,
    radius: f64,
    count: usize,
    rng: &mut ChaCha8Rng,
) -> Result<Pattern> {
    check_spacing("radius", radius)?;
    check_count(count)?;
    // A maximal sample has about 0.7 items per square radius, and its border acts as if the strip
    // were about one radius wider. The extra length keeps the upstream end, where the strip is cut,
    // outside the kept items.
    let mut length = radius * (count as f64 * radius / (0.62 * (width + radius)) + 4.0);
    check_length(count, length)?;
    let mut points = loop {
        // Even a few items are the start of a sample over the whole width.
        if 2.0 * (length / radius + 1.0) * (width / radius + 1.0) > MOST_CELLS {
            return Err(Error::usage(
                "'radius'",
                format!(
                    "{} m is too fine for a belt {} m wide",
                    shown_number(radius),
                    shown_number(width)
                ),
                "give a larger radius, fewer items or a narrower belt",
            ));
        }
        let points = Sampler::new(length, width, radius * MARGIN, rng).run();
        if points.len() > count {
            break points;
        }
        length *= 1.25;
    };
    points.sort_by(|a, b| b[0].total_cmp(&a[0]));
    points.truncate(count);
    let first = points.first().map_or(0.0, |p| p[0]);
    let items = points
        .iter()
        .enumerate()
        .map(|(i, p)| Item::at((i + 1).to_string(), p[0] - first, p[1] - width / 2.0))
        .collect();
    Pattern::new(items)
}

/// The radius [m] at which [`poisson_disk`] yields about `density` items per metre on a belt of
/// `width` [m], from [`MEASURED`].
pub(super) fn radius_of(width: f64, density: f64) -> f64 {
    // With q = W / r the density is q g(q) / W, which increases with q.
    let asked = density * width;
    let (mut low, mut high) = (0.0, 1.0);
    while high * per_radius(high) < asked {
        high *= 2.0;
    }
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        match middle * per_radius(middle) < asked {
            true => low = middle,
            false => high = middle,
        }
    }
    width / high
}

/// Items of a maximal sample per radius of belt, for a belt that is `ratio` radii wide: linear
/// interpolation between the rows of [`MEASURED`], extrapolated from the last two beyond them.
fn per_radius(ratio: f64) -> f64 {
    let above = MEASURED.partition_point(|row| row.0 < ratio);
    let above = above.clamp(1, MEASURED.len() - 1);
    let [(q, g), (next_q, next_g)] = [MEASURED[above - 1], MEASURED[above]];
    g + (next_g - g) * (ratio - q) / (next_q - q)
}

type Point = [f64; 2];

/// Points in `[0, size.0] x [0, size.1]` with a background grid whose cells hold one point each.
struct Sampler<'a> {
    size: Point,
    /// Minimum distance between two points.
    least: f64,
    cell: f64,
    columns: usize,
    rows: usize,
    /// Index of the point in each cell plus one; 0 means an empty cell.
    cells: Vec<u32>,
    points: Vec<Point>,
    rng: &'a mut ChaCha8Rng,
}

impl<'a> Sampler<'a> {
    fn new(length: f64, width: f64, least: f64, rng: &'a mut ChaCha8Rng) -> Self {
        let cell = least / std::f64::consts::SQRT_2;
        let columns = (length / cell) as usize + 1;
        let rows = (width / cell) as usize + 1;
        Self {
            size: [length, width],
            least,
            cell,
            columns,
            rows,
            cells: vec![0; columns * rows],
            points: Vec::new(),
            rng,
        }
    }

    fn run(mut self) -> Vec<Point> {
        let start = [
            self.rng.random::<f64>() * self.size[0],
            self.rng.random::<f64>() * self.size[1],
        ];
        self.insert(start);
        self.bridson();
        self.throw_darts();
        self.fill_corners();
        self.points
    }

    fn bridson(&mut self) {
        let mut active: Vec<u32> = vec![0];
        while !active.is_empty() {
            let at = self.rng.random_range(0..active.len());
            let centre = self.points[active[at] as usize];
            let found = (0..TRIES).find_map(|_| {
                let [dx, dy] = self.in_ring();
                let point = [centre[0] + dx, centre[1] + dy];
                self.fits(point, self.least).then_some(point)
            });
            match found {
                Some(point) => {
                    active.push(self.points.len() as u32);
                    self.insert(point);
                }
                None => {
                    active.swap_remove(at);
                }
            }
        }
    }

    /// A uniformly random point in the ring from r to 2 r around the origin. Uses rejection,
    /// because sine and cosine differ in the last bit between C libraries.
    fn in_ring(&mut self) -> Point {
        loop {
            let point = [(); 2].map(|()| 4.0 * self.rng.random::<f64>() - 2.0);
            let square = point[0] * point[0] + point[1] * point[1];
            if (1.0..4.0).contains(&square) {
                return point.map(|c| c * self.least);
            }
        }
    }

    /// Throws darts at the uncovered squares until almost no uncovered area is left.
    fn throw_darts(&mut self) {
        let mut side = self.cell;
        let mut squares: Vec<Point> = Vec::new();
        for column in 0..self.columns {
            for row in 0..self.rows {
                squares.push([column as f64 * side, row as f64 * side]);
            }
        }
        squares.retain(|&corner| !self.is_covered(corner, side));
        for _ in 0..QUARTERINGS {
            for _ in 0..DARTS * squares.len() {
                let corner = squares[self.rng.random_range(0..squares.len())];
                let dart = corner.map(|c| c + side * self.rng.random::<f64>());
                if self.fits(dart, self.least) {
                    self.insert(dart);
                }
            }
            side /= 2.0;
            squares = squares
                .iter()
                .flat_map(|&[x, y]| [[x, y], [x + side, y], [x, y + side], [x + side, y + side]])
                .filter(|&corner| !self.is_covered(corner, side))
                .collect();
        }
    }

    /// Whether a single point covers the square, or the square is outside the strip.
    fn is_covered(&self, [x, y]: Point, side: f64) -> bool {
        if x > self.size[0] || y > self.size[1] {
            return true;
        }
        let mut covered = false;
        self.for_each_near([x + side / 2.0, y + side / 2.0], 2, |j| {
            let [px, py] = self.points[j];
            let dx = (px - x).abs().max((px - x - side).abs());
            let dy = (py - y).abs().max((py - y - side).abs());
            covered |= dx * dx + dy * dy < self.least * self.least;
        });
        covered
    }

    /// Adds points until every position in the strip is closer than `least` to one.
    fn fill_corners(&mut self) {
        for x in [0.0, self.size[0]] {
            for y in [0.0, self.size[1]] {
                self.fill_at([x, y]);
            }
        }
        // Points added here are also visited: every pair of circles is checked from the later of
        // its two points.
        let mut corners = Vec::new();
        let mut i = 0;
        while i < self.points.len() {
            self.corners_around(i, &mut corners);
            for &corner in &corners {
                self.fill_at(corner);
            }
            i += 1;
        }
    }

    /// The positions where an uncovered region next to point `i` could have a corner.
    fn corners_around(&self, i: usize, corners: &mut Vec<Point>) {
        let [px, py] = self.points[i];
        let r = self.least;
        corners.clear();
        // A lone circle has no crossings; its extreme points are used instead.
        corners.extend([[px - r, py], [px + r, py], [px, py - r], [px, py + r]]);
        for x in [0.0, self.size[0]] {
            let square = r * r - (x - px) * (x - px);
            if square >= 0.0 {
                corners.extend([[x, py - square.sqrt()], [x, py + square.sqrt()]]);
            }
        }
        for y in [0.0, self.size[1]] {
            let square = r * r - (y - py) * (y - py);
            if square >= 0.0 {
                corners.extend([[px - square.sqrt(), y], [px + square.sqrt(), y]]);
            }
        }
        self.for_each_near([px, py], 3, |j| {
            let [qx, qy] = self.points[j];
            let (dx, dy) = (qx - px, qy - py);
            let square = dx * dx + dy * dy;
            if j != i && square < 4.0 * r * r {
                let height = (r * r / square - 0.25).sqrt();
                let (mx, my) = (px + dx / 2.0, py + dy / 2.0);
                corners.extend([
                    [mx - dy * height, my + dx * height],
                    [mx + dy * height, my - dx * height],
                ]);
            }
        });
    }

    /// If `corner` is uncovered, adds a point there.
    fn fill_at(&mut self, corner: Point) {
        // A corner is at exactly `least` from its own circles, apart from rounding.
        let tolerant = self.least * (1.0 - 1e-12);
        if self.fits(corner, tolerant) {
            self.insert(corner);
        }
    }

    fn insert(&mut self, point: Point) {
        let (column, row) = self.cell_of(point);
        self.points.push(point);
        self.cells[row * self.columns + column] = self.points.len() as u32;
    }

    fn cell_of(&self, point: Point) -> (usize, usize) {
        (
            ((point[0] / self.cell) as usize).min(self.columns - 1),
            ((point[1] / self.cell) as usize).min(self.rows - 1),
        )
    }

    /// Whether the strip has room for `point` with distance `least` around it.
    fn fits(&self, point: Point, least: f64) -> bool {
        let inside =
            (0.0..=self.size[0]).contains(&point[0]) && (0.0..=self.size[1]).contains(&point[1]);
        if !inside {
            return false;
        }
        let mut free = true;
        self.for_each_near(point, 2, |j| {
            let (dx, dy) = (self.points[j][0] - point[0], self.points[j][1] - point[1]);
            free &= dx * dx + dy * dy >= least * least;
        });
        free
    }

    /// Calls `visit` with every point at most `cells` cells away.
    fn for_each_near(&self, point: Point, cells: usize, mut visit: impl FnMut(usize)) {
        let (column, row) = self.cell_of(point);
        for r in row.saturating_sub(cells)..=(row + cells).min(self.rows - 1) {
            for c in column.saturating_sub(cells)..=(column + cells).min(self.columns - 1) {
                if let Some(index) = self.cells[r * self.columns + c].checked_sub(1) {
                    visit(index as usize);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::random_stream;

    fn draw(width: f64, radius: f64, count: usize, seed: u64) -> Pattern {
        poisson_disk(width, radius, count, &mut random_stream(seed, 0)).unwrap()
    }

    #[test]
    fn no_two_items_are_closer_than_the_radius() {
        for (width, radius) in [(1.05, 0.15), (0.4, 0.2), (0.1, 0.3), (2.0, 0.05)] {
            let pattern = draw(width, radius, 400, 3);
            let items = pattern.items();
            assert_eq!(items.len(), 400);
            assert_eq!(items[0].x0, 0.0);
            for (i, a) in items.iter().enumerate() {
                assert!(a.y.abs() <= width / 2.0 + 1e-12);
                for b in &items[..i] {
                    let distance = (a.x0 - b.x0).hypot(a.y - b.y);
                    assert!(distance >= radius, "{distance} < {radius}");
                }
            }
        }
    }

    #[test]
    fn no_further_item_would_fit() {
        for seed in 0..20 {
            let (width, radius) = (0.7, 0.1);
            let pattern = draw(width, radius, 200, seed);
            let items = pattern.items();
            // One radius short of the last item the strip was cut, not filled.
            let end = items[199].x0 + radius;
            for i in 0..600 {
                for j in 0..=140 {
                    let (x, y) = (end * i as f64 / 600.0, width * (j as f64 / 140.0 - 0.5));
                    let nearest = items
                        .iter()
                        .map(|item| (item.x0 - x).hypot(item.y - y))
                        .fold(f64::INFINITY, f64::min);
                    assert!(nearest < radius * MARGIN, "a gap at ({x}, {y}): {nearest}");
                }
            }
        }
    }

    /// A position in the strip, at or after `from`, that is at least `least` away from every point,
    /// if there is one. An uncovered region has a corner at a crossing of two circles, at a
    /// crossing of a circle with the border, or at a corner of the strip, so only these are
    /// checked.
    fn uncovered(points: &[Point], from: f64, size: Point, least: f64) -> Option<Point> {
        let mut places = vec![[from, 0.0], [from, size[1]], [size[0], 0.0], size];
        for (i, a) in points.iter().enumerate() {
            for at in [from, size[0]] {
                let side = (least * least - (at - a[0]).powi(2)).sqrt();
                places.extend([[at, a[1] - side], [at, a[1] + side]]);
            }
            for at in [0.0, size[1]] {
                let side = (least * least - (at - a[1]).powi(2)).sqrt();
                places.extend([[a[0] - side, at], [a[0] + side, at]]);
            }
            for b in &points[..i] {
                let (middle, half) = (
                    [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0],
                    (a[0] - b[0]).hypot(a[1] - b[1]) / 2.0,
                );
                let along = (least * least - half * half).sqrt() / (2.0 * half);
                for sign in [-along, along] {
                    let across = [sign * (b[1] - a[1]), sign * (a[0] - b[0])];
                    places.push([middle[0] + across[0], middle[1] + across[1]]);
                }
            }
        }
        // If the circles do not cross, the root is NaN and no point is closer.
        let inside = |p: &Point| p[0] >= from && p[0] <= size[0] && p[1] >= 0.0 && p[1] <= size[1];
        let far = |p: &Point| {
            let mut distances = points.iter().map(|q| (p[0] - q[0]).hypot(p[1] - q[1]));
            distances.all(|distance| distance >= least * (1.0 - 1e-9))
        };
        places.into_iter().find(|place| inside(place) && far(place))
    }

    /// A sampler of a strip with these points, before it is filled.
    fn sampler<'a>(size: Point, points: &[Point], rng: &'a mut ChaCha8Rng) -> Sampler<'a> {
        let mut sampler = Sampler::new(size[0], size[1], 1.0, rng);
        points.iter().for_each(|point| sampler.insert(*point));
        sampler
    }

    fn assert_apart(points: &[Point], what: &str) {
        for (i, a) in points.iter().enumerate() {
            for b in &points[..i] {
                let distance = (a[0] - b[0]).hypot(a[1] - b[1]);
                assert!(distance >= 1.0 - 1e-9, "{what}: {a:?} and {b:?}");
            }
        }
    }

    /// Darts hardly ever leave room for an item. This test fills the room with corners alone.
    #[test]
    fn whatever_is_left_uncovered_is_filled() {
        let mut rng = random_stream(1, 0);
        for (size, points) in [
            // The corners of the strip outside the only circle.
            ([6.0, 4.0], &[[3.0, 2.0]][..]),
            ([2.2, 0.1], &[[1.1, 0.05]]),
            // At one end and one side.
            ([3.0, 1.5], &[[0.2, 0.3]]),
            ([3.0, 1.5], &[[2.9, 1.4]]),
            // Between circles that cross, away from the border.
            (
                [1.7, 1.7],
                &[[0.0, 0.0], [1.7, 0.0], [0.0, 1.7], [1.7, 1.7]],
            ),
            ([2.0, 1.8], &[[0.0, 0.9], [2.0, 0.9], [1.0, 0.0]]),
            // Along a line.
            ([9.0, 0.0], &[[4.0, 0.0]]),
            ([9.0, 1e-3], &[[1.5, 0.0], [4.0, 1e-3]]),
        ] {
            let what = format!("{size:?} around {points:?}");
            let mut sampler = sampler(size, points, &mut rng);
            assert!(
                uncovered(&sampler.points, 0.0, size, 1.0).is_some(),
                "{what}"
            );
            sampler.fill_corners();
            assert_apart(&sampler.points, &what);
            assert_eq!(uncovered(&sampler.points, 0.0, size, 1.0), None, "{what}");
        }
    }

    /// The corners of the strip themselves come first.
    #[test]
    fn an_uncovered_corner_of_the_belt_holds_an_item() {
        let mut rng = random_stream(1, 0);
        let size = [4.0, 3.0];
        let mut sampler = sampler(size, &[[2.0, 1.5]], &mut rng);
        sampler.fill_corners();
        assert_eq!(
            sampler.points[1..5],
            [[0.0, 0.0], [0.0, 3.0], [4.0, 0.0], [4.0, 3.0]]
        );
        // A covered corner holds no point.
        let mut sampler = Sampler::new(4.0, 3.0, 1.0, &mut rng);
        sampler.insert([0.5, 0.5]);
        sampler.fill_corners();
        assert_eq!(sampler.points[1..4], [[0.0, 3.0], [4.0, 0.0], [4.0, 3.0]]);
    }

    /// No sample has room for a further item anywhere in the strip, including its corners. Some of
    /// these samples would have room after the darts alone.
    #[test]
    fn samples_are_maximal_up_to_the_corners() {
        let mut left = 0;
        for size in [[8.0, 4.0], [12.0, 1.1], [20.0, 0.4], [40.0, 1e-3]] {
            for seed in 0..40 {
                let mut rng = random_stream(seed, 3);
                let mut darts = Sampler::new(size[0], size[1], 1.0, &mut rng);
                let start = size.map(|size| darts.rng.random::<f64>() * size);
                darts.insert(start);
                darts.bridson();
                darts.throw_darts();
                left += usize::from(uncovered(&darts.points, 0.0, size, 1.0).is_some());
                let mut rng = random_stream(seed, 3);
                let points = Sampler::new(size[0], size[1], 1.0, &mut rng).run();
                assert_apart(&points, &format!("{size:?}, seed {seed}"));
                let gap = uncovered(&points, 0.0, size, 1.0);
                assert_eq!(gap, None, "{size:?}, seed {seed}");
            }
        }
        assert!(left > 0, "no sample needs its corners filled");
    }

    /// The same for patterns, which are cut at the last item and shifted so that the first is at 0.
    #[test]
    fn patterns_are_maximal_up_to_the_edges_of_the_belt() {
        for (width, radius) in [(0.7, 0.1), (1.05, 0.3), (0.2, 0.25), (0.01, 0.5)] {
            for seed in 0..10 {
                let pattern = draw(width, radius, 60, seed);
                let points: Vec<Point> = pattern
                    .items()
                    .iter()
                    .map(|item| [item.x0, item.y + width / 2.0])
                    .collect();
                let from = points[59][0] + radius * MARGIN;
                let gap = uncovered(&points, from, [0.0, width], radius * MARGIN);
                assert_eq!(gap, None, "width {width}, radius {radius}, seed {seed}");
            }
        }
    }

    #[test]
    fn the_same_seed_draws_the_same_pattern_for_ever() {
        assert_eq!(draw(1.05, 0.2, 29, 7), draw(1.05, 0.2, 29, 7));
        assert_ne!(draw(1.05, 0.2, 29, 7), draw(1.05, 0.2, 29, 8));
    }

    #[test]
    fn narrow_strips_and_single_items_work() {
        assert_eq!(draw(0.01, 0.5, 1, 1).len(), 1);
        assert_eq!(draw(0.01, 0.5, 50, 1).len(), 50);
        // A sample that would not fit into memory is rejected before it is started.
        for (width, radius, count, problem) in [
            (1.0, 0.1, 0, "'count': 0 items is not a valid pattern size"),
            (1.0, f64::NAN, 5, "'radius': NaN m is not a valid distance"),
            (1e3, 1e-4, 5, "'radius': 0.0001 m is too fine for a belt"),
            (1.0, 0.1, usize::MAX, "items is not a valid pattern size"),
            (1e-3, 1e3, 10_000, "'count': 10000 items would take"),
        ] {
            let drawn = poisson_disk(width, radius, count, &mut random_stream(1, 0));
            let message = drawn.unwrap_err().to_string();
            assert!(message.contains(problem), "{message}");
        }
    }
}
