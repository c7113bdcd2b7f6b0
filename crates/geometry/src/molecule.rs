//! A molecule: a rigid union of atoms and straight edges, written in the frame of its centre of
//! mass.

use glam::DVec2;
use parry2d_f64::{
    math::Pose,
    shape::{Compound, SharedShape},
};
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use crate::{
    Atom, AtomRow, Bend, CircleTree, Edge, Ellipse, FacingParts, GeometryError, Outline, Shape,
    Support,
    atom::reach,
    check_length, check_positive,
    covered_area::covered_area,
    hull::{HullSide, hull_sides},
    interior::{self, Interior, MIN_ROUNDING},
    properties::Properties,
    union::{Bar, Union},
};

/// A rigid union of discs, and of thick straight edges between them, with its mass, moment of
/// inertia and bounding circle.
///
/// The atoms' offsets are relative to the centre of mass; the atoms keep the order given. Atoms may
/// overlap; each adds its own mass. Edges have no mass of their own ([`Self::with_edges`]), unless
/// the mass is spread evenly over the whole body ([`Self::uniform`], [`Self::polygon`],
/// [`Self::capsule`]).
///
/// ```
/// use carom_geometry::{Atom, Molecule};
/// use glam::DVec2;
///
/// let left = Atom::new(DVec2::new(0.0, 0.0), 0.5, 1.0)?;
/// let right = Atom::new(DVec2::new(1.0, 0.0), 0.5, 1.0)?;
/// let dumbbell = Molecule::new([left, right])?;
/// assert_eq!(dumbbell.atoms()[0].offset(), DVec2::new(-0.5, 0.0));
/// // Two discs: 2 (m r²/2 + m d²), r = d = 1/2.
/// assert_eq!(dumbbell.moment_of_inertia(), 0.75);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(into = "Written", try_from = "Written")]
pub struct Molecule {
    atoms: SmallVec<[Atom; 1]>,
    edges: Vec<Edge>,
    /// The shapes of the atoms, if any is not a disc; else empty.
    ellipses: Vec<Ellipse>,
    /// Whether what closed lines of edges enclose belongs to the molecule.
    interior: Interior,
    /// Whether the mass is spread evenly over the area; else it is that of the atoms.
    is_uniform: bool,
    mass: f64,
    moment_of_inertia: f64,
    area: f64,
    bounding_radius: f64,
    is_round: bool,
    /// Corners of the rectangle that holds all atoms (length).
    rectangle: [DVec2; 2],
    /// All atoms, if they are between two and [`CircleTree::CROSSOVER`].
    rows: Vec<AtomRow>,
    tree: Option<CircleTree>,
    /// Sides of the convex hull of a body with edges.
    sides: Vec<HullSide>,
    /// Closed lines of edges around a solid interior, each as the indices of its atoms.
    rings: Vec<Vec<u32>>,
}

/// Molecules are equal if their atoms, their edges, their interior and the distribution of their
/// mass are; all other fields follow from these.
impl PartialEq for Molecule {
    fn eq(&self, other: &Self) -> bool {
        self.atoms == other.atoms
            && self.edges == other.edges
            && self.ellipses == other.ellipses
            && self.interior == other.interior
            && self.is_uniform == other.is_uniform
            && self.mass == other.mass
    }
}

impl Molecule {
    /// A molecule of the given atoms, whose offsets may be in any frame.
    ///
    /// # Errors
    /// [`GeometryError::NoAtoms`] or [`GeometryError::CoincidentAtoms`].
    pub fn new(atoms: impl IntoIterator<Item = Atom>) -> Result<Self, GeometryError> {
        let mut atoms: SmallVec<[Atom; 1]> = atoms.into_iter().collect();
        refuse_coincident(&atoms)?;
        let mass: f64 = atoms.iter().map(Atom::mass).sum();
        let centre = if atoms.len() == 1 {
            atoms[0].offset()
        } else {
            atoms
                .iter()
                .map(|atom| atom.mass() * atom.offset())
                .sum::<DVec2>()
                / mass
        };
        for atom in &mut atoms {
            *atom = atom.moved_by(-centre);
        }
        Ok(Self::of_centred(atoms))
    }

    /// A molecule of atoms, whose offsets may be in any frame, and of edges without mass between
    /// pairs of them.
    ///
    /// ```
    /// use carom_geometry::{Atom, Interior, Molecule};
    /// use glam::DVec2;
    ///
    /// // A dumbbell with a bar of half its thickness.
    /// let atom = |x| Atom::new(DVec2::new(x, 0.0), 0.5, 1.0);
    /// let bar = [([0, 1], 0.25)];
    /// let dumbbell = Molecule::with_edges([atom(-1.0)?, atom(1.0)?], &bar, Interior::Solid)?;
    /// assert_eq!((dumbbell.mass(), dumbbell.edges().len()), (2.0, 1));
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Self::new`]; [`GeometryError::Edge`] if an edge names an atom that is not there,
    /// one atom twice or two atoms of another edge, or if its radius is not positive or larger than
    /// that of an atom at its ends.
    pub fn with_edges(
        atoms: impl IntoIterator<Item = Atom>,
        edges: &[([u32; 2], f64)],
        interior: Interior,
    ) -> Result<Self, GeometryError> {
        let molecule = Self::new(atoms)?;
        if edges.is_empty() {
            return Ok(molecule);
        }
        Self::of_parts(molecule.atoms, edges, interior, None)
    }

    /// A molecule whose `mass` is spread evenly over the area of its atoms and edges, and of its
    /// interior if that is solid.
    ///
    /// # Errors
    /// As [`Self::with_edges`]; [`GeometryError::NotPositive`] for the mass.
    pub fn uniform(
        atoms: impl IntoIterator<Item = Atom>,
        edges: &[([u32; 2], f64)],
        interior: Interior,
        mass: f64,
    ) -> Result<Self, GeometryError> {
        check_positive("the mass of a molecule", mass)?;
        let mut atoms: SmallVec<[Atom; 1]> = atoms.into_iter().collect();
        refuse_coincident(&atoms)?;
        // Twice: the rounding of the centre is then that of lengths of the size of the molecule.
        for _ in 0..2 {
            let edges = edges_between(&atoms, edges)?;
            let centre = Properties::new(&union_of(&atoms, &edges, interior)).centroid();
            for atom in &mut atoms {
                *atom = atom.moved_by(-centre);
            }
        }
        Self::of_parts(atoms, edges, interior, Some(mass))
    }

    /// A polygon with these corners (length, in any frame), convex or not, of which all points
    /// within `radius` (length) belong to it, with its `mass` spread evenly.
    ///
    /// Its atoms are the corners, in the order given, and edge i leads from corner i to the next.
    ///
    /// ```
    /// use carom_geometry::Molecule;
    /// use glam::DVec2;
    ///
    /// let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(DVec2::from);
    /// let rectangle = Molecule::polygon(&corners, 1e-6, 3.0)?;
    /// assert!((rectangle.moment_of_inertia() - 3.0 * (4.0 + 1.0) / 12.0).abs() < 1e-5);
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// [`GeometryError::Polygon`] for fewer than three corners and for sides that cross or touch
    /// each other; others as [`Self::uniform`].
    pub fn polygon(corners: &[DVec2], radius: f64, mass: f64) -> Result<Self, GeometryError> {
        let corners = interior::simple_polygon(corners, radius)?;
        let share = mass / corners.len() as f64;
        let atoms: Result<Vec<Atom>, GeometryError> = corners
            .iter()
            .map(|&corner| Atom::new(corner, radius, share))
            .collect();
        let edges = interior::closed_line(corners.len() as u32, radius);
        Self::uniform(atoms?, &edges, Interior::Solid, mass)
    }

    /// A capsule (discorectangle, stadium): all points within `radius` of a line of this length,
    /// with its `mass` spread evenly.
    ///
    /// # Errors
    /// As [`Self::uniform`].
    #[doc(alias = "discorectangle")]
    #[doc(alias = "spherocylinder")]
    #[doc(alias = "needle")]
    pub fn capsule(length: f64, radius: f64, mass: f64) -> Result<Self, GeometryError> {
        let end = |x: f64| Atom::new(DVec2::new(x, 0.0), radius, 0.5 * mass);
        let ends = [end(-0.5 * length)?, end(0.5 * length)?];
        Self::uniform(ends, &[([0, 1], radius)], Interior::Solid, mass)
    }

    /// An ellipse with these semi-axes (length, the longer one first, along x), with its `mass`
    /// spread evenly. Equal semi-axes give a disc.
    ///
    /// ```
    /// use carom_geometry::Molecule;
    ///
    /// let ellipse = Molecule::ellipse([2.0, 1.0], 3.0)?;
    /// assert_eq!(ellipse.moment_of_inertia(), 3.0 * (4.0 + 1.0) / 4.0);
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::of_ellipses`].
    pub fn ellipse(axes: [f64; 2], mass: f64) -> Result<Self, GeometryError> {
        Self::of_ellipses([(DVec2::ZERO, Ellipse::new(axes, DVec2::X)?, mass)])
    }

    /// A molecule of uniform ellipses: the place of each (length, in any frame), its shape and its
    /// mass. They may touch, but not overlap by more than rounding.
    ///
    /// Each ellipse is an atom, whose radius is the longer semi-axis.
    ///
    /// # Errors
    /// Those of [`Self::new`]; [`GeometryError::EllipsesOverlap`].
    pub fn of_ellipses(
        parts: impl IntoIterator<Item = (DVec2, Ellipse, f64)>,
    ) -> Result<Self, GeometryError> {
        let (mut atoms, mut ellipses) = (Vec::new(), Vec::new());
        for (place, ellipse, mass) in parts {
            atoms.push(Atom::new(place, ellipse.axes()[0], mass)?);
            ellipses.push(ellipse);
        }
        let atoms = Self::new(atoms)?.atoms;
        Self::stretched(atoms, ellipses)
    }

    /// A molecule of centred atoms of these shapes.
    fn stretched(
        atoms: SmallVec<[Atom; 1]>,
        ellipses: Vec<Ellipse>,
    ) -> Result<Self, GeometryError> {
        if ellipses.len() != atoms.len() {
            return Err(GeometryError::NoAtoms);
        }
        if ellipses
            .iter()
            .all(|ellipse| ellipse.axes()[0] == ellipse.axes()[1])
        {
            return Ok(Self::of_centred(atoms));
        }
        refuse_overlapping(&atoms, &ellipses)?;
        let area = ellipses.iter().map(Ellipse::area).sum();
        let parts = || atoms.iter().zip(&ellipses);
        let moment_of_inertia = parts()
            .map(|(atom, ellipse)| {
                atom.mass() * (ellipse.gyration() + atom.offset().length_squared())
            })
            .sum();
        let extent = |axis: DVec2| {
            parts()
                .map(|(atom, ellipse)| axis.dot(atom.offset()) + ellipse.at(axis).distance)
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let high = DVec2::new(extent(DVec2::X), extent(DVec2::Y));
        let low = -DVec2::new(extent(DVec2::NEG_X), extent(DVec2::NEG_Y));
        Ok(Self {
            moment_of_inertia,
            is_round: false,
            rectangle: [low, high],
            ellipses,
            ..Self::of_area(atoms, area)
        })
    }

    /// A molecule of atoms whose offsets are already relative to their centre of mass.
    fn of_centred(atoms: SmallVec<[Atom; 1]>) -> Self {
        let area = area_of_atoms(&atoms);
        Self::of_area(atoms, area)
    }

    /// A molecule of centred atoms whose union has this area (length²).
    fn of_area(atoms: SmallVec<[Atom; 1]>, area: f64) -> Self {
        let bounding_radius = atoms.iter().map(reach).fold(0.0, f64::max);
        let is_few = (2..=CircleTree::CROSSOVER).contains(&atoms.len());
        Self {
            mass: atoms.iter().map(Atom::mass).sum(),
            moment_of_inertia: atoms.iter().map(inertia_about_origin).sum(),
            area,
            bounding_radius,
            is_round: is_round(&atoms, bounding_radius),
            rectangle: rectangle(&atoms),
            rows: if is_few {
                AtomRow::rows(&atoms).collect()
            } else {
                Vec::new()
            },
            tree: (atoms.len() > CircleTree::CROSSOVER)
                .then(|| CircleTree::new(&atoms, bounding_radius)),
            atoms,
            edges: Vec::new(),
            ellipses: Vec::new(),
            interior: Interior::default(),
            is_uniform: false,
            sides: Vec::new(),
            rings: Vec::new(),
        }
    }

    /// These atoms with edges between them, and all that follows from the edges but area and mass.
    fn joined_by(self, edges: Vec<Edge>, interior: Interior) -> Self {
        Self {
            sides: hull_sides(&self.atoms, &edges),
            rings: interior::solid_rings(&self.atoms, &edges, interior),
            edges,
            interior,
            // These would leave out the edges.
            rows: Vec::new(),
            ..self
        }
    }

    /// A molecule of centred atoms and edges; `mass` if it is spread evenly.
    fn of_parts(
        atoms: SmallVec<[Atom; 1]>,
        edges: &[([u32; 2], f64)],
        interior: Interior,
        mass: Option<f64>,
    ) -> Result<Self, GeometryError> {
        let edges = edges_between(&atoms, edges)?;
        interior::check_lines(&atoms, &edges, interior)?;
        let properties = Properties::new(&union_of(&atoms, &edges, interior));
        check_positive("the area of a molecule", properties.area)?;
        check_positive("the second moment of the area", properties.second_moment)?;
        let mut molecule = Self::of_area(atoms, properties.area).joined_by(edges, interior);
        if let Some(mass) = mass {
            molecule.is_uniform = true;
            molecule.mass = mass;
            molecule.moment_of_inertia = mass * (properties.second_moment / properties.area);
        }
        Ok(molecule)
    }

    /// A wall: a straight edge with the given span from end to end (length) about the origin, and
    /// its two end points.
    ///
    /// All points within `radius` (length, may be 0) of the edge belong to the wall. Its mass is
    /// infinite. The end points are atoms 0 and 1, of this radius, at minus and plus half the span.
    ///
    /// ```
    /// use carom_geometry::{Molecule, gap_between};
    /// use glam::DVec2;
    ///
    /// let wall = Molecule::wall(DVec2::new(2.0, 0.0), 0.0)?;
    /// let disc = Molecule::disc(0.5, 1.0)?;
    /// let gap = |x: f64, y: f64| gap_between(&wall, DVec2::X, &disc, DVec2::X, DVec2::new(x, y));
    /// assert_eq!((gap(0.3, 2.0), gap(0.3, -2.0), gap(4.0, 4.0)), (1.5, 1.5, 4.5));
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// [`GeometryError`] if the span is zero or not finite, or the radius is neither zero nor
    /// positive.
    #[doc(alias = "segment")]
    pub fn wall(span: DVec2, radius: f64) -> Result<Self, GeometryError> {
        let ends = [-0.5 * span, 0.5 * span];
        Ok(Self::of_wall(Edge::of_wall(span, radius)?).ended(ends))
    }

    /// A curved wall: an arc of a circle about the origin, and its two end points, if it is not the
    /// whole circle.
    ///
    /// All points within `radius` (length, may be 0, below the radius of the circle) of the arc
    /// belong to the wall. Its mass is infinite. The end points are atoms 0 and 1, of this radius.
    ///
    /// # Errors
    /// [`GeometryError`] if the radius is out of range.
    pub fn arc(bend: Bend, radius: f64) -> Result<Self, GeometryError> {
        let wall = Self::of_wall(Edge::of_bend(bend, radius)?);
        Ok(if bend.is_circle() {
            wall
        } else {
            let [first, second] = bend.ends();
            // The edge runs clockwise.
            wall.ended([second, first])
        })
    }

    /// This wall with its end points (length), the second in the direction of its edge.
    fn ended(mut self, ends: [DVec2; 2]) -> Self {
        let radius = self.edges[0].radius();
        self.atoms = ends
            .into_iter()
            .map(|end| Atom::end_of_wall(end, radius))
            .collect();
        self.edges = self.edges.into_iter().map(Edge::with_ends).collect();
        self.area += std::f64::consts::PI * radius * radius;
        self
    }

    /// A wall between two end points whose middle is at `middle` in its own frame (length): the
    /// origin is the pivot about which it turns.
    ///
    /// ```
    /// use carom_geometry::Molecule;
    /// use glam::DVec2;
    ///
    /// // A flap with its hinge at one end.
    /// let flap = Molecule::wall_about(DVec2::new(2.0, 0.0), DVec2::new(1.0, 0.0), 0.5)?;
    /// assert_eq!(flap.atoms()[0].offset(), DVec2::ZERO);
    /// assert!((flap.bounding_radius() - 2.5).abs() < 1e-14);
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::wall`], and if `middle` is not finite.
    pub fn wall_about(span: DVec2, middle: DVec2, radius: f64) -> Result<Self, GeometryError> {
        check_length("the x distance of a wall from its pivot", middle.x)?;
        check_length("the y distance of a wall from its pivot", middle.y)?;
        let mut wall = Self::wall(span, radius)?;
        if middle == DVec2::ZERO {
            return Ok(wall);
        }
        wall.atoms = [-0.5, 0.5]
            .map(|half| Atom::end_of_wall(middle + half * span, radius))
            .into_iter()
            .collect();
        let edges = wall.edges.into_iter();
        wall.edges = edges.map(|edge| edge.with_middle(middle)).collect();
        let reach = wall.edges.iter().map(Edge::reach).fold(0.0, f64::max);
        wall.bounding_radius = (reach + radius) * (1.0 + 4.0 * f64::EPSILON);
        Ok(wall)
    }

    /// A wall without end points, for a wall that meets its own periodic image.
    ///
    /// # Errors
    /// As [`Self::wall`].
    pub fn wall_without_ends(span: DVec2, radius: f64) -> Result<Self, GeometryError> {
        Ok(Self::of_wall(Edge::of_wall(span, radius)?))
    }

    /// A wall of this edge, without end points.
    fn of_wall(edge: Edge) -> Self {
        Self {
            atoms: SmallVec::new(),
            mass: f64::INFINITY,
            moment_of_inertia: f64::INFINITY,
            area: 4.0 * edge.half_length() * edge.radius(),
            bounding_radius: (edge.reach() + edge.radius()) * (1.0 + 4.0 * f64::EPSILON),
            is_round: false,
            rectangle: rectangle(&[]),
            rows: Vec::new(),
            tree: None,
            edges: vec![edge],
            ellipses: Vec::new(),
            interior: Interior::default(),
            is_uniform: false,
            sides: Vec::new(),
            rings: Vec::new(),
        }
    }

    /// One disc of `radius` (length) and `mass`.
    ///
    /// # Errors
    /// [`GeometryError`] if either is not positive.
    pub fn disc(radius: f64, mass: f64) -> Result<Self, GeometryError> {
        Self::new([Atom::new(DVec2::ZERO, radius, mass)?])
    }

    /// A shape by name, of touching atoms of `atom_radius` (length) and `atom_mass` each.
    ///
    /// # Errors
    /// [`GeometryError`] if the radius, the mass or the number of atoms is out of range.
    pub fn named(shape: Shape, atom_radius: f64, atom_mass: f64) -> Result<Self, GeometryError> {
        Self::new(shape.atoms(atom_radius, atom_mass)?)
    }

    /// This molecule with all lengths multiplied by `scale`; masses remain.
    ///
    /// At scale 1 it is equal to the bit. The centre of mass remains at the origin to rounding.
    ///
    /// # Errors
    /// [`GeometryError`] if a length is then out of range.
    pub fn scaled(&self, scale: f64) -> Result<Self, GeometryError> {
        if let Some(wall) = self.wall_edge() {
            let bend = wall.bend().map(|bend| bend.scaled(scale)).transpose()?;
            return if let Some(bend) = bend {
                Self::arc(bend, scale * wall.radius())
            } else if self.atoms.is_empty() {
                Self::wall_without_ends(scale * wall.span(), scale * wall.radius())
            } else {
                let middle = scale * wall.middle();
                Self::wall_about(scale * wall.span(), middle, scale * wall.radius())
            };
        }
        let atom =
            |atom: &Atom| Atom::new(scale * atom.offset(), scale * atom.radius(), atom.mass());
        let atoms: SmallVec<[Atom; 1]> = self.atoms.iter().map(atom).collect::<Result<_, _>>()?;
        if !self.ellipses.is_empty() {
            let scaled = self.ellipses.iter().map(|ellipse| ellipse.scaled(scale));
            return Self::stretched(atoms, scaled.collect::<Result<_, _>>()?);
        }
        let edges: Vec<_> = ends_and_radii(&self.edges)
            .map(|(ends, radius)| (ends, scale * radius))
            .collect();
        let edges = edges_between(&atoms, &edges)?;
        if edges.is_empty() && !self.is_uniform {
            return Ok(Self::of_area(atoms, scale * scale * self.area));
        }
        let area = scale * scale * self.area;
        let mut scaled = Self::of_area(atoms, area).joined_by(edges, self.interior);
        if self.is_uniform {
            scaled.is_uniform = true;
            scaled.mass = self.mass;
            scaled.moment_of_inertia = scale * scale * self.moment_of_inertia;
        }
        Ok(scaled)
    }

    /// The atoms relative to the centre of mass, in the order given; for a wall, its end points.
    pub fn atoms(&self) -> &[Atom] {
        &self.atoms
    }

    /// The edges, in the order given; empty for a union of discs.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The shapes of the atoms, one for each, if any is an ellipse; empty for a union of discs.
    pub fn ellipses(&self) -> &[Ellipse] {
        &self.ellipses
    }

    /// The shape of an atom: an ellipse, of equal axes if it is a disc.
    ///
    /// # Panics
    /// If the molecule has no such atom.
    pub fn shape_of(&self, atom: usize) -> Ellipse {
        self.outline().shape_of(atom)
    }

    /// Whether all parts are discs: there are neither edges nor ellipses.
    pub fn is_of_discs(&self) -> bool {
        self.edges.is_empty() && self.ellipses.is_empty()
    }

    /// Whether what closed lines of edges enclose belongs to the molecule.
    pub fn interior(&self) -> Interior {
        self.interior
    }

    /// Whether the mass is spread evenly over the area, see [`Self::uniform`]; else it is that of
    /// the atoms.
    pub fn is_uniform(&self) -> bool {
        self.is_uniform
    }

    /// Closed lines of edges around a solid interior, each as the indices of its atoms.
    pub(crate) fn solid_rings(&self) -> &[Vec<u32>] {
        &self.rings
    }

    /// The edge of a wall; `None` unless this is one.
    pub fn wall_edge(&self) -> Option<&Edge> {
        self.edges.first().filter(|_| self.is_wall())
    }

    /// Whether this is a wall, straight or curved, of infinite mass.
    pub fn is_wall(&self) -> bool {
        self.mass == f64::INFINITY
    }

    /// Total mass; infinite for a wall.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Moment of inertia about the centre of mass (mass × length²): each atom a uniform disc, Σ m
    /// (r²/2 + d²), or the whole body of uniform density ([`Self::uniform`]).
    pub fn moment_of_inertia(&self) -> f64 {
        self.moment_of_inertia
    }

    /// Radius of the smallest circle about the centre of mass that contains all atoms (length).
    ///
    /// parry's bounding sphere of a compound is neither centred there nor tight.
    #[doc(alias = "bounding circle")]
    pub fn bounding_radius(&self) -> f64 {
        self.bounding_radius
    }

    /// The covered area (length²): that of the union of atoms and edges, and of the interior if
    /// that is solid. Overlaps count once; enclosed holes do not count.
    ///
    /// ```
    /// use carom_geometry::{Atom, Molecule};
    /// use glam::DVec2;
    /// use std::f64::consts::PI;
    ///
    /// // Two unit discs at distance 1 share a lens of 2π/3 − √3/2.
    /// let atom = |x| Atom::new(DVec2::new(x, 0.0), 1.0, 1.0);
    /// let fused = Molecule::new([atom(0.0)?, atom(1.0)?])?;
    /// assert!((fused.area() - (2.0 * PI - (2.0 * PI / 3.0 - 0.75f64.sqrt()))).abs() < 1e-14);
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Length of the whole boundary; around enclosed holes, too. For a wall, that of both sides and
    /// of the ends.
    ///
    /// The second virial coefficient of a convex molecule with others of its kind is A + P²/4π,
    /// with its area A and its perimeter P (length²; Isihara, J. Chem. Phys. 18 (1950) 1446, in
    /// the plane).
    ///
    /// ```
    /// use carom_geometry::Molecule;
    ///
    /// let capsule = Molecule::capsule(2.0, 0.5, 1.0)?;
    /// assert!((capsule.perimeter() - (4.0 + std::f64::consts::PI)).abs() < 1e-14);
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    pub fn perimeter(&self) -> f64 {
        if let Some(wall) = self.wall_edge() {
            let of_ends = if wall.ends().is_some() {
                std::f64::consts::TAU * wall.radius()
            } else {
                0.0
            };
            return 4.0 * wall.half_length() + of_ends;
        }
        if !self.ellipses.is_empty() {
            return self.ellipses.iter().map(Ellipse::perimeter).sum();
        }
        Properties::new(&self.union()).perimeter
    }

    /// The union of atoms, edges and solid interiors.
    pub(crate) fn union(&self) -> Union {
        union_of(&self.atoms, &self.edges, self.interior)
    }

    /// Whether this is a single atom. Other molecules may be round, too: see
    /// [`is_round`](Self::is_round).
    pub fn is_disc(&self) -> bool {
        self.atoms.len() == 1 && self.ellipses.is_empty()
    }

    /// Whether the union of the atoms is a disc about the centre of mass, to 10⁻¹² of its radius.
    ///
    /// All contact normals then pass through the centre of mass, so no smooth contact changes the
    /// spin: it is not a degree of freedom of the thermal motion. Round are single atoms, and those
    /// that hide further atoms, which change the moment of inertia only.
    ///
    /// ```
    /// use carom_geometry::{Atom, Molecule};
    /// use glam::DVec2;
    ///
    /// let atom = |x, radius| Atom::new(DVec2::new(x, 0.0), radius, 1.0);
    /// let heavy_rim = Molecule::new([atom(0.0, 1.0)?, atom(-0.8, 0.1)?, atom(0.8, 0.1)?])?;
    /// assert!(heavy_rim.is_round() && !heavy_rim.is_disc());
    /// // One hidden atom moves the centre of mass away from the centre of the disc.
    /// assert!(!Molecule::new([atom(0.0, 1.0)?, atom(0.8, 0.1)?])?.is_round());
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    #[doc(alias = "rotational degree of freedom")]
    pub fn is_round(&self) -> bool {
        self.is_round
    }

    /// The outline of this molecule, as detection needs it.
    #[inline]
    pub fn outline(&self) -> Outline<'_> {
        Outline {
            atoms: &self.atoms,
            bounding_radius: self.bounding_radius,
            rectangle: (self.atoms.len() > 1 && !self.is_wall() || !self.ellipses.is_empty())
                .then_some(&self.rectangle),
            rows: &self.rows,
            tree: self.tree.as_ref(),
            edges: &self.edges,
            ellipses: &self.ellipses,
            is_wall: self.is_wall(),
            sides: &self.sides,
        }
    }
}

/// The serialized form of a molecule, from which all fields follow to the bit.
#[derive(Serialize, Deserialize)]
enum Written {
    /// Atoms relative to their centre of mass. They are read without centring, which would move
    /// them by a rounding.
    Atoms(SmallVec<[Atom; 1]>),
    /// Atoms relative to their centre of mass, and edges between them.
    Edged {
        atoms: SmallVec<[Atom; 1]>,
        edges: Vec<([u32; 2], f64)>,
        interior: Interior,
        /// The mass that is spread evenly.
        mass: Option<f64>,
    },
    Wall {
        span: DVec2,
        middle: DVec2,
        radius: f64,
        has_ends: bool,
    },
    Arc {
        bend: Bend,
        radius: f64,
    },
    /// Atoms relative to their centre of mass, and their shapes.
    Ellipses {
        atoms: SmallVec<[Atom; 1]>,
        ellipses: Vec<Ellipse>,
    },
}

impl From<Molecule> for Written {
    fn from(molecule: Molecule) -> Self {
        if let Some(wall) = molecule.wall_edge() {
            if let Some(&bend) = wall.bend() {
                let radius = wall.radius();
                return Self::Arc { bend, radius };
            }
            return Self::Wall {
                span: wall.span(),
                middle: wall.middle(),
                radius: wall.radius(),
                has_ends: !molecule.atoms.is_empty(),
            };
        }
        if !molecule.ellipses.is_empty() {
            return Self::Ellipses {
                atoms: molecule.atoms,
                ellipses: molecule.ellipses,
            };
        }
        if molecule.edges.is_empty() && !molecule.is_uniform {
            return Self::Atoms(molecule.atoms);
        }
        Self::Edged {
            edges: ends_and_radii(&molecule.edges).collect(),
            interior: molecule.interior,
            mass: molecule.is_uniform.then_some(molecule.mass),
            atoms: molecule.atoms,
        }
    }
}

impl TryFrom<Written> for Molecule {
    type Error = GeometryError;

    fn try_from(written: Written) -> Result<Self, GeometryError> {
        match written {
            Written::Atoms(atoms) => {
                refuse_coincident(&atoms)?;
                Ok(Self::of_centred(atoms))
            }
            Written::Ellipses { atoms, ellipses } => {
                refuse_coincident(&atoms)?;
                Self::stretched(atoms, ellipses)
            }
            Written::Edged {
                atoms,
                edges,
                interior,
                mass,
            } => {
                refuse_coincident(&atoms)?;
                mass.map_or(Ok(1.0), |mass| {
                    check_positive("the mass of a molecule", mass)
                })?;
                Self::of_parts(atoms, &edges, interior, mass)
            }
            Written::Arc { bend, radius } => Self::arc(bend, radius),
            Written::Wall {
                span,
                middle,
                radius,
                has_ends: true,
            } => Self::wall_about(span, middle, radius),
            Written::Wall {
                span,
                radius,
                has_ends: false,
                ..
            } => Self::wall_without_ends(span, radius),
        }
    }
}

fn refuse_coincident(atoms: &[Atom]) -> Result<(), GeometryError> {
    if atoms.is_empty() {
        return Err(GeometryError::NoAtoms);
    }
    for second in 0..atoms.len() {
        for first in 0..second {
            if atoms[first].offset() == atoms[second].offset() {
                return Err(GeometryError::CoincidentAtoms { first, second });
            }
        }
    }
    Ok(())
}

/// Refuses ellipses that overlap by more than rounding: the area of their union is not known.
fn refuse_overlapping(atoms: &[Atom], ellipses: &[Ellipse]) -> Result<(), GeometryError> {
    for second in 0..atoms.len() {
        for first in 0..second {
            let parts = FacingParts {
                a: &ellipses[first],
                b: &ellipses[second],
                rotations: [DVec2::X; 2],
                d: atoms[second].offset() - atoms[first].offset(),
            };
            let size = atoms[first].radius() + atoms[second].radius();
            let found = parts.farthest(f64::EPSILON * size);
            if found.gap < -MAX_OVERLAP * size {
                let depth = -found.gap;
                return Err(GeometryError::EllipsesOverlap {
                    first,
                    second,
                    depth,
                });
            }
        }
    }
    Ok(())
}

/// The largest overlap of two ellipses of one molecule, as a share of their lengths: that of parts
/// that are meant to touch, with places of six digits.
const MAX_OVERLAP: f64 = 1e-6;

/// The edges between pairs of these atoms.
fn edges_between(atoms: &[Atom], edges: &[([u32; 2], f64)]) -> Result<Vec<Edge>, GeometryError> {
    let mut made: Vec<Edge> = Vec::with_capacity(edges.len());
    for (index, &([first, second], radius)) in edges.iter().enumerate() {
        let refused = |problem| GeometryError::Edge {
            index,
            ends: [first, second],
            problem,
        };
        let [Some(from), Some(to)] = [first, second].map(|end| atoms.get(end as usize)) else {
            return Err(refused("names an atom that is not there"));
        };
        let ends = [(first, from.offset()), (second, to.offset())];
        if first == second {
            return Err(refused("has one atom at both ends"));
        }
        if radius > from.radius().min(to.radius()) {
            return Err(refused("is thicker than an atom at its ends"));
        }
        let is_same = |edge: &Edge| {
            edge.ends() == Some([first, second]) || edge.ends() == Some([second, first])
        };
        if made.iter().any(is_same) {
            return Err(refused("lies between the same atoms as another"));
        }
        let edge = Edge::between(ends, radius)?;
        if radius < MIN_ROUNDING * edge.half_length() {
            return Err(refused(
                "is too thin for its length: rounding hides its two sides",
            ));
        }
        made.push(edge);
    }
    Ok(made)
}

fn union_of(atoms: &[Atom], edges: &[Edge], interior: Interior) -> Union {
    let circle = |atom: &Atom| (atom.offset(), atom.radius());
    let bar = |(ends, radius)| Bar { ends, radius };
    Union {
        circles: atoms.iter().map(circle).collect(),
        bars: ends_and_radii(edges).map(bar).collect(),
        rings: interior::solid_rings(atoms, edges, interior),
    }
}

/// The atoms at the ends of each edge, and its radius.
fn ends_and_radii(edges: &[Edge]) -> impl Iterator<Item = ([u32; 2], f64)> {
    edges
        .iter()
        .filter_map(|edge| Some((edge.ends()?, edge.radius())))
}

/// Sides of the polygon by which an arc is given to parry.
const SIDES_OF_ARC: u32 = 256;

/// The molecule as a parry shape; an arc without its thickness.
impl From<&Molecule> for Compound {
    fn from(molecule: &Molecule) -> Self {
        let parts = molecule
            .atoms()
            .iter()
            // The end points of a wall belong to its edge.
            .filter(|_| !molecule.is_wall())
            .map(|atom| {
                (
                    Pose::from_translation(atom.offset()),
                    SharedShape::new(*atom.ball()),
                )
            });
        let edges = molecule.edges().iter().map(|edge| {
            if let Some(bend) = edge.bend() {
                let line = SharedShape::polyline(bend.points(SIDES_OF_ARC).collect(), None);
                return (Pose::identity(), line);
            }
            let [from, to] = edge.segment();
            let line = if edge.radius() > 0.0 {
                SharedShape::capsule(from, to, edge.radius())
            } else {
                SharedShape::segment(from, to)
            };
            (Pose::identity(), line)
        });
        Compound::new(parts.chain(edges).collect())
    }
}

/// Corners of the rectangle that contains all atoms.
fn rectangle(atoms: &[Atom]) -> [DVec2; 2] {
    let radius = |atom: &Atom| DVec2::splat(atom.radius());
    let low = atoms.iter().fold(DVec2::INFINITY, |low, atom| {
        low.min(atom.offset() - radius(atom))
    });
    let high = atoms.iter().fold(DVec2::NEG_INFINITY, |high, atom| {
        high.max(atom.offset() + radius(atom))
    });
    [low, high]
}

/// A molecule is round if its outline deviates from a circle about the centre of mass by at most
/// this share of its radius. Smaller: the rounding of the centre of mass of atoms that are given
/// far from the origin counts as a shape. Larger: molecules count as round whose spin thermalises
/// within a run; at a lever arm of this share, that takes some 10²⁴ contacts.
const ROUND: f64 = 1e-12;

/// Whether one atom about the centre of mass covers all others.
fn is_round(atoms: &[Atom], bounding_radius: f64) -> bool {
    let deviation = ROUND * bounding_radius;
    atoms.iter().any(|atom| {
        atom.offset().length() <= deviation && atom.radius() >= bounding_radius - deviation
    })
}

/// Area of the union of the atoms.
fn area_of_atoms(atoms: &[Atom]) -> f64 {
    let circles: Vec<_> = atoms
        .iter()
        .map(|atom| (atom.offset(), atom.radius()))
        .collect();
    covered_area(&circles)
}

/// Moment of inertia of one uniform disc about the origin (parallel-axis theorem).
fn inertia_about_origin(atom: &Atom) -> f64 {
    atom.mass() * (0.5 * atom.radius() * atom.radius() + atom.offset().length_squared())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use parry2d_f64::mass_properties::MassProperties;
    use proptest::prelude::*;

    fn molecules() -> impl Strategy<Value = Vec<Atom>> {
        prop::collection::vec((-1.0..1.0, -1.0..1.0, 0.01..0.5, 0.1..10.0), 1..8).prop_map(|list| {
            let atom = |(x, y, r, m)| Atom::new(DVec2::new(x, y), r, m).unwrap();
            list.into_iter().map(atom).collect()
        })
    }

    /// Corners of a convex polygon, counter-clockwise, anywhere.
    fn convex_corners() -> impl Strategy<Value = Vec<DVec2>> {
        let angles = prop::collection::vec(0.2..1.0f64, 3..12);
        let numbers = (0.3..2.0f64, 0.3..2.0f64, -3.0..3.0f64, -3.0..3.0f64);
        (angles, numbers).prop_map(|(angles, (a, b, x, y))| {
            let all: f64 = angles.iter().sum();
            let mut angle = 0.0;
            let corner = |step: &f64| {
                angle += TAU * step / all;
                DVec2::new(x, y) + DVec2::from_angle(angle) * DVec2::new(a, b)
            };
            angles.iter().map(corner).collect()
        })
    }

    /// Radius of corners that parry takes for sharp (length).
    const SHARP: f64 = 1e-9;

    /// Corners by which an arc about a corner is replaced.
    const CORNERS_OF_ARC: u32 = 1000;

    /// The outline of all points within `radius` of a convex polygon, or of the line between two
    /// corners.
    fn rounded(corners: &[DVec2], radius: f64) -> Vec<DVec2> {
        let count = corners.len();
        let arc = |index: usize| {
            let corner = corners[index];
            let before = corner - corners[(index + count - 1) % count];
            let after = corners[(index + 1) % count] - corner;
            let turn = before
                .perp_dot(after)
                .atan2(before.dot(after))
                .rem_euclid(TAU);
            let outwards = -before.normalize().perp();
            (0..=CORNERS_OF_ARC).map(move |step| {
                let angle = turn * f64::from(step) / f64::from(CORNERS_OF_ARC);
                corner + radius * DVec2::from_angle(angle).rotate(outwards)
            })
        };
        (0..count).flat_map(arc).collect()
    }

    /// Area, centre and moment of inertia of a uniform molecule are those of parry for a density of
    /// 1, to this share. `first` is where its first atom was given.
    fn agree(
        molecule: &Molecule,
        first: DVec2,
        parry: MassProperties,
        share: f64,
    ) -> Result<(), TestCaseError> {
        let area = molecule.area() / parry.mass() - 1.0;
        prop_assert!(area.abs() < share, "area off by {area:e}");
        let centre = first - molecule.atoms()[0].offset() - parry.local_com;
        let size = molecule.bounding_radius();
        prop_assert!(centre.length() < share * size, "centre off by {centre}");
        let found = molecule.moment_of_inertia() / molecule.mass();
        let inertia = found / (parry.principal_inertia() / parry.mass()) - 1.0;
        prop_assert!(
            inertia.abs() < share,
            "moment of inertia off by {inertia:e}"
        );
        Ok(())
    }

    proptest! {
        #[test]
        fn mass_centre_and_inertia_agree_with_parry(atoms in molecules()) {
            let molecule = Molecule::new(atoms.clone()).unwrap();
            let oracle: MassProperties = atoms
                .iter()
                .map(|atom| {
                    let density = atom.mass() / (std::f64::consts::PI * atom.radius().powi(2));
                    MassProperties::from_ball(density, atom.radius())
                        .transform_by(&Pose::from_translation(atom.offset()))
                })
                .sum();
            prop_assert!((molecule.mass() - oracle.mass()).abs() < 1e-12 * molecule.mass());
            let inertia = oracle.principal_inertia();
            prop_assert!((molecule.moment_of_inertia() - inertia).abs() < 1e-10 * inertia);
            let centre = atoms[0].offset() - molecule.atoms()[0].offset();
            prop_assert!((centre - oracle.local_com).length() < 1e-12);
        }

        #[test]
        fn convex_polygons_agree_with_parry(corners in convex_corners(), radius in 0.01..1.0f64) {
            let of_polygon = |corners: &[DVec2]| MassProperties::from_convex_polygon(1.0, corners);
            let sharp = Molecule::polygon(&corners, SHARP, 3.0).unwrap();
            agree(&sharp, corners[0], of_polygon(&corners), 1e-6)?;
            let round = Molecule::polygon(&corners, radius, 3.0).unwrap();
            agree(&round, corners[0], of_polygon(&rounded(&corners, radius)), 1e-5)?;
        }

        #[test]
        fn concave_polygons_agree_with_parry(
            radii in prop::collection::vec(0.2..1.0f64, 4..16),
            x in -3.0..3.0f64, y in -3.0..3.0f64,
            sides in prop::array::uniform2(0.5..3.0f64), share in 0.05..0.45f64,
        ) {
            let sum = |pieces: &[Vec<DVec2>]| -> MassProperties {
                let of = |piece: &Vec<DVec2>| MassProperties::from_convex_polygon(1.0, piece);
                pieces.iter().map(of).sum()
            };
            // A star, cut into triangles about its middle.
            let (middle, count) = (DVec2::new(x, y), radii.len());
            let step = TAU / count as f64;
            let corner = |index: usize| {
                middle + radii[index % count] * DVec2::from_angle(step * index as f64)
            };
            let corners: Vec<DVec2> = (0..count).map(corner).collect();
            let triangle = |index| vec![middle, corner(index), corner(index + 1)];
            let triangles: Vec<_> = (0..count).map(triangle).collect();
            let star = Molecule::polygon(&corners, SHARP, 3.0).unwrap();
            agree(&star, corners[0], sum(&triangles), 1e-6)?;
            // A U, cut into three rectangles.
            let [w, h] = sides;
            let t = share * w.min(h);
            let at = |list: &[(f64, f64)]| -> Vec<DVec2> {
                list.iter().map(|&place| middle + DVec2::from(place)).collect()
            };
            let corners = at(&[
                (0.0, 0.0), (w, 0.0), (w, h), (w - t, h), (w - t, t), (t, t), (t, h), (0.0, h),
            ]);
            let rectangles = [
                at(&[(0.0, 0.0), (w, 0.0), (w, t), (0.0, t)]),
                at(&[(0.0, t), (t, t), (t, h), (0.0, h)]),
                at(&[(w - t, t), (w, t), (w, h), (w - t, h)]),
            ];
            let u = Molecule::polygon(&corners, SHARP, 3.0).unwrap();
            agree(&u, corners[0], sum(&rectangles), 1e-6)?;
        }

        /// For a capsule in the plane, parry 0.31 takes the centroid of half a ball, 3/8 of its
        /// radius, for that of half a disc, 4/3π of it: its moment of inertia is that of an outline
        /// of many corners here.
        #[test]
        fn capsules_agree_with_parry(
            from in prop::array::uniform2(-2.0..2.0f64), angle in -3.2..3.2f64,
            length in 0.01..4.0f64, radius in 0.01..2.0f64,
        ) {
            let from = DVec2::from(from);
            let ends = [from, from + length * DVec2::from_angle(angle)];
            let atoms = ends.map(|end| Atom::new(end, radius, 1.0).unwrap());
            let edge = [([0, 1], radius)];
            let capsule = Molecule::uniform(atoms, &edge, Interior::Solid, 3.0).unwrap();
            let outline = MassProperties::from_convex_polygon(1.0, &rounded(&ends, radius));
            agree(&capsule, from, outline, 1e-5)?;
            let whole = MassProperties::from_capsule(1.0, ends[0], ends[1], radius);
            prop_assert!((capsule.area() / whole.mass() - 1.0).abs() < 1e-12);
            let centre = from - capsule.atoms()[0].offset();
            prop_assert!((centre - whole.local_com).length() < 1e-12 * (1.0 + length + radius));
        }

        #[test]
        fn bounding_circle_holds_every_atom_and_touches_one(atoms in molecules()) {
            let molecule = Molecule::new(atoms).unwrap();
            let farthest = molecule
                .atoms()
                .iter()
                .map(|atom| atom.offset().length() + atom.radius())
                .fold(0.0, f64::max);
            prop_assert!(molecule.bounding_radius() >= farthest);
            prop_assert!(molecule.bounding_radius() <= farthest * (1.0 + 8.0 * f64::EPSILON));
        }

        #[test]
        fn compound_has_the_same_atoms(atoms in molecules()) {
            let molecule = Molecule::new(atoms).unwrap();
            let compound = Compound::from(&molecule);
            prop_assert_eq!(compound.shapes().len(), molecule.atoms().len());
            for ((pose, ball), atom) in compound.shapes().iter().zip(molecule.atoms()) {
                prop_assert_eq!(pose.translation, atom.offset());
                prop_assert_eq!(ball.as_ball().unwrap().radius, atom.radius());
            }
        }
    }

    proptest! {
        /// Centring atoms twice changes them by a rounding; serialization must not.
        #[test]
        fn serialization_preserves_a_molecule_to_the_bit(atoms in molecules()) {
            let molecule = Molecule::new(atoms).unwrap();
            let again = Molecule::try_from(Written::from(molecule.clone())).unwrap();
            prop_assert_eq!(format!("{:?}", again), format!("{:?}", molecule));
        }

        #[test]
        fn serialization_preserves_a_wall_to_the_bit(x in -1.0..1.0f64, y in 0.1..1.0f64, radius in 0.01..0.1f64, has_ends in any::<bool>()) {
            let span = DVec2::new(x, y);
            let wall = if has_ends { Molecule::wall(span, radius) } else { Molecule::wall_without_ends(span, radius) };
            let wall = wall.unwrap();
            let again = Molecule::try_from(Written::from(wall.clone())).unwrap();
            prop_assert_eq!(format!("{:?}", again), format!("{:?}", wall));
        }
    }

    #[test]
    fn a_molecule_is_round_if_one_atom_about_the_centre_of_mass_covers_the_others() {
        let of = |atoms: &[(f64, f64, f64)]| {
            let atoms = atoms
                .iter()
                .map(|&(x, y, radius)| Atom::new(DVec2::new(x, y), radius, 1.0).unwrap());
            Molecule::new(atoms).unwrap().is_round()
        };
        assert!(of(&[(0.3, 7.0, 0.01)]));
        // Far from the origin the centre of mass is off by roundings of the coordinates.
        for (x, y) in [(0.0, 0.0), (0.3, -0.7), (100.1, 33.3)] {
            assert!(
                of(&[(x, y, 1.0), (x - 0.75, y, 0.25), (x + 0.75, y, 0.125)]),
                "{x} {y}"
            );
            let third = [0.0, TAU / 3.0, 2.0 * TAU / 3.0]
                .map(|angle: f64| (x + 0.8 * angle.cos(), y + 0.8 * angle.sin(), 0.1));
            assert!(of(&[third[0], third[1], (x, y, 1.0), third[2]]), "{x} {y}");
        }
        // One hidden atom off the centre, an atom that sticks out, a dumbbell, a ring around a
        // hole.
        assert!(!of(&[(0.0, 0.0, 1.0), (0.5, 0.0, 0.25)]));
        assert!(!of(&[(0.0, 0.0, 1.0), (1e-9, 0.0, 0.25)]));
        assert!(!of(&[(0.0, 0.0, 1.0), (-0.8, 0.0, 0.25), (0.8, 0.0, 0.1)]));
        assert!(!of(&[(-0.5, 0.0, 0.5), (0.5, 0.0, 0.5)]));
        assert!(
            !Molecule::named(Shape::Ring(12), 0.1, 1.0)
                .unwrap()
                .is_round()
        );
        assert!(!Molecule::wall(DVec2::X, 0.1).unwrap().is_round());
    }

    #[test]
    fn empty_and_coincident_are_refused() {
        assert_eq!(Molecule::new([]).unwrap_err(), GeometryError::NoAtoms);
        let atom = Atom::new(DVec2::ONE, 0.1, 1.0).unwrap();
        let refused = Molecule::new([atom, atom]).unwrap_err();
        assert_eq!(
            refused,
            GeometryError::CoincidentAtoms {
                first: 0,
                second: 1
            }
        );
    }

    #[test]
    fn invalid_lengths_are_refused() {
        for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e61, 1e-61] {
            assert!(Molecule::disc(bad, 1.0).is_err(), "radius {bad}");
            assert!(Molecule::disc(1.0, bad).is_err(), "mass {bad}");
        }
        assert!(Atom::new(DVec2::new(f64::NAN, 0.0), 1.0, 1.0).is_err());
    }
}
