//! Which bin of which robot an item goes into, compiled from the bins' and the station's classes.

use super::class::ItemClass;
use super::robot::{Bin, Robot};

/// A class of items on one station. All classes that the station does not name are one, together
/// with the items without a class: they go into the same bins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct ClassId(u16);

impl ClassId {
    /// Whatever the station does not name.
    pub const OTHER: Self = Self(0);

    fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// For each robot and class, where its items go.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sorting {
    /// The classes with a name, sorted; class i + 1 has name i.
    names: Vec<String>,
    /// For each robot and class, the bin.
    bins: Vec<Vec<Option<u16>>>,
    /// For each class, the factor of its weight.
    values: Vec<f64>,
    /// For each class, whether its items are to be picked and some robot can take them.
    taken: Vec<bool>,
    /// Whether every robot has a bin for every class.
    universal: bool,
}

impl Sorting {
    /// Compiles valid robots and classes.
    pub(super) fn new(robots: &[Robot], classes: &[ItemClass]) -> Self {
        let of_bin = |bin: &Bin| bin.classes.clone().unwrap_or_default();
        let in_bins = robots.iter().flat_map(|robot| &robot.bins).flat_map(of_bin);
        let stated = classes.iter().map(|class| class.name.clone());
        let mut names: Vec<String> = in_bins.chain(stated).collect();
        names.sort_unstable();
        names.dedup();
        let all = || std::iter::once(None).chain(names.iter().map(|name| Some(name.as_str())));
        // A robot has at most 100 bins.
        let bin_of = |robot: &Robot, class| robot.bin_for(class).map(|bin| bin as u16);
        let bins: Vec<Vec<_>> = robots
            .iter()
            .map(|robot| all().map(|class| bin_of(robot, class)).collect())
            .collect();
        let stated = |class: Option<&str>| classes.iter().find(|c| Some(c.name.as_str()) == class);
        let values = all().map(|class| stated(class).map_or(1.0, |class| class.value));
        let wanted = all().map(|class| stated(class).is_none_or(|class| class.wanted));
        let some_bin = |class: usize| bins.iter().any(|robot| robot[class].is_some());
        let taken = wanted
            .enumerate()
            .map(|(class, wanted)| wanted && some_bin(class))
            .collect();
        let values = values.collect();
        let universal = bins.iter().flatten().all(Option::is_some);
        Self {
            universal,
            bins,
            values,
            taken,
            names,
        }
    }

    /// The class with this name.
    pub(super) fn class(&self, name: Option<&str>) -> ClassId {
        let place = name.and_then(|name| {
            let found = self
                .names
                .binary_search_by(|other| other.as_str().cmp(name));
            found.ok()
        });
        // The number of names is checked where the station is.
        place.map_or(ClassId::OTHER, |place| ClassId(place as u16 + 1))
    }

    /// Number of names.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    #[inline]
    pub(super) fn has_bin(&self, robot: usize, class: ClassId) -> bool {
        self.universal || self.bin(robot, class).is_some()
    }

    #[inline]
    pub(super) fn bin(&self, robot: usize, class: ClassId) -> Option<u16> {
        self.bins[robot][class.index()]
    }

    pub(super) fn value(&self, class: ClassId) -> f64 {
        self.values[class.index()]
    }

    #[inline]
    pub(super) fn takes(&self, class: ClassId) -> bool {
        self.taken[class.index()]
    }

    /// Whether the items of some class are taken by nobody.
    pub(super) fn leaves_items(&self) -> bool {
        self.taken.contains(&false)
    }
}
