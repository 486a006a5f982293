//! Writes the JSON Schemas of all results into a folder. It is a part of `cargo xtask docs`.

use canvass_reports::results::schemas::{file_name, schemas};
use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let folder: PathBuf = std::env::args_os().nth(1).unwrap_or_else(|| "docs/schemas".into()).into();
    std::fs::create_dir_all(&folder)?;
    for (contract, schema) in schemas() {
        std::fs::write(folder.join(file_name(contract)), format!("{:#}\n", schema.as_value()))?;
    }
    Ok(())
}
