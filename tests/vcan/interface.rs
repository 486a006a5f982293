//! Virtual CAN interfaces, one for each test.

use std::process::Command;

/// An interface that is up, and is removed at the end of the test.
pub struct Interface {
    name: String,
}

impl Interface {
    pub fn new(name: impl Into<String>) -> Self {
        let name = name.into();
        // An interrupted run may have left the interface.
        let _ = Command::new("ip").args(["link", "del", &name]).output();
        ip(&["link", "add", "dev", &name, "type", "vcan"]);
        let interface = Self { name };
        interface.up();
        interface
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn up(&self) {
        ip(&["link", "set", &self.name, "up"]);
    }

    pub fn down(&self) {
        ip(&["link", "set", &self.name, "down"]);
    }
}

impl Drop for Interface {
    fn drop(&mut self) {
        let _ = Command::new("ip").args(["link", "del", &self.name]).output();
    }
}

/// The frames sent on an interface, by the kernel's count.
pub fn transmitted(interface: &str) -> u64 {
    let path = format!("/sys/class/net/{interface}/statistics/tx_packets");
    std::fs::read_to_string(path).unwrap().trim().parse().unwrap()
}

/// Runs iproute2; returns its output.
pub fn ip(args: &[&str]) -> String {
    let output = Command::new("ip").args(args).output().unwrap();
    assert!(output.status.success(), "ip {}: {}", args.join(" "), String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}
