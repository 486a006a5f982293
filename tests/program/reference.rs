//! The reference pages of the book: `canvass list … --format markdown` has an entry for everything that `list` names.

use crate::running::run;
use serde_json::Value;

/// A page, and the text with which the entry of an id begins.
struct Reference {
    what: &'static str,
    entry: fn(&str) -> String,
}

const REFERENCES: [Reference; 4] = [
    Reference { what: "cases", entry: |id| format!("\n- **`{id}`** (") },
    Reference { what: "rules", entry: |id| format!("\n## {id}\n\n*") },
    Reference { what: "eds-rules", entry: |id| format!("\n## {id}\n\n*") },
    Reference { what: "faults", entry: |id| format!("\n| `{id}` | ") },
];

fn ids(what: &str) -> Vec<String> {
    let listed: Value = serde_json::from_str(&run(&["list", what, "--format", "json"]).stdout).unwrap();
    listed.as_array().unwrap().iter().map(|row| row["id"].as_str().unwrap().to_owned()).collect()
}

/// The text of an entry, up to the next entry or the next heading.
fn body(rest: &str) -> &str {
    let end = ["\n- **`", "\n#", "\n| `"].iter().filter_map(|next| rest.find(next)).min().unwrap_or(rest.len());
    &rest[..end]
}

#[test]
fn everything_that_is_listed_has_one_entry_with_a_text() {
    for Reference { what, entry } in REFERENCES {
        let page = run(&["list", what, "--format", "markdown"]).stdout;
        let ids = ids(what);
        assert!(ids.len() > 40, "{what}: {}", ids.len());
        for id in ids {
            let parts: Vec<&str> = page.split(&entry(&id)).collect();
            assert_eq!(parts.len(), 2, "{what}: {id}");
            assert!(body(parts[1]).split_whitespace().count() > 3, "{what}: {id}: {}", body(parts[1]));
        }
    }
}

/// The table at the top links to each rule: GitHub and mdBook omit the slash from the anchor of a heading.
#[test]
fn the_table_of_a_handbook_links_to_its_headings() {
    for what in ["rules", "eds-rules"] {
        let page = run(&["list", what, "--format", "markdown"]).stdout;
        for id in ids(what) {
            assert!(page.contains(&format!("\n| [{id}](#{}) | ", id.replace('/', ""))), "{what}: {id}");
        }
    }
}
