//! The command's one line of refusal as an exception.

use command_line::told;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use recording::Error;

/// Where the exceptions and warnings are.
const PACKAGE: &str = "courier._errors";

/// `courier.InputError` with the line that the command would have written, and file, column and row where the error names them.
pub fn refused(py: Python<'_>, error: &anyhow::Error) -> PyErr {
    let place = error
        .chain()
        .find_map(|cause| cause.downcast_ref::<Error>());
    let made = || -> PyResult<PyErr> {
        let fields = PyDict::new(py);
        if let Some(place) = place {
            fields.set_item("file", place.file.as_os_str())?;
            fields.set_item("column", &place.column)?;
            fields.set_item("row", place.row)?;
        }
        of_class(py, "InputError", &told(error), &fields)
    };
    made().unwrap_or_else(|error| error)
}

/// The same of words that are no command line.
pub fn refused_words(py: Python<'_>, line: &str) -> PyErr {
    of_class(py, "InputError", line, &PyDict::new(py)).unwrap_or_else(|error| error)
}

/// `courier.ProgramError`: a panic, which is an error of the program and not of its input.
pub fn panicked(py: Python<'_>, line: &str) -> PyErr {
    of_class(py, "ProgramError", line, &PyDict::new(py)).unwrap_or_else(|error| error)
}

fn of_class(py: Python<'_>, name: &str, line: &str, fields: &Bound<'_, PyDict>) -> PyResult<PyErr> {
    let class = py.import(PACKAGE)?.getattr(name)?;
    Ok(PyErr::from_value(class.call((line,), Some(fields))?))
}

/// A line that the command would have written as a warning, as a `courier.RecordingWarning` where the package was called.
pub fn warn(py: Python<'_>, line: &str) -> PyResult<()> {
    py.import(PACKAGE)?.call_method1("warn", (line,)).map(drop)
}
