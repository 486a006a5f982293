//! A load that keeps every processor busy.

use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

/// One computing thread for each processor.
pub struct Load {
    ends: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Load {
    /// Starts the load.
    pub fn start() -> Self {
        let ends = Arc::new(AtomicBool::new(false));
        let processors = thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let threads = (0..processors)
            .map(|_| {
                let ends = Arc::clone(&ends);
                thread::spawn(move || {
                    let mut number = 1_u64;
                    while !ends.load(Ordering::Relaxed) {
                        for _ in 0..100_000 {
                            number = black_box(number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
                        }
                    }
                })
            })
            .collect();
        Self { ends, threads }
    }

    /// Ends the load, and waits for its threads.
    pub fn stop(self) {
        self.ends.store(true, Ordering::Relaxed);
        for thread in self.threads {
            // A counting thread does not panic.
            let _ = thread.join();
        }
    }
}
