//! The order of orientations with k-fold symmetry: nematic (k = 2), tetratic (k = 4), k-atic.
//!
//! Each body has an angle θ: that of its axis x′, or of the axis of its self-propulsion if it is
//! round. With z = exp(kiθ), Z = Σ z / N of a sample is its order parameter, S_k = |Z| from 0 to 1,
//! and arg(Z) / k the director, known up to multiples of 2π/k (de Gennes & Prost 1993, section 2.1;
//! in two dimensions S₂ is the positive eigenvalue of the tensor ⟨2 u u − 1⟩). For N independent,
//! isotropic orientations ⟨S_k²⟩ = 1/N exactly.
//!
//! * Local order: the mean of cos k(θ_j − θ_i) over the neighbours j of i within a cutoff, averaged
//!   over the bodies that have any. 0 for independent orientations.
//! * g_k(r) = ⟨cos k(θ_j − θ_i)⟩ over the pairs at the distance r, 1 for aligned bodies. With true
//!   long-range order it tends to S_k², with quasi-long-range order it falls as a power of r (D.
//!   Frenkel & R. Eppenga, Phys. Rev. A 31 (1985) 1776).
//! * In time: ⟨cos k(θ(t₀ + t) − θ(t₀))⟩ of a body, and Re ⟨Z(t₀ + t) Z*(t₀)⟩ of the whole group.

use carom_engine::{Observer, View};
use carom_geometry::{GeometryError, PeriodicBox, check_positive};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    CutoffError, Group, Histogram,
    body_frame::axis_of,
    cell_list::CellList,
    hexatic_order::power,
    lags::{Clock, LagSum, LaggedSample, Lags, PairSums},
};

/// Orientational order of k-fold symmetry of a group: global and local, over distances, and in
/// time. Bodies without an axis do not count: walls, and round bodies that nothing drives.
///
/// Samples must be one spacing apart for the correlations in time.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, OrientationalOrder, OrderRanges};
///
/// // Two rods, one a quarter turn from the other: no nematic order, and full tetratic order.
/// let scene = Scene::from_toml(r#"
///     [[molecule]]
///     shape = "dumbbell"
///     atom_radius = 0.05
///     atom_mass = 1.0
///     at = [0.2, 0.2]
///     [[molecule]]
///     shape = "dumbbell"
///     atom_radius = 0.05
///     atom_mass = 1.0
///     at = [0.5, 0.2]
///     orientation = 1.5707963267948966
/// "#)?;
/// let simulation = Simulation::new(&scene)?;
/// let ranges = OrderRanges { near: 0.4, far: 0.4, bins: 4, spacing: 1.0, longest: 1.0 };
/// for (k, expected) in [(2, 0.0), (4, 1.0)] {
///     let mut order = OrientationalOrder::new(Group::All, k, &simulation.view().bounds(), ranges)?;
///     order.sample(&simulation.view());
///     assert!((order.series()[0].global - expected).abs() < 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "nematic")]
#[doc(alias = "tetratic")]
#[doc(alias = "k-atic")]
pub struct OrientationalOrder {
    group: Group,
    k: u32,
    bounds: PeriodicBox,
    /// Cutoff of the local order (length).
    near: f64,
    /// Longest distance of g_k (length).
    far: f64,
    series: Vec<OrderPoint>,
    /// Σ over the samples of S_k and S_k².
    global: [f64; 2],
    /// [Σ local order, number of bodies with neighbours] over all samples.
    local: [f64; 2],
    distances: Histogram,
    /// Σ cos k(θ_j − θ_i) in each bin of the distances.
    cosines: Vec<f64>,
    clock: Clock,
    of_body: Lags<DVec2, Product>,
    of_group: Lags<DVec2, Product>,
    passed_over: u64,
}

/// The distances and lags over which orientations are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    clippy::exhaustive_structs,
    reason = "a caller chooses each of the ranges"
)]
pub struct OrderRanges {
    /// Cutoff of the local order (length, less than half the shorter side of the box).
    pub near: f64,
    /// Longest distance of g_k (length, less than half the shorter side of the box).
    pub far: f64,
    /// Bins up to `far`; 0 is taken as 1.
    pub bins: usize,
    /// Time between two samples.
    pub spacing: f64,
    /// Longest lag (time); below one spacing it is taken as one spacing.
    pub longest: f64,
}

/// The order at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OrderPoint {
    /// Time of the sample.
    pub time: f64,
    /// S_k = |mean of exp(kiθ)|, from 0 to 1.
    pub global: f64,
    /// Angle of the director (radian), from −π/k to π/k.
    pub director: f64,
    /// Mean of the local order over the bodies with neighbours, from −1 to 1; `None` without any.
    pub local: Option<f64>,
}

/// The order of pairs in one bin of distances.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PairOrderPoint {
    /// Centre of the bin (length).
    pub distance: f64,
    /// Number of ordered pairs.
    pub pairs: u64,
    /// g_k, from −1 to 1; `None` without pairs.
    pub g: Option<f64>,
}

/// The order at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OrderLagPoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one body at t₀ and at t₀ + t.
    pub pairs: u64,
    /// ⟨cos k(θ(t₀ + t) − θ(t₀))⟩ of a body, from −1 to 1.
    pub of_body: f64,
    /// Re ⟨Z(t₀ + t) Z*(t₀)⟩ of the group; ⟨S_k²⟩ at lag 0.
    pub of_group: f64,
}

/// Σ z(t₀ + t)·z(t₀) over pairs of samples.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Product(f64);

impl PairSums<DVec2> for Product {
    fn add(&mut self, before: &DVec2, now: &DVec2) {
        self.0 += before.dot(*now);
    }
}

impl OrientationalOrder {
    /// Order of k-fold symmetry of the bodies of a group.
    ///
    /// # Errors
    /// [`CutoffError`] if a length or time of `ranges` is not positive and finite, or a length not
    /// less than half the shorter side of the box.
    pub fn new(
        group: Group,
        k: u32,
        bounds: &PeriodicBox,
        ranges: OrderRanges,
    ) -> Result<Self, CutoffError> {
        let half = 0.5 * bounds.sides().min_element();
        let near = check_positive("the cutoff of the local order", ranges.near)?;
        let far = check_positive("the longest distance of g_k", ranges.far)?;
        if let Some(cutoff) = [near, far].into_iter().find(|&cutoff| cutoff >= half) {
            return Err(CutoffError::BeyondHalf { cutoff, half });
        }
        let lags = || -> Result<_, GeometryError> { Lags::new(ranges.spacing, ranges.longest) };
        let (clock, of_body) = lags()?;
        let (_, of_group) = lags()?;
        let distances = Histogram::new(0.0, far, ranges.bins);
        Ok(Self {
            group,
            k,
            bounds: *bounds,
            near,
            far,
            series: Vec::new(),
            global: [0.0; 2],
            local: [0.0; 2],
            cosines: vec![0.0; distances.counts().len()],
            distances,
            clock,
            of_body,
            of_group,
            passed_over: 0,
        })
    }

    /// k.
    pub fn symmetry(&self) -> u32 {
        self.k
    }

    /// Cutoff of the local order (length).
    pub fn near(&self) -> f64 {
        self.near
    }

    /// The samples so far.
    pub fn series(&self) -> &[OrderPoint] {
        &self.series
    }

    /// g_k in each bin from the samples so far.
    pub fn pair_points(&self) -> Vec<PairOrderPoint> {
        let point = |(bin, (&pairs, &cosine)): (usize, (&u64, &f64))| PairOrderPoint {
            distance: self.distances.centre(bin),
            pairs,
            g: (pairs > 0).then(|| cosine / pairs as f64),
        };
        let bins = self.distances.counts().iter().zip(&self.cosines);
        bins.enumerate().map(point).collect()
    }

    /// The correlations in time so far in ascending order of lag, from lag 0 on; lags without pairs
    /// are omitted.
    pub fn lag_points(&self) -> Vec<OrderLagPoint> {
        let of_body = self.of_body.each(&self.clock);
        let of_group = self.of_group.each(&self.clock);
        let mean = |sum: &LagSum<Product>| sum.sums.0 / sum.pairs as f64;
        let lags = of_body.zip(of_group).filter(|((_, sum), _)| sum.pairs > 0);
        lags.map(|((lag, body), (_, group))| OrderLagPoint {
            lag,
            pairs: body.pairs,
            of_body: mean(body),
            of_group: mean(group),
        })
        .collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.of_body.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far: S_k and S_k² (w = 1 for each sample), the local order (w =
    /// 1 for each body with neighbours), g_k in each bin (w the number of pairs), then the
    /// correlation of a body at each of the [lags](Self::lags), and that of the group.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let samples = self.series.len() as f64;
        let bins = self.cosines.iter().zip(self.distances.counts());
        let of_lags = |lags: &Lags<DVec2, Product>| lags.terms([|sums| sums.0]);
        let mut sums: Vec<[f64; 2]> = self.global.map(|sum| [sum, samples]).to_vec();
        sums.push(self.local);
        sums.extend(bins.map(|(&cosine, &pairs)| [cosine, pairs as f64]));
        sums.extend(of_lags(&self.of_body));
        sums.extend(of_lags(&self.of_group));
        sums
    }

    /// The number of samples skipped because their box differs from that of the constructor, or
    /// because no body had an axis.
    pub fn passed_over(&self) -> u64 {
        self.passed_over
    }

    /// Adds the pairs of one sample; returns [Σ local order, number of bodies with neighbours].
    fn add_pairs(&mut self, places: &[DVec2], orders: &[DVec2], bounds: &PeriodicBox) -> [f64; 2] {
        let reach = self.near.max(self.far);
        let cells = CellList::for_cutoff(places, bounds, reach);
        let mut near = vec![[0.0; 2]; places.len()];
        cells.for_each_pair_within(reach, |[i, j], squared| {
            let cosine = orders[i].dot(orders[j]);
            if squared < self.near * self.near {
                near[i][0] += cosine;
                near[i][1] += 1.0;
            }
            let bin = (squared.sqrt() / self.distances.width()) as usize;
            if let Some(sum) = self.cosines.get_mut(bin) {
                *sum += cosine;
                self.distances.add(squared.sqrt());
            }
        });
        let with_neighbours = near.iter().filter(|[_, count]| *count > 0.0);
        with_neighbours.fold([0.0; 2], |[sum, bodies], [cosine, count]| {
            [sum + cosine / count, bodies + 1.0]
        })
    }
}

impl Observer for OrientationalOrder {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let mut places = Vec::new();
        let mut now = Vec::new();
        for body in view.bodies().filter(|body| self.group.contains(body.body)) {
            if let Some(axis) = axis_of(view, &body) {
                places.push(body.motion.position);
                now.push(LaggedSample {
                    id: body.body.id(),
                    state: power(axis, self.k),
                });
            }
        }
        let bounds = view.bounds();
        if bounds.sides() != self.bounds.sides() || places.is_empty() {
            self.passed_over += 1;
            return;
        }
        let orders: Vec<DVec2> = now.iter().map(|sample| sample.state).collect();
        let order = orders.iter().sum::<DVec2>() / orders.len() as f64;
        let [local, bodies] = self.add_pairs(&places, &orders, &bounds);
        let global = order.length();
        self.series.push(OrderPoint {
            time: view.time().to_f64(),
            global,
            director: order.to_angle() / f64::from(self.k),
            local: (bodies > 0.0).then(|| local / bodies),
        });
        self.global[0] += global;
        self.global[1] += global * global;
        self.local[0] += local;
        self.local[1] += bodies;
        let whole = [LaggedSample {
            id: 0,
            state: order,
        }];
        // Both clear their past at a gap.
        let [is_due, _] = [&mut self.of_body, &mut self.of_group]
            .map(|lags| lags.is_due(&self.clock, view.time()));
        if is_due {
            self.of_body.take(&mut self.clock, view.time(), &now);
            self.of_group.take(&mut self.clock, view.time(), &whole);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{MoleculeSpec, Scene, Simulation};

    const RANGES: OrderRanges = OrderRanges {
        near: 0.12,
        far: 0.42,
        bins: 6,
        spacing: 0.5,
        longest: 5.0,
    };

    /// Small dumbbells on a square lattice with 10 columns, at these angles (radian).
    fn scene(sides: [f64; 2], count: usize, angle: impl Fn(usize) -> f64, turning: f64) -> Scene {
        let one = "[[molecule]]\nshape = \"dumbbell\"\natom_radius = 0.001\natom_mass = 1.0\nat = [0.5, 0.5]";
        let one: MoleculeSpec = Scene::from_toml(one).unwrap().molecule.remove(0);
        let mut scene = Scene::default();
        scene.bounds.sides = sides;
        scene.molecule = (0..count)
            .map(|k| MoleculeSpec {
                at: [(k % 10) as f64 / 10.0, (k / 10) as f64 / 10.0 * sides[1]],
                orientation: Some(angle(k)),
                angular_velocity: turning,
                ..one.clone()
            })
            .collect();
        scene
    }

    fn order_of(scene: &Scene, k: u32, ranges: OrderRanges, samples: u32) -> OrientationalOrder {
        let mut simulation = Simulation::new(scene).unwrap();
        let bounds = simulation.view().bounds();
        let mut order = OrientationalOrder::new(Group::All, k, &bounds, ranges).unwrap();
        for sample in 0..samples {
            simulation.run_until(0.5 * f64::from(sample)).unwrap();
            order.sample(&simulation.view());
        }
        order
    }

    #[test]
    fn aligned_bodies_have_order_one_at_all_distances_and_lags() {
        let order = order_of(&scene([1.0; 2], 100, |_| 0.3, 0.0), 2, RANGES, 12);
        let point = order.series()[3];
        assert!((point.global - 1.0).abs() < 1e-12 && (point.director - 0.3).abs() < 1e-12);
        assert!((point.local.unwrap() - 1.0).abs() < 1e-12);
        let pairs = order.pair_points();
        assert_eq!(pairs.iter().map(|bin| bin.pairs).collect::<Vec<_>>()[0], 0);
        // Four at the distance 0.1; four at 0.1414 and four at 0.2.
        assert_eq!([pairs[1].pairs, pairs[2].pairs], [12 * 400, 12 * 800]);
        for bin in pairs.iter().filter(|bin| bin.pairs > 0) {
            assert!((bin.g.unwrap() - 1.0).abs() < 1e-12, "{bin:?}");
        }
        for lag in order.lag_points() {
            assert!((lag.of_body - 1.0).abs() < 1e-12 && (lag.of_group - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn directions_k_fold_apart_are_k_atic_alone() {
        let third = std::f64::consts::TAU / 3.0;
        let of_three = |k| third * (k % 3) as f64 + 0.1;
        for (k, expected) in [(1, 0.0), (2, 0.0), (3, 1.0), (6, 1.0)] {
            let order = order_of(&scene([1.0; 2], 99, of_three, 0.0), k, RANGES, 1);
            let found = order.series()[0].global;
            assert!((found - expected).abs() < 1e-12, "k = {k}: {found}");
        }
        let chess = |k: usize| std::f64::consts::FRAC_PI_2 * ((k + k / 10) % 2) as f64;
        let order = order_of(&scene([1.0; 2], 100, chess, 0.0), 2, RANGES, 1);
        assert!((order.series()[0].local.unwrap() + 1.0).abs() < 1e-12);
        let tetratic = order_of(&scene([1.0; 2], 100, chess, 0.0), 4, RANGES, 1);
        assert!((tetratic.series()[0].local.unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn bodies_that_turn_together_lose_their_direction_and_keep_their_order() {
        let order = order_of(&scene([1.0; 2], 100, |_| 0.0, 0.7), 4, RANGES, 11);
        for lag in order.lag_points() {
            let expected = (4.0 * 0.7 * lag.lag).cos();
            assert!((lag.of_body - expected).abs() < 1e-9, "{lag:?}");
            assert!((lag.of_group - expected).abs() < 1e-9, "{lag:?}");
        }
        assert!(
            order
                .series()
                .iter()
                .all(|point| (point.global - 1.0).abs() < 1e-12)
        );
        let sums = order.sums();
        assert_eq!(sums.len(), 3 + 6 + 2 * order.lags().len());
        assert_eq!(sums[0][1], 11.0);
    }

    #[test]
    fn random_orientations_have_the_mean_square_one_by_their_number() {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for count in [1, 2, 3, 50] {
            let squares = (0..2000).map(|_| {
                let angles: Vec<f64> = (0..count)
                    .map(|_| std::f64::consts::TAU * uniform())
                    .collect();
                let z = angles
                    .iter()
                    .map(|&angle| power(DVec2::from_angle(angle), 3))
                    .sum::<DVec2>();
                (z / f64::from(count)).length_squared()
            });
            let (mean, error) = carom_tables::block_sums::mean_of_series(squares).unwrap();
            let expected = 1.0 / f64::from(count);
            assert!(
                (mean - expected).abs() < 4.0 * error + 1e-12,
                "{count}: {mean} ± {error}"
            );
        }
    }

    #[test]
    fn few_bodies_narrow_boxes_and_discs_give_numbers_or_nothing() {
        for (sides, count) in [([1.0, 0.02], 10), ([1.0; 2], 1), ([1.0; 2], 2)] {
            let half = 0.499 * f64::min(sides[0], sides[1]);
            let ranges = OrderRanges {
                near: half,
                far: half,
                ..RANGES
            };
            let order = order_of(&scene(sides, count, |_| 0.2, 0.0), 2, ranges, 3);
            assert!((order.series()[2].global - 1.0).abs() < 1e-12);
            assert!(order.sums().iter().flatten().all(|sum| sum.is_finite()));
        }
        let discs = Scene::from_toml("[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]").unwrap();
        let order = order_of(&discs, 2, RANGES, 3);
        assert_eq!((order.series().len(), order.passed_over()), (0, 3));
        let bounds = PeriodicBox::new(DVec2::ONE).unwrap();
        let beyond = OrderRanges {
            near: 0.5,
            ..RANGES
        };
        let error = OrientationalOrder::new(Group::All, 2, &bounds, beyond).unwrap_err();
        assert_eq!(
            error,
            CutoffError::BeyondHalf {
                cutoff: 0.5,
                half: 0.5
            }
        );
    }
}
