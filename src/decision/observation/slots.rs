//! Which candidates get a slot when there are more than slots.

use crate::decision::snapshot::Snapshot;

/// Half of the slots go to the shortest processing times, the rest to those of what is
/// left that close first; ties to the one further downstream. The first are what is
/// worth picking, the second what is lost otherwise. Slots keep the candidates' order,
/// downstream first. Without more candidates than slots everyone has one.
#[derive(Debug, Clone)]
pub struct SlotChoice {
    slots: usize,
    chosen: Vec<usize>,
    keyed: Vec<(f64, usize)>,
}

impl SlotChoice {
    /// A choice for so many slots.
    pub fn new(slots: usize) -> Self {
        Self {
            slots,
            chosen: Vec::with_capacity(slots),
            keyed: Vec::new(),
        }
    }

    /// Makes the choice.
    pub fn choose(&mut self, snapshot: &Snapshot) {
        let candidates = snapshot.candidates;
        self.chosen.clear();
        if candidates.len() <= self.slots {
            self.chosen.extend(0..candidates.len());
            return;
        }
        let moment = snapshot.moment();
        self.keyed.clear();
        let times = candidates.iter().enumerate();
        self.keyed
            .extend(times.map(|(i, c)| (moment.processing_time(c), i)));
        let by_key = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let half = self.slots.div_ceil(2);
        self.keyed.select_nth_unstable_by(half, by_key);
        self.chosen.extend(self.keyed[..half].iter().map(|k| k.1));
        let rest = &mut self.keyed[half..];
        for key in rest.iter_mut() {
            key.0 = candidates[key.1].close;
        }
        let others = self.slots - half;
        if others > 0 {
            rest.select_nth_unstable_by(others - 1, by_key);
            self.chosen.extend(rest[..others].iter().map(|k| k.1));
        }
        self.chosen.sort_unstable();
    }

    /// The candidate in each slot that has one.
    pub fn chosen(&self) -> &[usize] {
        &self.chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decision::Candidate;
    use crate::station::built_in;

    #[test]
    fn half_are_the_shortest_and_half_close_first() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        // Robot 0 has its bin at (1.3, -0.525): the further from it, the longer.
        let candidate = |item: u32, y: f64, close: f64| Candidate {
            item,
            x0: 1.3,
            y,
            weight: 0.5,
            open: 0.0,
            close,
        };
        let candidates = [
            candidate(0, 0.1, 9.0),
            candidate(1, -0.5, 8.0),
            candidate(2, 0.0, 3.0),
            candidate(3, -0.4, 2.0),
            candidate(4, -0.3, 1.0),
            candidate(5, 0.2, 1.5),
        ];
        let snapshot = Snapshot {
            station: &station,
            time: 0.0,
            robot: 0,
            candidates: &candidates,
            free_at: &[0.0, 0.0],
            in_view: &[],
        };
        let mut choice = SlotChoice::new(4);
        choice.choose(&snapshot);
        // 1 and 3 are the shortest; 4 and 5 close first of the others.
        assert_eq!(choice.chosen(), [1, 3, 4, 5]);
        let mut choice = SlotChoice::new(1);
        choice.choose(&snapshot);
        assert_eq!(choice.chosen(), [1]);
        let mut choice = SlotChoice::new(6);
        choice.choose(&snapshot);
        assert_eq!(choice.chosen(), [0, 1, 2, 3, 4, 5]);
    }
}
