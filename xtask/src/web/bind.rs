//! JavaScript for WebAssembly: by the library of wasm-bindgen, so that no program has to be installed in the version that
//! fits. It is much to build, so it stands behind a feature that only this asks for.

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
