//! Virtual CAN interfaces, one for each test.

use std::process::Command;

/// An interface that is up, and removed at the end.
pub struct Interface {
    name: &'static str,
}

impl Interface {
    pub fn new(name: &'static str) -> Self {
        // What an interrupted run left behind.
        let _ = Command::new("ip").args(["link", "del", name]).output();
        ip(&["link", "add", "dev", name, "type", "vcan"]);
        let interface = Self { name };
        interface.up();
        interface
    }

    pub fn name(&self) -> &'static str {
        self.name
    }

    pub fn up(&self) {
        ip(&["link", "set", self.name, "up"]);
    }

    pub fn down(&self) {
        ip(&["link", "set", self.name, "down"]);
    }
}

impl Drop for Interface {
    fn drop(&mut self) {
        let _ = Command::new("ip").args(["link", "del", self.name]).output();
    }
}

fn ip(args: &[&str]) {
    let output = Command::new("ip").args(args).output().unwrap();
    assert!(output.status.success(), "ip {}: {}", args.join(" "), String::from_utf8_lossy(&output.stderr));
}
