//! A maximal Poisson disk sample of a strip, in the steps that the folder's page names.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// Darts thrown around an active item before it is retired (Bridson's k).
const TRIES: usize = 30;
/// Darts thrown per uncovered square before the squares are quartered.
const DARTS: usize = 4;
/// How often the squares are quartered. What remains is smaller than a hundredth of the radius and
/// is left to the corners.
const QUARTERINGS: usize = 8;

/// A position in the strip, along and across it.
pub(super) type Point = [f64; 2];

/// Points in `[0, size.0] x [0, size.1]` with a background grid whose cells hold one point each.
pub(super) struct Sampler<'a> {
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
    /// An empty strip of this size, for points at least `least` apart.
    pub(super) fn new(length: f64, width: f64, least: f64, rng: &'a mut ChaCha8Rng) -> Self {
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

    /// The points of a maximal sample.
    pub(super) fn run(mut self) -> Vec<Point> {
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
pub(super) mod tests {
    use super::*;
    use crate::pattern::random_stream;

    /// A position in the strip, at or after `from`, that is at least `least` away from every point,
    /// if there is one. An uncovered region has a corner at a crossing of two circles, at a
    /// crossing of a circle with the border, or at a corner of the strip, so only these are
    /// checked.
    pub(in super::super) fn uncovered(
        points: &[Point],
        from: f64,
        size: Point,
        least: f64,
    ) -> Option<Point> {
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
    fn uncovered_areas_are_filled() {
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
}
