//! chromedriver, as a process.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

/// A chromedriver process; each browser has its own, so that simultaneous tests do not share anything.
pub struct Driver {
    process: Child,
    port: u16,
}

impl Driver {
    /// Starts chromedriver on a free port.
    pub fn start() -> Self {
        let process = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromedriver: cargo xtask ci installs it");
        // The struct is made first, so that the process ends even if it prints no port.
        let mut driver = Self { process, port: 0 };
        driver.port = port(&mut driver.process).expect("chromedriver tells its port");
        driver
    }

    /// The address at which chromedriver listens.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}", self.port)
    }

    /// The number of the process.
    pub fn id(&self) -> u32 {
        self.process.id()
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The port that chromedriver has chosen and prints.
fn port(driver: &mut Child) -> Option<u16> {
    let mut lines = BufReader::new(driver.stdout.take()?).lines().map_while(Result::ok);
    let port = lines.by_ref().find_map(|line| told(&line));
    // The later lines of chromedriver must be read, or the process would block.
    std::thread::spawn(move || lines.for_each(drop));
    port
}

/// The port, if this line contains it.
fn told(line: &str) -> Option<u16> {
    let port = line.split_once("on port ")?.1.trim_end_matches('.').parse().ok()?;
    line.contains("successfully").then_some(port)
}

#[cfg(test)]
mod tests {
    use super::told;

    #[test]
    fn the_port_is_the_one_that_it_listens_on() {
        assert_eq!(told("Starting ChromeDriver 156.0.8078.79 on port 0"), None);
        assert_eq!(told("ChromeDriver was started successfully on port 45881."), Some(45881));
    }
}
