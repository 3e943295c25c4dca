//! How many files this process may have open, and who has to leave room for whom.
//!
//! Connections are refused before the last descriptors are taken: the journal and the
//! recording need some now and then, and must get them.

/// Descriptors that connections leave free, at most.
const SPARE: u64 = 96;

/// Whether a connection under `descriptor` takes one of the last that there are. The system
/// gives the lowest that is free, so the number shows how many are in use.
#[cfg(unix)]
pub fn is_short(socket: &impl std::os::fd::AsRawFd) -> bool {
    use nix::sys::resource::{Resource, getrlimit};
    let descriptor = u64::try_from(socket.as_raw_fd()).unwrap_or_default();
    getrlimit(Resource::RLIMIT_NOFILE)
        .is_ok_and(|(most, _)| descriptor >= most.saturating_sub(SPARE.min(most / 4)))
}

/// Whether a connection takes one of the last descriptors: not known here.
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
