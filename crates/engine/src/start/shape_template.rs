//! The shape that the keys of a molecule or of a gas describe, before its size and mass are given.

use carom_geometry::{
    Atom, DEFAULT_ROUNDING, EdgedShape, Ellipse, GeometryError, Interior, Molecule, Shape,
    check_corner_count,
};
use glam::DVec2;

use crate::scene::{
    MoleculeSpec, atom_spec::AtomSpec, ellipse_spec::EllipseSpec, gas_spec::GasSpec,
};

/// The keys of a shape that a molecule and a gas have in common.
#[derive(Clone, Copy)]
pub(crate) struct ShapeKeys<'a> {
    pub shape: Option<&'a str>,
    pub atoms: &'a [AtomSpec],
    pub ellipses: &'a [EllipseSpec],
    pub edges: &'a [[u32; 2]],
    pub edge_radius: Option<f64>,
    pub hollow: bool,
    pub polygon: &'a [[f64; 2]],
    pub rounding: Option<f64>,
}

impl<'a> From<&'a MoleculeSpec> for ShapeKeys<'a> {
    fn from(spec: &'a MoleculeSpec) -> Self {
        Self {
            shape: spec.shape.as_deref(),
            atoms: &spec.atoms,
            ellipses: &spec.ellipses,
            edges: &spec.edges,
            edge_radius: spec.edge_radius,
            hollow: spec.hollow,
            polygon: &spec.polygon,
            rounding: spec.rounding,
        }
    }
}

/// A gas without any description of its molecules is one of discs.
impl<'a> From<&'a GasSpec> for ShapeKeys<'a> {
    fn from(spec: &'a GasSpec) -> Self {
        let is_listed = !(spec.atoms.is_empty() && spec.ellipses.is_empty());
        let is_undescribed = !is_listed && spec.polygon.is_empty();
        Self {
            shape: spec.shape.as_deref().or(is_undescribed.then_some("disc")),
            atoms: &spec.atoms,
            ellipses: &spec.ellipses,
            edges: &spec.edges,
            edge_radius: spec.edge_radius,
            hollow: spec.hollow,
            polygon: &spec.polygon,
            rounding: spec.rounding,
        }
    }
}

/// A shape of any size and mass.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Template {
    /// Equal discs, by name; the size is the radius of an atom, the mass that of an atom.
    Named(Shape),
    /// A body with sides, by name.
    Edged { shape: EdgedShape, rounding: f64 },
    /// Own corners, and the radius of the corners, at scale 1.
    Polygon { corners: Vec<DVec2>, radius: f64 },
    /// Own atoms and edges at scale 1; the mass is a factor.
    Listed {
        atoms: Vec<Atom>,
        edges: Vec<([u32; 2], f64)>,
        interior: Interior,
    },
    /// Own ellipses at scale 1, with discs as ellipses of equal axes: the place, the shape and the
    /// mass of each; the mass is a factor.
    Ellipses(Vec<(DVec2, Ellipse, f64)>),
}

/// Why keys describe no shape.
#[derive(Debug)]
pub(crate) enum Refusal {
    Keys(String),
    Geometry(GeometryError),
}

impl From<GeometryError> for Refusal {
    fn from(error: GeometryError) -> Self {
        Self::Geometry(error)
    }
}

fn keys(problem: &str) -> Refusal {
    Refusal::Keys(problem.to_owned())
}

impl Template {
    /// The shape that the keys describe.
    pub fn new(given: ShapeKeys<'_>) -> Result<Self, Refusal> {
        let is_listed = !given.atoms.is_empty();
        let of_ellipses = !given.ellipses.is_empty();
        if given.shape.is_some() && is_listed {
            return Err(keys("give `shape` or `atoms`, not both"));
        }
        if !given.polygon.is_empty() && (given.shape.is_some() || is_listed) {
            return Err(keys("give one of `shape`, `atoms` and `polygon`"));
        }
        if of_ellipses && (given.shape.is_some() || !given.polygon.is_empty()) {
            return Err(keys("give one of `shape`, `ellipses` and `polygon`"));
        }
        if of_ellipses && !given.edges.is_empty() {
            return Err(keys(
                "`edges` do not go with `ellipses`, because the area of a body of both is not known: describe the \
                 ellipses as a body of their own, or build the shape of `atoms` and `edges` only",
            ));
        }
        let of_edges = !given.edges.is_empty() || given.edge_radius.is_some() || given.hollow;
        if of_edges && !is_listed {
            return Err(keys(
                "`edges`, `edge_radius` and `hollow` go with a list of `atoms`",
            ));
        }
        if given.edges.is_empty() && (given.edge_radius.is_some() || given.hollow) {
            return Err(keys("`edge_radius` and `hollow` go with `edges`"));
        }
        if !given.polygon.is_empty() {
            return Self::polygon(given);
        }
        let template = match given.shape {
            None if of_ellipses => Self::ellipses(given)?,
            None => Self::listed(given)?,
            Some(name) => match name.parse::<Shape>() {
                Ok(shape) => Self::Named(shape),
                Err(GeometryError::UnknownShape(_)) => Self::Edged {
                    shape: name.parse()?,
                    rounding: given.rounding.unwrap_or(DEFAULT_ROUNDING),
                },
                Err(reason) => return Err(reason.into()),
            },
        };
        let has_corners = matches!(
            template,
            Self::Edged { shape, .. }
                if !matches!(shape, EdgedShape::Capsule(_) | EdgedShape::Ellipse(_))
        );
        if given.rounding.is_some() && !has_corners {
            return Err(keys(
                "`rounding` goes with a shape that has corners: square, rectangle:A, triangle, polygon:N, kite:A,B or \
                 `polygon`",
            ));
        }
        Ok(template)
    }

    fn polygon(given: ShapeKeys<'_>) -> Result<Self, Refusal> {
        check_corner_count(given.polygon.len())?;
        let corners: Vec<DVec2> = given.polygon.iter().map(|&corner| corner.into()).collect();
        let size = corners
            .iter()
            .enumerate()
            .flat_map(|(index, corner)| {
                corners[..index].iter().map(|other| corner.distance(*other))
            })
            .fold(0.0, f64::max);
        let radius = given.rounding.unwrap_or(DEFAULT_ROUNDING) * size;
        Ok(Self::Polygon { corners, radius })
    }

    fn ellipses(given: ShapeKeys<'_>) -> Result<Self, Refusal> {
        let disc = |spec: &AtomSpec| {
            let shape = Ellipse::new([spec.radius; 2], DVec2::X)?;
            Ok((DVec2::from(spec.at), shape, spec.mass))
        };
        let ellipse = |spec: &EllipseSpec| Ok((DVec2::from(spec.at), spec.shape()?, spec.mass));
        let discs = given.atoms.iter().map(disc);
        let parts = discs.chain(given.ellipses.iter().map(ellipse));
        let parts = parts.collect::<Result<_, GeometryError>>()?;
        Ok(Self::Ellipses(parts))
    }

    fn listed(given: ShapeKeys<'_>) -> Result<Self, Refusal> {
        let atom = |spec: &AtomSpec| Atom::new(DVec2::from(spec.at), spec.radius, spec.mass);
        let atoms: Vec<Atom> = given.atoms.iter().map(atom).collect::<Result<_, _>>()?;
        let radius = |end: u32| atoms.get(end as usize).map_or(0.0, Atom::radius);
        let edge = |&[first, second]: &[u32; 2]| {
            let thinner = radius(first).min(radius(second));
            ([first, second], given.edge_radius.unwrap_or(thinner))
        };
        Ok(Self::Listed {
            edges: given.edges.iter().map(edge).collect(),
            interior: if given.hollow {
                Interior::Hollow
            } else {
                Interior::Solid
            },
            atoms,
        })
    }

    /// This shape as a list of atoms of size 1 and mass 1 each, where it is one of discs.
    pub fn unfolded(self) -> Result<Self, GeometryError> {
        match self {
            Self::Named(shape) => Ok(Self::Listed {
                atoms: shape.atoms(1.0, 1.0)?,
                edges: Vec::new(),
                interior: Interior::default(),
            }),
            other => Ok(other),
        }
    }

    /// The molecule of this size or scale, with this mass: for discs by name that of an atom, for a
    /// list a factor.
    pub fn molecule(&self, length: f64, mass: f64) -> Result<Molecule, GeometryError> {
        match self {
            Self::Named(shape) => Molecule::named(*shape, length, mass),
            Self::Edged { shape, rounding } => shape.molecule(length, *rounding, mass),
            Self::Polygon { corners, radius } => {
                let corners: Vec<DVec2> = corners.iter().map(|corner| length * *corner).collect();
                Molecule::polygon(&corners, length * radius, mass)
            }
            Self::Listed {
                atoms,
                edges,
                interior,
            } => {
                let atom = |atom: &Atom| {
                    let (offset, radius) = (length * atom.offset(), length * atom.radius());
                    Atom::new(offset, radius, mass * atom.mass())
                };
                let atoms: Vec<Atom> = atoms.iter().map(atom).collect::<Result<_, _>>()?;
                let edge = |&(ends, radius): &([u32; 2], f64)| (ends, length * radius);
                let edges: Vec<_> = edges.iter().map(edge).collect();
                Molecule::with_edges(atoms, &edges, *interior)
            }
            Self::Ellipses(parts) => {
                let part = |&(place, shape, own): &(DVec2, Ellipse, f64)| {
                    let shape = Ellipse::new(shape.axes().map(|axis| length * axis), shape.along());
                    Ok((length * place, shape?, mass * own))
                };
                let parts: Vec<_> = parts
                    .iter()
                    .map(part)
                    .collect::<Result<_, GeometryError>>()?;
                Molecule::of_ellipses(parts)
            }
        }
    }

    /// The molecule of this size or scale with this mass per area.
    pub fn of_density(&self, length: f64, density: f64) -> Result<Molecule, GeometryError> {
        let of_mass_1 = self.molecule(length, 1.0)?;
        self.molecule(length, density * of_mass_1.area() / of_mass_1.mass())
    }
}
