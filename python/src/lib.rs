//! The module `courier._native`: what the commands of `courier` do, as functions of Python.
//!
//! Nothing is computed here. Options are words, taken apart by the command's own parser; answers are the command's own JSON and text, of
//! which the package beside this one (`courier/`) makes dataclasses. `recording` gives columns as memory that NumPy reads in place,
//! `work` does what takes long without the interpreter's lock, `error` turns the command's one line into an exception, `commands` is
//! one function a command.

#![cfg(feature = "module")]

mod commands;
mod error;
mod recording;
mod work;

use pyo3::prelude::*;

/// The native half of the package `courier`.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::commands::{check, diagnose, diagnose_many, encoder, isolability, replay};
    #[pymodule_export]
    use crate::recording::{Column, Recording};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("VERSION", env!("CARGO_PKG_VERSION"))?;
        module.add("HAS_PARQUET", cfg!(feature = "parquet"))
    }
}
