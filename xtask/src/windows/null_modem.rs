//! Two joined serial ports for programs of Windows: pseudo-terminals, which Wine treats as ports.

use anyhow::{Context, Result};
use nix::pty::openpty;
use nix::sys::termios::{SetArg, cfmakeraw, tcgetattr, tcsetattr};
use std::fs::File;
use std::os::fd::OwnedFd;
use std::path::Path;

/// The names of the ports.
pub const PORTS: [&str; 2] = ["COM3", "COM4"];
/// The variable that names the ports to the tests.
pub const VARIABLE: &str = "CANVASS_NULL_MODEM";

/// The joined ports, which exist until this is dropped.
pub struct NullModem {
    _open: [OwnedFd; 2],
}

impl NullModem {
    /// Joins the ports, in the Windows of this folder.
    pub fn join(windows: &Path) -> Result<Self> {
        let [(near, first), (far, second)] = [port(windows, PORTS[0])?, port(windows, PORTS[1])?];
        forward(near.try_clone()?, far.try_clone()?);
        forward(far, near);
        Ok(Self { _open: [first, second] })
    }
}

/// Creates a port: the end that no program opens, and a handle that keeps the port open after the last program.
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

/// Copies bytes from one end to the other, until this program ends.
fn forward(mut from: File, mut to: File) {
    std::thread::spawn(move || std::io::copy(&mut from, &mut to));
}
