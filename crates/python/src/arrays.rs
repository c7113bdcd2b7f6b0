//! Quantities of all bodies as NumPy arrays: owned copies at the present time, which cannot be
//! written to, since assignments would not change the simulation.

use std::collections::HashMap;

use carom::{
    View,
    engine::{BodyView, Tag},
    observers::{bonded_atoms, kinds_of_groups, names_of_kinds},
};
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods};
use pyo3::{
    exceptions::PyValueError,
    prelude::*,
    types::{PyDict, PyTuple},
};

/// An array of rows of `width` numbers.
pub fn rows<'py, T: Element>(
    py: Python<'py>,
    numbers: Vec<T>,
    width: usize,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let count = numbers.len() / width;
    PyArray1::from_vec(py, numbers).reshape([count, width])
}

/// The read-only array with this name.
pub fn named<'py>(py: Python<'py>, view: &View<'_>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    read_only(owned(py, view, name)?)
}

/// The array, which can then no longer be written to.
pub fn read_only<'py>(array: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    array.call_method1("setflags", (false,))?;
    Ok(array)
}

fn owned<'py>(py: Python<'py>, view: &View<'_>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let pairs = |pair: &dyn Fn(BodyView<'_>) -> [f64; 2]| -> PyResult<_> {
        let mut numbers = Vec::with_capacity(2 * view.len());
        view.bodies().for_each(|body| numbers.extend(pair(body)));
        Ok(rows(py, numbers, 2)?.into_any())
    };
    let single = |number: &dyn Fn(BodyView<'_>) -> f64| -> PyResult<_> {
        Ok(PyArray1::from_vec(py, view.bodies().map(number).collect()).into_any())
    };
    match name {
        "positions" => pairs(&|body| body.motion.position.to_array()),
        "unwrapped_positions" => pairs(&|body| body.unwrapped(&view.bounds()).to_array()),
        "velocities" => pairs(&|body| body.motion.velocity.to_array()),
        "angles" => single(&|body| body.motion.orientation.radians()),
        "angular_velocities" => single(&|body| body.motion.angular_velocity),
        "radii" => single(&|body| body.body.reach()),
        "masses" => single(&|body| body.body.mass()),
        "energies" => single(&|body| body.energy()),
        "ids" => Ok(
            PyArray1::from_vec(py, view.bodies().map(|body| body.body.id()).collect()).into_any(),
        ),
        "fixed" => Ok(PyArray1::from_vec(
            py,
            view.bodies().map(|body| body.body.is_fixed()).collect(),
        )
        .into_any()),
        "locked" => Ok(PyArray1::from_vec(
            py,
            view.bodies().map(|body| body.body.is_locked()).collect(),
        )
        .into_any()),
        _ => Err(PyValueError::new_err(format!("unknown array {name:?}"))),
    }
}

/// Quantities of all atoms by name, one row each, with the numbers and the names of their kinds.
pub fn atoms<'py>(py: Python<'py>, view: &View<'_>) -> PyResult<Bound<'py, PyDict>> {
    let (mut positions, mut velocities, mut images) = (Vec::new(), Vec::new(), Vec::new());
    let (mut angles, mut radii, mut masses) = (Vec::new(), Vec::new(), Vec::new());
    let (mut ids, mut kind_of, mut fixed) = (Vec::new(), Vec::new(), Vec::new());
    let kinds = kinds_of_groups(view);
    for (body, &kind) in view
        .bodies()
        .zip(&kinds)
        .filter(|(body, _)| !body.body.is_wall())
    {
        let rotation = body.motion.orientation.cos_sin();
        for atom in body.body.molecule().atoms() {
            let arm = rotation.rotate(atom.offset());
            positions.extend((body.motion.position + arm).to_array());
            velocities.extend(body.motion.velocity_of(arm).to_array());
            images.extend(body.winding);
            angles.push(body.motion.orientation.radians());
            radii.push(atom.radius());
            masses.push(atom.mass());
            ids.push(body.body.id());
            kind_of.push(kind as u64);
            fixed.push(body.body.is_fixed());
        }
    }
    let atoms = PyDict::new(py);
    atoms.set_item("positions", rows(py, positions, 2)?)?;
    atoms.set_item("velocities", rows(py, velocities, 2)?)?;
    atoms.set_item("images", rows(py, images, 2)?)?;
    atoms.set_item("angles", PyArray1::from_vec(py, angles))?;
    atoms.set_item("radii", PyArray1::from_vec(py, radii))?;
    atoms.set_item("masses", PyArray1::from_vec(py, masses))?;
    atoms.set_item("ids", PyArray1::from_vec(py, ids))?;
    atoms.set_item("kinds", PyArray1::from_vec(py, kind_of))?;
    atoms.set_item("fixed", PyArray1::from_vec(py, fixed))?;
    let bonds = bonded_atoms(view).into_iter().flatten();
    let bonds = bonds.map(|atom| atom as u64).collect();
    atoms.set_item("bonds", rows(py, bonds, 2)?)?;
    atoms.set_item("names", names_of_kinds(view, &kinds))?;
    Ok(atoms)
}

/// The tags of each body.
pub fn tags(py: Python<'_>, view: &View<'_>) -> PyResult<Vec<Py<PyTuple>>> {
    let mut known: HashMap<&[Tag], Py<PyTuple>> = HashMap::new();
    let mut all = Vec::with_capacity(view.len());
    for body in view.bodies() {
        let tags = body.body.tags();
        let names = match known.get(tags) {
            Some(names) => names.clone_ref(py),
            None => {
                let names =
                    PyTuple::new(py, tags.iter().map(|&tag| view.tag_names().name(tag)))?.unbind();
                known.insert(tags, names.clone_ref(py));
                names
            }
        };
        all.push(names);
    }
    Ok(all)
}
