//! Errors of the crates as Python exceptions, with the same words.

use pyo3::{PyErr, import_exception};

import_exception!(carom._errors, BusyError);
import_exception!(carom._errors, CheckpointError);
import_exception!(carom._errors, EditError);
import_exception!(carom._errors, MeasureError);
import_exception!(carom._errors, MoleculeError);
import_exception!(carom._errors, RunError);
import_exception!(carom._errors, SceneError);

/// An error with all its causes in one line.
fn words(error: impl Into<anyhow::Error>) -> String {
    let error: anyhow::Error = error.into();
    let mut words = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        // Some errors repeat their cause.
        if !words.ends_with(&cause) {
            words = format!("{words}: {cause}");
        }
    }
    words
}

/// A `SceneError`.
pub fn scene(error: impl Into<anyhow::Error>) -> PyErr {
    SceneError::new_err(words(error))
}

/// A `RunError`.
pub fn run(error: impl Into<anyhow::Error>) -> PyErr {
    RunError::new_err(words(error))
}

/// An `EditError`.
pub fn edit(error: impl Into<anyhow::Error>) -> PyErr {
    EditError::new_err(words(error))
}

/// A `MeasureError`.
pub fn measure(error: impl Into<anyhow::Error>) -> PyErr {
    MeasureError::new_err(words(error))
}

/// A `MoleculeError`.
pub fn molecule(error: impl Into<anyhow::Error>) -> PyErr {
    MoleculeError::new_err(words(error))
}

/// A `CheckpointError`.
pub fn checkpoint(error: impl Into<anyhow::Error>) -> PyErr {
    CheckpointError::new_err(words(error))
}

/// The simulation is in use.
pub fn busy() -> PyErr {
    BusyError::new_err(
        "the simulation is running: wait until `run` returns, or use `copy()` before it",
    )
}
