//! Two serial ports that are joined, for programs of Windows: pseudo-terminals, which Wine takes for ports.

use anyhow::{Context, Result};
use nix::pty::openpty;
use nix::sys::termios::{SetArg, cfmakeraw, tcgetattr, tcsetattr};
use std::fs::File;
use std::os::fd::OwnedFd;
use std::path::Path;

/// The names of the ports.
pub const PORTS: [&str; 2] = ["COM3", "COM4"];
/// The variable by which the tests know them.
pub const VARIABLE: &str = "CANVASS_NULL_MODEM";

/// What keeps the ports there.
pub struct NullModem {
    _open: [OwnedFd; 2],
}

impl NullModem {
    /// Joins them, in the Windows of that folder.
    pub fn join(windows: &Path) -> Result<Self> {
        let [(near, first), (far, second)] = [port(windows, PORTS[0])?, port(windows, PORTS[1])?];
        forward(near.try_clone()?, far.try_clone()?);
        forward(far, near);
        Ok(Self { _open: [first, second] })
    }
}

/// The end of a port that no program opens, and what keeps it from being closed with the last program.
fn port(windows: &Path, name: &str) -> Result<(File, OwnedFd)> {
    let terminal = openpty(None, None).context("a pseudo-terminal")?;
    let mut settings = tcgetattr(&terminal.slave)?;
    cfmakeraw(&mut settings);
    tcsetattr(&terminal.slave, SetArg::TCSANOW, &settings)?;
    let link = windows.join("dosdevices").join(name.to_lowercase());
    let _ = std::fs::remove_file(&link);
    std::os::unix::fs::symlink(nix::unistd::ttyname(&terminal.slave)?, &link)
        .with_context(|| link.display().to_string())?;
    Ok((File::from(terminal.master), terminal.slave))
}

/// What comes from one end goes to the other, until this program ends.
fn forward(mut from: File, mut to: File) {
    std::thread::spawn(move || std::io::copy(&mut from, &mut to));
}
