//! The module `canvass._native`: what Python can't do quickly enough itself.
//!
//! - `capture`: captures, as Python objects and as Arrow streams;
//! - `simulation`: simulated buses;
//! - `description`: the objects of a device description.

mod capture;
mod description;
mod frame;
mod message;
mod simulation;
mod stream;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<capture::Capture>()?;
    module.add_class::<capture::Frames>()?;
    module.add_class::<capture::Messages>()?;
    module.add_class::<stream::Table>()?;
    module.add_class::<frame::Frame>()?;
    module.add_class::<message::Message>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_function(wrap_pyfunction!(description::objects, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::models, module)?)?;
    Ok(())
}
