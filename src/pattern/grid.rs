//! The grid pattern.

use super::item::{Item, LARGEST, MOST_ITEMS, Pattern};
use crate::error::{Error, Result, shown_number};

/// `count` items on a square lattice with `spacing` [m] on a belt of `width` [m], column by column
/// upstream from x0 = 0 (Jermann et al., grid sampled patterns). The last column may be partial.
///
/// # Errors
/// If the width or the spacing is not a positive length, or there are no items or too many.
pub fn grid(width: f64, spacing: f64, count: usize) -> Result<Pattern> {
    check_width(width)?;
    check_spacing("spacing", spacing)?;
    check_count(count)?;
    // If the spacing divides the width, both edges count despite rounding.
    let rows = (width / spacing + 1e-9).floor() as usize + 1;
    let middle = (rows - 1) as f64 / 2.0;
    check_length(count, (count / rows) as f64 * spacing)?;
    let items = (0..count)
        .map(|i| {
            let (column, row) = (i / rows, i % rows);
            Item::at(
                (i + 1).to_string(),
                -(column as f64) * spacing,
                (row as f64 - middle) * spacing,
            )
        })
        .collect();
    Pattern::new(items)
}

/// `count` items of `density` [1/m] in columns over the whole `width` [m], the first at x0 = 0. The
/// number of rows is that of a square lattice of this density; the distance between columns then
/// makes the density exact, which a square lattice could not.
pub(super) fn lattice(width: f64, density: f64, count: usize) -> Result<Pattern> {
    // r rows at W / (r - 1), with columns equally far apart: r (r - 1) / W items per metre.
    let rows = (0.5 + (0.25 + density * width).sqrt()).round().max(1.0) as usize;
    let between_columns = rows as f64 / density;
    let between_rows = width / (rows.max(2) - 1) as f64;
    let middle = (rows - 1) as f64 / 2.0;
    let item = |i: usize| {
        let (column, row) = (i / rows, i % rows);
        (
            -(column as f64) * between_columns,
            (row as f64 - middle) * between_rows,
        )
    };
    Pattern::numbered((0..count).map(item).collect())
}

/// Checks the width [m] of a belt.
pub(super) fn check_width(width: f64) -> Result<()> {
    if (1e-6..=LARGEST).contains(&width) {
        return Ok(());
    }
    Err(Error::usage(
        "'width'",
        format!("{} m is not the width of a belt", shown_number(width)),
        format!("give metres, from 1e-6 to {LARGEST:e}"),
    ))
}

/// Checks a spacing or radius, which must be a length that fits on a belt.
pub(super) fn check_spacing(name: &str, value: f64) -> Result<()> {
    if (1e-4..=1e3).contains(&value) {
        return Ok(());
    }
    Err(Error::usage(
        format!("'{name}'"),
        format!(
            "{} m is not a valid distance between items",
            shown_number(value)
        ),
        "give metres, from 0.0001 to 1000",
    ))
}

/// Checks the number of items of a pattern. Call it before that many are created.
pub(super) fn check_count(count: usize) -> Result<()> {
    if (1..=MOST_ITEMS).contains(&count) {
        return Ok(());
    }
    Err(Error::usage(
        "'count'",
        format!("{count} items is not a valid pattern size"),
        format!("give 1 to {MOST_ITEMS} items"),
    ))
}

/// Checks the length [m] of belt that `count` items take up.
pub(super) fn check_length(count: usize, length: f64) -> Result<()> {
    if length <= LARGEST {
        return Ok(());
    }
    Err(Error::usage(
        "'count'",
        format!(
            "{count} items would take {} m of belt",
            shown_number(length)
        ),
        format!("use fewer items or a smaller distance; at most {LARGEST:e} m"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_grid_has_eight_rows_on_the_wide_belt() {
        let pattern = grid(1.05, 0.15, 50).unwrap();
        let items = pattern.items();
        assert_eq!(items[0].y, -0.525);
        assert!((items[7].y - 0.525).abs() < 1e-15);
        assert_eq!(items[8].x0, -0.15);
        // The last column contains the remaining two of 50.
        assert_eq!(items[48].x0, items[49].x0);
        assert_eq!(items[48].x0, -6.0 * 0.15);
        pattern
            .check_on(
                &crate::station::built_in("paper")
                    .unwrap()
                    .station(None)
                    .unwrap(),
            )
            .unwrap();
    }

    #[test]
    fn a_spacing_wider_than_the_belt_is_one_row() {
        let pattern = grid(0.4, 0.5, 3).unwrap();
        assert!(pattern.items().iter().all(|item| item.y == 0.0));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e308] {
            let message = grid(bad, 0.15, 5).unwrap_err().to_string();
            assert!(message.contains("'width'"), "{message}");
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let message = grid(0.4, bad, 3).unwrap_err().to_string();
            assert!(
                message.contains("is not a valid distance between items"),
                "{message}"
            );
        }
        for (count, spacing) in [(0, 0.1), (usize::MAX, 0.1), (10_000, 1000.0)] {
            let message = grid(0.4, spacing, count).unwrap_err().to_string();
            assert!(message.starts_with("'count': "), "{message}");
        }
    }
}
