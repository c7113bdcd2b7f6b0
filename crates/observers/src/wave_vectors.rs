//! Wave vectors of a periodic box in shells of equal length, and Σ exp(i k·x) over bodies,
//! also with weights.
//!
//! The wave vectors are k = 2π (n_x / Lx, n_y / Ly) without k = 0; of k and −k, whose sums are
//! complex conjugates, there is one. In a box with the tilt b they are 2π (n_x / Lx, (n_y − n_x b /
//! Lx) / Ly).

use carom_geometry::PeriodicBox;
use carom_kinematics::Orientation;
use glam::DVec2;

/// The largest relative difference of two k² in one shell: far above the rounding of k², a few
/// 1e-16, and below the distance of different k² in a square box with 10⁴ shells, 1e-5.
const SAME_LENGTH: f64 = 1e-9;

/// Doublings of the area or width that is searched for shells; 2⁶⁴ times the first is never
/// reached.
const MAX_DOUBLINGS: usize = 64;

/// The wave vectors of one length.
#[derive(Debug, Clone)]
pub(crate) struct WaveShell {
    /// |k| (1 / length).
    pub(crate) wave_number: f64,
    /// (n_x, n_y) with n_y ≥ 0, one of each pair k and −k.
    pub(crate) vectors: Vec<[i64; 2]>,
}

/// The `requested` shells of smallest |k|. The circle of k in which they are searched doubles its
/// area until it holds them.
pub(crate) fn shortest_shells(bounds: &PeriodicBox, requested: usize) -> Vec<WaveShell> {
    let unit = bounds.sides().recip() * std::f64::consts::TAU;
    let mut radius_squared = unit.min_element() * unit.min_element() * (1.0 + SAME_LENGTH);
    let mut shells = shells_between(unit, [0.0, radius_squared]);
    for _ in 0..MAX_DOUBLINGS {
        if shells.len() >= requested {
            break;
        }
        radius_squared *= 2.0;
        shells = shells_between(unit, [0.0, radius_squared]);
    }
    shells.truncate(requested);
    shells
}

/// The `requested` shells whose |k| is nearest to `wave_number` (1 / length), in ascending order of
/// |k|. The ring of k in which they are searched doubles its width until it holds them.
///
/// The cost is that of all wave vectors up to `wave_number`, which the caller must limit.
pub(crate) fn nearest_shells(
    bounds: &PeriodicBox,
    wave_number: f64,
    requested: usize,
) -> Vec<WaveShell> {
    let unit = bounds.sides().recip() * std::f64::consts::TAU;
    let mut half_width = unit.min_element();
    let mut shells = Vec::new();
    for _ in 0..MAX_DOUBLINGS {
        let ends = [wave_number - half_width, wave_number + half_width];
        shells = shells_between(unit, ends.map(|end| end.max(0.0) * end.max(0.0)));
        if shells.len() >= requested {
            break;
        }
        half_width *= 2.0;
    }
    let distance = |shell: &WaveShell| (shell.wave_number - wave_number).abs();
    shells.sort_by(|one, other| distance(one).total_cmp(&distance(other)));
    shells.truncate(requested);
    shells.sort_by(|one, other| one.wave_number.total_cmp(&other.wave_number));
    shells
}

/// The wave vectors of a tilted box, (n_x, n_y) with n_y ≥ 0, and for each the index in
/// `wave_numbers` (1 / length, ascending) of that which is nearest to its |k|; those up to the last
/// of them.
pub(crate) fn in_tilted_shells(
    tilted: &PeriodicBox,
    wave_numbers: &[f64],
) -> (Vec<usize>, Vec<[i64; 2]>) {
    let sides = tilted.sides();
    let unit = sides.recip() * std::f64::consts::TAU;
    let most = wave_numbers.last().copied().unwrap_or(0.0);
    let most = most * most * (1.0 + SAME_LENGTH);
    let turns = tilted.tilt() / sides.x;
    let across = (most.sqrt() / unit.x).floor() as i64;
    let (mut shells, mut vectors) = (Vec::new(), Vec::new());
    // The half plane n_x > 0 and the half axis n_y > 0 have one of each pair k and −k.
    for x in 0..=across {
        let along = unit.x * x as f64;
        let (middle, reach) = (
            turns * x as f64,
            (most - along * along).max(0.0).sqrt() / unit.y,
        );
        let lowest = if x == 0 {
            1
        } else {
            (middle - reach).ceil() as i64
        };
        for y in lowest..=(middle + reach).floor() as i64 {
            let k = along.hypot(unit.y * (y as f64 - middle));
            shells.push(nearest_of(wave_numbers, k));
            vectors.push(if y < 0 { [-x, -y] } else { [x, y] });
        }
    }
    (shells, vectors)
}

/// The index of the number in an ascending list that is nearest to a value.
fn nearest_of(numbers: &[f64], value: f64) -> usize {
    let above = numbers.partition_point(|&number| number < value);
    if above == 0 {
        return 0;
    }
    let is_below = above == numbers.len() || value - numbers[above - 1] <= numbers[above] - value;
    if is_below { above - 1 } else { above }
}

/// All shells with k² between two limits, in ascending order; `unit` is 2π / L.
fn shells_between(unit: DVec2, [least, most]: [f64; 2]) -> Vec<WaveShell> {
    let [across, up] = (most.sqrt() / unit)
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
        .filter(|&(squared, _)| (least..=most).contains(&squared))
        .collect();
    vectors.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut shells: Vec<WaveShell> = Vec::new();
    for (squared, vector) in vectors {
        match shells.last_mut() {
            Some(last) if squared <= last.wave_number * last.wave_number * (1.0 + SAME_LENGTH) => {
                last.vectors.push(vector);
            }
            _ => shells.push(WaveShell {
                wave_number: squared.sqrt(),
                vectors: vec![vector],
            }),
        }
    }
    shells
}

/// Bodies whose waves are computed together: whole vector registers, and tables of their powers
/// that fit into the first cache.
const BLOCK: usize = 16;

/// A wave from its factors takes the time of about so many powers.
const POWERS_PER_WAVE: usize = 4;

/// The largest |n_x| or |n_y|.
fn largest(vectors: &[[i64; 2]], axis: usize) -> usize {
    let numbers = vectors.iter().map(|vector| vector[axis].unsigned_abs());
    numbers.max().unwrap_or(0) as usize
}

/// Partial sums of a wave, one for each lane of two vector registers.
const LANES: usize = 4;

/// Σ exp(2πi (n_x x + n_y y)) over places in units of the sides, for each vector (n_x, n_y) with
/// n_y ≥ 0, as real and imaginary part. A wave is a product of powers of exp(2πi x) and exp(2πi y),
/// whose rounding grows with the power: some 1e-16 n. The products for n_x are those for −n_x, with
/// other signs.
///
/// Where the powers up to the largest number cost more than the waves of the vectors themselves,
/// the powers come from two short tables.
pub(crate) fn sums_of_waves(places: &[DVec2], vectors: &[[i64; 2]]) -> Vec<DVec2> {
    sums_of_weighted_waves(places, vectors, |_| 1.0)
}

/// Σ w exp(2πi (n_x x + n_y y)) over places as of [`sums_of_waves`], w the weight of a place by its
/// index.
pub(crate) fn sums_of_weighted_waves(
    places: &[DVec2],
    vectors: &[[i64; 2]],
    weight: impl Fn(usize) -> f64,
) -> Vec<DVec2> {
    if largest(vectors, 0) + largest(vectors, 1) > POWERS_PER_WAVE * vectors.len() {
        sums_by_factors(places, vectors, weight)
    } else {
        sums_by_powers(places, vectors, weight)
    }
}

/// Σ w exp(2πi (n_x x + n_y y)) over places by products of two powers along each axis.
fn sums_by_factors(
    places: &[DVec2],
    vectors: &[[i64; 2]],
    weight: impl Fn(usize) -> f64,
) -> Vec<DVec2> {
    let [mut across, mut up] = [0, 1].map(|axis| Factors::new(largest(vectors, axis)));
    let mut sums = vec![DVec2::ZERO; vectors.len()];
    for (block, begin) in places.chunks(BLOCK).zip((0..).step_by(BLOCK)) {
        across.set(block.iter().map(|place| (place.x, 1.0)));
        up.set(
            (begin..)
                .zip(block)
                .map(|(index, place)| (place.y, weight(index))),
        );
        for (sum, &[x, y]) in sums.iter_mut().zip(vectors) {
            let [real, imaginary] = product(&across.wave(x), &up.wave(y));
            *sum += DVec2::new(real.iter().sum(), imaginary.iter().sum());
        }
    }
    sums
}

/// Σ w exp(2πi (n_x x + n_y y)) over places by products of powers.
fn sums_by_powers(
    places: &[DVec2],
    vectors: &[[i64; 2]],
    weight: impl Fn(usize) -> f64,
) -> Vec<DVec2> {
    let mut pairs: Vec<[usize; 2]> = vectors
        .iter()
        .map(|vector| vector.map(|number| number.unsigned_abs() as usize))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let [mut across, mut up] = [0, 1].map(|axis| Powers::new(largest(vectors, axis)));
    let mut sums = vec![[0.0; 4]; pairs.len()];
    for (block, begin) in places.chunks(BLOCK).zip((0..).step_by(BLOCK)) {
        across.set(block.iter().map(|place| (place.x, 1.0)));
        up.set(
            (begin..)
                .zip(block)
                .map(|(index, place)| (place.y, weight(index))),
        );
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

    /// Computes the powers for places x in turns, times a weight; those that a short block lacks
    /// are 0.
    fn set(&mut self, turns: impl Iterator<Item = (f64, f64)>) {
        let mut first = [[0.0; BLOCK]; 2];
        self.0[0] = [[0.0; BLOCK]; 2];
        for (place, (x, weight)) in turns.enumerate() {
            let DVec2 { x: cos, y: sin } = Orientation::from_turns(x).cos_sin();
            (first[0][place], first[1][place]) = (cos, sin);
            self.0[0][0][place] = weight;
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

/// Two tables of powers, exp(2πi n x) = exp(2πi (n mod s) x) exp(2πi ⌊n/s⌋ s x), s a power of two
/// near the root of the largest n.
struct Factors {
    stride: usize,
    low: Powers,
    high: Powers,
}

impl Factors {
    /// Room for the powers up to `largest`.
    fn new(largest: usize) -> Self {
        let stride = 1 << largest.max(1).ilog2().div_ceil(2);
        Self {
            stride,
            low: Powers::new(stride - 1),
            high: Powers::new(largest / stride),
        }
    }

    /// Computes the powers for places x in turns, times a weight.
    fn set(&mut self, turns: impl Iterator<Item = (f64, f64)> + Clone) {
        // Exact: the stride is a power of two.
        let stride = self.stride as f64;
        self.high
            .set(turns.clone().map(|(x, weight)| (x * stride, weight)));
        self.low.set(turns.map(|(x, _)| (x, 1.0)));
    }

    /// exp(2πi n x) of the bodies of the block, |n| up to the largest.
    fn wave(&self, n: i64) -> [[f64; BLOCK]; 2] {
        let power = n.unsigned_abs() as usize;
        let (low, high) = (power % self.stride, power / self.stride);
        let [real, mut imaginary] = product(&self.low.0[low], &self.high.0[high]);
        if n < 0 {
            for part in &mut imaginary {
                *part = -*part;
            }
        }
        [real, imaginary]
    }
}

/// The products of two numbers for each body of a block: real and imaginary parts.
fn product(a: &[[f64; BLOCK]; 2], b: &[[f64; BLOCK]; 2]) -> [[f64; BLOCK]; 2] {
    let [mut real, mut imaginary] = [[0.0; BLOCK]; 2];
    for place in 0..BLOCK {
        real[place] = a[0][place] * b[0][place] - a[1][place] * b[1][place];
        imaginary[place] = a[0][place] * b[1][place] + a[1][place] * b[0][place];
    }
    [real, imaginary]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_powers_are_the_waves_themselves() {
        let places: Vec<DVec2> = (0..37)
            .map(|body| DVec2::new(f64::from(body) * 0.381_966, f64::from(body).sqrt()) % 1.0)
            .collect();
        let vectors = [[1, 0], [0, 1], [-7, 3], [40, 200], [-200, 0], [13, 13]];
        let weight = |place: usize| (place as f64).cos();
        let by_powers = sums_by_powers(&places, &vectors, |_| 1.0);
        let by_factors = sums_by_factors(&places, &vectors, |_| 1.0);
        let weighted_by_powers = sums_by_powers(&places, &vectors, weight);
        let weighted_by_factors = sums_by_factors(&places, &vectors, weight);
        for (index, [x, y]) in vectors.into_iter().enumerate() {
            let turns = DVec2::new(x as f64, y as f64);
            let wave = |place: &DVec2| Orientation::from_turns(turns.dot(*place)).cos_sin();
            let direct: DVec2 = places.iter().map(wave).sum();
            let weighted: DVec2 = (0..)
                .zip(&places)
                .map(|(index, place)| weight(index) * wave(place))
                .sum();
            for (found, expected) in [
                (by_powers[index], direct),
                (by_factors[index], direct),
                (weighted_by_powers[index], weighted),
                (weighted_by_factors[index], weighted),
            ] {
                assert!(
                    (found - expected).length() < 1e-11,
                    "{x} {y}: {found} {expected}"
                );
            }
        }
    }

    /// All shells of a square box and a long one, by their distance from k.
    #[test]
    fn the_nearest_shells_are_found() {
        for (sides, wave_number) in [([1.0, 1.0], 70.0), ([1.0, 1.0], 1.0), ([40.0, 0.5], 13.0)] {
            let bounds = PeriodicBox::new(DVec2::from(sides)).unwrap();
            let found = nearest_shells(&bounds, wave_number, 7);
            let mut all: Vec<f64> = shortest_shells(&bounds, 600)
                .iter()
                .map(|shell| shell.wave_number)
                .collect();
            all.sort_by(|a, b| (a - wave_number).abs().total_cmp(&(b - wave_number).abs()));
            let mut nearest = all[..7].to_vec();
            nearest.sort_by(f64::total_cmp);
            let found: Vec<f64> = found.iter().map(|shell| shell.wave_number).collect();
            assert_eq!(found, nearest);
        }
        // |n|² = 25: (5, 0), (0, 5), (±3, 4), (±4, 3).
        let square = PeriodicBox::new(DVec2::ONE).unwrap();
        let five = nearest_shells(&square, 5.0 * std::f64::consts::TAU, 1);
        assert_eq!((five.len(), five[0].vectors.len()), (1, 6));
    }
}
