//! The page in Chromium, for measurements and pictures.

pub use canvass_webdriver::{Browser, Screen};

use anyhow::Result;
use std::path::Path;

/// The page, opened as one file from the disk.
pub struct Opened(pub Browser);

impl Opened {
    /// Opens the page without files.
    ///
    /// # Errors
    /// If the page was not made.
    pub fn new(screen: Screen) -> Result<Self> {
        let browser = Browser::open(&super::file()?, screen);
        browser.wait("document.documentElement.dataset.ready === 'yes'");
        Ok(Self(browser))
    }

    /// Opens files in the page, as the file dialog does.
    ///
    /// # Errors
    /// If a file does not exist.
    pub fn take(&self, files: &[&str]) -> Result<()> {
        let paths = files.iter().map(|file| Ok(std::fs::canonicalize(Path::new(file))?.display().to_string()));
        self.0.fill("#files", &paths.collect::<Result<Vec<_>>>()?.join("\n"));
        Ok(())
    }

    /// Shows a view.
    pub fn view(&self, id: &str) {
        self.0.click(&format!("#tab-{id}"));
        self.0.wait(&format!("!document.getElementById('view-{id}').hidden"));
    }
}
