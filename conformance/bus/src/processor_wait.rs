//! The time for which a ready thread had to wait for a processor.
//!
//! A frame without a time stamp gets the time at which the reading thread woke. On a busy machine the thread wakes
//! late, because it waits for a processor. The kernel counts this wait: it is the second number of `schedstat`, in
//! nanoseconds (Documentation/scheduler/sched-stats.rst of Linux).

use canvass_traces::Duration;
#[cfg(target_os = "linux")]
use std::{fs::File, os::unix::fs::FileExt};

/// A clock of the time that one thread spends waiting for a processor: the thread that creates the value. Only Linux
/// reports this time; on other systems it is always zero.
#[derive(Debug)]
pub(crate) struct ProcessorWait {
    #[cfg(target_os = "linux")]
    counts: Option<File>,
    waited: u64,
}

impl ProcessorWait {
    /// Counts the wait of the calling thread from now on.
    pub(crate) fn of_this_thread() -> Self {
        let mut wait = Self {
            #[cfg(target_os = "linux")]
            counts: File::open("/proc/thread-self/schedstat").ok(),
            waited: 0,
        };
        wait.since_last();
        wait
    }

    /// The wait since the last call.
    pub(crate) fn since_last(&mut self) -> Duration {
        let before = self.waited;
        self.waited = self.counted().unwrap_or(before);
        Duration(self.waited.saturating_sub(before))
    }

    #[cfg(target_os = "linux")]
    fn counted(&self) -> Option<u64> {
        let mut line = [0; 64];
        let length = self.counts.as_ref()?.read_at(&mut line, 0).ok()?;
        waited(line.get(..length)?)
    }

    #[cfg(not(target_os = "linux"))]
    fn counted(&self) -> Option<u64> {
        None
    }
}

/// The second of the three numbers in `schedstat`.
#[cfg(target_os = "linux")]
fn waited(line: &[u8]) -> Option<u64> {
    std::str::from_utf8(line).ok()?.split_ascii_whitespace().nth(1)?.parse().ok()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_second_number_is_the_wait() {
        assert_eq!(waited(b"430207 6994731 3\n"), Some(6_994_731));
        assert_eq!(waited(b"430207"), None);
        assert_eq!(waited(b"1 -1 1"), None);
    }

    /// If more threads than processors are ready, each thread has to wait.
    #[test]
    fn a_thread_among_many_waits() {
        let threads = 4 * std::thread::available_parallelism().unwrap().get();
        let together = std::sync::Barrier::new(threads);
        let waits = std::thread::scope(|scope| {
            let busy = || {
                together.wait();
                let mut wait = ProcessorWait::of_this_thread();
                let begun = std::time::Instant::now();
                while begun.elapsed() < std::time::Duration::from_millis(200) {
                    std::hint::black_box(0);
                }
                wait.since_last()
            };
            let running: Vec<_> = (0..threads).map(|_| scope.spawn(busy)).collect();
            running.into_iter().map(|thread| thread.join().unwrap()).collect::<Vec<_>>()
        });
        let least = Duration::from_millis(20);
        assert!(waits.iter().filter(|&&wait| wait > least).count() > threads / 2, "{waits:?}");
    }
}
