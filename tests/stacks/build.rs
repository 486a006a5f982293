//! Lets zencan generate its node from the device configuration, as its documentation says.

fn main() -> Result<(), zencan_build::errors::CompileError> {
    println!("cargo:rerun-if-changed=zencan.toml");
    zencan_build::build_node_from_device_config("ZENCAN", "zencan.toml")
}
