//! Voronoi cells: the area around each body that is nearer to it than to any other, and the number
//! of bodies whose cells share an edge with it.
//!
//! Places are centres of mass; areas are relative to the mean area a₀ of the cells of the same
//! sample. For independent, uniform positions the area a has ⟨(a/a₀)²⟩ = 1.2802 (E. N. Gilbert,
//! Ann. Math. Stat. 33 (1962) 958), so that the variance of a/a₀ is 0.2802; in a lattice it is 0.
//! The free share of a cell with a disc of radius r is 1 − πr²/a: in the densest lattice of discs 1
//! − π/√12 = 0.0931.
//!
//! Cells are those of the periodic system, also where a body borders on its own images. Bodies
//! whose cell is bounded by a wall, and a body at the place of another, do not count.

use std::f64::consts::PI;

use carom_engine::{BodyView, Observer, View};
use carom_geometry::{GeometryError, check_positive};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{AdaptiveHistogram, Group, delaunay::cell_area, hexatic_order::bonds_between_walls};

/// The numbers of neighbours that are counted one by one: from 3 to 9; the first and the last hold
/// those beyond.
const MIN_NEIGHBOURS: usize = 3;
const COUNTED: usize = 7;

/// Voronoi cells of a group at each sample; fixed discs and molecules count, walls do not.
///
/// Samples without cells are omitted, and those of a few bodies in an extremely narrow box (more
/// than a million images). A sample costs about a microsecond a body.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, VoronoiCells};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 400")?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(3.0)?;
/// let mut cells = VoronoiCells::adaptive(Group::All, 50);
/// cells.sample(&simulation.view());
/// let point = cells.series()[0];
/// assert_eq!(point.cells, 400);
/// assert!((400.0 * point.mean_area - 1.0).abs() < 1e-12);
/// // A gas: nearly independent positions.
/// assert!((0.1..0.35).contains(&point.variance));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "free volume")]
#[doc(alias = "Dirichlet tessellation")]
pub struct VoronoiCells {
    group: Group,
    series: Vec<VoronoiPoint>,
    /// a/a₀ of each cell.
    areas: AdaptiveHistogram,
    /// Cells with so many neighbours, from [`MIN_NEIGHBOURS`] on, over all samples.
    counts: [u64; COUNTED],
    /// Σ (a/a₀ − 1)² over all cells and samples.
    squares: f64,
    /// Σ (1 − πr²/a) and the number of cells, in the samples of equal discs.
    free: [f64; 2],
}

/// The Voronoi cells at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct VoronoiPoint {
    /// Time of the sample.
    pub time: f64,
    /// Cells that count: those that no wall bounds.
    pub cells: u64,
    /// Mean area of a cell, a₀ (length²).
    pub mean_area: f64,
    /// Variance of the area by the square of its mean, ⟨(a/a₀ − 1)²⟩.
    pub variance: f64,
    /// Area of the smallest cell by the mean.
    pub smallest: f64,
    /// Area of the largest cell by the mean.
    pub largest: f64,
    /// Mean of 1 − πr²/a; `None` if the bodies are not discs of one radius.
    pub free: Option<f64>,
}

impl VoronoiCells {
    /// Cells with the distribution of their relative areas in `bins` equal bins from 0 to `largest`
    /// (mean areas); `bins` = 0 is taken as 1.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `largest` is not positive and finite.
    pub fn new(group: Group, largest: f64, bins: usize) -> Result<Self, GeometryError> {
        let largest = check_positive("the largest area of a histogram", largest)?;
        Ok(Self {
            areas: AdaptiveHistogram::within(0.0, largest, bins),
            ..Self::adaptive(group, bins)
        })
    }

    /// Cells with the distribution of their relative areas in at least `bins` bins whose range
    /// follows the areas, so that none is lost.
    pub fn adaptive(group: Group, bins: usize) -> Self {
        Self {
            group,
            series: Vec::new(),
            areas: AdaptiveHistogram::of_magnitudes(bins),
            counts: [0; COUNTED],
            squares: 0.0,
            free: [0.0; 2],
        }
    }

    /// The samples so far.
    pub fn series(&self) -> &[VoronoiPoint] {
        &self.series
    }

    /// Distribution of the areas over all samples so far (mean areas).
    pub fn areas(&self) -> &AdaptiveHistogram {
        &self.areas
    }

    /// The numbers of neighbours of [`sums`](Self::sums).
    pub fn neighbours() -> impl Iterator<Item = usize> {
        MIN_NEIGHBOURS..MIN_NEIGHBOURS + COUNTED
    }

    /// [Σx, Σw] over all samples so far, w = 1 for each cell: whether it has a number of
    /// neighbours, for each of [`neighbours`](Self::neighbours), the first and the last with those
    /// beyond; (a/a₀ − 1)²; 1 − πr²/a in the samples of equal discs.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let cells = self.counts.iter().sum::<u64>() as f64;
        let shares = self.counts.iter().map(|&count| [count as f64, cells]);
        shares.chain([[self.squares, cells], self.free]).collect()
    }
}

impl Observer for VoronoiCells {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let members: Vec<_> = self.group.molecules(view).collect();
        let places: Vec<DVec2> = members.iter().map(|body| body.motion.position).collect();
        let Some((bonds, is_at_wall)) = bonds_between_walls(&places, view) else {
            return;
        };
        let cells = bonds
            .iter()
            .zip(is_at_wall)
            .filter(|(bonds, is_at_wall)| !is_at_wall && !bonds.is_empty())
            .map(|(bonds, _)| (cell_area(bonds), bonds.len()));
        let cells: Vec<(f64, usize)> = cells.collect();
        if !cells.is_empty() {
            self.count(&cells, common_radius(&members), view.time().to_f64());
        }
    }
}

impl VoronoiCells {
    /// Counts the cells of a sample, at least one, by area and number of neighbours. `radius` is
    /// that of all bodies, if they are equal discs.
    fn count(&mut self, cells: &[(f64, usize)], radius: Option<f64>, time: f64) {
        let number = cells.len() as f64;
        let mean_area = cells.iter().map(|cell| cell.0).sum::<f64>() / number;
        let (mut squares, mut free) = (0.0, 0.0);
        let (mut smallest, mut largest) = (f64::INFINITY, 0.0_f64);
        for &(area, neighbours) in cells {
            let relative = area / mean_area;
            self.areas.add(relative);
            squares += (relative - 1.0).powi(2);
            (smallest, largest) = (smallest.min(relative), largest.max(relative));
            free += radius.map_or(0.0, |radius| 1.0 - PI * radius * radius / area);
            let place = neighbours.saturating_sub(MIN_NEIGHBOURS).min(COUNTED - 1);
            self.counts[place] += 1;
        }
        self.squares += squares;
        if radius.is_some() {
            self.free = [self.free[0] + free, self.free[1] + number];
        }
        self.series.push(VoronoiPoint {
            time,
            cells: cells.len() as u64,
            mean_area,
            variance: squares / number,
            smallest,
            largest,
            free: radius.map(|_| free / number),
        });
    }
}

/// The radius of all bodies (length), if they are discs of one radius.
fn common_radius(bodies: &[BodyView<'_>]) -> Option<f64> {
    let radius = bodies.first()?.body.molecule().bounding_radius();
    let is_same = |body: &BodyView<'_>| {
        let molecule = body.body.molecule();
        molecule.is_disc() && molecule.bounding_radius() == radius
    };
    bodies.iter().all(is_same).then_some(radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{discs_at, random_points, triangular_lattice};
    use carom_engine::{Scene, Simulation};

    /// Fixed discs of a radius in a box, with walls in TOML.
    fn cells_of(sides: [f64; 2], places: &[DVec2], radius: f64, walls: &str) -> VoronoiCells {
        let mut scene = discs_at(sides, radius, places.iter().copied());
        scene.wall = Scene::from_toml(walls).unwrap().wall;
        let mut cells = VoronoiCells::adaptive(Group::All, 20);
        cells.sample(&Simulation::new(&scene).unwrap().view());
        cells
    }

    /// Area and number of sides of the cell of a body, from a large square of which the bisectors
    /// to all images of all bodies cut a part.
    fn cut_out(places: &[DVec2], index: usize, sides: DVec2) -> (f64, usize) {
        let far = 4.0 * sides.max_element();
        let corners = [(-far, -far), (far, -far), (far, far), (-far, far)];
        let mut cell: Vec<DVec2> = corners.map(DVec2::from).to_vec();
        for (other, place) in places.iter().enumerate() {
            for image in (-4..=4).flat_map(|x| (-4..=4).map(move |y| [x, y])) {
                if other == index && image == [0; 2] {
                    continue;
                }
                let to = *place - places[index] + sides * DVec2::from(image.map(f64::from));
                let beyond = |corner: DVec2| corner.dot(to) - 0.5 * to.length_squared();
                let mut kept = Vec::new();
                for (k, &corner) in cell.iter().enumerate() {
                    let next = cell[(k + 1) % cell.len()];
                    let (here, there) = (beyond(corner), beyond(next));
                    if here <= 0.0 {
                        kept.push(corner);
                    }
                    if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
                        kept.push(corner.lerp(next, here / (here - there)));
                    }
                }
                cell = kept;
            }
        }
        let count = cell.len();
        let twice: f64 = (0..count)
            .map(|k| cell[k].perp_dot(cell[(k + 1) % count]))
            .sum();
        (0.5 * twice, count)
    }

    #[test]
    fn a_few_random_points_have_the_cells_that_bisectors_cut_out() {
        for (count, sides) in [
            (2, [1.0, 0.7]),
            (3, [1.0, 0.8]),
            (5, [1.0, 1.0]),
            (12, [0.8, 1.0]),
        ] {
            for seed in 0..8 {
                let scene = random_points(count, sides, seed);
                let places: Vec<DVec2> = scene
                    .bumper
                    .iter()
                    .map(|body| DVec2::from(body.at))
                    .collect();
                let cells = cells_of(sides, &places, 1e-9, "");
                let expected: Vec<(f64, usize)> = (0..count)
                    .map(|index| cut_out(&places, index, DVec2::from(sides)))
                    .collect();
                let mean = sides[0] * sides[1] / count as f64;
                let relative = || expected.iter().map(|cell| cell.0 / mean);
                let point = cells.series()[0];
                let variance =
                    relative().map(|area| (area - 1.0).powi(2)).sum::<f64>() / count as f64;
                for (found, expected) in [
                    (point.mean_area / mean, 1.0),
                    (point.variance, variance),
                    (point.smallest, relative().fold(f64::INFINITY, f64::min)),
                    (point.largest, relative().fold(0.0, f64::max)),
                ] {
                    assert!((found - expected).abs() < 1e-9, "{found} {expected}");
                }
                for (bin, number) in VoronoiCells::neighbours().enumerate() {
                    let of_number = expected.iter().filter(|cell| cell.1.clamp(3, 9) == number);
                    let found = cells.sums()[bin];
                    assert_eq!(found, [of_number.count() as f64, count as f64]);
                }
            }
        }
    }

    #[test]
    fn the_areas_add_up_to_that_of_the_box() {
        for (count, sides) in [
            (4, [1.0, 0.7]),
            (40, [0.1, 7.0]),
            (500, [1.0, 2.0]),
            (3000, [1.0, 1.0]),
        ] {
            let scene = random_points(count, sides, 5);
            let mut cells = VoronoiCells::adaptive(Group::All, 20);
            cells.sample(&Simulation::new(&scene).unwrap().view());
            let point = cells.series()[0];
            let total = point.mean_area * point.cells as f64;
            let relative = total / (sides[0] * sides[1]);
            assert!((relative - 1.0).abs() < 1e-12, "{count}: {relative}");
        }
    }

    #[test]
    fn a_triangular_lattice_has_six_neighbours_and_equal_areas() {
        let (sides, places) = triangular_lattice(12, 14);
        let cells = cells_of(sides, &places, 0.49, "");
        let point = cells.series()[0];
        assert_eq!((point.cells, cells.sums()[3]), (168, [168.0, 168.0]));
        assert!((point.mean_area - 0.75_f64.sqrt()).abs() < 1e-12);
        assert!((point.smallest - 1.0).abs() < 1e-9 && (point.largest - 1.0).abs() < 1e-9);
        assert!(point.variance < 1e-18);
        // The share of the discs is π/√12 (2r)².
        let expected = 1.0 - PI / 12.0_f64.sqrt() * 0.98 * 0.98;
        assert!((point.free.unwrap() - expected).abs() < 1e-12);
        assert!((cells.sums()[8][0] / 168.0 - expected).abs() < 1e-12);
        // Rows next to a wall are bounded by it.
        let beside = cells_of(sides, &places, 0.2, "[[wall]]\ny = 0.001\n");
        assert_eq!(beside.series()[0].cells, 168 - 2 * 12);
        assert!((beside.series()[0].mean_area - 0.75_f64.sqrt()).abs() < 1e-12);
        // A square lattice.
        let square: Vec<DVec2> = (0..64)
            .map(|k| DVec2::new(f64::from(k % 8), f64::from(k / 8)))
            .collect();
        let cells = cells_of([8.0; 2], &square, 0.1, "");
        assert_eq!(cells.sums()[1], [64.0; 2]);
        assert!((cells.series()[0].mean_area - 1.0).abs() < 1e-12);
    }

    #[test]
    fn random_positions_have_the_variance_of_a_poisson_voronoi_tessellation() {
        let mut cells = VoronoiCells::new(Group::All, 4.0, 40).unwrap();
        for seed in 0..60 {
            let scene = random_points(1000, [0.5, 2.0], seed);
            cells.sample(&Simulation::new(&scene).unwrap().view());
        }
        let variances = cells.series().iter().map(|point| point.variance);
        let (mean, error) = carom_tables::block_sums::mean_of_series(variances).unwrap();
        assert!(
            (mean - 0.2802).abs() < 4.0 * error && error < 0.003,
            "{mean} ± {error}"
        );
        // The share of triangles (P. Calka, Adv. Appl. Probab. 35 (2003) 551).
        let sums = cells.sums();
        let share = |bin: usize| sums[bin][0] / sums[bin][1];
        assert!((share(0) - 0.01124).abs() < 0.002, "{}", share(0));
        let neighbours: f64 = (0..7).map(|bin| share(bin) * (bin + 3) as f64).sum();
        // Six on average, but for the few with ten and more, which count as nine.
        assert!((5.97..6.0).contains(&neighbours), "{neighbours}");
        assert_eq!(cells.areas().total(), 60_000);
        assert!(cells.areas().beyond() < 60);
    }

    #[test]
    fn few_bodies_and_other_shapes_have_cells() {
        for (count, sides) in [
            (0, [1.0; 2]),
            (1, [1.0; 2]),
            (2, [1.0, 0.02]),
            (3, [0.01, 1.0]),
        ] {
            let mut cells = VoronoiCells::adaptive(Group::All, 20);
            let scene = random_points(count, sides, 1);
            cells.sample(&Simulation::new(&scene).unwrap().view());
            assert_eq!(cells.series().len(), usize::from(count > 0));
            assert!(cells.sums().iter().flatten().all(|sum| sum.is_finite()));
        }
        for largest in [0.0, -1.0, f64::NAN] {
            assert!(VoronoiCells::new(Group::All, largest, 10).is_err());
        }
        // Discs of two radii have no common free share.
        let two =
            "[[bumper]]\nradius = 0.1\nat = [0.2, 0.2]\n[[bumper]]\nradius = 0.2\nat = [0.7, 0.7]";
        let mut cells = VoronoiCells::adaptive(Group::All, 20);
        cells.sample(
            &Simulation::new(&Scene::from_toml(two).unwrap())
                .unwrap()
                .view(),
        );
        assert_eq!((cells.series()[0].free, cells.sums()[8]), (None, [0.0; 2]));
    }
}
