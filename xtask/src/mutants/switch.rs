//! The switch of the mutated crate, which chooses its mutant. The file is copied beside the rewritten sources, and is
//! no part of xtask.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{LazyLock, Mutex};

/// The number of this process's mutant, from 1; 0: none.
static CHOSEN: LazyLock<u32> = LazyLock::new(|| number("CANVASS_MUTANT"));
/// The file that lists each reached point once.
static REACHED: LazyLock<Option<Mutex<std::fs::File>>> = LazyLock::new(|| {
    let path = std::env::var_os("CANVASS_MUTANTS_REACHED")?;
    Some(Mutex::new(std::fs::File::create(path).ok()?))
});
/// Whether a point was reached before, by the number of its first mutant. The array is longer than the number of
/// mutants.
static SEEN: [AtomicBool; 1 << 15] = [const { AtomicBool::new(false) }; 1 << 15];

fn number(name: &str) -> u32 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(0)
}

/// The mutant of a point that is active, from 1; 0: none. The point has `count` mutants, numbered from `first`.
#[inline]
pub fn at(first: u32, count: u32) -> u32 {
    let chosen = *CHOSEN;
    if chosen == 0 {
        mark(first);
        return 0;
    }
    let offset = chosen.wrapping_sub(first);
    if offset < count { offset + 1 } else { 0 }
}

#[cold]
fn mark(first: u32) {
    if SEEN.get(first as usize).is_none_or(|seen| seen.swap(true, Ordering::Relaxed)) {
        return;
    }
    if let Some(Ok(mut reached)) = REACHED.as_ref().map(Mutex::lock) {
        let _ = writeln!(reached, "{first}");
    }
}
