//! Recorded patterns: turns the output of a tracker or detector into a [`Pattern`].
//!
//! With a camera above the belt, any multi-object tracker writes one line per box,
//! `frame,id,left,top,width,height,conf[,x,y,z]`, in pixels and with frames from 1 (Milan et al.
//! 2016, "MOT16: A Benchmark for Multi-Object Tracking", arXiv:1603.00831). The other supported
//! formats, [`FORMATS`], are equivalent. Items do not slide and the belt runs at a constant speed
//! V, so all boxes of a track agree: with its centre at s [m] along the travel at time
//! `t = (frame - 1) / fps` [s], the item was at x0 = s - V t [m] at time 0. An item's position is
//! the median over its boxes, which is robust to a few bad boxes. Finally the whole pattern is
//! shifted along x so that the item furthest downstream is at x0 = 0.
//!
//! # Frame
//! The camera looks down on the belt and the image is not mirrored: image x points to the right,
//! image y down, and "left of the travel" is a quarter turn counterclockwise on the screen. The
//! belt frame is right-handed (REP-103), so its y points to the left of the travel:
//!
//! | axis | reverse | items travel on the screen | belt x | belt y |
//! |---|---|---|---|---|
//! | x | no | to the right | image x | - image y (up) |
//! | x | yes | to the left | - image x | image y (down) |
//! | y | no | down | image y | image x (right) |
//! | y | yes | up | - image y | - image x (left) |
//!
//! MOTChallenge counts pixels from 1. Since x is shifted anyway, this only matters for
//! [`ImportOptions::centre_px`], which uses the file's own counting.
//!
//! # Processing
//! The steps, in this order:
//! 0. Boxes without a track id are linked to tracks by the belt's motion.
//! 1. Lines that cannot be read are dropped; of a repeated (frame, id), the first is kept.
//! 2. A track whose position jumps against the belt's motion consists of several objects with the
//!    same id: it is split into `ID`, `ID.2`, ... Gaps that fit the motion are not jumps.
//! 3. Tracks that clearly do not ride on the belt are dropped.
//! 4. Tracks that follow each other in time at the same place on the belt are a single object whose
//!    id changed: they are merged under the first id.
//! 5. Objects that are then seen in too few frames, or are too slow, are dropped.
//!
//! The tracks also show the belt's direction and speed. If they contradict the options, the report
//! says so and suggests values that would agree. If the pattern would be wrong by centimetres, the
//! import fails. The [`ImportReport`] lists all of this.
//!
//! [`Pattern`]: crate::pattern::Pattern

mod class_names;
mod class_naming;
mod formats;
mod import;
mod link;
mod listing;
mod median;
mod mismatch;
mod motion;
mod object;
mod options;
mod pace;
mod place;
mod read;
mod report;
mod track;

pub use class_names::ClassNames;
pub(crate) use formats::recognised;
pub use formats::{Format, Recording};
pub use import::{Import, import};
pub use motion::Motion;
pub use options::{Boxes, ImageAxis, ImportOptions};
pub use read::DroppedLine;
pub use report::{Dropped, ImportReport, Merged, Split};
