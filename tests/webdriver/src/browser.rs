//! The browser from its start to its end, and its pictures.

use crate::address::url;
use crate::driver::Driver;
use crate::screen::{Screen, capabilities};
use fantoccini::wd::PrintConfiguration;
use fantoccini::{Client, ClientBuilder};
use hyper_util::client::legacy::connect::HttpConnector;
use std::fmt::Display;
use std::path::Path;
use std::time::Duration;
use tokio::runtime::{Builder, Runtime};
use tokio::time::timeout;

/// Time limit of an answer.
const LONGEST: Duration = Duration::from_secs(120);
/// Maximum time that the browser takes to end after a failed test.
const AFTER_FAILURE: Duration = Duration::from_secs(5);

/// A browser window with one page.
pub struct Browser {
    pub(crate) client: Client,
    runtime: Runtime,
    // The fields are dropped in this order: the profile is deleted when no process writes into it any more.
    pub(crate) driver: Driver,
    _profile: tempfile::TempDir,
}

impl Browser {
    /// Opens a file in a browser with an empty profile.
    #[track_caller]
    pub fn open(page: &Path, screen: Screen) -> Self {
        Self::prepared(&url(page), screen, |_| {})
    }

    /// Opens an address after `prepare` has changed the browser.
    #[track_caller]
    pub fn prepared(address: &str, screen: Screen, prepare: impl FnOnce(&Self)) -> Self {
        let profile = tempfile::tempdir().expect("a folder for the profile");
        let driver = Driver::start();
        let runtime = Builder::new_current_thread().enable_all().build().expect("a runtime");
        let mut connector = HttpConnector::new();
        // Commands are small, and each waits for its answer: without this option the system would delay them.
        connector.set_nodelay(true);
        let mut builder = ClientBuilder::new(connector);
        builder.capabilities(capabilities(screen, profile.path()));
        let client = answer(&runtime, "a new session", builder.connect(&driver.address()));
        let browser = Self { client, runtime, driver, _profile: profile };
        // Requests of a new window do not belong to the page.
        browser.go("about:blank");
        browser.log("performance");
        browser.log("browser");
        prepare(&browser);
        browser.go(address);
        browser
    }

    /// Goes to an address.
    #[track_caller]
    pub fn go(&self, address: &str) {
        self.ask(format_args!("go to {address}"), self.client.goto(address));
    }

    /// A picture of the visible part of the page, as PNG.
    #[track_caller]
    pub fn picture(&self) -> Vec<u8> {
        self.ask("a picture", self.client.screenshot())
    }

    /// The page as it would be printed, as PDF.
    #[track_caller]
    pub fn print(&self) -> Vec<u8> {
        self.ask("a print", self.client.print(PrintConfiguration::default()))
    }

    /// The private memory of the page's process in kB: memory shared with other processes, such as the browser's own
    /// code, does not count. If there are several pages, the largest counts.
    ///
    /// # Errors
    /// If the system offers no data about its processes.
    pub fn memory(&self) -> std::io::Result<u64> {
        crate::memory::of_pages(self.driver.id())
    }

    /// Waits for the answer to a command.
    #[track_caller]
    pub(crate) fn ask<T, E: Display>(&self, what: impl Display, answered: impl Future<Output = Result<T, E>>) -> T {
        answer(&self.runtime, what, answered)
    }
}

#[track_caller]
fn answer<T, E: Display>(runtime: &Runtime, what: impl Display, answered: impl Future<Output = Result<T, E>>) -> T {
    match runtime.block_on(async { timeout(LONGEST, answered).await }) {
        Ok(Ok(value)) => value,
        Ok(Err(error)) => panic!("{what}: {error}"),
        Err(_) => panic!("{what}: no answer within {LONGEST:?}"),
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // chromedriver ends the browser: if chromedriver were killed before, the browser would stay.
        let closed = self.client.clone().close();
        if std::thread::panicking() {
            // The last command may never be answered, and a second panic would hide the first.
            let _ = self.runtime.block_on(async { timeout(AFTER_FAILURE, closed).await });
        } else {
            self.ask("the end of the session", closed);
        }
    }
}
