//! Runs work on many items, on as many threads as there are cores.

use anyhow::{Result, bail};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Calls `work` for each of `items`, and prints the progress after every `told` items. The results are in the order of
/// `items`.
pub fn each<T: Sync, R: Send>(items: &[T], told: usize, work: impl Fn(&T) -> Result<R> + Sync) -> Result<Vec<R>> {
    let next = AtomicUsize::new(0);
    let worker = || -> Result<Vec<(usize, R)>> {
        let mut done = Vec::new();
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(at) else { return Ok(done) };
            done.push((at, work(item)?));
            if (at + 1).is_multiple_of(told) {
                eprintln!("{} of {}", at + 1, items.len());
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut done = Vec::new();
    std::thread::scope(|scope| -> Result<()> {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        for worker in workers {
            let Ok(results) = worker.join() else { bail!("a thread failed") };
            done.extend(results?);
        }
        Ok(())
    })?;
    done.sort_by_key(|(at, _)| *at);
    Ok(done.into_iter().map(|(_, result)| result).collect())
}
