//! Molecules: mass, inertia, area, and the part of the outline that a round probe can touch.

use carom::{
    SceneError,
    engine::MoleculeSpec,
    geometry::{Atom, Edge, ExcludedRegion, ExposedArc, ExposedSide, Molecule, Shape},
};
use carom_report::molecule_picture;
use glam::DVec2;
use numpy::{PyArray1, PyArray2};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    arrays::{read_only, rows},
    errors,
    scene::table_of,
};

/// A molecule.
#[pyclass(frozen, module = "carom._carom")]
pub struct MoleculeCore(pub Molecule);

/// Most atoms of a molecule given as a list; finding coincident ones takes the square of their
/// number.
const MAX_ATOMS: usize = 65_536;

impl MoleculeCore {
    fn region(&self, probe: f64) -> PyResult<ExcludedRegion> {
        ExcludedRegion::new(&self.0, probe).map_err(errors::molecule)
    }
}

#[pymethods]
impl MoleculeCore {
    /// From x, y, radius and mass of each atom.
    #[new]
    fn new(atoms: Vec<[f64; 4]>) -> PyResult<Self> {
        if atoms.len() > MAX_ATOMS {
            let words = format!(
                "a molecule has at most {MAX_ATOMS} atoms, but {} are given",
                atoms.len()
            );
            return Err(errors::MoleculeError::new_err(words));
        }
        let atom = |[x, y, radius, mass]: [f64; 4]| Atom::new(DVec2::new(x, y), radius, mass);
        let atoms: Result<Vec<Atom>, _> = atoms.into_iter().map(atom).collect();
        Molecule::new(atoms.map_err(errors::molecule)?)
            .map(Self)
            .map_err(errors::molecule)
    }

    #[staticmethod]
    fn named(shape: &str, radius: f64, mass: f64) -> PyResult<Self> {
        let shape: Shape = shape.parse().map_err(errors::molecule)?;
        Molecule::named(shape, radius, mass)
            .map(Self)
            .map_err(errors::molecule)
    }

    /// From the keys of the shape, the size and the mass of a single molecule of a scene.
    #[staticmethod]
    fn described(keys: &Bound<'_, PyDict>) -> PyResult<Self> {
        let spec: MoleculeSpec = table_of(keys, 0)?.try_into().map_err(errors::molecule)?;
        spec.molecule("").map(Self).map_err(|error| match error {
            // Without the name of an entry, which a molecule of its own does not have.
            SceneError::Geometry { reason, .. } => errors::molecule(reason),
            SceneError::Entry { problem, .. } => errors::molecule(anyhow::Error::msg(problem)),
            other => errors::molecule(other),
        })
    }

    /// Indices of the atoms at the ends of each edge.
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let ends = self.0.edges().iter().filter_map(Edge::ends);
        rows(py, ends.flat_map(|ends| ends.map(i64::from)).collect(), 2)
    }

    /// Whether both have equal atoms, edges, interiors and masses.
    fn equals(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    /// x, y, radius and mass of each atom, about the centre of mass.
    fn atoms<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let atoms = self.0.atoms().iter();
        let row = |atom: &Atom| [atom.offset().x, atom.offset().y, atom.radius(), atom.mass()];
        read_only(rows(py, atoms.flat_map(row).collect(), 4)?.into_any())
    }

    fn mass(&self) -> f64 {
        self.0.mass()
    }

    fn moment_of_inertia(&self) -> f64 {
        self.0.moment_of_inertia()
    }

    fn area(&self) -> f64 {
        self.0.area()
    }

    fn bounding_radius(&self) -> f64 {
        self.0.bounding_radius()
    }

    /// Atom, start and end angle, radius, and centre of each arc.
    fn arcs<'py>(&self, py: Python<'py>, probe: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let region = self.region(probe)?;
        let arcs = region.arcs().iter();
        let row = |arc: &ExposedArc| {
            [
                arc.atom as f64,
                arc.start,
                arc.end,
                arc.radius,
                arc.centre.x,
                arc.centre.y,
            ]
        };
        rows(py, arcs.flat_map(row).collect(), 6)
    }

    /// Edge, first and last place of the probe's centre, normal, and distance of each side.
    fn sides<'py>(&self, py: Python<'py>, probe: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let region = self.region(probe)?;
        let row = |side: &ExposedSide| {
            [
                side.edge as f64,
                side.start.x,
                side.start.y,
                side.end.x,
                side.end.y,
                side.normal,
                side.radius,
            ]
        };
        rows(py, region.sides().iter().flat_map(row).collect(), 7)
    }

    /// Perimeter, area and area of pockets.
    fn excluded(&self, probe: f64) -> PyResult<(f64, f64, f64)> {
        let region = self.region(probe)?;
        Ok((region.perimeter(), region.area(), region.pocket_area()))
    }

    fn atom_shares<'py>(&self, py: Python<'py>, probe: f64) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.region(probe)?.atom_shares()))
    }

    fn edge_shares<'py>(&self, py: Python<'py>, probe: f64) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.region(probe)?.edge_shares()))
    }

    fn mean_free_path(&self, area: f64, probe: f64) -> PyResult<f64> {
        Ok(self.region(probe)?.mean_free_path(area))
    }

    fn svg(&self, probe: f64) -> PyResult<String> {
        Ok(molecule_picture::svg(&self.0, &self.region(probe)?, probe))
    }
}
