//! conformance/macros
