//! Consoles of Windows: they take sequences only after they were told to.

/// Whether sequences act on what shows that stream. A terminal that is no console of Windows, such as that of a POSIX shell,
/// always takes them.
#[cfg(windows)]
#[expect(unsafe_code, reason = "the standard library does not know the modes of consoles")]
pub fn takes_sequences(stream: &impl std::os::windows::io::AsRawHandle) -> bool {
    use windows_sys::Win32::System::Console::{ENABLE_VIRTUAL_TERMINAL_PROCESSING, GetConsoleMode, SetConsoleMode};
    let (console, mut mode) = (stream.as_raw_handle(), 0);
    // SAFETY: the handle is that of a stream which is there meanwhile; only the mode is written.
    unsafe {
        GetConsoleMode(console, &raw mut mode) == 0
            || SetConsoleMode(console, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING) != 0
    }
}

/// Other systems have no such consoles.
#[cfg(not(windows))]
pub const fn takes_sequences<S>(_: &S) -> bool {
    true
}

/// What was typed. A shell of Unix puts the files in place of `*.log` itself; those of Windows leave that to the program.
pub fn arguments() -> Vec<std::ffi::OsString> {
    #[cfg(windows)]
    return wild::args_os().collect();
    #[cfg(not(windows))]
    return std::env::args_os().collect();
}
