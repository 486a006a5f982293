//! The switch of the mutated crate: which of its mutants acts. Copied beside the rewritten sources, no part of xtask.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{LazyLock, Mutex};

/// The mutant of this process, from 1; 0: none.
static CHOSEN: LazyLock<u32> = LazyLock::new(|| number("CANVASS_MUTANT"));
/// Where each point that is reached is written, once.
static REACHED: LazyLock<Option<Mutex<std::fs::File>>> = LazyLock::new(|| {
    let path = std::env::var_os("CANVASS_MUTANTS_REACHED")?;
    Some(Mutex::new(std::fs::File::create(path).ok()?))
});
/// Points that were reached before. More mutants than that there are not.
static SEEN: [AtomicBool; 1 << 15] = [const { AtomicBool::new(false) }; 1 << 15];

fn number(name: &str) -> u32 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(0)
}

/// Which mutant of a point acts, from 1; 0: none. The point's mutants are `first` and those after it.
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
