//! The departure windows of a robot that leaves from several places.

/// Where there is no window.
const NONE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// For each item and place of one robot, the departure window [s].
#[derive(Debug, Clone)]
pub(super) struct Windows {
    places: usize,
    list: Vec<(f64, f64)>,
}

impl Windows {
    /// No windows yet, for a robot with `places` places.
    pub(super) fn new(places: usize, items: usize) -> Self {
        Self {
            places,
            list: vec![NONE; places * items],
        }
    }

    /// Enters the windows of `item` from each place; returns the earliest opening and the latest
    /// closing of them.
    pub(super) fn fill(
        &mut self,
        item: u32,
        window: impl Fn(usize) -> Option<(f64, f64)>,
    ) -> Option<(f64, f64)> {
        let mut widest: Option<(f64, f64)> = None;
        for place in 0..self.places {
            let Some((open, close)) = window(place) else {
                continue;
            };
            self.list[item as usize * self.places + place] = (open, close);
            let (first, last) = widest.unwrap_or(NONE);
            widest = Some((first.min(open), last.max(close)));
        }
        widest
    }

    /// The window of `item` from `place`; it closes before it opens if there is none.
    #[inline]
    pub(super) fn of(&self, item: u32, place: usize) -> (f64, f64) {
        self.list[item as usize * self.places + place]
    }

    /// When the last window of `item`, from any place, closes [s].
    #[inline]
    pub(super) fn last_close(&self, item: u32) -> f64 {
        let begin = item as usize * self.places;
        let windows = self.list[begin..begin + self.places].iter();
        windows
            .map(|window| window.1)
            .fold(f64::NEG_INFINITY, f64::max)
    }
}
