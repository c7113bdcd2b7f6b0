//! The compiled part of the Python package `carom`: plain functions and one class, which the
//! modules in `python/carom` wrap.
//!
//! Scenes cross the border as TOML text, results as encoded records, bodies as NumPy arrays.

mod arrays;
mod collisions;
mod contacts;
mod edits;
mod errors;
mod molecule;
mod records;
mod run_loop;
mod scene;
mod simulation;
mod studies;

use pyo3::prelude::*;

/// The module `carom._carom`.
#[pymodule]
fn _carom(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", carom::VERSION)?;
    module.add_class::<molecule::MoleculeCore>()?;
    module.add_class::<simulation::Core>()?;
    module.add_function(wrap_pyfunction!(scene::scene_of, module)?)?;
    module.add_function(wrap_pyfunction!(scene::scene_of_text, module)?)?;
    module.add_function(wrap_pyfunction!(scene::tables_of, module)?)?;
    module.add_function(wrap_pyfunction!(scene::scene_of_file, module)?)?;
    module.add_function(wrap_pyfunction!(scene::measure_kinds, module)?)?;
    module.add_function(wrap_pyfunction!(contacts::first_contact, module)?)?;
    module.add_function(wrap_pyfunction!(records::run_scene, module)?)?;
    module.add_function(wrap_pyfunction!(records::record_of_folder, module)?)?;
    module.add_function(wrap_pyfunction!(records::merge_records, module)?)?;
    module.add_function(wrap_pyfunction!(records::record_contents, module)?)?;
    module.add_function(wrap_pyfunction!(records::table_pictures, module)?)?;
    module.add_function(wrap_pyfunction!(records::mean_of_series, module)?)?;
    module.add_function(wrap_pyfunction!(studies::study_point, module)?)?;
    Ok(())
}
