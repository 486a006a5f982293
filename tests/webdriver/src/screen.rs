//! Settings of the browser.

use fantoccini::wd::Capabilities;
use serde_json::{Value, json};
use std::path::Path;

/// The screen of a desktop computer or of a phone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Screen {
    /// A window of 1280 by 900.
    Desk,
    /// The window of a small laptop at a zoom of 200 %: 640 by 450 points.
    Zoomed,
    /// A touch screen of 390 by 800 points, with two pixels per point in each direction.
    Phone,
}

/// Options that keep the browser from requests of its own, and make its pictures repeatable.
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

/// The capabilities of a new session, with all messages and requests of the page in the logs.
pub fn capabilities(screen: Screen, profile: &Path) -> Capabilities {
    let profile = format!("--user-data-dir={}", profile.display());
    let options: Vec<&str> = OPTIONS.into_iter().chain([profile.as_str()]).collect();
    let mut options = json!({ "args": options });
    let emulated = match screen {
        Screen::Desk => None,
        Screen::Zoomed => Some((640, 450, false)),
        Screen::Phone => Some((390, 800, true)),
    };
    if let Some((width, height, touch)) = emulated {
        options["mobileEmulation"] =
            json!({ "deviceMetrics": { "width": width, "height": height, "pixelRatio": 2, "touch": touch } });
    }
    let logs = json!({ "browser": "ALL", "performance": "ALL" });
    let named = [("goog:chromeOptions", options), ("goog:loggingPrefs", logs)];
    named.into_iter().map(|(name, value): (&str, Value)| (name.to_owned(), value)).collect()
}
