//! The structure factor S(k) of the centres of mass.
//!
//! S(k) = ⟨|Σ exp(i k·x)|²⟩ / N over the wave vectors of the box, k = 2π (n_x / Lx, n_y / Ly)
//! without k = 0 (Hansen & McDonald 2013, section 4.1). It is 1 for independent, uniform positions
//! of any number of bodies, and N at the reciprocal vectors of a perfect lattice. For a fluid at
//! equilibrium it tends for k → 0 to n kT κ, with n bodies per area and κ the isothermal
//! compressibility. Wave vectors of one length form a shell; S is its mean over the shell.
//!
//! Two groups a and b have the partial structure factor S_ab = ⟨ρ_a(k) ρ_b(−k)⟩ / √(N_a N_b), with
//! ρ = Σ exp(i k·x) over the group (N. W. Ashcroft & D. C. Langreth, Phys. Rev. 156 (1967) 685). It
//! is 0 for independent positions of different bodies, and may be negative. For groups that divide
//! all N bodies, S = Σ √(N_a N_b) S_ab / N over all ordered pairs.
//!
//! In a sheared box with the tilt b images are at multiples of R = (Lx, 0) and (b, Ly), and
//! exp(i k·R) = 1 has the solutions k = 2π (n_x / Lx, (n_y − n_x b / Lx) / Ly). They move with the
//! tilt, so that |k| changes: each of them counts in the shell of the box without tilt whose |k| is
//! nearest, up to the |k| of the last shell. With places (x − y b / Ly) / Lx and y / Ly in units of
//! the sides, k·x = 2π (n_x x + n_y y) as without tilt.

use carom_engine::{Observer, View};
use carom_geometry::PeriodicBox;
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    Group,
    wave_vectors::{in_tilted_shells, shortest_shells, sums_of_waves},
};

/// The largest number of shells. The cost of a sample is the number of bodies times that of wave
/// vectors, in a square box two to seven a shell.
const MAX_SHELLS: usize = 10_000;

/// Structure factor of two groups, or of one with itself, over the samples; fixed discs and
/// molecules count, walls do not. Under shear S is a mean over the directions of the wave vectors
/// of the present images, each in the shell whose |k| is nearest.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, StructureFactor};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 200")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut structure = StructureFactor::new([Group::All; 2], &simulation.view().bounds(), 5)?;
/// for sample in 1..=20 {
///     simulation.run_until(0.2 * f64::from(sample))?;
///     structure.sample(&simulation.view());
/// }
/// // k² = 1, 2, 4, 5, 8 in units of (2π)². Discs with a size suppress long waves.
/// let points = structure.points();
/// assert_eq!(points.len(), 5);
/// assert!((points[4].wave_number - 8f64.sqrt() * std::f64::consts::TAU).abs() < 1e-12);
/// assert!(points.iter().all(|point| point.s < 0.7));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "scattering")]
pub struct StructureFactor {
    groups: [Group; 2],
    bounds: PeriodicBox,
    shells: Vec<Shell>,
    passed_over: u64,
}

/// The wave vectors of one length, one of each pair k and −k, which have the same S.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Shell {
    wave_number: f64,
    /// (n_x, n_y).
    vectors: Vec<[i64; 2]>,
    /// Σ ρ_a(k) ρ_b(−k) / √(N_a N_b) over samples and vectors, real part.
    sum: f64,
    /// The number of terms in the sum.
    terms: u64,
}

/// The structure factor in one shell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StructurePoint {
    /// |k| (1 / length).
    pub wave_number: f64,
    /// Number of wave vectors of this length in the box without tilt; k and −k count as one.
    pub vectors: usize,
    /// S; at least 0 for a group with itself.
    pub s: f64,
}

/// A number of shells that is 0 or too large.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the number of shells must be 1 to {MAX_SHELLS}, but is {shells}")]
pub struct ShellsError {
    /// The number given.
    pub shells: usize,
}

impl StructureFactor {
    /// S in the `shells` shells of smallest |k| > 0 of this box, 1 to 10 000.
    ///
    /// # Errors
    /// [`ShellsError`] if `shells` is 0 or larger.
    pub fn new(
        groups: [Group; 2],
        bounds: &PeriodicBox,
        shells: usize,
    ) -> Result<Self, ShellsError> {
        if !(1..=MAX_SHELLS).contains(&shells) {
            return Err(ShellsError { shells });
        }
        let shells = shortest_shells(bounds, shells)
            .into_iter()
            .map(|shell| Shell {
                wave_number: shell.wave_number,
                vectors: shell.vectors,
                sum: 0.0,
                terms: 0,
            })
            .collect();
        Ok(Self {
            groups,
            bounds: *bounds,
            shells,
            passed_over: 0,
        })
    }

    /// S in each shell, in ascending order of |k|; empty before the first sample, and without the
    /// shells in which no wave vector has been under shear.
    pub fn points(&self) -> Vec<StructurePoint> {
        let point = |shell: &Shell| StructurePoint {
            wave_number: shell.wave_number,
            vectors: shell.vectors.len(),
            s: shell.sum / shell.terms as f64,
        };
        let counted = self.shells.iter().filter(|shell| shell.terms > 0);
        counted.map(point).collect()
    }

    /// |k| of each shell in ascending order (1 / length).
    pub fn wave_numbers(&self) -> Vec<f64> {
        self.shells.iter().map(|shell| shell.wave_number).collect()
    }

    /// [Σx, Σw] of each shell over all samples so far: x is S of one wave vector in one sample, and
    /// w is 1.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.shells
            .iter()
            .map(|shell| [shell.sum, shell.terms as f64])
            .collect()
    }

    /// The number of samples skipped because their box differs from that of the constructor, or
    /// because a group was empty.
    pub fn passed_over(&self) -> u64 {
        self.passed_over
    }
}

/// Re ρ_a(k) ρ_b(−k) / √(N_a N_b) of one sample for each wave vector of a box, (n_x, n_y) with n_y
/// ≥ 0; `None` in a box of other sides or if a group is empty.
pub(crate) fn products_of_waves(
    view: &View<'_>,
    bounds: &PeriodicBox,
    groups: [Group; 2],
    vectors: &[[i64; 2]],
) -> Option<Vec<f64>> {
    let (sides, tilt) = (bounds.sides(), view.bounds().tilt());
    // In units of the sides.
    let mut places = groups.map(|group| -> Vec<DVec2> {
        let members = group.molecules(view);
        members.map(|view| view.motion.position / sides).collect()
    });
    if view.bounds().sides() != sides || places.iter().any(Vec::is_empty) {
        return None;
    }
    if tilt != 0.0 {
        for place in places.iter_mut().flatten() {
            place.x -= tilt / sides.x * place.y;
        }
    }
    let [first, second] = &places;
    let waves = sums_of_waves(first, vectors);
    let others = if groups[0] == groups[1] {
        waves.clone()
    } else {
        sums_of_waves(second, vectors)
    };
    // Exact for equal groups: the root of a square.
    let count = (first.len() as f64 * second.len() as f64).sqrt();
    let products = waves.iter().zip(&others);
    Some(
        products
            .map(|(one, other)| one.dot(*other) / count)
            .collect(),
    )
}

impl Observer for StructureFactor {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let tilt = view.bounds().tilt();
        // The shell and the numbers of each wave vector.
        let (shells, vectors): (Vec<usize>, Vec<[i64; 2]>) = if tilt == 0.0 {
            let shells = self.shells.iter().enumerate();
            shells
                .flat_map(|(place, shell)| shell.vectors.iter().map(move |&vector| (place, vector)))
                .unzip()
        } else {
            in_tilted_shells(&self.bounds.tilted(tilt), &self.wave_numbers())
        };
        let Some(products) = products_of_waves(view, &self.bounds, self.groups, &vectors) else {
            self.passed_over += 1;
            return;
        };
        for (shell, product) in shells.into_iter().zip(products) {
            self.shells[shell].sum += product;
            self.shells[shell].terms += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{discs_at, moving_with_the_flow, random_points};
    use carom_engine::{Scene, Simulation};

    fn observe(scenes: &[Scene], shells: usize) -> StructureFactor {
        let bounds = Simulation::new(&scenes[0]).unwrap().view().bounds();
        let mut structure = StructureFactor::new([Group::All; 2], &bounds, shells).unwrap();
        for scene in scenes {
            structure.sample(&Simulation::new(scene).unwrap().view());
        }
        structure
    }

    #[test]
    fn a_square_lattice_has_bragg_peaks_and_nothing_else() {
        let site = |site: u32| {
            let [x, y] = [f64::from(site % 8), f64::from(site / 8)];
            DVec2::new(0.25 * x + 0.03, 0.25 * y)
        };
        let scene = discs_at([2.0; 2], 0.01, (0..64).map(site));
        let structure = observe(&[scene], 40);
        for point in structure.points() {
            // In units of 2π / L: the peaks are at |n|² = 8² and 2 · 8².
            let squared = (point.wave_number / std::f64::consts::PI).powi(2).round();
            match squared {
                // (8, 0) and (0, 8).
                64.0 => assert!(
                    (point.s - 64.0).abs() < 1e-9 && point.vectors == 2,
                    "{point:?}"
                ),
                _ => assert!(point.s < 1e-20, "{point:?}"),
            }
        }
        let peak = std::f64::consts::TAU / 0.25;
        assert!(
            structure
                .wave_numbers()
                .iter()
                .any(|k| (k - peak).abs() < 1e-9)
        );
    }

    #[test]
    fn shells_are_complete_and_ascend_in_square_and_long_boxes() {
        let square = PeriodicBox::new(DVec2::ONE).unwrap();
        let structure = StructureFactor::new([Group::All; 2], &square, 12).unwrap();
        let squares = [1, 2, 4, 5, 8, 9, 10, 13, 16, 17, 18, 20].map(f64::from);
        // Half of the representations of these numbers as sums of two squares.
        let vectors = [2, 2, 2, 4, 2, 2, 4, 4, 2, 4, 2, 4];
        for ((shell, square), count) in structure.shells.iter().zip(squares).zip(vectors) {
            assert!(
                (shell.wave_number / square.sqrt() / std::f64::consts::TAU - 1.0).abs() < 1e-14
            );
            assert_eq!(shell.vectors.len(), count, "{square}");
        }
        let long = PeriodicBox::new(DVec2::new(1e6, 1.0)).unwrap();
        let structure = StructureFactor::new([Group::All; 2], &long, 100).unwrap();
        let numbers: Vec<[i64; 2]> = structure
            .shells
            .iter()
            .map(|shell| shell.vectors[0])
            .collect();
        assert_eq!(numbers, (1..=100).map(|x| [x, 0]).collect::<Vec<_>>());
        for shells in [0, MAX_SHELLS + 1] {
            assert_eq!(
                StructureFactor::new([Group::All; 2], &long, shells).unwrap_err(),
                ShellsError { shells }
            );
        }
    }

    #[test]
    fn random_positions_give_one() {
        let scenes: Vec<Scene> = (0..100)
            .map(|seed| random_points(100, [1.0, 1.5], seed))
            .collect();
        let structure = observe(&scenes, 30);
        let sums = structure.sums();
        for (point, [x, w]) in structure.points().iter().zip(&sums) {
            // |Σ|²/N has the variance 1 − 1/N for independent phases.
            let error = 1.0 / w.sqrt();
            assert!((x / w - 1.0).abs() < 5.0 * error, "{point:?}");
            assert_eq!((point.s, *w), (x / w, 100.0 * point.vectors as f64));
        }
        let [x, w] = sums
            .iter()
            .fold([0.0, 0.0], |all, sum| [all[0] + sum[0], all[1] + sum[1]]);
        assert!((x / w - 1.0).abs() < 5.0 / w.sqrt());
    }

    /// The lattice of the wave vectors that belongs to a sheared square lattice has its peaks at
    /// n_x and n_y that are multiples of 6, at all times.
    #[test]
    fn a_lattice_in_a_flow_has_the_bragg_peaks_of_its_images() {
        let site = |site: u32| {
            let [x, y] = [f64::from(site % 6), f64::from(site / 6)];
            DVec2::new(0.5 * x + 0.03, 0.5 * y + 0.1)
        };
        let places: Vec<DVec2> = (0..36).map(site).collect();
        let mut simulation = Simulation::new(&moving_with_the_flow([3.0; 2], &places)).unwrap();
        let mut structure =
            StructureFactor::new([Group::All; 2], &simulation.view().bounds(), 60).unwrap();
        let most = structure.wave_numbers()[59];
        let mut expected = vec![[0.0; 2]; 60];
        for time in [0.0, 0.31, 1.0, 1.9, 3.3, 7.7] {
            simulation.run_until(time).unwrap();
            structure.sample(&simulation.view());
            let (tilt, numbers) = (simulation.view().bounds().tilt(), structure.wave_numbers());
            for n_x in -40..=40_i32 {
                for n_y in -60..=60_i32 {
                    let (x, y) = (f64::from(n_x), f64::from(n_y) - f64::from(n_x) * tilt / 3.0);
                    let k = std::f64::consts::TAU / 3.0 * x.hypot(y);
                    if (n_x, n_y) == (0, 0) || k > most * (1.0 + 1e-12) {
                        continue;
                    }
                    let away = |shell: &usize| (numbers[*shell] - k).abs();
                    let shells = 0..60;
                    let nearest = shells.min_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
                    let is_peak = n_x % 6 == 0 && n_y % 6 == 0;
                    expected[nearest][0] += if is_peak { 18.0 } else { 0.0 };
                    expected[nearest][1] += 0.5;
                }
            }
        }
        for (found, expected) in structure.sums().iter().zip(&expected) {
            assert_eq!(found[1], expected[1]);
            assert!(
                (found[0] - expected[0]).abs() < 1e-6,
                "{found:?} {expected:?}"
            );
        }
        assert!(expected.iter().map(|sum| sum[0]).sum::<f64>() > 200.0);
    }

    /// S of random places against sums over the bodies with other images, which must not matter.
    #[test]
    fn waves_in_a_flow_are_those_of_the_images() {
        let scene = random_points(40, [1.0, 1.5], 6);
        let places: Vec<DVec2> = scene
            .bumper
            .iter()
            .map(|disc| DVec2::from(disc.at))
            .collect();
        let mut simulation = Simulation::new(&moving_with_the_flow([1.0, 1.5], &places)).unwrap();
        simulation.run_until(2.6).unwrap();
        let view = simulation.view();
        let bounds = view.bounds();
        assert!(bounds.tilt() != 0.0);
        let unit = bounds.sides().recip() * std::f64::consts::TAU;
        let vectors: Vec<[i64; 2]> = (0..6).flat_map(|y| (-5..6).map(move |x| [x, y])).collect();
        let found = products_of_waves(&view, &bounds, [Group::All; 2], &vectors).unwrap();
        for ([n_x, n_y], found) in vectors.into_iter().zip(found) {
            let [x, y] = [n_x, n_y].map(|n| n as f64);
            let k = unit * DVec2::new(x, y - x * bounds.tilt() / bounds.sides().x);
            let wave = |(index, body): (usize, carom_engine::BodyView<'_>)| {
                let image = [index as i64 % 3 - 1, index as i64 % 5 - 2];
                let phase = k.dot(body.motion.position + bounds.shift(image));
                DVec2::new(phase.cos(), phase.sin())
            };
            let sum: DVec2 = view.bodies().enumerate().map(wave).sum();
            let expected = sum.length_squared() / 40.0;
            assert!(
                (found - expected).abs() < 1e-9,
                "{n_x} {n_y}: {found} {expected}"
            );
        }
    }

    #[test]
    fn partial_structure_factors_add_up_to_the_total() {
        let mut scene = random_points(90, [1.0, 1.5], 4);
        for (index, bumper) in scene.bumper.iter_mut().enumerate() {
            bumper.tags = vec![["a", "b", "b"][index % 3].to_owned()];
        }
        let simulation = Simulation::new(&scene).unwrap();
        let [a, b] = ["a", "b"].map(|name| Group::from(simulation.find_tag(name).unwrap()));
        let observe = |groups: [Group; 2]| {
            let bounds = simulation.view().bounds();
            let mut structure = StructureFactor::new(groups, &bounds, 40).unwrap();
            structure.sample(&simulation.view());
            structure.points()
        };
        let all = observe([Group::All; 2]);
        let pairs = [[a, a], [a, b], [b, a], [b, b]].map(observe);
        // √(N_a N_b) / N with 30 and 60 bodies.
        let weights = [1.0 / 3.0, 2f64.sqrt() / 3.0, 2f64.sqrt() / 3.0, 2.0 / 3.0];
        for (index, total) in all.iter().enumerate() {
            let sum: f64 = pairs
                .iter()
                .zip(weights)
                .map(|(points, weight)| weight * points[index].s)
                .sum();
            assert!((sum - total.s).abs() < 1e-12, "{sum} {}", total.s);
        }
        assert_eq!(pairs[1], pairs[2]);
        assert!(pairs[1].iter().any(|point| point.s < 0.0));
    }
}
