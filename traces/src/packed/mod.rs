//! zstd and lz4: by the usual C libraries or, in WebAssembly, which has no C, by Rust libraries that only read.

#[cfg(not(target_family = "wasm"))]
mod in_c;
#[cfg(any(test, target_family = "wasm"))]
#[cfg_attr(not(target_family = "wasm"), expect(unused, reason = "the writer is called in WebAssembly only"))]
mod in_rust;

#[cfg(not(target_family = "wasm"))]
pub(crate) use in_c::{ZstdWriter, lz4, mcap_options, zstd};
#[cfg(target_family = "wasm")]
pub(crate) use in_rust::{ZstdWriter, lz4, mcap_options, zstd};
