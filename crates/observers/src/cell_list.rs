//! A cell list of positions in a periodic box: the nearest of each, all pairs up to a distance, and
//! all images up to a distance.
//!
//! # Tilted boxes
//!
//! In a box with the tilt b, sheared or skewed by an earlier shear, the cells are parallelograms:
//! rectangles in x' = x − a y and y, with the slope a = b/Ly. In these coordinates images are at
//! multiples of Lx and Ly, as without a tilt. The tilt is taken within ±Lx/2, which has the same
//! images.
//!
//! 1. Two places at a distance d differ by at most d along y, and by at most d √(1 + a²) along x'
//!    (Cauchy and Schwarz). Cells as long as that have them in adjacent cells, and places that are
//!    n columns or rows apart have at least the distance n times the width over √(1 + a²), or n
//!    times the height.
//! 2. The shortest shift of an image is at least the shorter side: those in the own row are
//!    multiples of Lx, and others differ by Ly or more along y. So at most one image is nearer than
//!    half the shorter side. It is in the row whose distance along y is at most Ly/2, and in the
//!    column whose distance along x is at most Lx/2.

use carom_geometry::PeriodicBox;
use glam::{DVec2, Vec2Swizzles};

/// The largest relative difference of the squares of distances that are taken as equal: far above
/// their rounding, far below any spread in a fluid.
const AS_NEAR: f64 = 1e-9;

/// More than rounding can move a body into another cell, in cells.
const CELL_ROUNDING: f64 = 1e-9;

/// Bodies per cell of the search for the nearest. About nine cells, with 18 bodies, hold six.
const BODIES_PER_CELL: f64 = 2.0;

/// Positions in the order of their cells.
pub(crate) struct CellList<'a> {
    places: &'a [DVec2],
    sides: DVec2,
    /// The box if it is tilted, with a tilt within half a side.
    tilted: Option<PeriodicBox>,
    cells: [usize; 2],
    /// The positions in the order of their cells.
    sorted: Vec<DVec2>,
    /// The index in `places` of each of the sorted.
    members: Vec<usize>,
    /// The index in `members` of the first body of each cell; one more entry than cells.
    begins: Vec<usize>,
}

impl<'a> CellList<'a> {
    /// Cells of about two bodies, for [`Self::nearest`].
    pub(crate) fn for_nearest(places: &'a [DVec2], bounds: &PeriodicBox) -> Self {
        let sides = bounds.sides();
        // Square cells, except in boxes so narrow that one cell is as wide as the box.
        let requested = (places.len() as f64 / BODIES_PER_CELL).max(1.0);
        let shape = (requested * sides / sides.yx()).map(f64::sqrt).floor();
        let cells = shape.clamp(DVec2::ONE, DVec2::splat(requested.floor()));
        Self::with_cells(places, bounds, cells)
    }

    /// Cells no narrower than `cutoff`, for [`Self::for_each_pair_within`].
    pub(crate) fn for_cutoff(places: &'a [DVec2], bounds: &PeriodicBox, cutoff: f64) -> Self {
        // Not many more cells than bodies, even for a short cutoff.
        let most = (places.len() as f64).sqrt().ceil().max(1.0);
        let mut cells = bounds.sides() / cutoff;
        if let Some(tilted) = folded(bounds) {
            cells.x /= stretch(&tilted);
        }
        Self::with_cells(
            places,
            bounds,
            cells.floor().clamp(DVec2::ONE, DVec2::splat(most)),
        )
    }

    fn with_cells(places: &'a [DVec2], bounds: &PeriodicBox, cells: DVec2) -> Self {
        let cells = cells.to_array().map(|n| n as usize);
        let mut list = Self {
            places,
            sides: bounds.sides(),
            tilted: folded(bounds),
            cells,
            sorted: Vec::new(),
            members: (0..places.len()).collect(),
            begins: vec![0; cells[0] * cells[1] + 1],
        };
        let cell_of: Vec<usize> = (0..places.len())
            .map(|index| {
                let [x, y] = list.cell(places[index]);
                x + y * cells[0]
            })
            .collect();
        list.members.sort_by_key(|&index| cell_of[index]);
        list.sorted = list.members.iter().map(|&index| places[index]).collect();
        for &cell in &cell_of {
            list.begins[cell + 1] += 1;
        }
        for cell in 1..list.begins.len() {
            list.begins[cell] += list.begins[cell - 1];
        }
        list
    }

    /// Column and row of a place in the box.
    fn cell(&self, place: DVec2) -> [usize; 2] {
        let mut scaled = place / self.sides;
        if let Some(tilted) = &self.tilted {
            scaled.x = across(tilted, place) / self.sides.x;
            scaled.x -= scaled.x.floor();
        }
        let axis = |place: f64, cells: usize| ((place * cells as f64) as usize).min(cells - 1);
        [axis(scaled.x, self.cells[0]), axis(scaled.y, self.cells[1])]
    }

    /// Collects the squared distances and displacements to the `count` nearest bodies, each in its
    /// nearest image, and to all others as near as the last of them. The search goes in rings of
    /// cells until no body farther out can be a neighbour.
    pub(crate) fn nearest(&self, index: usize, count: usize, found: &mut Vec<(f64, DVec2)>) {
        found.clear();
        let [columns, rows] = self.cells;
        let size = self.sides / DVec2::new(columns as f64, rows as f64);
        let mut width = size.min_element();
        if let Some(tilted) = &self.tilted {
            width = size.y.min(size.x / stretch(tilted));
        }
        let last_ring = columns.max(rows) / 2;
        let mut limit = f64::INFINITY;
        for ring in 0..=last_ring {
            self.collect_ring(index, ring, found);
            // Cells in later rings are at least this far away.
            let reached = ring as f64 * width;
            if found.len() >= count {
                found.select_nth_unstable_by(count - 1, |one, other| one.0.total_cmp(&other.0));
                limit = found[count - 1].0 * (1.0 + AS_NEAR);
                if limit <= reached * reached {
                    break;
                }
            }
        }
        found.retain(|&(squared, _)| squared <= limit);
    }

    /// Adds the bodies in the cells `ring` columns or rows away, and no farther.
    fn collect_ring(&self, index: usize, ring: usize, found: &mut Vec<(f64, DVec2)>) {
        let [columns, rows] = self.cells;
        let [column, row] = self.cell(self.places[index]);
        for (y, up) in near(row, rows, ring) {
            for (x, across) in near(column, columns, ring) {
                if up.max(across) != ring {
                    continue;
                }
                for other in self.members_of(x + y * columns) {
                    if self.members[other] != index {
                        let displacement = self.sorted[other] - self.places[index];
                        let nearest = match &self.tilted {
                            None => displacement - self.sides * (displacement / self.sides).round(),
                            Some(tilted) => tilted.nearest_image(displacement),
                        };
                        found.push((nearest.length_squared(), nearest));
                    }
                }
            }
        }
    }

    /// Calls `f` with the indices of each ordered pair closer than `cutoff`, less than half the
    /// shorter side, and its squared distance.
    pub(crate) fn for_each_pair_within(&self, cutoff: f64, f: impl FnMut([usize; 2], f64)) {
        match &self.tilted {
            None => self.pairs_within(cutoff, |place, j| self.squared_distance(place, j), f),
            Some(tilted) => {
                let squared =
                    |place: DVec2, j: usize| squared_in_tilted(tilted, self.sorted[j] - place);
                self.pairs_within(cutoff, squared, f);
            }
        }
    }

    /// [`Self::for_each_pair_within`] with a function for the squared distance from a place in the
    /// box to one of the sorted.
    #[inline]
    fn pairs_within(
        &self,
        cutoff: f64,
        squared: impl Fn(DVec2, usize) -> f64,
        mut f: impl FnMut([usize; 2], f64),
    ) {
        let [columns, rows] = self.cells;
        let cutoff_squared = cutoff * cutoff;
        for cell in 0..columns * rows {
            for other in self.cells_near([cell % columns, cell / columns]) {
                for i in self.members_of(cell) {
                    for j in self.members_of(other).filter(|&j| j != i) {
                        let squared = squared(self.sorted[i], j);
                        if squared < cutoff_squared {
                            f([self.members[i], self.members[j]], squared);
                        }
                    }
                }
            }
        }
    }

    /// Calls `f` with the index, the image (boxes) and the displacement (length) of each body
    /// within `range` of one, in all its images, and of others in the same cells. The body itself
    /// is one of them, and its images are if the box is as narrow as `range`. Images are those of
    /// the tilt within half a side.
    pub(crate) fn for_each_image_near(
        &self,
        index: usize,
        range: f64,
        mut f: impl FnMut(usize, [i64; 2], DVec2),
    ) {
        let [columns, rows] = self.cells.map(|cells| cells as i64);
        let size = self.sides / DVec2::new(columns as f64, rows as f64);
        let place = self.places[index];
        let mut reach = DVec2::splat(range) + CELL_ROUNDING * size;
        let mut middle = place;
        if let Some(tilted) = &self.tilted {
            reach.x *= stretch(tilted);
            middle.x = across(tilted, place);
        }
        let [left, bottom] = whole(((middle - reach) / size).floor());
        let [right, top] = whole(((middle + reach) / size).floor());
        for row in bottom..=top {
            for column in left..=right {
                let image = [column.div_euclid(columns), row.div_euclid(rows)];
                if let Some(tilted) = &self.tilted {
                    let cell = column.rem_euclid(columns) + row.rem_euclid(rows) * columns;
                    for other in self.members_of(cell as usize) {
                        // The cells hold the image of the body in the parallelogram.
                        let moved = (across(tilted, self.sorted[other]) / self.sides.x).floor();
                        let image = [image[0] - moved as i64, image[1]];
                        let displacement = self.sorted[other] + tilted.shift(image) - place;
                        f(self.members[other], image, displacement);
                    }
                    continue;
                }
                let shift = self.sides * DVec2::new(image[0] as f64, image[1] as f64) - place;
                let cell = column.rem_euclid(columns) + row.rem_euclid(rows) * columns;
                for other in self.members_of(cell as usize) {
                    f(self.members[other], image, self.sorted[other] + shift);
                }
            }
        }
    }

    /// Calls `f` with the index of each body closer than `cutoff`, less than half the shorter side,
    /// to a place in the box, and its squared distance.
    pub(crate) fn for_each_within(&self, place: DVec2, cutoff: f64, mut f: impl FnMut(usize, f64)) {
        for cell in self.cells_near(self.cell(place)) {
            for j in self.members_of(cell) {
                let squared = match &self.tilted {
                    None => self.squared_distance(place, j),
                    Some(tilted) => squared_in_tilted(tilted, self.sorted[j] - place),
                };
                if squared < cutoff * cutoff {
                    f(self.members[j], squared);
                }
            }
        }
    }

    /// A cell and those around it. With one or two cells along a side, each is listed once.
    fn cells_near(&self, [x, y]: [usize; 2]) -> impl Iterator<Item = usize> + use<> {
        let [columns, rows] = self.cells;
        let near = |at: usize, cells: usize| {
            (0..cells.min(3)).map(move |step| (at + cells - 1 + step) % cells)
        };
        near(y, rows).flat_map(move |y| near(x, columns).map(move |x| x + y * columns))
    }

    /// The squared distance from a place in the box to one of the sorted, in its nearest image: a
    /// component of the distance is at most half a side. The box has no tilt.
    fn squared_distance(&self, place: DVec2, sorted: usize) -> f64 {
        let apart = (self.sorted[sorted] - place).abs();
        apart.min(self.sides - apart).length_squared()
    }

    /// The places in `members` of the bodies of a cell.
    fn members_of(&self, cell: usize) -> std::ops::Range<usize> {
        self.begins[cell]..self.begins[cell + 1]
    }
}

/// A tilted box with its tilt within half a side, which has the same images; `None` without a tilt.
pub(crate) fn folded(bounds: &PeriodicBox) -> Option<PeriodicBox> {
    let (tilt, side) = (bounds.tilt(), bounds.sides().x);
    let folded = tilt - side * (tilt / side).round();
    (folded != 0.0).then(|| bounds.tilted(folded))
}

/// The factor between a distance and the length along x − a y that it may take in a tilted box,
/// with a margin for the rounding of places.
fn stretch(tilted: &PeriodicBox) -> f64 {
    (tilted.tilt() / tilted.sides().y).hypot(1.0) * (1.0 + CELL_ROUNDING)
}

/// x − a y of a place (length).
fn across(tilted: &PeriodicBox, place: DVec2) -> f64 {
    place.x - tilted.tilt() / tilted.sides().y * place.y
}

/// The square of a distance in a tilted box by the image that is nearer than half the shorter side,
/// if there is one; otherwise of no image nearer than that.
#[inline]
fn squared_in_tilted(tilted: &PeriodicBox, apart: DVec2) -> f64 {
    let sides = tilted.sides();
    let row = (apart.y / sides.y).round();
    let x = apart.x - row * tilted.tilt();
    let x = x - sides.x * (x / sides.x).round();
    DVec2::new(x, apart.y - row * sides.y).length_squared()
}

fn whole(numbers: DVec2) -> [i64; 2] {
    numbers.to_array().map(|number| number as i64)
}

/// The columns (or rows) up to `ring` away from one, each once, and how far they are.
fn near(at: usize, cells: usize, ring: usize) -> impl Iterator<Item = (usize, usize)> {
    let below = ring.min((cells - 1) / 2);
    let above = ring.min(cells / 2);
    let steps = (1..=below).map(move |step| ((at + cells - step) % cells, step));
    steps.chain((0..=above).map(move |step| ((at + step) % cells, step)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places in a box of these sides, by two irrational steps.
    fn places(count: u32, sides: DVec2) -> Vec<DVec2> {
        let place = |index: u32| {
            let steps = f64::from(index) * DVec2::new(0.754_877_666_246_693, 0.569_840_290_998_053);
            sides * (steps - steps.floor())
        };
        (1..=count).map(place).collect()
    }

    /// All images of a displacement within some boxes.
    fn images(bounds: PeriodicBox, apart: DVec2) -> impl Iterator<Item = DVec2> {
        let images = (-8..=8_i64).flat_map(|row| (-12..=12_i64).map(move |column| [column, row]));
        images.map(move |image| apart + bounds.shift(image))
    }

    const BOXES: [[f64; 3]; 6] = [
        [1.0, 1.0, 0.3],
        [1.0, 1.0, -0.5],
        [1.0, 1.0, 2.8],
        [3.0, 1.0, 1.2],
        [1.0, 2.5, -0.49],
        [4.0, 0.5, -1.9],
    ];

    #[test]
    fn pairs_in_tilted_boxes_are_those_of_all_images() {
        for [width, height, tilt] in BOXES {
            let bounds = PeriodicBox::new(DVec2::new(width, height))
                .unwrap()
                .tilted(tilt);
            let half = 0.5 * bounds.sides().min_element();
            for (count, cutoff) in [(90, 0.999 * half), (90, 0.3 * half), (4, 0.9 * half)] {
                let places = places(count, bounds.sides());
                let mut expected = Vec::new();
                for (i, one) in places.iter().enumerate() {
                    for (j, other) in places.iter().enumerate().filter(|&(j, _)| j != i) {
                        let near = images(bounds, *other - *one)
                            .map(DVec2::length_squared)
                            .filter(|&squared| squared < cutoff * cutoff);
                        expected.extend(near.map(|squared| ([i, j], squared)));
                    }
                }
                let cells = CellList::for_cutoff(&places, &bounds, cutoff);
                let mut found = Vec::new();
                cells.for_each_pair_within(cutoff, |pair, squared| found.push((pair, squared)));
                let mut by_place = Vec::new();
                for (i, place) in places.iter().enumerate() {
                    cells.for_each_within(*place, cutoff, |j, squared| {
                        if i != j {
                            by_place.push(([i, j], squared));
                        }
                    });
                }
                assert!(!expected.is_empty() || count == 4);
                for found in [&mut found, &mut by_place] {
                    found.sort_by_key(|(pair, _)| *pair);
                    assert_eq!(found.len(), expected.len(), "{bounds:?} {cutoff}");
                    for (one, other) in found.iter().zip(&expected) {
                        assert_eq!(one.0, other.0);
                        assert!((one.1 - other.1).abs() < 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn the_nearest_in_tilted_boxes_are_those_of_all_images() {
        for [width, height, tilt] in BOXES {
            let bounds = PeriodicBox::new(DVec2::new(width, height))
                .unwrap()
                .tilted(tilt);
            for count in [8, 120] {
                let places = places(count, bounds.sides());
                let cells = CellList::for_nearest(&places, &bounds);
                let mut found = Vec::new();
                for (i, one) in places.iter().enumerate() {
                    let others = places.iter().enumerate().filter(|&(j, _)| j != i);
                    let nearest = |(_, other): (usize, &DVec2)| {
                        let squares = images(bounds, *other - *one).map(DVec2::length_squared);
                        squares.fold(f64::INFINITY, f64::min)
                    };
                    let mut expected: Vec<f64> = others.map(nearest).collect();
                    expected.sort_by(f64::total_cmp);
                    cells.nearest(i, 6, &mut found);
                    found.sort_by(|a, b| a.0.total_cmp(&b.0));
                    for (one, other) in found.iter().zip(&expected[..6]) {
                        assert!((one.0 - other).abs() < 1e-12, "{bounds:?} {i}");
                        assert!((one.1.length_squared() - other).abs() < 1e-12);
                    }
                    assert!(found.len() >= 6);
                }
            }
        }
    }

    #[test]
    fn all_images_in_range_of_a_tilted_box_are_found_once() {
        for [width, height, tilt] in BOXES {
            let bounds = PeriodicBox::new(DVec2::new(width, height))
                .unwrap()
                .tilted(tilt);
            let places = places(30, bounds.sides());
            let cells = CellList::for_nearest(&places, &bounds);
            let range = 0.8 * bounds.sides().min_element();
            for (i, one) in places.iter().enumerate() {
                let mut found = Vec::new();
                cells.for_each_image_near(i, range, |other, image, displacement| {
                    let shift = folded(&bounds).unwrap().shift(image);
                    assert!((places[other] + shift - *one - displacement).length() < 1e-12);
                    if displacement.length() < range {
                        found.push((other, displacement.length_squared()));
                    }
                });
                let mut expected = Vec::new();
                for (j, other) in places.iter().enumerate() {
                    let near = images(bounds, *other - *one).map(DVec2::length_squared);
                    let near = near.filter(|&squared| squared < range * range);
                    expected.extend(near.map(|squared| (j, squared)));
                }
                let order =
                    |a: &(usize, f64), b: &(usize, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
                found.sort_by(order);
                expected.sort_by(order);
                assert_eq!(found.len(), expected.len(), "{bounds:?} {i}");
                for (one, other) in found.iter().zip(&expected) {
                    assert!(one.0 == other.0 && (one.1 - other.1).abs() < 1e-12);
                }
            }
        }
    }
}
