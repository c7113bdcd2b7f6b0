//! Clusters: bodies that are connected by gaps shorter than a given one, or by bonds and wells.
//!
//! Two bodies are connected if the distance of their surfaces, where they are nearest, is shorter
//! than the gap, or if their centres are nearer than a distance, or if they are bonded
//! ([`Bonding`]), also through the border of the periodic box; a cluster is a set of bodies that
//! connections join. With n_s clusters of s bodies, the mean size of a cluster is the number
//! average Σ s n_s / Σ n_s, and the mean size of the cluster of a body is the weight average
//! S = Σ s² n_s / Σ s n_s, which diverges at percolation (Stauffer & Aharony, Introduction to
//! Percolation Theory, 1994; here all clusters count, the largest too).
//!
//! A cluster percolates along x if it joins a body with an image of the same body that is shifted
//! along x (it wraps around the box), whether or not it is shifted along y, too.
//!
//! Discs of radius r at independent, uniform positions, n per area, percolate above nπr² = 1.128
//! (Quintanilla, Torquato & Ziff, J. Phys. A 33 (2000) L399). At this density a cluster wraps
//! around a large square box along x with the probability 0.5211, and along x or y with 0.6905
//! (Pinson 1994; Newman & Ziff, Phys. Rev. E 64 (2001) 016706).

use carom_engine::{BodyView, Observer, View};
use carom_geometry::{GeometryError, Molecule, check_positive, gap_between};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Bonding, Group,
    cell_list::CellList,
    delaunay::crosses_a_wall,
    disjoint_sets::DisjointSets,
    size_bins::{bin_of, smallest_of},
};

/// Clusters of a group at each sample; fixed discs and molecules count, walls do not, and bodies on
/// two sides of a wall are not connected through it.
///
/// The gap of two bodies is that of [`gap_between`]: of two discs, the distance of their centres
/// less both radii. Bodies that overlap are connected. Rules for pairs of tags make no difference.
/// Samples without bodies are omitted. A sample costs a search of a few cells for each body of a
/// homogeneous system, and more for a gap far longer than the mean distance.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Clusters, Group};
///
/// // A pair through the border of the box at a gap of 0.02, and a disc alone.
/// let scene = Scene::from_toml(r"
///     [[bumper]]
///     radius = 0.04
///     at = [0.05, 0.5]
///     [[bumper]]
///     radius = 0.04
///     at = [0.95, 0.5]
///     [[bumper]]
///     radius = 0.04
///     at = [0.5, 0.5]
/// ")?;
/// let mut clusters = Clusters::new(Group::All, 0.03)?;
/// clusters.sample(&Simulation::new(&scene)?.view());
/// let point = clusters.series()[0];
/// assert_eq!((point.clusters, point.largest, point.wraps), (2, 2, [false; 2]));
/// assert_eq!((point.number_mean(), point.weight_mean), (3.0 / 2.0, 5.0 / 3.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "percolation")]
#[doc(alias = "connected components")]
pub struct Clusters {
    group: Group,
    connection: Connection,
    series: Vec<ClusterPoint>,
    /// Clusters by their size in logarithmic bins, over all samples; the last bin holds those
    /// beyond.
    counts: Vec<u64>,
    sums: ClusterSums,
}

/// What connects two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
enum Connection {
    /// A gap shorter than this (length).
    Gap(f64),
    /// Centres of mass nearer than this (length).
    Centres(f64),
    Bonded(Bonding),
}

/// Sums over all samples.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct ClusterSums {
    bodies: f64,
    clusters: f64,
    largest: f64,
    /// Σ s² over all clusters.
    squares: f64,
    /// Samples with a cluster that percolates along x, along y, along x or y.
    percolating: [f64; 3],
}

/// The clusters at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ClusterPoint {
    /// Time of the sample.
    pub time: f64,
    /// Number of bodies.
    pub bodies: u64,
    /// Number of clusters; a body alone is one.
    pub clusters: u64,
    /// Number of bodies in the largest cluster.
    pub largest: u64,
    /// Mean size of the cluster of a body, Σ s² n_s / Σ s n_s (bodies).
    pub weight_mean: f64,
    /// Whether a cluster percolates along x, and along y.
    pub wraps: [bool; 2],
}

impl ClusterPoint {
    /// Mean size of a cluster, Σ s n_s / Σ n_s (bodies).
    pub fn number_mean(&self) -> f64 {
        self.bodies as f64 / self.clusters as f64
    }
}

/// More bodies than any system has (the engine numbers them with 32 bits).
const MAX_SIZE: u64 = u32::MAX as u64;

/// A molecule in its place.
struct PlacedMolecule<'a> {
    molecule: &'a Molecule,
    /// (cos θ, sin θ) of its orientation.
    rotation: DVec2,
    /// Its bounding radius (length).
    radius: f64,
}

impl Clusters {
    /// Clusters of the bodies of a group with gaps shorter than `gap` (length), by size in
    /// logarithmic bins.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `gap` is not positive and finite.
    pub fn new(group: Group, gap: f64) -> Result<Self, GeometryError> {
        let gap = check_positive("the gap of clusters", gap)?;
        Ok(Self::connected_by(group, Connection::Gap(gap)))
    }

    /// Clusters of the bodies of a group whose centres of mass are nearer than `distance` (length),
    /// whatever their sizes and shapes, by size in logarithmic bins.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `distance` is not positive and finite.
    pub fn by_distance(group: Group, distance: f64) -> Result<Self, GeometryError> {
        let distance = check_positive("the distance of clusters", distance)?;
        Ok(Self::connected_by(group, Connection::Centres(distance)))
    }

    /// Clusters of the bodies of a group that are bonded, by size in logarithmic bins. They change
    /// when a pair enters or leaves a well, and when bonds are made or cut.
    ///
    /// ```
    /// use carom_engine::{Scene, Simulation, Observer};
    /// use carom_observers::{Bonding, Clusters, Group};
    ///
    /// // Chains of four discs, and discs alone.
    /// let scene = Scene::from_toml(
    ///     "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 8\n\
    ///      chain = { members = 4, tether = { max = 0.04 } }\n\
    ///      [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 2",
    /// )?;
    /// let mut clusters = Clusters::bonded(Group::All, Bonding::Bonds);
    /// clusters.sample(&Simulation::new(&scene)?.view());
    /// let point = clusters.series()[0];
    /// assert_eq!((point.clusters, point.largest), (4, 4));
    /// assert_eq!((point.number_mean(), point.weight_mean), (10.0 / 4.0, 34.0 / 10.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn bonded(group: Group, bonding: Bonding) -> Self {
        Self::connected_by(group, Connection::Bonded(bonding))
    }

    fn connected_by(group: Group, connection: Connection) -> Self {
        Self {
            group,
            connection,
            series: Vec::new(),
            counts: vec![0; bin_of(MAX_SIZE) + 1],
            sums: ClusterSums::default(),
        }
    }

    /// The gap below which bodies are connected (length); `None` if they are connected otherwise.
    pub fn gap(&self) -> Option<f64> {
        match self.connection {
            Connection::Gap(gap) => Some(gap),
            Connection::Centres(_) | Connection::Bonded(_) => None,
        }
    }

    /// The distance of the centres below which bodies are connected (length); `None` if they are
    /// connected otherwise.
    pub fn distance(&self) -> Option<f64> {
        match self.connection {
            Connection::Centres(distance) => Some(distance),
            Connection::Gap(_) | Connection::Bonded(_) => None,
        }
    }

    /// The samples so far.
    pub fn series(&self) -> &[ClusterPoint] {
        &self.series
    }

    /// The smallest size of each bin, and that beyond the last (bodies): 1 to 8, then four bins for
    /// each octave.
    pub fn sizes(&self) -> impl Iterator<Item = u64> {
        (0..=self.counts.len()).map(smallest_of)
    }

    /// Number of clusters in each bin of sizes over all samples so far.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// [Σx, Σw] over all samples so far: the number of clusters and the size of the largest, of
    /// each sample; the number average and the weight average of the size; whether a cluster
    /// percolates along x, along y, along x or y, of each sample; then n_s by the number of bodies
    /// for each bin, the mean over its sizes, so that Σ s n_s = 1.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let samples = self.series.len() as f64;
        let sums = &self.sums;
        let [x, y, either] = sums.percolating;
        let means = [
            [sums.clusters, samples],
            [sums.largest, samples],
            [sums.bodies, sums.clusters],
            [sums.squares, sums.bodies],
            [x, samples],
            [y, samples],
            [either, samples],
        ];
        let of_sizes = self.counts.iter().enumerate().map(|(bin, &count)| {
            let width = smallest_of(bin + 1) - smallest_of(bin);
            [count as f64 / width as f64, sums.bodies]
        });
        means.into_iter().chain(of_sizes).collect()
    }
}

/// Connects all bodies whose gap is shorter than a given one (length).
fn sets_within(gap: f64, members: &[BodyView<'_>], view: &View<'_>) -> DisjointSets {
    let placed = members.iter().map(|body| PlacedMolecule {
        molecule: body.body.molecule(),
        rotation: body.motion.orientation.cos_sin(),
        radius: body.body.molecule().bounding_radius(),
    });
    let bodies: Vec<PlacedMolecule<'_>> = placed.collect();
    let radii: Vec<f64> = bodies.iter().map(|body| body.radius).collect();
    let is_near = |pair: [usize; 2], displacement: DVec2| {
        gap_of(pair.map(|index| &bodies[index]), displacement) < gap
    };
    sets_of_near(gap, &radii, is_near, members, view)
}

/// Connects the pairs that are near, with no wall between them, of those whose distance is shorter
/// than a limit and both radii together (length).
fn sets_of_near(
    limit: f64,
    radii: &[f64],
    is_near: impl Fn([usize; 2], DVec2) -> bool,
    members: &[BodyView<'_>],
    view: &View<'_>,
) -> DisjointSets {
    let places: Vec<DVec2> = members.iter().map(|body| body.motion.position).collect();
    let mut sets = DisjointSets::new(places.len());
    let cells = CellList::for_nearest(&places, &view.bounds());
    let walls: Vec<[DVec2; 2]> = view
        .bodies()
        .flat_map(|body| body.wall_segments())
        .collect();
    let sides = view.bounds().sides();
    for (index, &radius) in radii.iter().enumerate() {
        // Each pair is found from the body with the larger radius, or else the later one.
        let range = 2.0 * radius + limit;
        cells.for_each_image_near(index, range, |other, image, displacement| {
            let is_first = if other == index {
                image > [0; 2]
            } else {
                (radii[other], other) < (radius, index)
            };
            let farthest = radius + radii[other] + limit;
            let may_touch = displacement.length_squared() < farthest * farthest;
            let place = places[index];
            if is_first
                && may_touch
                && is_near([index, other], displacement)
                && !crosses_a_wall([place, place + displacement], &walls, sides)
            {
                sets.connect(index, other, image);
            }
        });
    }
    sets
}

/// The gap of two bodies, the second at a displacement from the first (length).
fn gap_of([one, other]: [&PlacedMolecule<'_>; 2], displacement: DVec2) -> f64 {
    gap_between(
        one.molecule,
        one.rotation,
        other.molecule,
        other.rotation,
        displacement,
    )
}

impl Observer for Clusters {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let members: Vec<_> = self.group.molecules(view).collect();
        if members.is_empty() {
            return;
        }
        let sets = match self.connection {
            Connection::Gap(gap) => sets_within(gap, &members, view),
            Connection::Centres(distance) => {
                let radii = vec![0.0; members.len()];
                sets_of_near(distance, &radii, |_, _| true, &members, view)
            }
            Connection::Bonded(bonding) => bonding.sets(&members, view),
        };
        let (mut clusters, mut largest, mut squares) = (0, 0, 0.0);
        let mut wraps = [false; 2];
        for set in sets.sets() {
            clusters += 1;
            largest = largest.max(set.size);
            squares += (set.size as f64).powi(2);
            wraps = [wraps[0] | set.wraps[0], wraps[1] | set.wraps[1]];
            self.counts[bin_of(set.size.min(MAX_SIZE))] += 1;
        }
        let bodies = members.len() as f64;
        self.sums.bodies += bodies;
        self.sums.clusters += clusters as f64;
        self.sums.largest += largest as f64;
        self.sums.squares += squares;
        let [x, y] = wraps;
        for (sum, is_percolating) in self.sums.percolating.iter_mut().zip([x, y, x || y]) {
            *sum += f64::from(u8::from(is_percolating));
        }
        self.series.push(ClusterPoint {
            time: view.time().to_f64(),
            bodies: members.len() as u64,
            clusters,
            largest,
            weight_mean: squares / bodies,
            wraps,
        });
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::test_scenes::{discs_at, random_points};
    use carom_engine::{Scene, Simulation};

    fn clusters_of(scene: &Scene, gap: f64) -> Clusters {
        let mut clusters = Clusters::new(Group::All, gap).unwrap();
        clusters.sample(&Simulation::new(scene).unwrap().view());
        clusters
    }

    /// The only sample of points, as good as, in a box.
    fn point_of(sides: [f64; 2], places: &[[f64; 2]], gap: f64) -> ClusterPoint {
        let scene = discs_at(sides, 1e-9, places.iter().copied().map(DVec2::from));
        clusters_of(&scene, gap).series()[0]
    }

    /// Sizes of the clusters of points, ascending, and whether one wraps: from all pairs of bodies
    /// and images, by a walk that notes where it comes to each body.
    fn walk(places: &[DVec2], sides: DVec2, gap: f64) -> (Vec<u64>, [bool; 2]) {
        let mut visited: Vec<Option<[i32; 2]>> = vec![None; places.len()];
        let (mut sizes, mut wraps) = (Vec::new(), [false; 2]);
        for start in 0..places.len() {
            if visited[start].is_some() {
                continue;
            }
            visited[start] = Some([0; 2]);
            let (mut open, mut size) = (vec![start], 0);
            while let Some(one) = open.pop() {
                size += 1;
                let here = visited[one].unwrap();
                for other in 0..places.len() {
                    for image in (-3..=3).flat_map(|x| (-3..=3).map(move |y| [x, y])) {
                        let shift = sides * DVec2::from(image.map(f64::from));
                        if (places[other] + shift - places[one]).length() >= gap {
                            continue;
                        }
                        let there = [here[0] + image[0], here[1] + image[1]];
                        match visited[other] {
                            None => {
                                visited[other] = Some(there);
                                open.push(other);
                            }
                            Some(before) => {
                                wraps[0] |= before[0] != there[0];
                                wraps[1] |= before[1] != there[1];
                            }
                        }
                    }
                }
            }
            sizes.push(size);
        }
        sizes.sort_unstable();
        (sizes, wraps)
    }

    #[test]
    fn random_points_have_the_clusters_of_a_walk_over_all_pairs() {
        let mut found_wraps = [0; 4];
        for (count, sides) in [
            (1, [1.0, 0.7]),
            (2, [1.0, 0.3]),
            (3, [0.2, 1.0]),
            (40, [1.0, 1.0]),
        ] {
            for seed in 0..40 {
                let scene = random_points(count, sides, seed);
                let places: Vec<DVec2> = scene
                    .bumper
                    .iter()
                    .map(|body| DVec2::from(body.at))
                    .collect();
                // From far apart to all connected; the radii of the discs are below rounding.
                let gap = 0.05 + 0.4 * seed as f64 / 40.0;
                let clusters = clusters_of(&scene, gap);
                let (sizes, wraps) = walk(&places, DVec2::from(sides), gap + 2e-9);
                let point = clusters.series()[0];
                assert_eq!(point.wraps, wraps, "{count} {seed}");
                assert_eq!(point.clusters, sizes.len() as u64);
                assert_eq!(point.largest, *sizes.last().unwrap());
                let squares: u64 = sizes.iter().map(|size| size * size).sum();
                assert_eq!(point.weight_mean, squares as f64 / count as f64);
                let begins: Vec<u64> = clusters.sizes().collect();
                for (bin, &counted) in clusters.counts().iter().enumerate() {
                    let expected = sizes
                        .iter()
                        .filter(|&&size| (begins[bin]..begins[bin + 1]).contains(&size));
                    assert_eq!(counted, expected.count() as u64);
                }
                found_wraps[usize::from(wraps[0]) + 2 * usize::from(wraps[1])] += 1;
            }
        }
        assert!(
            found_wraps.iter().all(|&count| count > 3),
            "{found_wraps:?}"
        );
    }

    #[test]
    fn chains_crosses_and_pairs_are_found() {
        let sides = [1.0, 2.0];
        // Ten points along x, 0.1 apart: around the box only if the gap is longer than that.
        let chain: Vec<[f64; 2]> = (0..10).map(|k| [0.1 * f64::from(k) + 0.03, 1.9]).collect();
        let point = point_of(sides, &chain, 0.101);
        assert_eq!((point.clusters, point.largest), (1, 10));
        assert_eq!(point.wraps, [true, false]);
        assert_eq!(point_of(sides, &chain, 0.099).clusters, 10);
        // A chain with a gap is one cluster that does not wrap.
        let point = point_of(sides, &chain[..9], 0.101);
        assert_eq!((point.clusters, point.wraps), (1, [false; 2]));
        // With one along y, through its middle, a cross.
        let along_y = (0..20).map(|k| [0.53, 0.1 * f64::from(k)]);
        let along_y = along_y.filter(|place| (place[1] - 1.9).abs() > 0.01);
        let cross: Vec<[f64; 2]> = chain.iter().copied().chain(along_y).collect();
        let point = point_of(sides, &cross, 0.101);
        assert_eq!(
            (point.bodies, point.clusters, point.wraps),
            (29, 1, [true; 2])
        );
        // A diagonal wraps along both.
        let diagonal: Vec<[f64; 2]> = (0..10)
            .map(|k| [0.1 * f64::from(k), 0.2 * f64::from(k)])
            .collect();
        assert_eq!(point_of(sides, &diagonal, 0.23).wraps, [true; 2]);
        // Pairs apart.
        let pairs: Vec<[f64; 2]> = (0..10)
            .map(|k| [0.05 * f64::from(k % 2) + 0.98, 0.4 * f64::from(k / 2)])
            .map(|[x, y]| [x % 1.0, y])
            .collect();
        let point = point_of(sides, &pairs, 0.06);
        assert_eq!(
            (point.clusters, point.largest, point.weight_mean),
            (5, 2, 2.0)
        );
        assert_eq!((point.number_mean(), point.wraps), (2.0, [false; 2]));
        // One body, next to its own image along x, and no body.
        assert_eq!(
            point_of([0.1, 1.0], &[[0.0, 0.0]], 0.11).wraps,
            [true, false]
        );
        assert!(clusters_of(&Scene::default(), 0.1).series().is_empty());
    }

    /// The gap of molecules is that of their surfaces, whatever their bounding circles.
    #[test]
    fn rods_are_connected_by_the_gap_of_their_surfaces() {
        // Rods of two discs along x: 0.3 long, 0.1 wide.
        let rods = |places: &[[f64; 2]]| -> String {
            let rod = |at: &[f64; 2]| {
                format!(
                    "[[molecule]]\natoms = [{{ at = [-0.1, 0], radius = 0.05, mass = 1 }}, \
                     {{ at = [0.1, 0], radius = 0.05, mass = 1 }}]\nat = {at:?}\nfixed = true\n"
                )
            };
            places.iter().map(rod).collect()
        };
        let connected = |places: &[[f64; 2]], gap: f64| {
            let scene = Scene::from_toml(&rods(places)).unwrap();
            clusters_of(&scene, gap).series()[0].clusters == 1
        };
        // Side by side 0.13 apart, and end to end 0.32 apart: gaps 0.03 and 0.02.
        let beside = [[0.5, 0.5], [0.5, 0.63]];
        assert!(connected(&beside, 0.0301) && !connected(&beside, 0.0299));
        let in_line = [[0.5, 0.5], [0.82, 0.5]];
        assert!(connected(&in_line, 0.0201) && !connected(&in_line, 0.0199));
        // A large disc and a small one.
        let discs = "[[bumper]]\nradius = 0.2\nat = [0.3, 0.3]\n[[bumper]]\nradius = 0.01\nat = [0.3, 0.53]";
        let scene = Scene::from_toml(discs).unwrap();
        assert_eq!(clusters_of(&scene, 0.0201).series()[0].clusters, 1);
        assert_eq!(clusters_of(&scene, 0.0199).series()[0].clusters, 2);
    }

    /// Rods side by side, and a large disc beside a small one, by the distance of their centres.
    #[test]
    fn bodies_are_connected_by_the_distance_of_their_centres_whatever_their_shapes() {
        let counted = |text: &str, distance: f64| {
            let mut clusters = Clusters::by_distance(Group::All, distance).unwrap();
            let simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
            clusters.sample(&simulation.view());
            assert_eq!(
                (clusters.gap(), clusters.distance()),
                (None, Some(distance))
            );
            let point = clusters.series()[0];
            (point.clusters, point.wraps)
        };
        let rod = |y: f64| {
            format!(
                "[[molecule]]\natoms = [{{ at = [-0.1, 0], radius = 0.05, mass = 1 }}, \
                 {{ at = [0.1, 0], radius = 0.05, mass = 1 }}]\nat = [0.5, {y}]\nfixed = true\n"
            )
        };
        let rods = [rod(0.5), rod(0.63)].concat();
        assert_eq!(counted(&rods, 0.1301).0, 1);
        assert_eq!(counted(&rods, 0.1299).0, 2);
        let disc =
            |x: f64, radius: f64| format!("[[bumper]]\nradius = {radius}\nat = [{x}, 0.3]\n");
        // 0.25 apart, the gap is 0.04.
        let discs = [disc(0.3, 0.2), disc(0.55, 0.01)].concat();
        assert_eq!(counted(&discs, 0.2501).0, 1);
        assert_eq!(counted(&discs, 0.2499).0, 2);
        // A row around the box, of discs of two radii in turn, and the row with a gap.
        let row = |count: u32| -> String {
            let radius = |k: u32| 0.01 + 0.02 * f64::from(k % 2);
            let discs = (0..count).map(|k| disc(0.1 * f64::from(k), radius(k)));
            discs.collect()
        };
        assert_eq!(counted(&row(10), 0.1001), (1, [true, false]));
        assert_eq!(counted(&row(9), 0.1001), (1, [false; 2]));
        assert_eq!(counted(&row(10), 0.0999), (10, [false; 2]));
        let wall = format!("{}[[wall]]\nx = 0.25\n", row(10));
        assert_eq!(counted(&wall, 0.1001), (1, [false; 2]));
        for refused in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Clusters::by_distance(Group::All, refused).is_err());
        }
    }

    /// Free points at rest, with tags.
    fn points(places: &[([f64; 2], &str)]) -> String {
        let point = |(at, tag): &([f64; 2], &str)| {
            format!(
                "[[molecule]]\natoms = [{{ at = [0, 0], radius = 1e-3, mass = 1 }}]\nat = {at:?}\n\
                 tags = [{tag:?}]\n"
            )
        };
        places.iter().map(point).collect()
    }

    fn bonded_point(text: &str, bonding: Bonding) -> ClusterPoint {
        let mut clusters = Clusters::bonded(Group::All, bonding);
        let simulation = Simulation::new(&Scene::from_toml(text).unwrap()).unwrap();
        clusters.sample(&simulation.view());
        clusters.series()[0]
    }

    #[test]
    fn a_chain_and_a_ring_are_two_clusters_and_chains_around_the_box_wrap() {
        // A chain of three through the border of the box, a square ring, and a point alone.
        let places = [
            [0.9, 0.5],
            [0.0, 0.5],
            [0.1, 0.5],
            [0.4, 0.4],
            [0.5, 0.4],
            [0.5, 0.5],
            [0.4, 0.5],
            [0.7, 0.7],
        ];
        let text = |places: &[[f64; 2]], pairs: &[[usize; 2]]| {
            let bonds = format!("[[bond]]\npairs = {pairs:?}\ntether = {{ max = 0.2 }}\n");
            let tagged: Vec<_> = places.iter().map(|place| (*place, "point")).collect();
            format!("{bonds}{}", points(&tagged))
        };
        let pairs = [[0, 1], [1, 2], [3, 4], [4, 5], [5, 6], [6, 3]];
        let scene = text(&places, &pairs);
        for bonding in [Bonding::Bonds, Bonding::BondsOrWells] {
            let point = bonded_point(&scene, bonding);
            assert_eq!((point.bodies, point.clusters, point.largest), (8, 3, 4));
            assert_eq!(point.weight_mean, (9.0 + 16.0 + 1.0) / 8.0);
            assert_eq!(point.wraps, [false; 2]);
        }
        assert_eq!(bonded_point(&scene, Bonding::Wells).clusters, 8);
        // Ten points along y around the box, and nine.
        let column: Vec<[f64; 2]> = (0..10).map(|k| [0.3, 0.1 * f64::from(k)]).collect();
        let around: Vec<[usize; 2]> = (0..10).map(|k| [k, (k + 1) % 10]).collect();
        let point = bonded_point(&text(&column, &around), Bonding::Bonds);
        assert_eq!((point.clusters, point.wraps), (1, [false, true]));
        let point = bonded_point(&text(&column, &around[..9]), Bonding::Bonds);
        assert_eq!((point.clusters, point.wraps), (1, [false; 2]));
    }

    #[test]
    fn clusters_of_a_group_have_no_connections_through_others() {
        let places = [[0.2, 0.5], [0.3, 0.5], [0.4, 0.5], [0.5, 0.5]];
        let tags = ["a", "b", "a", "a"];
        let tagged: Vec<_> = places.into_iter().zip(tags).collect();
        let bonds = "[[bond]]\npairs = [[0, 1], [1, 2], [2, 3]]\ntether = { max = 0.2 }\n";
        let scene = Scene::from_toml(&format!("{bonds}{}", points(&tagged))).unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let group = Group::Tagged(simulation.find_tag("a").unwrap());
        let mut clusters = Clusters::bonded(group, Bonding::Bonds);
        clusters.sample(&simulation.view());
        let point = clusters.series()[0];
        assert_eq!((point.bodies, point.clusters, point.largest), (3, 2, 2));
    }

    /// Discs of diameter 0.04 with wells up to 0.06.
    #[test]
    fn discs_in_a_well_are_bonded_while_they_are_within_its_range() {
        let wells = |energy: f64| {
            let disc = |x: f64, speed: f64| {
                format!(
                    "[[molecule]]\natoms = [{{ at = [0, 0], radius = 0.02, mass = 1 }}]\n\
                     at = [{x}, 0.5]\nvelocity = [{speed}, 0]\ntags = [\"sticky\"]\n"
                )
            };
            let well = format!("[[well]]\nbetween = [\"sticky\"]\nsteps = [[1.5, {energy}]]\n");
            let discs = [disc(0.95, 1.0), disc(0.05, -1.0), disc(0.5, 0.0)].concat();
            Simulation::new(&Scene::from_toml(&format!("{well}{discs}")).unwrap()).unwrap()
        };
        // 0.1 apart through the border of the box at a relative speed of 2: the pair enters the
        // well at 0.02, and leaves it with its speed.
        for (energy, bodies_together) in [(-0.5, 2), (0.5, 1)] {
            let mut simulation = wells(energy);
            let mut bonded = Clusters::bonded(Group::All, Bonding::Wells);
            for time in [0.0, 0.022, 0.2] {
                simulation.run_until(time).unwrap();
                bonded.sample(&simulation.view());
            }
            let largest = bonded.series().iter().map(|point| point.largest);
            assert_eq!(largest.collect::<Vec<u64>>(), [1, bodies_together, 1]);
            let within = bonded.series()[1];
            assert_eq!(
                (within.clusters, within.wraps),
                (4 - bodies_together, [false; 2])
            );
        }
    }

    /// Continuum percolation of overlapping discs of radius r = gap / 2.
    #[test]
    fn independent_discs_percolate_at_their_known_density() {
        let share = |count: usize, density: f64, seeds: u64| {
            let gap = 2.0 * (density / (PI * count as f64)).sqrt();
            let mut clusters = Clusters::new(Group::All, gap).unwrap();
            for seed in 0..seeds {
                let scene = random_points(count, [1.0; 2], seed);
                clusters.sample(&Simulation::new(&scene).unwrap().view());
            }
            let sums = clusters.sums();
            let bodies: f64 = clusters
                .series()
                .iter()
                .map(|point| point.bodies as f64)
                .sum();
            assert_eq!(bodies, (count as u64 * seeds) as f64);
            [sums[4], sums[6]].map(|[sum, weight]| sum / weight)
        };
        assert_eq!(share(1000, 0.8, 40), [0.0; 2]);
        assert_eq!(share(1000, 1.5, 40), [1.0; 2]);
        // At the threshold 1.128 with the probabilities of conformal invariance, 0.5211 and 0.6905.
        // The standard error of a share p of 400 samples is √(p (1 − p) / 400) < 0.025.
        let [along_x, either] = share(1000, 1.128, 400);
        assert!((along_x - 0.5211).abs() < 0.1, "{along_x}");
        assert!((either - 0.6905).abs() < 0.1, "{either}");
    }

    #[test]
    fn degenerate_places_and_gaps_that_are_refused() {
        for gap in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Clusters::new(Group::All, gap).is_err());
        }
        // All at one place; a square lattice.
        let point = point_of([1.0; 2], &[[0.3, 0.3]; 5], 1e-3);
        assert_eq!(
            (point.clusters, point.largest, point.wraps),
            (1, 5, [false; 2])
        );
        let lattice: Vec<[f64; 2]> = (0..64)
            .map(|k| [0.125 * f64::from(k % 8), 0.125 * f64::from(k / 8)])
            .collect();
        assert_eq!(point_of([1.0; 2], &lattice, 0.1251).wraps, [true; 2]);
        assert_eq!(point_of([1.0; 2], &lattice, 0.1249).clusters, 64);
    }

    /// Two rows on both sides of a wall, and one away from it.
    #[test]
    fn nothing_is_connected_through_a_wall() {
        let row = |y: f64| (0..4).map(move |k| [0.1 + 0.25 * f64::from(k), y]);
        let places: Vec<[f64; 2]> = row(0.46).chain(row(0.54)).collect();
        let disc = |at: &[f64; 2]| format!("[[bumper]]\nradius = 0.01\nat = {at:?}\n");
        let discs: String = places.iter().map(disc).collect();
        let clusters = |wall: &str| {
            let scene = Scene::from_toml(&format!("{discs}{wall}")).unwrap();
            clusters_of(&scene, 0.1).series()[0].clusters
        };
        assert_eq!(clusters(""), 4);
        assert_eq!(clusters("[[wall]]\ny = 0.5"), 8);
        assert_eq!(clusters("[[wall]]\nfrom = [0.3, 0.5]\nto = [0.4, 0.5]"), 5);
    }
}
