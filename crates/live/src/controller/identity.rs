//! Events about the identity of items: counted, and reported the first time.

use super::Controller;
use crate::items::IdNews;
use crate::sight::PlacedDetection;
use pickline::error::shown;

impl Controller {
    /// Counts an event, and reports it if it is the first of its kind.
    fn note_and_remark(&mut self, what: &'static str, remark: impl FnOnce(&Self) -> String) {
        if self.tally.note(what) {
            let remark = remark(self);
            let rest = format!("further ones are only counted, as {what} in the status");
            self.remarks.push(format!("{remark}\n  {rest}"));
        }
    }

    /// The name of an item, safe to print.
    pub(super) fn name_of(&self, item: u32) -> String {
        let tracked = self.world.items().get(item);
        let name = tracked.map_or("?", |tracked| tracked.id.as_str());
        format!("`{}`", shown(name))
    }

    /// A picture shows an item twice.
    pub(super) fn note_doubled(&mut self, item: u32, sight: &PlacedDetection) {
        self.note_and_remark("doubled", |line| {
            let tracked = line.world.items().get(item);
            let way = tracked.map_or(0.0, |tracked| sight.way(tracked.place, tracked.y));
            format!(
                "a picture shows item {} twice, {:.1} mm apart: the second detection is treated as \
                 a second box around it",
                line.name_of(item),
                1e3 * way,
            )
        });
    }

    /// Two items turned out to be one.
    pub(super) fn note_fused(&mut self, [one, other]: &[String; 2]) {
        self.note_and_remark("fused", |_| {
            format!(
                "items {one} and {other} are so near that they may be one, and pictures show only \
                 one: they are merged"
            )
        });
    }

    /// A known item was seen under a new id.
    pub(super) fn note_news(&mut self, item: u32, sight: &PlacedDetection, news: IdNews) {
        let id = sight.id().map(shown).unwrap_or_default();
        match news {
            IdNews::Nothing => {}
            IdNews::Renumbered => self.note_and_remark("renumbered", |line| {
                format!(
                    "the tracker has a new id for item {}, `{id}`: by its position it is the same \
                     item",
                    line.name_of(item),
                )
            }),
            IdNews::Fused => self.note_and_remark("fused", |line| {
                format!(
                    "another camera has an id for item {}, `{id}`: by its position it is the same \
                     item",
                    line.name_of(item),
                )
            }),
        }
    }

    /// The id of item `before` was seen on another one, `item`, either elsewhere or beside it.
    pub(super) fn note_two(
        &mut self,
        before: u32,
        item: u32,
        sight: &PlacedDetection,
        is_split: bool,
    ) {
        let id = sight.id().map(shown).unwrap_or_default();
        let tracked = self.world.items().get(before);
        let way = tracked.map_or(0.0, |tracked| sight.way(tracked.place, tracked.y));
        let names = move |line: &Self| (line.name_of(before), line.name_of(item));
        if is_split {
            self.note_and_remark("split", |line| {
                let (before, item) = names(line);
                format!(
                    "a picture shows two items {:.1} mm apart, {before} and {item}, which had been \
                     treated as one",
                    1e3 * way,
                )
            });
        } else {
            self.note_and_remark("id_reused", |line| {
                let (before, item) = names(line);
                format!(
                    "the tracker uses the id `{id}` {way:.3} m from its item: this is treated as \
                     another item, {item}; the earlier one is now called {before}"
                )
            });
        }
    }
}
