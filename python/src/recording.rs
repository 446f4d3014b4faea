//! Recordings, column by column.

use crate::work::done;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use recording::COLUMNS;
use std::path::PathBuf;
use std::sync::Arc;

/// A recording in memory; it does not change.
#[pyclass(frozen)]
pub struct Recording {
    pub(crate) path: PathBuf,
    pub(crate) inner: Arc<recording::Recording>,
}

#[pymethods]
impl Recording {
    /// Reads and checks the recording at `path`.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let inner = done(py, "read", |tell| {
            let inner = courier::recordings::read(&path)?;
            inner.warnings.iter().for_each(|line| tell(line));
            Ok(Arc::new(inner))
        })?;
        Ok(Self { path, inner })
    }

    /// Where it was read, as it was named.
    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    /// Number of samples.
    fn __len__(&self) -> usize {
        self.inner.samples.len()
    }

    /// Names of the columns of numbers that hold anything, in the order of `samples.csv`; further quantities that were logged behind them.
    #[getter]
    fn columns(&self) -> Vec<String> {
        let samples = &self.inner.samples;
        let held = COLUMNS.iter().filter(|(column, _)| samples.has(*column));
        let logged = samples.logged().iter().map(|logged| logged.name.clone());
        held.map(|(_, name)| (*name).to_owned())
            .chain(logged)
            .collect()
    }

    /// A column of numbers.
    fn column(&self, name: &str) -> PyResult<Column> {
        let missing = || PyKeyError::new_err(name.to_owned());
        let column = Column {
            recording: Arc::clone(&self.inner),
            place: Place::named(&self.inner, name).ok_or_else(missing)?,
        };
        Ok(column)
    }

    /// Names of the motions, in the order of their first appearance.
    #[getter]
    fn run_names(&self) -> Vec<String> {
        self.inner.samples.run_names().to_vec()
    }

    /// Of each sample, the number of its motion: a place in `run_names`.
    fn run_numbers(&self) -> Column {
        let samples = &self.inner.samples;
        let numbers = (0..samples.len()).map(|index| samples.run_number(index) as u32);
        Column {
            recording: Arc::clone(&self.inner),
            place: Place::Runs(numbers.collect()),
        }
    }

    /// The text of `recording.toml`.
    #[getter]
    fn toml(&self) -> String {
        self.inner.meta.to_toml()
    }

    /// The same as JSON.
    #[getter]
    fn meta_json(&self) -> String {
        let table: toml::Table = self.inner.meta.to_toml().parse().unwrap_or_default();
        serde_json::to_string(&table).unwrap_or_default()
    }
}

/// Where the numbers of a column are.
enum Place {
    /// One of the layout's columns.
    Layout(recording::Column),
    /// A quantity that was logged besides, by its place.
    Logged(usize),
    /// Numbers of the motions.
    Runs(Vec<u32>),
}

impl Place {
    fn named(recording: &recording::Recording, name: &str) -> Option<Self> {
        let samples = &recording.samples;
        let layout = recording::Column::by_name(name).filter(|column| samples.has(*column));
        let logged = || {
            samples
                .logged()
                .iter()
                .position(|logged| logged.name == name)
        };
        layout
            .map(Self::Layout)
            .or_else(|| logged().map(Self::Logged))
    }
}

/// A column of a recording. NumPy reads it in place: `numpy.asarray(column)` copies nothing and keeps the recording.
#[pyclass(frozen)]
pub struct Column {
    recording: Arc<recording::Recording>,
    place: Place,
}

#[pymethods]
impl Column {
    /// Where the numbers are and of which type, in NumPy's array interface, version 3; they cannot be written to.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let samples = &self.recording.samples;
        let (address, length, kind) = match &self.place {
            Place::Layout(column) => numbers(samples.column(*column)),
            Place::Logged(place) => numbers(&samples.logged()[*place].values),
            Place::Runs(runs) => (runs.as_ptr().expose_provenance(), runs.len(), "u4"),
        };
        let order = if cfg!(target_endian = "little") {
            '<'
        } else {
            '>'
        };
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("typestr", format!("{order}{kind}"))?;
        interface.set_item("shape", (length,))?;
        interface.set_item("data", (address, true))?;
        Ok(interface)
    }
}

fn numbers(values: &[f64]) -> (usize, usize, &'static str) {
    (values.as_ptr().expose_provenance(), values.len(), "f8")
}
