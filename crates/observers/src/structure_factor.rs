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

use carom_engine::{Observer, View};
use carom_geometry::PeriodicBox;
use carom_kinematics::Orientation;
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::Group;

/// The largest number of shells. The cost of a sample is the number of bodies times that of wave
/// vectors, in a square box two to seven a shell.
const MAX_SHELLS: usize = 10_000;

/// The largest relative difference of two k² in one shell: far above the rounding of k², a few
/// 1e-16, and below the distance of different k² in a square box with 10⁴ shells, 1e-5.
const SAME_LENGTH: f64 = 1e-9;

/// Doublings of the area that is searched for shells; 2⁶⁴ times the first is never reached.
const MAX_DOUBLINGS: usize = 64;

/// Structure factor of two groups, or of one with itself, over the samples; fixed discs and
/// molecules count, walls do not.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, StructureFactor};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 200")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut structure = StructureFactor::new([Group::All; 2], simulation.view().bounds(), 5)?;
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
    samples: u64,
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
}

/// The structure factor in one shell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StructurePoint {
    /// |k| (1 / length).
    pub wave_number: f64,
    /// Number of wave vectors of this length; k and −k count as one.
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
        let shells = shortest_shells(bounds, shells);
        Ok(Self {
            groups,
            bounds: *bounds,
            shells,
            samples: 0,
            passed_over: 0,
        })
    }

    /// S in each shell, in ascending order of |k|; empty before the first sample.
    pub fn points(&self) -> Vec<StructurePoint> {
        let point = |shell: &Shell| StructurePoint {
            wave_number: shell.wave_number,
            vectors: shell.vectors.len(),
            s: shell.sum / (self.samples as f64 * shell.vectors.len() as f64),
        };
        if self.samples == 0 {
            Vec::new()
        } else {
            self.shells.iter().map(point).collect()
        }
    }

    /// |k| of each shell in ascending order (1 / length).
    pub fn wave_numbers(&self) -> Vec<f64> {
        self.shells.iter().map(|shell| shell.wave_number).collect()
    }

    /// [Σx, Σw] of each shell over all samples so far: x is S of one wave vector in one sample, and
    /// w is 1.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let samples = self.samples as f64;
        self.shells
            .iter()
            .map(|shell| [shell.sum, samples * shell.vectors.len() as f64])
            .collect()
    }

    /// The places of the bodies of a group in units of the sides.
    fn places(&self, view: &View<'_>, group: Group) -> Vec<DVec2> {
        let sides = self.bounds.sides();
        let members = view
            .bodies()
            .filter(|view| !view.body.is_wall() && group.contains(view.body));
        members.map(|view| view.motion.position / sides).collect()
    }

    /// The number of samples skipped because their box differs from that of the constructor, or
    /// because a group was empty.
    pub fn passed_over(&self) -> u64 {
        self.passed_over
    }
}

impl Observer for StructureFactor {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let places = self.groups.map(|group| self.places(view, group));
        if *view.bounds() != self.bounds || places.iter().any(Vec::is_empty) {
            self.passed_over += 1;
            return;
        }
        let vectors: Vec<[i64; 2]> = self
            .shells
            .iter()
            .flat_map(|shell| shell.vectors.iter().copied())
            .collect();
        let [first, second] = &places;
        let waves = sums_of_waves(first, &vectors);
        let others = if self.groups[0] == self.groups[1] {
            waves.clone()
        } else {
            sums_of_waves(second, &vectors)
        };
        // Exact for equal groups: the root of a square.
        let count = (first.len() as f64 * second.len() as f64).sqrt();
        let mut products = waves
            .iter()
            .zip(&others)
            .map(|(one, other)| one.dot(*other));
        for shell in &mut self.shells {
            for product in products.by_ref().take(shell.vectors.len()) {
                shell.sum += product / count;
            }
        }
        self.samples += 1;
    }
}

/// Bodies whose waves are computed together: whole vector registers, and tables of their powers
/// that fit into the first cache.
const BLOCK: usize = 16;

/// Partial sums of a wave, one for each lane of two vector registers.
const LANES: usize = 4;

/// Σ exp(2πi (n_x x + n_y y)) over places in units of the sides, for each vector (n_x, n_y) with
/// n_y ≥ 0, as real and imaginary part. A wave is a product of powers of exp(2πi x) and exp(2πi y),
/// whose rounding grows with the power: some 1e-16 n. The products for n_x are those for −n_x, with
/// other signs.
fn sums_of_waves(places: &[DVec2], vectors: &[[i64; 2]]) -> Vec<DVec2> {
    let mut pairs: Vec<[usize; 2]> = vectors
        .iter()
        .map(|vector| vector.map(|number| number.unsigned_abs() as usize))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let largest = |axis: usize| pairs.iter().map(|pair| pair[axis]).max().unwrap_or(0);
    let [mut across, mut up] = [0, 1].map(|axis| Powers::new(largest(axis)));
    let mut sums = vec![[0.0; 4]; pairs.len()];
    for block in places.chunks(BLOCK) {
        across.set(block.iter().map(|place| place.x));
        up.set(block.iter().map(|place| place.y));
        for (sums, &[x, y]) in sums.iter_mut().zip(&pairs) {
            let products = sums_of_products(&across.0[x], &up.0[y]);
            for (sum, product) in sums.iter_mut().zip(products) {
                *sum += product;
            }
        }
    }
    let wave = |&[x, y]: &[i64; 2]| {
        let pair = [x, y].map(|number| number.unsigned_abs() as usize);
        let place = pairs.binary_search(&pair).unwrap_or_default();
        let [real, imaginary, real_imaginary, imaginary_real] = sums[place];
        if x < 0 {
            DVec2::new(real + imaginary, real_imaginary - imaginary_real)
        } else {
            DVec2::new(real - imaginary, real_imaginary + imaginary_real)
        }
    };
    vectors.iter().map(wave).collect()
}

/// Sums over the bodies of a block of the products of two numbers a and b: real parts, imaginary
/// parts, real part of a and imaginary part of b, and the reverse.
fn sums_of_products(a: &[[f64; BLOCK]; 2], b: &[[f64; BLOCK]; 2]) -> [f64; 4] {
    let [mut real, mut imaginary] = [[0.0; LANES]; 2];
    let [mut real_imaginary, mut imaginary_real] = [[0.0; LANES]; 2];
    for start in (0..BLOCK).step_by(LANES) {
        for lane in 0..LANES {
            let place = start + lane;
            real[lane] += a[0][place] * b[0][place];
            imaginary[lane] += a[1][place] * b[1][place];
            real_imaginary[lane] += a[0][place] * b[1][place];
            imaginary_real[lane] += a[1][place] * b[0][place];
        }
    }
    [real, imaginary, real_imaginary, imaginary_real].map(|lanes| lanes.iter().sum())
}

/// The powers exp(2πi n x) of the bodies of a block for n = 0, 1, …: real and imaginary parts.
struct Powers(Vec<[[f64; BLOCK]; 2]>);

impl Powers {
    /// Room for the powers up to `largest`.
    fn new(largest: usize) -> Self {
        Self(vec![[[0.0; BLOCK]; 2]; largest + 1])
    }

    /// Computes the powers for places x in turns; those that a short block lacks are 0.
    fn set(&mut self, turns: impl Iterator<Item = f64>) {
        let mut first = [[0.0; BLOCK]; 2];
        self.0[0] = [[0.0; BLOCK]; 2];
        for (place, x) in turns.enumerate() {
            let DVec2 { x: cos, y: sin } = Orientation::from_turns(x).cos_sin();
            (first[0][place], first[1][place]) = (cos, sin);
            self.0[0][0][place] = 1.0;
        }
        for n in 1..self.0.len() {
            let [real, imaginary] = self.0[n - 1];
            for place in 0..BLOCK {
                let (cos, sin) = (first[0][place], first[1][place]);
                self.0[n][0][place] = real[place] * cos - imaginary[place] * sin;
                self.0[n][1][place] = real[place] * sin + imaginary[place] * cos;
            }
        }
    }
}

/// The `requested` shells of smallest |k|. The circle of k in which they are searched doubles its
/// area until it holds them.
fn shortest_shells(bounds: &PeriodicBox, requested: usize) -> Vec<Shell> {
    let unit = bounds.sides().recip() * std::f64::consts::TAU;
    let mut radius_squared = unit.min_element() * unit.min_element() * (1.0 + SAME_LENGTH);
    let mut shells = shells_within(unit, radius_squared);
    for _ in 0..MAX_DOUBLINGS {
        if shells.len() >= requested {
            break;
        }
        radius_squared *= 2.0;
        shells = shells_within(unit, radius_squared);
    }
    shells.truncate(requested);
    shells
}

/// All shells with k² up to a limit, in ascending order; `unit` is 2π / L.
fn shells_within(unit: DVec2, radius_squared: f64) -> Vec<Shell> {
    let [across, up] = (radius_squared.sqrt() / unit)
        .floor()
        .to_array()
        .map(|most| most as i64);
    // The half plane n_y > 0 and the half axis n_x > 0 have one of each pair k and −k.
    let half_plane = (0..=up).flat_map(|y| (-across..=across).map(move |x| [x, y]));
    let mut vectors: Vec<(f64, [i64; 2])> = half_plane
        .filter(|&[x, y]| y > 0 || x > 0)
        .map(|[x, y]| {
            (
                (unit * DVec2::new(x as f64, y as f64)).length_squared(),
                [x, y],
            )
        })
        .filter(|&(squared, _)| squared <= radius_squared)
        .collect();
    vectors.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut shells: Vec<Shell> = Vec::new();
    for (squared, vector) in vectors {
        match shells.last_mut() {
            Some(last) if squared <= last.wave_number * last.wave_number * (1.0 + SAME_LENGTH) => {
                last.vectors.push(vector);
            }
            _ => shells.push(Shell {
                wave_number: squared.sqrt(),
                vectors: vec![vector],
                sum: 0.0,
            }),
        }
    }
    shells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::random_points;
    use carom_engine::{BumperSpec, Scene, Simulation};

    fn observe(scenes: &[Scene], shells: usize) -> StructureFactor {
        let bounds = *Simulation::new(&scenes[0]).unwrap().view().bounds();
        let mut structure = StructureFactor::new([Group::All; 2], &bounds, shells).unwrap();
        for scene in scenes {
            structure.sample(&Simulation::new(scene).unwrap().view());
        }
        structure
    }

    #[test]
    fn a_square_lattice_has_bragg_peaks_and_nothing_else() {
        let mut scene = Scene::default();
        scene.bounds.sides = [2.0, 2.0];
        let sites = (0..64).map(|site| {
            [
                f64::from(site % 8) * 0.25 + 0.03,
                f64::from(site / 8) * 0.25,
            ]
        });
        scene.bumper = sites
            .map(|at| BumperSpec {
                radius: 0.01,
                at,
                tags: vec![],
            })
            .collect();
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
    fn products_of_powers_are_the_waves_themselves() {
        let places: Vec<DVec2> = (0..37)
            .map(|body| DVec2::new(f64::from(body) * 0.381_966, f64::from(body).sqrt()) % 1.0)
            .collect();
        let vectors = [[1, 0], [0, 1], [-7, 3], [40, 200], [-200, 0], [13, 13]];
        for (found, [x, y]) in sums_of_waves(&places, &vectors).into_iter().zip(vectors) {
            let turns = DVec2::new(x as f64, y as f64);
            let wave = |place: &DVec2| Orientation::from_turns(turns.dot(*place)).cos_sin();
            let direct: DVec2 = places.iter().map(wave).sum();
            assert!(
                (found - direct).length() < 1e-11,
                "{x} {y}: {found} {direct}"
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

    #[test]
    fn partial_structure_factors_add_up_to_the_total() {
        let mut scene = random_points(90, [1.0, 1.5], 4);
        for (index, bumper) in scene.bumper.iter_mut().enumerate() {
            bumper.tags = vec![["a", "b", "b"][index % 3].to_owned()];
        }
        let simulation = Simulation::new(&scene).unwrap();
        let [a, b] = ["a", "b"].map(|name| Group::from(simulation.find_tag(name).unwrap()));
        let observe = |groups: [Group; 2]| {
            let bounds = simulation.view().bounds().to_owned();
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
