//! Windows consoles, which interpret terminal sequences only after a program has requested this.

/// Switches terminal sequences on; returns whether the stream's terminal interprets them. A terminal without a
/// Windows console, such as that of a POSIX shell, always does.
#[cfg(windows)]
#[expect(unsafe_code, reason = "the standard library has no function for console modes")]
pub fn takes_sequences(stream: &impl std::os::windows::io::AsRawHandle) -> bool {
    use windows_sys::Win32::System::Console::{ENABLE_VIRTUAL_TERMINAL_PROCESSING, GetConsoleMode, SetConsoleMode};
    let (console, mut mode) = (stream.as_raw_handle(), 0);
    // SAFETY: the handle is valid while the stream is borrowed, and the call writes only the console's mode.
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

/// The typed arguments, with wildcards expanded: shells of Windows leave that to the program.
pub fn arguments() -> Vec<std::ffi::OsString> {
    #[cfg(windows)]
    return wild::args_os().collect();
    #[cfg(not(windows))]
    return std::env::args_os().collect();
}
