//! Work without the GIL: on threads of this process, with panics as errors, stopped by Ctrl-C.

use crate::errors::{exception, panicked};
use crate::progress::Watched;
use pickline::{Environment, Error};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::cell::RefCell;
use std::mem;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How long Ctrl-C may go unnoticed.
const POLL: Duration = Duration::from_millis(50);

/// The threads of the process with this id.
type Pool = (u32, Arc<ThreadPool>);

static POOL: Mutex<Option<Pool>> = Mutex::new(None);

/// The threads of this process. A fork does not copy threads, so a child gets its own.
pub(crate) fn pool() -> Result<Arc<ThreadPool>, Error> {
    let mut kept = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, pool)) = &*kept
        && *owner == process
    {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new()
        .thread_name(|index| format!("pickline-{index}"))
        .build()
        .map_err(|error| {
            let cure = "let the process have more threads, or set RAYON_NUM_THREADS to fewer";
            Error::resources("the threads of pickline", error.to_string(), cure)
        })?;
    let pool = Arc::new(pool);
    // The threads of the parent's pool are not there to be told to end.
    mem::forget(kept.replace((process, Arc::clone(&pool))));
    Ok(pool)
}

/// Runs `work` without the GIL; a panic is a `RuntimeError`.
pub(crate) fn quick<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    done.map_err(|panic| panicked(&*panic))?.map_err(exception)
}

/// Like [`quick`], on the threads of this process.
pub(crate) fn parallel<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> PyResult<T> {
    quick(py, || pool()?.install(work))
}

/// What came of long work.
pub(crate) struct Worked<T> {
    pub value: T,
    /// Whether Ctrl-C ended it early, so that this is only what was found by then.
    pub interrupted: bool,
}

thread_local! {
    /// What stops the work that called the strategy that this thread is in.
    static CALLER: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// Calls `callable` on a thread of long work that `stop` stops.
pub(crate) fn within<T>(stop: &Arc<AtomicBool>, callable: impl FnOnce() -> T) -> T {
    let before = CALLER.replace(Some(Arc::clone(stop)));
    let returned = callable();
    CALLER.set(before);
    returned
}

/// Like [`parallel`], for long work, which reports its progress to `watcher`, if there is one, and which
/// Ctrl-C asks to stop. If the work has no result then, and if the signal's handler or `watcher` raises
/// anything but `KeyboardInterrupt`, that is raised when the work has stopped.
pub(crate) fn long<T: Send>(
    py: Python<'_>,
    watcher: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Environment) -> Result<T, Error> + Send,
) -> PyResult<Worked<T>> {
    long_until(py, watcher, &Arc::default(), &|_| {}, work)
}

/// Like [`long`], for work that `stop` stops as well; once Ctrl-C has been pressed, `insist` is called again
/// and again until the work ends.
pub(crate) fn long_until<T: Send>(
    py: Python<'_>,
    watcher: Option<&Bound<'_, PyAny>>,
    stop: &Arc<AtomicBool>,
    insist: &(dyn Fn(Python<'_>) + Sync),
    work: impl FnOnce(&Environment) -> Result<T, Error> + Send,
) -> PyResult<Worked<T>> {
    let watched = Watched::default();
    if let Some(caller) = CALLER.with_borrow(Option::clone) {
        // A strategy calls this. All threads may be in strategies and wait, so this one does the work, and
        // whoever called the strategy looks for Ctrl-C.
        let environment = Environment {
            stop: &*caller,
            progress: &watched,
            ..Environment::QUIET
        };
        let value = quick(py, || work(&environment))?;
        return Ok(Worked {
            value,
            interrupted: caller.load(Ordering::Relaxed),
        });
    }
    let watcher = watcher.map(|watcher| watcher.clone().unbind());
    let mut raised = None;
    let done = quick(py, || {
        let pool = pool()?;
        let (sender, receiver) = channel();
        let watched = &watched;
        pool.in_place_scope(|scope| {
            scope.spawn(move |_| {
                let environment = Environment {
                    stop: &**stop,
                    progress: watched,
                    ..Environment::QUIET
                };
                // The receiver is there until the work is done.
                let _ = sender.send(work(&environment));
            });
            let mut told = None;
            loop {
                let waited = receiver.recv_timeout(POLL);
                if raised.is_none() {
                    raised = Python::attach(|py| {
                        let tell = || watched.tell(watcher.as_ref()?.bind(py), &mut told);
                        py.check_signals().err().or_else(tell)
                    });
                    stop.store(raised.is_some(), Ordering::Relaxed);
                } else if matches!(waited, Err(RecvTimeoutError::Timeout)) {
                    Python::attach(insist);
                }
                match waited {
                    Ok(done) => return done,
                    // The work has panicked, and the scope says so.
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(Error::internal("the work has no result"));
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                }
            }
        })
    });
    match (raised, done) {
        (None, done) => Ok(Worked {
            value: done?,
            interrupted: false,
        }),
        (Some(error), Ok(value)) if error.get_type(py).is(py.get_type::<PyKeyboardInterrupt>()) => {
            Ok(Worked {
                value,
                interrupted: true,
            })
        }
        (Some(error), _) => Err(error),
    }
}
