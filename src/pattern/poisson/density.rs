//! How dense a maximal Poisson disk sample is.

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

/// The radius [m] at which [`poisson_disk`](super::poisson_disk) yields about `density` items per metre on a belt of
/// `width` [m], from [`MEASURED`].
pub(in crate::pattern) fn radius_of(width: f64, density: f64) -> f64 {
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
