//! Recorded patterns: what a tracker or a detector wrote of a film becomes a [`Pattern`].
//!
//! A camera above the belt and any multi-object tracker write one line per box,
//! `frame,id,left,top,width,height,conf[,x,y,z]` in pixels with frames from 1
//! (Milan et al. 2016, "MOT16: A Benchmark for Multi-Object Tracking",
//! arXiv:1603.00831). [`FORMATS`] are the other forms that are read; their numbers come to the
//! same. Items do not slide and the belt runs at one speed V, so every
//! box of a track tells the same thing: with its centre at s [m] along the travel at
//! time t = (frame - 1) / fps [s], the item was at x0 = s - V t [m] at time 0. An
//! item's position is the median over its boxes, which a few bad boxes cannot move.
//! At the end the whole pattern is shifted along x so that the item furthest
//! downstream is at x0 = 0.
//!
//! # Frame
//! The camera looks down on the belt and the image is not mirrored: image x points to
//! the right, image y down, and "left of the travel" is a quarter turn against the
//! clock on the screen. The belt frame is right-handed (REP-103), so its y points to
//! the left of the travel:
//!
//! | axis | reverse | items travel on the screen | belt x | belt y |
//! |---|---|---|---|---|
//! | x | no | to the right | image x | - image y (up) |
//! | x | yes | to the left | - image x | image y (down) |
//! | y | no | down | image y | image x (right) |
//! | y | yes | up | - image y | - image x (left) |
//!
//! MOTChallenge counts pixels from 1; since x is shifted anyway, that matters for
//! [`Options::centre_px`] only, which is meant in the file's own counting.
//!
//! # What a real tracker's file needs
//! In this order:
//! 0. Boxes without a track's id are linked to tracks by the belt's motion.
//! 1. Lines that cannot be read are dropped; of a repeated (frame, id) the first stays.
//! 2. A track whose position jumps against the belt's motion is several objects under
//!    one id: it is split into `ID`, `ID.2`, ... Gaps that fit the motion are no jump.
//! 3. Tracks that plainly do not ride on the belt are dropped.
//! 4. Tracks that follow each other in time at the same place on the belt are one
//!    object whose id changed: they are merged under the first one's id.
//! 5. What is then seen in too few frames or too slow is dropped.
//!
//! The tracks show the belt's direction and speed as well. Where they contradict what was
//! given, the report says so and names the figures that would agree; where the pattern would
//! be wrong by centimetres, the import is refused. The [`Report`] lists all of it.
//!
//! [`Pattern`]: crate::pattern::Pattern

mod formats;
mod import;
mod link;
mod motion;
mod options;
mod pace;
mod place;
mod read;
mod report;
mod track;

pub use formats::{FORMATS, Format, Recording, recognised};
pub use import::{Import, import};
pub use motion::Motion;
pub use options::{Axis, Boxes, Options};
pub use report::{Dropped, DroppedLine, Merged, Report, Split};
