//! File descriptors: connections leave the last ones to the journal and the recording.
//!
//! Connections are refused before the last descriptors are in use, because the journal and the
//! recording need some now and then.

/// Maximum number of descriptors that connections leave free.
const SPARE_DESCRIPTORS: u64 = 96;

/// Whether a connection with this `descriptor` takes one of the last ones. The system assigns the
/// lowest free number, so it shows how many are in use.
#[cfg(unix)]
pub fn is_short(socket: &impl std::os::fd::AsRawFd) -> bool {
    use nix::sys::resource::{Resource, getrlimit};
    let descriptor = u64::try_from(socket.as_raw_fd()).unwrap_or_default();
    getrlimit(Resource::RLIMIT_NOFILE)
        .is_ok_and(|(most, _)| descriptor >= most.saturating_sub(SPARE_DESCRIPTORS.min(most / 4)))
}

/// Whether a connection takes one of the last descriptors. This is not known on this system.
#[cfg(not(unix))]
pub fn is_short<S>(_: &S) -> bool {
    false
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    struct Fake(i32);

    impl std::os::fd::AsRawFd for Fake {
        fn as_raw_fd(&self) -> i32 {
            self.0
        }
    }

    #[test]
    fn the_last_descriptors_are_left_alone() {
        assert!(!is_short(&Fake(3)));
        assert!(is_short(&Fake(i32::MAX)));
    }
}
