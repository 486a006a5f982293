//! `docs/fleet.md` shows the current tables and views.

use canvass_fleet::{table, views};

fn page() -> String {
    std::fs::read_to_string(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/fleet.md")).unwrap()
}

#[test]
fn the_tables_are_those_of_the_program() {
    // `canvass-fleet schema --markdown` prints the current text.
    assert!(page().contains(table::markdown().trim_end()), "the tables in docs/fleet.md are not those of the program");
}

#[test]
fn the_views_are_those_that_ship() {
    for view in views::VIEWS {
        let row = format!("| `{}` | {}. {} |", view.name, view.title(), view.doc());
        assert!(page().contains(&row), "docs/fleet.md has no row:\n{row}");
    }
}
