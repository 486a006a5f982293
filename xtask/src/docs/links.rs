//! Checks the links of a folder of HTML: each must lead to a file of that folder, and to an existing anchor.

use anyhow::{Context, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// The content of a page.
#[derive(Default)]
struct Page {
    /// The anchors of the page.
    names: BTreeSet<String>,
    /// The targets of its links and pictures, as written.
    links: Vec<String>,
}

/// Messages about broken links. Links to other computers are not followed.
///
/// # Errors
/// If a file can't be read.
pub fn broken(folder: &Path) -> Result<Vec<String>> {
    let mut pages = BTreeMap::new();
    gather(folder, folder, &mut pages)?;
    let mut broken = Vec::new();
    for (path, page) in &pages {
        for link in page.links.iter().filter(|link| !is_elsewhere(link)) {
            if let Some(why) = fault(folder, &pages, path, link) {
                broken.push(format!("{}: {link}: {why}", path.display()));
            }
        }
    }
    Ok(broken)
}

/// All pages below a folder, by their paths from the top.
fn gather(top: &Path, folder: &Path, pages: &mut BTreeMap<PathBuf, Page>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            gather(top, &path, pages)?;
        } else if path.extension().is_some_and(|extension| extension == "html") {
            pages.insert(path.strip_prefix(top)?.to_owned(), read(&fs::read_to_string(&path)?));
        }
    }
    Ok(())
}

fn is_elsewhere(link: &str) -> bool {
    let scheme = link.split(['/', '#', '?']).next().unwrap_or_default();
    scheme.contains(':') || link.starts_with("//")
}

/// The fault of a link on the page `from`, if it has one.
fn fault(folder: &Path, pages: &BTreeMap<PathBuf, Page>, from: &Path, link: &str) -> Option<String> {
    let (file, name) = link.split_once('#').unwrap_or((link, ""));
    let to = if file.is_empty() { from.to_owned() } else { resolved(from, file) };
    if !folder.join(&to).is_file() {
        return Some(format!("{} does not exist", to.display()));
    }
    let page = pages.get(&to).filter(|_| !name.is_empty())?;
    (!page.names.contains(name)).then(|| format!("{} has no anchor {name}", to.display()))
}

/// The path, from the top, of a link's target.
fn resolved(from: &Path, file: &str) -> PathBuf {
    let mut path = from.parent().unwrap_or(Path::new("")).to_owned();
    let file = file.split('?').next().unwrap_or_default();
    for component in Path::new(file).components() {
        match component {
            // No path is above the top: the remaining path does not exist.
            Component::ParentDir => path = path.parent().map_or_else(|| "..".into(), Path::to_owned),
            Component::Normal(name) => path.push(name),
            _ => {}
        }
    }
    path
}

/// Collects the anchors and links of a page. Text contains no `<`, so that each `<` begins a tag; scripts, which may
/// contain `<`, are left out.
fn read(html: &str) -> Page {
    let mut page = Page::default();
    let mut rest = html;
    while let Some((_, tag)) = rest.split_once('<') {
        let (tag, after) = tag.split_once('>').unwrap_or((tag, ""));
        rest = if tag.starts_with("script") { after.split_once("</script").map_or("", |both| both.1) } else { after };
        for (name, value) in attributes(tag) {
            match name {
                "id" => drop(page.names.insert(value)),
                "href" | "src" => page.links.push(value),
                _ => {}
            }
        }
    }
    page
}

/// The names and values of a tag's attributes. mdBook quotes values with double quotes.
fn attributes(tag: &str) -> Vec<(&str, String)> {
    let mut found = Vec::new();
    let mut rest = tag;
    while let Some((before, (value, after))) = rest.split_once('"').and_then(|(a, b)| Some((a, b.split_once('"')?))) {
        let name = before.trim_end_matches('=').rsplit(char::is_whitespace).next().unwrap_or_default();
        found.push((name, value.replace("&amp;", "&").replace("%20", " ")));
        rest = after;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_to_files_and_names_that_are_not_there_are_told() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("more")).unwrap();
        fs::write(folder.path().join("more/picture.png"), "").unwrap();
        let index = r##"<h1 id="top">a &lt; b</h1><a href="#top">1</a> <a class="x" href="more/page.html#there">2</a>
            <a href="more/page.html#gone">3</a> <a href="page.md">4</a> <a href="https://example.org/no">5</a>
            <script>if (a < b) { c = '<a href="nowhere">'; }</script> <a href="../out.html">6</a>"##;
        fs::write(folder.path().join("index.html"), index).unwrap();
        let page = r##"<img src="picture.png" alt="a"><a id="there" href="../index.html">1</a><a href="#no">2</a>"##;
        fs::write(folder.path().join("more/page.html"), page).unwrap();
        let expected = [
            "index.html: more/page.html#gone: more/page.html has no anchor gone",
            "index.html: page.md: page.md does not exist",
            "index.html: ../out.html: ../out.html does not exist",
            "more/page.html: #no: more/page.html has no anchor no",
        ];
        assert_eq!(broken(folder.path()).unwrap(), expected);
    }
}
