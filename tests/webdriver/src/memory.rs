//! The memory of the pages, as Linux reports it.

use std::fs::{read_dir, read_to_string};
use std::io;

/// The private memory in kB of the largest page among the descendants of a process.
pub fn of_pages(ancestor: u32) -> io::Result<u64> {
    let mut most = 0;
    for process in descendants(ancestor)? {
        // A process may end before its files are read.
        let file = |name: &str| read_to_string(format!("/proc/{process}/{name}"));
        let shows = file("cmdline").is_ok_and(|words| words.contains("--type=renderer"));
        let status = file("status").unwrap_or_default();
        let own = status.lines().find_map(|line| line.strip_prefix("RssAnon:")?.trim().strip_suffix("kB"));
        most = most.max(own.filter(|_| shows).map_or(0, |own| own.trim().parse().unwrap_or(0)));
    }
    Ok(most)
}

/// The descendants of a process.
fn descendants(ancestor: u32) -> io::Result<Vec<u32>> {
    let parent = |process: u32| {
        let status = read_to_string(format!("/proc/{process}/status")).ok()?;
        status.lines().find_map(|line| line.strip_prefix("PPid:")?.trim().parse::<u32>().ok())
    };
    let processes = read_dir("/proc")?.flatten().filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let is_of = |process: &u32| {
        let line = std::iter::successors(parent(*process), |above| parent(*above).filter(|above| *above > 0));
        line.take(50).any(|above| above == ancestor)
    };
    Ok(processes.filter(is_of).collect())
}
