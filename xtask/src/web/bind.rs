//! JavaScript for WebAssembly, by the library of wasm-bindgen, so that no program of the matching version has to be
//! installed. The library takes long to build, so that it is compiled only with the feature `bind`.

use anyhow::Result;

/// Writes the module, its JavaScript and the compressed module into a folder.
#[cfg(feature = "bind")]
pub fn bind(wasm: &str, folder: &str) -> Result<()> {
    let mut bindgen = wasm_bindgen_cli_support::Bindgen::new();
    bindgen
        .input_path(wasm)
        .out_name("canvass_web")
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true)
        .web(true)?
        .generate(folder)?;
    let module = std::fs::read(format!("{folder}/canvass_web_bg.wasm"))?;
    std::fs::write(format!("{folder}/canvass_web.wasm.gz"), pack(&module)?)?;
    Ok(())
}

/// Compresses the module by gzip, with libdeflate: zlib's best level gives a file that is a twentieth larger.
#[cfg(feature = "bind")]
fn pack(module: &[u8]) -> Result<Vec<u8>> {
    let mut compressor = libdeflater::Compressor::new(libdeflater::CompressionLvl::best());
    let mut packed = vec![0; compressor.gzip_compress_bound(module.len())];
    let length = compressor.gzip_compress(module, &mut packed)?;
    packed.truncate(length);
    Ok(packed)
}

/// Makes the bindings with an xtask that has the feature `bind`.
#[cfg(not(feature = "bind"))]
pub fn bind(wasm: &str, folder: &str) -> Result<()> {
    super::by_another("bind", &["web-bind", wasm, folder])
}
