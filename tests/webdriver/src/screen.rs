//! What the browser is asked to be.

use fantoccini::wd::Capabilities;
use serde_json::{Value, json};
use std::path::Path;

/// A window as large as a desk has, or a phone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Screen {
    /// A window of 1280 by 900.
    Desk,
    /// 390 by 800, each of four points of the screen, and touched.
    Phone,
}

/// What keeps the browser from doing anything but what the page does, and one picture like the next.
const OPTIONS: [&str; 11] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--force-prefers-reduced-motion",
    "--disable-sync",
    "--window-size=1280,900",
];

/// What chromedriver is told of a new session: with all that the page says and asks for in the logs.
pub fn capabilities(screen: Screen, profile: &Path) -> Capabilities {
    let profile = format!("--user-data-dir={}", profile.display());
    let options: Vec<&str> = OPTIONS.into_iter().chain([profile.as_str()]).collect();
    let mut options = json!({ "args": options });
    if screen == Screen::Phone {
        options["mobileEmulation"] =
            json!({ "deviceMetrics": { "width": 390, "height": 800, "pixelRatio": 2, "touch": true } });
    }
    let logs = json!({ "browser": "ALL", "performance": "ALL" });
    let named = [("goog:chromeOptions", options), ("goog:loggingPrefs", logs)];
    named.into_iter().map(|(name, value): (&str, Value)| (name.to_owned(), value)).collect()
}
