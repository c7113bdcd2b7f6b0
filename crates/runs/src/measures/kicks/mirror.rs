//! Mirror symmetry of a molecule: an axis through its centre of mass, and the image of each atom
//! and each straight edge.

use std::f64::consts::{PI, TAU};

use carom::{Molecule, geometry::Atom};
use glam::DVec2;

/// A mirror axis of a molecule.
#[derive(Debug, Clone, PartialEq)]
pub struct Mirror {
    /// Angle of the axis from x′, from 0 to below π (radians).
    pub angle: f64,
    /// Index of the image of each part: of the atoms, and of the edges with numbers after them.
    pub images: Vec<usize>,
}

/// Largest distance of an atom from the image of another one, in bounding radii. Smaller: atoms
/// written with few digits would not be symmetric. Larger: molecules that are almost symmetric
/// would count as such, and a correct run could fail.
const CLOSE: f64 = 1e-9;

/// Largest difference of two angles that are taken as equal (radians).
const SAME_ANGLE: f64 = 1e-9;

impl Mirror {
    /// The axis that moves most parts; of several the one with the smallest angle, and of an
    /// ellipse its longer one. `None` if the molecule has no mirror symmetry, is one disc, or has
    /// an ellipse among other parts.
    pub fn new(molecule: &Molecule) -> Option<Self> {
        let atoms = molecule.atoms();
        if let [ellipse, others @ ..] = molecule.ellipses() {
            let is_alone = others.is_empty() && molecule.edges().is_empty();
            let along = ellipse.along();
            return is_alone.then(|| Self {
                angle: folded(libm::atan2(along.y, along.x)),
                images: vec![0],
            });
        }
        // An axis maps the atom farthest from the centre of mass to an atom as far away.
        let distance = |atom: &Atom| atom.offset().length();
        let first = atoms
            .iter()
            .max_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        if atoms.len() == 1 {
            return None;
        }
        let angle = |atom: &Atom| libm::atan2(atom.offset().y, atom.offset().x);
        let axes = atoms
            .iter()
            .filter(|atom| distance(atom) > 0.0)
            .filter_map(|atom| {
                let axis = folded(0.5 * (angle(first) + angle(atom)));
                Some(Self {
                    angle: axis,
                    images: images(molecule, axis)?,
                })
            });
        let moved = |mirror: &Self| {
            mirror
                .images
                .iter()
                .enumerate()
                .filter(|(i, j)| i != *j)
                .count()
        };
        axes.min_by(|a, b| moved(b).cmp(&moved(a)).then(a.angle.total_cmp(&b.angle)))
    }

    /// Parts on the left of the axis and their images, by index; none if the axis passes through
    /// all of them. An edge across the axis is on neither side.
    pub fn sides(&self) -> [Vec<usize>; 2] {
        let left = |&(i, &j): &(usize, &usize)| i < j;
        self.images
            .iter()
            .enumerate()
            .filter(left)
            .map(|(i, &j)| (i, j))
            .unzip()
            .into()
    }

    /// Groups of sectors of directions θ that differ from their mirror image, each with that image,
    /// once; `None` if images of sectors are not sectors.
    ///
    /// Most groups are one sector. All kicks on a straight side have one direction: where it is on
    /// the border of two sectors, rounding decides which of them counts the kicks, and both are one
    /// group. `sides` are such directions (radians).
    pub fn sectors(&self, sectors: usize, sides: &[f64]) -> Option<Vec<[Vec<usize>; 2]>> {
        let shift = 2.0 * self.angle / TAU * sectors as f64;
        let whole = shift.round();
        let are_sectors = (shift - whole).abs() < SAME_ANGLE * sectors as f64;
        let partner = |sector: &usize| (whole as usize + 2 * sectors - 1 - sector) % sectors;
        let groups = grouped(sectors, sides);
        let pairs = groups.into_iter().filter_map(|group| {
            let image: Vec<usize> = group.iter().map(partner).collect();
            (group.iter().min() < image.iter().min()).then_some([group, image])
        });
        are_sectors.then(|| pairs.collect())
    }
}

/// The angle of an axis, from 0 to below π (radians).
fn folded(angle: f64) -> f64 {
    let axis = angle.rem_euclid(PI);
    if PI - axis < SAME_ANGLE { 0.0 } else { axis }
}

/// All sectors of the turn, those together between which one of these directions is (radians).
fn grouped(sectors: usize, directions: &[f64]) -> Vec<Vec<usize>> {
    let width = TAU / sectors as f64;
    let is_border_of = |sector: usize| {
        directions.iter().any(|direction| {
            let off = (direction - sector as f64 * width + PI).rem_euclid(TAU) - PI;
            off.abs() < SAME_ANGLE
        })
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for sector in 0..sectors {
        match groups.last_mut() {
            Some(last) if is_border_of(sector) => last.push(sector),
            _ => groups.push(vec![sector]),
        }
    }
    if groups.len() > 1
        && is_border_of(0)
        && let Some(last) = groups.pop()
    {
        groups[0].extend(last);
    }
    groups
}

/// The directions of the normals of the straight edges of a molecule, to both sides (radians).
pub fn directions_of_sides(molecule: &Molecule) -> Vec<f64> {
    let edges = molecule.edges().iter().filter(|edge| edge.ends().is_some());
    let normals = edges.map(|edge| edge.along().perp());
    normals
        .flat_map(|normal| [normal, -normal])
        .map(|normal| libm::atan2(normal.y, normal.x))
        .collect()
}

/// Index of the image of each part, if each atom has one of equal radius and mass, and each edge
/// one of equal radius; edges are numbered after the atoms.
fn images(molecule: &Molecule, angle: f64) -> Option<Vec<usize>> {
    let double = DVec2::new(libm::cos(2.0 * angle), libm::sin(2.0 * angle));
    let mirrored = |at: DVec2| {
        DVec2::new(
            double.x * at.x + double.y * at.y,
            double.y * at.x - double.x * at.y,
        )
    };
    let close = CLOSE * molecule.bounding_radius();
    let image = |atom: &Atom| {
        let at = mirrored(atom.offset());
        let is_image = |other: &Atom| {
            other.offset().distance(at) <= close
                && (other.radius() - atom.radius()).abs() <= close
                && (other.mass() - atom.mass()).abs() <= CLOSE * atom.mass()
        };
        molecule.atoms().iter().position(is_image)
    };
    let mut images: Vec<usize> = molecule.atoms().iter().map(image).collect::<Option<_>>()?;
    let edges = edges_of(molecule);
    let image = |&(ends, radius): &([usize; 2], f64)| {
        let mut moved = ends.map(|end| images[end]);
        moved.sort_unstable();
        let is_image =
            |&(other, thick): &([usize; 2], f64)| other == moved && (thick - radius).abs() <= close;
        edges.iter().position(is_image)
    };
    let moved: Vec<usize> = edges.iter().map(image).collect::<Option<_>>()?;
    let atoms = images.len();
    images.extend(moved.into_iter().map(|edge| atoms + edge));
    Some(images)
}

/// The atoms at the ends of each edge, the one of lower index first, and its radius.
fn edges_of(molecule: &Molecule) -> Vec<([usize; 2], f64)> {
    let edges = molecule.edges().iter();
    let ends = edges.filter_map(|edge| Some((edge.ends()?, edge.radius())));
    ends.map(|(ends, radius)| {
        let mut ends = ends.map(|end| end as usize);
        ends.sort_unstable();
        (ends, radius)
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Shape;

    fn named(shape: Shape) -> Molecule {
        Molecule::named(shape, 0.1, 1.0).unwrap()
    }

    fn of_atoms(atoms: &[(f64, f64)]) -> Molecule {
        Molecule::new(
            atoms
                .iter()
                .map(|&(x, y)| Atom::new(DVec2::new(x, y), 0.5, 1.0).unwrap()),
        )
        .unwrap()
    }

    #[test]
    fn the_tee_is_symmetric_about_its_stem() {
        let mirror = Mirror::new(&named(Shape::Tee)).unwrap();
        assert_eq!(mirror.images, [2, 1, 0, 3, 4]);
        assert_eq!(mirror.sides(), [vec![0], vec![2]]);
        // One-degree sectors: 10° to 11° is the mirror image of 169° to 170°, and the sector below
        // 270° of that above.
        let pairs = mirror.sectors(360, &[]).unwrap();
        for (one, other) in [(10, 169), (269, 270), (180, 359)] {
            assert!(pairs.contains(&[vec![one], vec![other]]));
        }
        let mut all: Vec<_> = pairs.into_iter().flatten().flatten().collect();
        all.sort_unstable();
        assert_eq!(all, (0..360).collect::<Vec<_>>());
    }

    #[test]
    fn an_l_of_equal_arms_is_symmetric_about_its_diagonal_and_others_are_not() {
        let equal = of_atoms(&[(0.0, 2.0), (0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]);
        let mirror = Mirror::new(&equal).unwrap();
        assert!((mirror.angle.to_degrees() - 45.0).abs() < 1e-9);
        assert_eq!(mirror.sides(), [vec![0, 1], vec![4, 3]]);
        let pairs = mirror.sectors(360, &[]).unwrap();
        assert!(pairs.contains(&[vec![0], vec![89]]));
        assert_eq!(
            Mirror::new(&of_atoms(&[
                (0.0, 3.0),
                (0.0, 2.0),
                (0.0, 1.0),
                (0.0, 0.0),
                (1.0, 0.0)
            ])),
            None
        );
        assert_eq!(Mirror::new(&named(Shape::Disc)), None);
    }

    #[test]
    fn edges_have_images_and_break_the_symmetry_without() {
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (0.0, 2.0)].map(DVec2::from);
        let rectangle = Molecule::polygon(&corners, 1e-6, 1.0).unwrap();
        let mirror = Mirror::new(&rectangle).unwrap();
        // About x′: the long edges 0 and 2 change places; the short ones cross the axis.
        assert_eq!(mirror.images, [3, 2, 1, 0, 4 + 2, 4 + 1, 4, 4 + 3]);
        assert_eq!(mirror.sides(), [vec![0, 1, 4], vec![3, 2, 6]]);
        let open = |edges: &[([u32; 2], f64)]| {
            let atoms = rectangle.atoms().iter().copied();
            let molecule =
                Molecule::with_edges(atoms, edges, carom::geometry::Interior::Hollow).unwrap();
            Mirror::new(&molecule)
        };
        assert_eq!(
            open(&[([0, 1], 1e-6), ([2, 3], 1e-7)]).unwrap().angle,
            0.5 * PI
        );
        assert_eq!(open(&[([0, 1], 1e-6), ([1, 2], 1e-6)]), None);
    }

    #[test]
    fn rods_and_rings_have_the_axis_that_moves_most_atoms() {
        let degrees = |shape| Mirror::new(&named(shape)).unwrap().angle.to_degrees();
        assert!((degrees(Shape::Rod(8)) - 90.0).abs() < 1e-9);
        // Of a hexagon, between two atoms: all six move.
        assert!((degrees(Shape::Ring(6)) - 30.0).abs() < 1e-9);
        let odd = of_atoms(&[(-1.0, 0.0), (1.0, 0.0), (0.0, 0.3)]);
        assert!((Mirror::new(&odd).unwrap().angle.to_degrees() - 90.0).abs() < 1e-9);
        // An axis at an odd angle maps no sector of one degree to another.
        let turned = |at: (f64, f64)| {
            let at = DVec2::from_angle(0.1).rotate(DVec2::from(at));
            (at.x, at.y)
        };
        let mirror = Mirror::new(&of_atoms(
            &[(-1.0, 0.0), (1.0, 0.0), (0.0, 0.3)].map(turned),
        ))
        .unwrap();
        assert_eq!(mirror.sectors(360, &[]), None);
        assert_eq!(mirror.images, [1, 0, 2]);
    }

    #[test]
    fn sectors_on_both_sides_of_the_normal_of_an_edge_are_one() {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(DVec2::from);
        let square = Molecule::polygon(&corners, 1e-6, 1.0).unwrap();
        let mirror = Mirror::new(&square).unwrap();
        let sides = directions_of_sides(&square);
        let pairs = mirror.sectors(72, &sides).unwrap();
        // In sectors of 5° the normals are the borders of 0, 18, 36 and 54.
        let group_of = |sector: usize| {
            let all = pairs.iter().flatten();
            all.clone().find(|group| group.contains(&sector)).cloned()
        };
        for [below, above] in [[71, 0], [17, 18], [35, 36], [53, 54]] {
            let found = group_of(above);
            assert_eq!(found, group_of(below), "{above}");
            assert!(found.is_none_or(|group| group.len() == 2));
        }
        assert_eq!(group_of(5).unwrap(), [5]);
        // A peak in either of the two sectors has its image in the image of both.
        for pair in &pairs {
            let [one, other] = pair.each_ref().map(Vec::len);
            assert_eq!(one, other);
        }
    }

    #[test]
    fn an_ellipse_is_symmetric_about_its_longer_axis() {
        let mirror = Mirror::new(&Molecule::ellipse([0.2, 0.1], 1.0).unwrap()).unwrap();
        assert_eq!((mirror.angle, mirror.sides()), (0.0, [vec![], vec![]]));
        assert!(
            mirror
                .sectors(72, &[])
                .unwrap()
                .contains(&[vec![3], vec![68]])
        );
    }
}
