//! How far bodies have moved out of their cages: displacements relative to the neighbours.
//!
//! With the displacement Δᵢ = xᵢ(t₀ + t) − xᵢ(t₀) of a body, and the z bodies j that are its
//! neighbours at t₀, the displacement relative to the cage is Δᵢ − Σⱼ Δⱼ / z (S. Mazoyer, F. Ebert,
//! G. Maret & P. Keim, arXiv:0903.4675). A wave that is long against the distance of neighbours
//! moves a body together with its cage and cancels; in two dimensions the displacements by such
//! waves grow with the size of the box (B. Illing et al., PNAS 114 (2017),
//! doi:10.1073/pnas.1612964114).
//!
//! In free flight displacements of different bodies are independent, up to terms of order 1/N by
//! conserved momentum: for bodies of one mass the mean square relative to the cage is ⟨1 + 1/z⟩
//! times the mean squared displacement, and so it is in a fluid at long lags, when neighbours at t₀
//! have parted.

use carom_engine::{BodyView, CollisionReport, Observer, View};
use carom_geometry::{GeometryError, PeriodicBox};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    CutoffError, Group,
    cell_list::CellList,
    delaunay::DelaunayBond,
    hexatic_order::bonds_between_walls,
    lags::{Clock, LaggedSample, Lags, PairSums},
    moving_frame::MovingFrame,
    pair_distribution::check_cutoff,
};

/// The neighbours that are the cage of a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Cage {
    /// Bodies whose Voronoi cells share an edge. Walls bound the cells.
    #[doc(alias = "voronoi")]
    Delaunay,
    /// Bodies whose centres of mass are nearer than this (length), also beyond a wall.
    Within(f64),
}

impl Cage {
    /// The bodies near each place, the body itself may be one of them; `None` in a box too narrow
    /// for the Voronoi cells.
    fn neighbours(self, places: &[DVec2], view: &View<'_>) -> Option<Vec<Vec<usize>>> {
        match self {
            Self::Within(distance) => {
                let cells = CellList::for_cutoff(places, &view.bounds(), distance);
                let near = |&place: &DVec2| {
                    let mut found = Vec::new();
                    cells.for_each_within(place, distance, |other, _| found.push(other));
                    found
                };
                Some(places.iter().map(near).collect())
            }
            Self::Delaunay => {
                let (bonds, _) = bonds_between_walls(places, view)?;
                let others =
                    |bonds: &Vec<DelaunayBond>| bonds.iter().map(|bond| bond.other).collect();
                Some(bonds.iter().map(others).collect())
            }
        }
    }
}

/// Mean squared displacement of the moving bodies of a group relative to their cages.
///
/// Cages consist of all bodies, whatever their tags; fixed discs and molecules count, walls do not.
/// The neighbours are those at the start of the lag; those that are removed later no longer count.
/// A body without neighbours does not contribute. Places are those of the centres of mass without
/// periodic jumps, under shear relative to the flow: it must then receive all contacts. After an
/// edit at a sample call `start`, so that the frame moves on with its new velocity. Samples must be
/// one spacing apart. A sample costs one search for neighbours, and about ten passes over all pairs
/// of neighbours.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Cage, CageDisplacement, Group};
///
/// // Two discs that move side by side, and a third that rests; a bumper far away fixes the frame.
/// let disc = |at: &str, velocity: &str| {
///     format!(
///         "[[molecule]]\natoms = [{{ at = [0, 0], radius = 0.01, mass = 1 }}]\n\
///          at = {at}\nvelocity = {velocity}\n"
///     )
/// };
/// let scene = [
///     disc("[0.1, 0.2]", "[1.0, 0.0]"),
///     disc("[0.1, 0.3]", "[1.0, 0.0]"),
///     disc("[0.1, 0.4]", "[0.0, 0.0]"),
///     "[[bumper]]\nradius = 0.01\nat = [0.5, 0.8]".to_owned(),
/// ]
/// .concat();
/// let mut simulation = Simulation::new(&Scene::from_toml(&scene)?)?;
/// let bounds = simulation.view().bounds();
/// let mut cages = CageDisplacement::new(Group::All, &bounds, Cage::Within(0.11), [0.1, 0.1])?;
/// for sample in 0..=1 {
///     simulation.observe_until(0.1 * f64::from(sample), &mut cages)?;
///     cages.sample(&simulation.view());
/// }
/// // Relative to their neighbours they move by 0, by half of 0.1, and by 0.1.
/// let point = cages.points()[1];
/// assert!((point.cage_relative - (0.05_f64.powi(2) + 0.1_f64.powi(2)) / 3.0).abs() < 1e-12);
/// assert!((point.mean_square_displacement - 2.0 * 0.1_f64.powi(2) / 3.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "cage-relative mean squared displacement")]
#[doc(alias = "CR-MSD")]
pub struct CageDisplacement {
    group: Group,
    cage: Cage,
    bounds: PeriodicBox,
    clock: Clock,
    frame: MovingFrame,
    lags: Lags<Configuration, Displacements>,
    passed_over: u64,
}

/// The averages at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CagePoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one body at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// Mean squared displacement relative to the cage (length²).
    pub cage_relative: f64,
    /// ⟨|Δ|²⟩ of the same bodies, in the frame of the centre of mass (length²).
    #[doc(alias = "MSD")]
    pub mean_square_displacement: f64,
}

/// A time or distance that is out of range.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CageError {
    /// A time is not positive and finite.
    #[error(transparent)]
    NotPositive(#[from] GeometryError),
    /// The distance of neighbours is not positive, or too long for the box.
    #[error(transparent)]
    Distance(#[from] CutoffError),
}

/// All bodies at one time, with the neighbours of those of the group.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Configuration {
    /// Numbers of the bodies, ascending.
    ids: Vec<u64>,
    /// Without periodic jumps, in the frame of the centre of mass (length).
    places: Vec<DVec2>,
    /// The index in `neighbours` of the first neighbour of each body; one more entry than bodies.
    begins: Vec<u32>,
    /// Indices in `ids`.
    neighbours: Vec<u32>,
}

impl Configuration {
    fn neighbours(&self, index: usize) -> &[u32] {
        &self.neighbours[self.begins[index] as usize..self.begins[index + 1] as usize]
    }

    /// The displacement of each body to a later time; `None` if it has been removed.
    fn displacements(&self, later: &Self) -> Vec<Option<DVec2>> {
        let mut rest = later.ids.iter().zip(&later.places).peekable();
        let displacement = |(&id, &before): (&u64, &DVec2)| {
            while rest.next_if(|&(&other, _)| other < id).is_some() {}
            let (_, &now) = rest.next_if(|&(&other, _)| other == id)?;
            Some(now - before)
        };
        self.ids
            .iter()
            .zip(&self.places)
            .map(displacement)
            .collect()
    }
}

/// Sums over the pairs of one body at two times, at one lag. Numbers are exact up to 2⁵³.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Displacements {
    pairs: f64,
    neighbours: f64,
    /// Σ |Δ|².
    squares: f64,
    /// Σ |Δ − Σ Δⱼ/z|².
    relative: f64,
}

impl PairSums<Configuration> for Displacements {
    fn add(&mut self, before: &Configuration, now: &Configuration) {
        let displacements = before.displacements(now);
        for (index, own) in displacements.iter().enumerate() {
            let neighbours = before.neighbours(index);
            let moved = neighbours
                .iter()
                .filter_map(|&other| displacements[other as usize]);
            let (sum, count) = moved.fold((DVec2::ZERO, 0.0), |(sum, count), displacement| {
                (sum + displacement, count + 1.0)
            });
            if let (Some(own), true) = (own, count > 0.0) {
                self.pairs += 1.0;
                self.neighbours += count;
                self.squares += own.length_squared();
                self.relative += (*own - sum / count).length_squared();
            }
        }
    }
}

impl CageDisplacement {
    /// Displacements over lags up to `longest` (time) of samples that are `spacing` (time) apart,
    /// relative to the neighbours of the rule `cage`.
    ///
    /// Lags are 0, 1, 2, …, 9, 10, 20, …, 90, 100, … spacings; a `longest` below one spacing is
    /// taken as one spacing.
    ///
    /// # Errors
    /// [`CageError`] if a time or the distance of neighbours is not positive and finite, or that
    /// distance is not less than half the shorter side of the box.
    pub fn new(
        group: Group,
        bounds: &PeriodicBox,
        cage: Cage,
        [spacing, longest]: [f64; 2],
    ) -> Result<Self, CageError> {
        if let Cage::Within(distance) = cage {
            check_cutoff(bounds, distance)?;
        }
        let (clock, lags) = Lags::new(spacing, longest)?;
        Ok(Self {
            group,
            cage,
            bounds: *bounds,
            clock,
            frame: MovingFrame::default(),
            lags,
            passed_over: 0,
        })
    }

    /// The rule of the neighbours.
    pub fn cage(&self) -> Cage {
        self.cage
    }

    /// The averages so far in ascending order of lag, from lag 0 on; lags without pairs are
    /// omitted.
    pub fn points(&self) -> Vec<CagePoint> {
        let lags = self.each().filter(|(_, sums)| sums.pairs > 0.0);
        lags.map(|(lag, sums)| point(lag, sums)).collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far, w the number of pairs: the mean squared displacement
    /// relative to the cage at each of the [lags](Self::lags) (length²), then ⟨|Δ|²⟩ at each
    /// (length²), then the number of neighbours at lag 0.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let terms: [fn(&Displacements) -> f64; 2] = [|sums| sums.relative, |sums| sums.squares];
        let of_lags = terms
            .into_iter()
            .flat_map(|term| self.each().map(move |(_, sums)| [term(sums), sums.pairs]));
        let at_zero = self.each().take(1);
        let neighbours = at_zero.map(|(_, sums)| [sums.neighbours, sums.pairs]);
        of_lags.chain(neighbours).collect()
    }

    /// The number of samples skipped because their box differs from that of the constructor, or is
    /// too narrow for the Voronoi cells.
    pub fn passed_over(&self) -> u64 {
        self.passed_over
    }

    /// The number of samples that were not one spacing after the previous sample, to one part in a
    /// million.
    ///
    /// An early sample is skipped. After a late sample no lag crosses the gap; earlier averages are
    /// kept.
    pub fn uneven(&self) -> u64 {
        self.lags.uneven()
    }

    fn each(&self) -> impl Iterator<Item = (f64, &Displacements)> {
        self.lags
            .each(&self.clock)
            .map(|(lag, sum)| (lag, &sum.sums))
    }

    /// All bodies now; `None` in a box too narrow for the Voronoi cells.
    fn configuration(&self, view: &View<'_>) -> Option<Configuration> {
        let bodies: Vec<BodyView<'_>> = Group::All.molecules(view).collect();
        let in_box: Vec<DVec2> = bodies.iter().map(|body| body.motion.position).collect();
        let mut found = self.cage.neighbours(&in_box, view)?;
        for (index, (body, others)) in bodies.iter().zip(&mut found).enumerate() {
            let is_member = body.body.is_free() && self.group.contains(body.body);
            // In a narrow box a body borders on its own images, which move as it does.
            others.retain(|&other| is_member && other != index);
        }
        let (begins, neighbours) = joined(&found);
        let bounds = view.bounds();
        let place = |body: &BodyView<'_>| self.frame.place(body, &bounds);
        Some(Configuration {
            ids: bodies.iter().map(|body| body.body.id()).collect(),
            places: bodies.iter().map(place).collect(),
            begins,
            neighbours,
        })
    }
}

/// Lists one after another, and where each begins, and the last ends.
fn joined(lists: &[Vec<usize>]) -> (Vec<u32>, Vec<u32>) {
    let (mut begins, mut all) = (vec![0], Vec::new());
    for list in lists {
        all.extend(list.iter().map(|&index| index as u32));
        begins.push(all.len() as u32);
    }
    (begins, all)
}

fn point(lag: f64, sums: &Displacements) -> CagePoint {
    CagePoint {
        lag,
        pairs: sums.pairs as u64,
        cage_relative: sums.relative / sums.pairs,
        mean_square_displacement: sums.squares / sums.pairs,
    }
}

impl Observer for CageDisplacement {
    #[inline]
    fn watches_any(&self) -> bool {
        self.frame.is_flowing()
    }

    fn start(&mut self, view: &View<'_>) {
        self.frame.follow(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.frame.collide(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.frame.follow(view);
        if view.bounds().sides() != self.bounds.sides() {
            self.passed_over += 1;
            return;
        }
        if !self.lags.is_due(&self.clock, view.time()) {
            return;
        }
        let Some(state) = self.configuration(view) else {
            self.passed_over += 1;
            return;
        };
        let now = [LaggedSample { id: 0, state }];
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{MIXTURE, moving_with_the_flow, triangular_lattice};
    use carom_engine::{Scene, Simulation};

    const SPACING: f64 = 0.1;

    fn cages_of(simulation: &Simulation, group: Group, cage: Cage) -> CageDisplacement {
        let bounds = simulation.view().bounds();
        CageDisplacement::new(group, &bounds, cage, [SPACING, 1.0]).unwrap()
    }

    fn tagged(simulation: &Simulation, name: &str) -> Group {
        Group::from(simulation.find_tag(name).unwrap())
    }

    /// Six rows of discs in a triangular lattice, all with one velocity along x; the two inner rows
    /// have a tag. A fixed disc far from all rows makes the frame that of the box.
    fn drifting_rows() -> Scene {
        let ([width, _], places) = triangular_lattice(6, 6);
        let disc = |(index, place): (usize, &DVec2)| {
            let tag = ["outer", "outer", "inner", "inner", "outer", "outer"][index / 6];
            let at = place.to_array();
            format!(
                "[[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 1.0\nat = {at:?}\n\
                 velocity = [1.5, 0.0]\ntags = [\"{tag}\"]\n"
            )
        };
        let discs: String = places.iter().enumerate().map(disc).collect();
        let text = format!(
            "[box]\nsides = [{width:?}, 9.0]\n[[bumper]]\nradius = 0.01\nat = [0.7, 7.0]\n{discs}"
        );
        Scene::from_toml(&text).unwrap()
    }

    /// Discs that move with the flow, over several passages of the images.
    #[test]
    fn a_lattice_in_a_flow_does_not_move_relative_to_it() {
        let site = |site: u32| DVec2::new(f64::from(site % 6), f64::from(site / 6)) + 0.2;
        let places: Vec<DVec2> = (0..36).map(site).collect();
        let scene = moving_with_the_flow([6.0; 2], &places);
        let mut simulation = Simulation::new(&scene).unwrap();
        let rules = [Cage::Within(1.2), Cage::Delaunay];
        let mut cages = rules.map(|cage| cages_of(&simulation, Group::All, cage));
        for sample in 0..=60 {
            let time = SPACING * f64::from(sample);
            for cages in &mut cages {
                simulation.observe_until(time, cages).unwrap();
                cages.sample(&simulation.view());
            }
        }
        assert!(simulation.view().shear_rate() != 0.0);
        for cages in cages {
            assert_eq!((cages.passed_over(), cages.uneven()), (0, 0));
            assert_eq!(cages.points().len(), 11);
            for point in cages.points() {
                assert!(point.cage_relative < 1e-20, "{point:?}");
                assert!(point.mean_square_displacement < 1e-20, "{point:?}");
            }
        }
    }

    #[test]
    fn a_lattice_that_drifts_as_a_whole_does_not_leave_its_cages() {
        let mut simulation = Simulation::new(&drifting_rows()).unwrap();
        let inner = tagged(&simulation, "inner");
        // The fixed disc borders on the cells of the outer rows, but is not within 1.1 of them.
        let mut all = [
            (inner, Cage::Delaunay, 12.0),
            (inner, Cage::Within(1.1), 12.0),
            (Group::All, Cage::Within(1.1), 36.0),
        ]
        .map(|(group, cage, count)| (cages_of(&simulation, group, cage), count));
        for sample in 0..=10 {
            let time = SPACING * f64::from(sample);
            simulation.run_until(time).unwrap();
            for (cages, _) in &mut all {
                cages.sample(&simulation.view());
            }
        }
        for (cages, count) in &all {
            let points = cages.points();
            assert_eq!(points.len(), 11);
            for point in &points {
                let moved = (1.5 * point.lag).powi(2);
                let error = (point.mean_square_displacement - moved).abs();
                assert!(error < 1e-12, "{point:?}");
                assert!(point.cage_relative < 1e-24, "{point:?}");
            }
            // At lag 0 each sample counts, at lag 10 only the first.
            assert_eq!(points[0].pairs as f64, 11.0 * count);
            assert_eq!(points[10].pairs as f64, *count);
        }
        // Each disc of the inner rows has six neighbours; those of the outermost two have four.
        for (place, expected) in [(0, 6.0), (1, 6.0), (2, (24.0 * 6.0 + 12.0 * 4.0) / 36.0)] {
            let [sum, pairs] = *all[place].0.sums().last().unwrap();
            assert!((sum / pairs - expected).abs() < 1e-12, "{sum} {pairs}");
        }
    }

    /// Number, place in the box, place without periodic jumps, and neighbours of each body.
    type Frame = Vec<(DVec2, Vec<usize>)>;

    /// The mean squares, relative to the cage and not, from stored frames.
    fn from_frames(frames: &[Frame], lag: usize, is_in: &[bool]) -> [f64; 3] {
        let stride = 10_usize.pow(lag.max(1).ilog10());
        let [mut pairs, mut relative, mut squares] = [0.0; 3];
        for origin in (0..frames.len() - lag).step_by(stride) {
            let moved = |body: usize| frames[origin + lag][body].0 - frames[origin][body].0;
            for (body, (_, neighbours)) in frames[origin].iter().enumerate() {
                if !is_in[body] || neighbours.is_empty() {
                    continue;
                }
                let sum: DVec2 = neighbours.iter().map(|&other| moved(other)).sum();
                let own = moved(body);
                pairs += 1.0;
                relative += (own - sum / neighbours.len() as f64).length_squared();
                squares += own.length_squared();
            }
        }
        [pairs, relative / pairs, squares / pairs]
    }

    /// Against sums over stored frames, with neighbours from all pairs of bodies.
    #[test]
    fn displacements_are_those_of_stored_frames() {
        for cage in [Cage::Within(0.15), Cage::Delaunay] {
            let mut simulation = Simulation::new(&Scene::from_toml(MIXTURE).unwrap()).unwrap();
            let bounds = simulation.view().bounds();
            let drift = simulation.view().centre_of_mass_frame().velocity();
            let group = tagged(&simulation, "a");
            let bodies = simulation.view();
            let is_in: Vec<bool> = bodies
                .bodies()
                .map(|body| group.contains(body.body))
                .collect();
            let mut cages = cages_of(&simulation, group, cage);
            let mut frames: Vec<Frame> = Vec::new();
            for sample in 0..25 {
                let time = SPACING * f64::from(sample);
                simulation.run_until(time).unwrap();
                let view = simulation.view();
                cages.sample(&view);
                let places: Vec<DVec2> = view.bodies().map(|body| body.motion.position).collect();
                let bonds = bonds_between_walls(&places, &view).unwrap().0;
                let neighbours = |body: usize| -> Vec<usize> {
                    let is_near = |other: &usize| {
                        let apart = bounds.nearest_image(places[*other] - places[body]);
                        *other != body && apart.length() < 0.15
                    };
                    match cage {
                        Cage::Within(_) => (0..places.len()).filter(is_near).collect(),
                        Cage::Delaunay => bonds[body].iter().map(|bond| bond.other).collect(),
                    }
                };
                let state = |(index, body): (usize, BodyView<'_>)| {
                    (body.unwrapped(&bounds) - time * drift, neighbours(index))
                };
                frames.push(view.bodies().enumerate().map(state).collect());
            }
            assert_eq!(is_in.iter().filter(|&&is_in| is_in).count(), 40);
            for point in cages.points() {
                let lag = (point.lag / SPACING).round() as usize;
                let [pairs, relative, square] = from_frames(&frames, lag, &is_in);
                assert_eq!(point.pairs as f64, pairs, "{lag}");
                for (found, expected) in [
                    (point.cage_relative, relative),
                    (point.mean_square_displacement, square),
                ] {
                    assert!(
                        (found - expected).abs() < 1e-12 * expected.max(1.0),
                        "{lag}"
                    );
                }
                assert!(lag == 0 || point.cage_relative > 0.0);
            }
            assert_eq!(cages.points().len(), 11);
            assert_eq!((cages.uneven(), cages.passed_over()), (0, 0));
        }
    }

    /// Discs that pass through each other move independently: ⟨1 + 1/z⟩ times the mean square.
    #[test]
    fn independent_bodies_move_relative_to_cages_by_the_mean_of_the_neighbours() {
        let count = 20_000_usize;
        let scene = format!(
            "[box]\nsides = [9.0, 9.0]\nseed = 3\n[[transparent]]\nbetween = [\"gas\"]\n[[gas]]\nradius = 0.001\n\
             mass = 2.0\ntemperature = 3.0\nvelocities = \"maxwell\"\ncount = {count}\ntags = [\"gas\"]\n"
        );
        let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
        let distance = 0.06;
        let mut cages = cages_of(&simulation, Group::All, Cage::Within(distance));
        let view = simulation.view();
        let places: Vec<DVec2> = view.bodies().map(|body| body.motion.position).collect();
        let cells = CellList::for_cutoff(&places, &view.bounds(), distance);
        let mut numbers = vec![0.0; count];
        cells.for_each_pair_within(distance, |[one, _], _| numbers[one] += 1.0);
        numbers.retain(|&number| number > 0.0);
        let factors = numbers.iter().map(|number| 1.0 + 1.0 / number);
        let expected = factors.sum::<f64>() / numbers.len() as f64;
        // About 2.8 neighbours at random: the mean is far from 1, and from 1 + 1/2.8 too.
        assert!((1.4..1.6).contains(&expected), "{expected}");
        for sample in 0..2 {
            simulation.run_until(SPACING * f64::from(sample)).unwrap();
            cages.sample(&simulation.view());
        }
        let point = cages.points()[1];
        assert_eq!(point.pairs, numbers.len() as u64);
        let ratio = point.cage_relative / point.mean_square_displacement;
        // The error of a mean of so many squares is about 1 %: neighbours share cages.
        assert!((ratio / expected - 1.0).abs() < 0.05, "{ratio} {expected}");
    }

    #[test]
    fn neighbours_that_are_removed_no_longer_count() {
        let configuration = |bodies: &[(u64, [f64; 2], &[usize])]| {
            let lists: Vec<Vec<usize>> = bodies.iter().map(|(_, _, list)| list.to_vec()).collect();
            let (begins, neighbours) = joined(&lists);
            Configuration {
                ids: bodies.iter().map(|&(id, _, _)| id).collect(),
                places: bodies.iter().map(|&(_, at, _)| DVec2::from(at)).collect(),
                begins,
                neighbours,
            }
        };
        let before = configuration(&[
            (1, [0.0, 0.0], &[1]),
            (2, [1.0, 0.0], &[0, 2, 3]),
            (5, [2.0, 0.0], &[0]),
            (6, [3.0, 0.0], &[]),
        ]);
        // Body 1 is removed, body 7 is new.
        let now = configuration(&[
            (2, [1.5, 2.0], &[]),
            (5, [2.0, 1.0], &[]),
            (6, [4.0, 0.0], &[]),
            (7, [0.0, 0.0], &[]),
        ]);
        let moved = [[0.5, 2.0], [0.0, 1.0], [1.0, 0.0]].map(|moved| Some(DVec2::from(moved)));
        let expected: Vec<_> = std::iter::once(None).chain(moved).collect();
        assert_eq!(before.displacements(&now), expected);
        let mut sums = Displacements::default();
        sums.add(&before, &now);
        // Body 2 has moved by (0.5, 2), its neighbours 5 and 6 by (0.5, 0.5) in the mean. Body 5
        // has lost its only neighbour, and body 6 had none.
        assert_eq!((sums.pairs, sums.neighbours), (1.0, 2.0));
        assert_eq!((sums.relative, sums.squares), (2.25, 4.25));
    }

    #[test]
    fn distances_and_times_out_of_range_are_refused() {
        let bounds = PeriodicBox::new(DVec2::new(1.0, 0.7)).unwrap();
        let error = |cage: Cage, times: [f64; 2]| {
            CageDisplacement::new(Group::All, &bounds, cage, times)
                .err()
                .map_or_else(String::new, |error| error.to_string())
        };
        assert_eq!(error(Cage::Within(0.3), [0.1, 1.0]), "");
        let said = error(Cage::Within(0.35), [0.1, 1.0]);
        assert!(said.contains("0.35 must be less than half"), "{said}");
        for refused in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!error(Cage::Within(refused), [0.1, 1.0]).is_empty());
            assert!(!error(Cage::Delaunay, [refused, 1.0]).is_empty());
            assert!(!error(Cage::Delaunay, [0.1, refused]).is_empty());
        }
    }
}
