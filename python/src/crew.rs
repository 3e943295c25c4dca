//! Short work that comes again and again: done by the thread that asks for it, with the help of threads
//! that stay awake for a while.
//!
//! To wake a thread takes as long as a step of many environments. A thread of the pool that has helped
//! therefore goes on looking for work for [`PATIENCE`] before it sleeps.

use crate::work::pool;
use pickline::Error;
use rayon::ThreadPool;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How long a thread without work looks for more.
const PATIENCE: Duration = Duration::from_micros(200);
/// Looks between two looks at the clock, and before another thread may have the core.
const LOOKS: usize = 100;

/// Portions of work, each of which one thread at a time works on.
pub(crate) struct Crew<T> {
    shared: Arc<Shared<T>>,
}

struct Shared<T> {
    portions: Vec<Mutex<T>>,
    work: fn(&mut T),
    /// The first portion that nobody has taken; their number if there is none.
    next: AtomicUsize,
    /// Number of portions that are done.
    done: AtomicUsize,
    /// What the work panicked with.
    panic: Mutex<Option<Box<dyn Any + Send>>>,
    /// Number of threads that help.
    helpers: AtomicUsize,
    /// The process that they belong to: a fork does not copy threads.
    process: AtomicU32,
}

impl<T: Send + 'static> Crew<T> {
    /// `work` for each of `portions`.
    pub(crate) fn new(portions: Vec<T>, work: fn(&mut T)) -> Self {
        let count = portions.len();
        Self {
            shared: Arc::new(Shared {
                portions: portions.into_iter().map(Mutex::new).collect(),
                work,
                next: AtomicUsize::new(count),
                done: AtomicUsize::new(count),
                panic: Mutex::new(None),
                helpers: AtomicUsize::new(0),
                process: AtomicU32::new(std::process::id()),
            }),
        }
    }

    /// The portions in order. Nobody works on them meanwhile, as the caller has the crew to itself.
    pub(crate) fn portions(&mut self) -> impl Iterator<Item = MutexGuard<'_, T>> {
        self.shared.portions.iter().map(locked)
    }

    /// Portion `index`.
    pub(crate) fn portion(&mut self, index: usize) -> MutexGuard<'_, T> {
        locked(&self.shared.portions[index])
    }

    /// Does the work for every portion.
    ///
    /// # Errors
    /// There are no threads.
    ///
    /// # Panics
    /// The work panics.
    pub(crate) fn work(&mut self) -> Result<(), Error> {
        let shared = &self.shared;
        let count = shared.portions.len();
        let pool = if count > 1 { Some(pool()?) } else { None };
        shared.done.store(0, Ordering::Relaxed);
        // Whoever sees that there are portions also sees what is in them.
        shared.next.store(0, Ordering::Release);
        if let Some(pool) = pool {
            self.call_helpers(&pool, count - 1);
        }
        while shared.work_on_next() {}
        let mut looks = 0;
        while shared.done.load(Ordering::Acquire) < count {
            looks += 1;
            if looks % LOOKS == 0 {
                thread::yield_now();
            }
            std::hint::spin_loop();
        }
        match locked(&shared.panic).take() {
            None => Ok(()),
            Some(panic) => resume_unwind(panic),
        }
    }

    /// Sees to it that up to `most` threads of `pool` help.
    fn call_helpers(&self, pool: &ThreadPool, most: usize) {
        let shared = &self.shared;
        let process = std::process::id();
        if shared.process.swap(process, Ordering::Relaxed) != process {
            shared.helpers.store(0, Ordering::Relaxed);
        }
        // The caller works as well.
        let wanted = most.min(pool.current_num_threads() - 1);
        while shared.helpers.load(Ordering::Relaxed) < wanted {
            shared.helpers.fetch_add(1, Ordering::Relaxed);
            let shared = Arc::clone(shared);
            pool.spawn(move || shared.help());
        }
    }
}

impl<T> Shared<T> {
    /// Works on portions until there has been none for a while.
    fn help(&self) {
        let mut since = Instant::now();
        while since.elapsed() < PATIENCE {
            for _ in 0..LOOKS {
                if self.work_on_next() {
                    since = Instant::now();
                }
                std::hint::spin_loop();
            }
        }
        self.helpers.fetch_sub(1, Ordering::Relaxed);
    }

    /// Works on the next portion; returns whether there was one.
    fn work_on_next(&self) -> bool {
        let count = self.portions.len();
        let following = |next: usize| (next < count).then_some(next + 1);
        let (seen, taken) = (Ordering::Acquire, Ordering::AcqRel);
        let Ok(index) = self.next.fetch_update(taken, seen, following) else {
            return false;
        };
        let mut portion = locked(&self.portions[index]);
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| (self.work)(&mut portion))) {
            *locked(&self.panic) = Some(panic);
        }
        drop(portion);
        self.done.fetch_add(1, Ordering::Release);
        true
    }
}

/// What is behind a lock. A panic is passed on by [`Crew::work`], so a poisoned lock tells nothing new.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
