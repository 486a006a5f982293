//! JavaScript in the page, and waiting for its results.

use crate::browser::Browser;
use serde_json::Value;
use std::time::{Duration, Instant};

impl Browser {
    /// Runs a function's body in the page, and returns its result.
    #[track_caller]
    pub fn run(&self, script: &str) -> Value {
        self.ask(script, self.client.execute(script, Vec::new()))
    }

    /// Runs a function's body in the page, and returns the number that it gives.
    #[track_caller]
    pub fn number(&self, script: &str) -> f64 {
        let value = self.run(script);
        value.as_f64().unwrap_or_else(|| panic!("{script}: {value}"))
    }

    /// Runs a function's body in the page, and returns the text that it gives.
    #[track_caller]
    pub fn text(&self, script: &str) -> String {
        let value = self.run(script);
        value.as_str().unwrap_or_else(|| panic!("{script}: {value}")).to_owned()
    }

    /// Waits until an expression holds, for a time that suffices for reactions of the page.
    #[track_caller]
    pub fn wait(&self, expression: &str) {
        self.wait_for(expression, Duration::from_secs(20));
    }

    /// Waits until an expression holds, for at most `longest`.
    #[track_caller]
    pub fn wait_for(&self, expression: &str, longest: Duration) {
        let begin = Instant::now();
        while self.run(&format!("return Boolean({expression})")) != Value::Bool(true) {
            assert!(begin.elapsed() < longest, "{expression} does not come true");
        }
    }
}
