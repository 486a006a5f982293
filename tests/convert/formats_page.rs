//! `docs/formats.md` agrees with the program.

use canvass_traces::Format;
use std::path::Path;

const BEGIN: &str = "<!-- The table is generated: `cargo test formats_page` prints it where it differs. -->\n";

fn table() -> String {
    let row = |format: Format| {
        let extensions: Vec<_> = format.extensions().iter().map(|extension| format!("`.{extension}`")).collect();
        let losses: Vec<_> = format.losses().iter().map(|loss| loss.name()).collect();
        let (written, lost) = match (format.is_written(), losses.is_empty()) {
            (false, _) => ("no", String::new()),
            (true, true) => ("yes", "nothing".to_owned()),
            (true, false) => ("yes", losses.join("; ")),
        };
        format!("| `{}` | {} | {} | yes | {written} | {lost} |\n", format.id(), format.summary(), extensions.join(" "))
    };
    let head = "| id | format | file names | read | written | what writing can lose |\n|---|---|---|---|---|---|\n";
    head.to_owned() + &Format::all().map(row).collect::<String>()
}

#[test]
fn the_table_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/formats.md");
    let page = std::fs::read_to_string(path).unwrap();
    let (_, behind) = page.split_once(BEGIN).unwrap();
    assert!(behind.trim_start().starts_with(&table()), "docs/formats.md should have this table:\n{}", table());
}
