pub mod error;
pub mod files;
pub mod kinematics;
pub mod pattern;
pub mod station;
