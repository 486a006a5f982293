//! The page with opened files.

use canvass_webdriver::{Browser, Screen, url};
use std::path::{Path, PathBuf};

/// The page, and a folder for the files to open.
pub struct Opened {
    pub browser: Browser,
    folder: tempfile::TempDir,
}

impl Opened {
    /// The page before any file is opened.
    pub fn empty(screen: Screen) -> Self {
        Self::of(screen, |_| {})
    }

    /// The empty page on a desktop screen; `prepare` changes the browser first.
    pub fn prepared(prepare: impl FnOnce(&Browser)) -> Self {
        Self::of(Screen::Desk, prepare)
    }

    fn of(screen: Screen, prepare: impl FnOnce(&Browser)) -> Self {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/page/canvass.html");
        assert!(page.exists(), "cargo xtask web makes {}", page.display());
        let browser = Browser::prepared(&url(&page), screen, prepare);
        browser.wait("document.documentElement.dataset.ready === 'yes'");
        Self { browser, folder: tempfile::tempdir().unwrap() }
    }

    /// The page with a capture of this name and content.
    pub fn with(screen: Screen, name: &str, content: impl AsRef<[u8]>) -> Self {
        let opened = Self::empty(screen);
        opened.take(&[opened.file(name, content)]);
        opened.browser.wait("/frames?, /.test(document.getElementById('status').textContent)");
        opened
    }

    /// Writes a file of this name into the folder.
    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    /// Opens files in the page, as the file dialog would.
    pub fn take(&self, files: &[PathBuf]) {
        let paths: Vec<_> = files.iter().map(|path| path.to_str().unwrap()).collect();
        self.browser.fill("#files", &paths.join("\n"));
    }

    /// Shows a view.
    pub fn view(&self, id: &str) {
        self.browser.click(&format!("#tab-{id}"));
    }

    /// The visible rows, with bars between their cells.
    pub fn rows(&self) -> Vec<String> {
        self.browser.wait("document.querySelector('.list-body .row .text')?.textContent");
        let rows = self.browser.run(
            "return [...document.querySelectorAll('.list-body .row')].filter((row) => !row.hidden) \
             .map((row) => [...row.children].filter((cell) => cell.checkVisibility()).map((cell) => cell.textContent).join('|'))",
        );
        rows.as_array().unwrap().iter().map(|row| row.as_str().unwrap().to_owned()).collect()
    }
}
