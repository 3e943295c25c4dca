//! Colours shared by pictures and pages.

/// Robot colours, used in rotation: Okabe and Ito's palette, distinguishable with colour
/// blindness.
pub(super) const ROBOT_COLOURS: [&str; 6] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9",
];

/// Background of pictures and pages, light and dark.
pub(super) const PAPER: [&str; 2] = ["#ffffff", "#0d1117"];

/// Colours of chart series, on light and on dark backgrounds. Robot colours fill shapes; these
/// draw thin lines and small markers, so each has a contrast of at least 3 to 1 with its
/// background (checked by a test). They also differ clearly with colour blindness, and markers
/// and dashes distinguish the series as well.
pub(super) const SERIES: [[&str; 7]; 2] = [
    [
        "#1359b0", "#c96400", "#02846f", "#ae3085", "#5a8fd8", "#3f3b4f", "#7a1206",
    ],
    [
        "#5a9cf5", "#f88824", "#17c98a", "#eb9fc1", "#f2e25a", "#b1e8ff", "#d9605a",
    ],
];

/// The series' colours as custom properties of a page that follows the reader's scheme:
/// `--series-0` and up.
pub(super) fn series_css() -> String {
    let rules = |colours: &[&str]| -> String {
        let rule = |(i, colour): (usize, &&str)| format!(" --series-{i}: {colour};");
        colours.iter().enumerate().map(rule).collect()
    };
    let [light, dark] = SERIES;
    format!(
        ":root {{{} }}\n@media screen and (prefers-color-scheme: dark) {{ :root {{{} }} }}\n",
        rules(&light),
        rules(&dark)
    )
}

/// A mix of two colours `#rrggbb`; `share` is the first colour's share.
pub(super) fn mixed(first: &str, second: &str, share: f64) -> String {
    let channel = |colour: &str, at: usize| {
        let digits = colour.get(at..at + 2).unwrap_or_default();
        f64::from(u8::from_str_radix(digits, 16).unwrap_or_default())
    };
    let mix = |at| (share * channel(first, at) + (1.0 - share) * channel(second, at)).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(1), mix(3), mix(5))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast ratio of two colours by WCAG 2.
    fn contrast(a: &str, b: &str) -> f64 {
        let luminance = |colour: &str| -> f64 {
            let channel = |at: usize| {
                let value = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
                if value <= 0.040_45 {
                    value / 12.92
                } else {
                    ((value + 0.055) / 1.055).powf(2.4)
                }
            };
            0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn series_stand_out_from_their_ground() {
        for (colours, paper) in SERIES.iter().zip(PAPER) {
            for colour in colours {
                let contrast = contrast(colour, paper);
                assert!(contrast >= 3.0, "{colour} on {paper}: {contrast:.2}");
            }
        }
    }

    #[test]
    fn colours_mix() {
        assert_eq!(mixed("#ff0000", "#0000ff", 0.5), "#800080");
        assert_eq!(mixed("#123456", "#ffffff", 1.0), "#123456");
    }
}
