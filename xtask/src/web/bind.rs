//! JavaScript for WebAssembly, by the library of wasm-bindgen, so that no program of the matching version has to be
//! installed. The library takes long to build, so it is behind a feature that only this needs.

use anyhow::Result;

/// Writes the module and its JavaScript into a folder.
#[cfg(feature = "web")]
pub fn bind(wasm: &str, folder: &str) -> Result<()> {
    let mut bindgen = wasm_bindgen_cli_support::Bindgen::new();
    bindgen
        .input_path(wasm)
        .out_name("canvass_web")
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true)
        .web(true)?
        .generate(folder)
}

/// Makes the bindings with an xtask that has the feature `web`.
#[cfg(not(feature = "web"))]
pub fn bind(wasm: &str, folder: &str) -> Result<()> {
    super::by_another(&["web-bind", wasm, folder])
}
