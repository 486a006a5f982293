//! Checks that a page has no errors and makes no requests.

use crate::browser::Browser;
use serde_json::{Value, json};

impl Browser {
    /// Checks that the page had no errors, that its policy refused nothing, and that it requested nothing but itself.
    #[track_caller]
    pub fn is_quiet(&self) {
        assert_eq!(self.log("browser"), json!([]), "the console");
        let requests = requests(&self.log("performance"));
        let own = self.text("return location.href.split('#')[0]");
        let others: Vec<_> =
            requests.iter().filter(|url| url.split('#').next() != Some(&own) && !is_within(url)).collect();
        assert!(!requests.is_empty(), "the page itself at least");
        assert!(others.is_empty(), "requests: {others:?}");
    }
}

/// All requests but those of the browser's own pages.
#[track_caller]
fn requests(log: &Value) -> Vec<String> {
    let entries = log.as_array().unwrap_or_else(|| panic!("expected a log, found {log}"));
    let messages = entries.iter().map(|entry| serde_json::from_str::<Value>(text(&entry["message"])).expect("JSON"));
    messages
        .filter(|event| event["message"]["method"] == "Network.requestWillBeSent")
        .filter(|event| !text(&event["message"]["params"]["documentURL"]).starts_with("chrome://"))
        .map(|event| text(&event["message"]["params"]["request"]["url"]).to_owned())
        .collect()
}

#[track_caller]
fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("expected a text, found {value}"))
}

/// Whether an address is of data within the page.
fn is_within(url: &str) -> bool {
    url.starts_with("data:image/svg+xml") || url.starts_with("blob:")
}
