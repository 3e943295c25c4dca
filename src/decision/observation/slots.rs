//! Chooses the candidates that get a slot if there are more candidates than slots.

use crate::decision::snapshot::Snapshot;

/// Half of the slots go to the candidates with the shortest processing times, the rest to the
/// remaining ones whose windows close first; on a tie, the one further downstream wins. The former
/// are worth picking; the latter would otherwise be lost. Slots keep the order of the candidates,
/// downstream first. If there are enough slots, every candidate gets one.
#[derive(Debug, Clone)]
pub(crate) struct SlotChoice {
    slots: usize,
    chosen: Vec<usize>,
    keyed: Vec<(f64, usize)>,
}

impl SlotChoice {
    /// Creates a choice for this number of slots.
    pub(super) fn new(slots: usize) -> Self {
        Self {
            slots,
            chosen: Vec::with_capacity(slots),
            keyed: Vec::new(),
        }
    }

    /// Chooses the candidates of `snapshot`.
    pub(super) fn choose(&mut self, snapshot: &Snapshot) {
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

    /// The candidate of each occupied slot.
    pub(super) fn chosen(&self) -> &[usize] {
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
        // Robot 0 has its bin at (1.3, -0.525): the further from it, the longer the pick.
        let candidate = |item: u32, y: f64, close: f64| Candidate {
            item,
            bin: 0,
            class: crate::station::ClassId::OTHER,
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
            places: &[0, 0],
            candidate_odds: &[],
            in_view: &[],
        };
        let mut choice = SlotChoice::new(4);
        choice.choose(&snapshot);
        // 1 and 3 have the shortest times; of the others, 4 and 5 close first.
        assert_eq!(choice.chosen(), [1, 3, 4, 5]);
        let mut choice = SlotChoice::new(1);
        choice.choose(&snapshot);
        assert_eq!(choice.chosen(), [1]);
        let mut choice = SlotChoice::new(6);
        choice.choose(&snapshot);
        assert_eq!(choice.chosen(), [0, 1, 2, 3, 4, 5]);
    }
}
