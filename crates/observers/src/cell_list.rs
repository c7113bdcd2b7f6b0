//! A cell list of positions in a periodic box: the nearest of each, all pairs up to a distance, and
//! all images up to a distance.

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
        Self::with_cells(places, sides, cells)
    }

    /// Cells no narrower than `cutoff`, for [`Self::for_each_pair_within`].
    pub(crate) fn for_cutoff(places: &'a [DVec2], bounds: &PeriodicBox, cutoff: f64) -> Self {
        // Not many more cells than bodies, even for a short cutoff.
        let most = (places.len() as f64).sqrt().ceil().max(1.0);
        let cells = (bounds.sides() / cutoff).floor();
        Self::with_cells(
            places,
            bounds.sides(),
            cells.clamp(DVec2::ONE, DVec2::splat(most)),
        )
    }

    fn with_cells(places: &'a [DVec2], sides: DVec2, cells: DVec2) -> Self {
        let cells = cells.to_array().map(|n| n as usize);
        let mut list = Self {
            places,
            sides,
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
        let place = place / self.sides;
        let axis = |place: f64, cells: usize| ((place * cells as f64) as usize).min(cells - 1);
        [axis(place.x, self.cells[0]), axis(place.y, self.cells[1])]
    }

    /// Collects the squared distances and displacements to the `count` nearest bodies, each in its
    /// nearest image, and to all others as near as the last of them. The search goes in rings of
    /// cells until no body farther out can be a neighbour.
    pub(crate) fn nearest(&self, index: usize, count: usize, found: &mut Vec<(f64, DVec2)>) {
        found.clear();
        let [columns, rows] = self.cells;
        let size = self.sides / DVec2::new(columns as f64, rows as f64);
        let last_ring = columns.max(rows) / 2;
        let mut limit = f64::INFINITY;
        for ring in 0..=last_ring {
            self.collect_ring(index, ring, found);
            // Cells in later rings are at least this far away.
            let reached = ring as f64 * size.min_element();
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
                        let nearest =
                            displacement - self.sides * (displacement / self.sides).round();
                        found.push((nearest.length_squared(), nearest));
                    }
                }
            }
        }
    }

    /// Calls `f` with the indices of each ordered pair closer than `cutoff`, less than half the
    /// shorter side, and its squared distance.
    pub(crate) fn for_each_pair_within(&self, cutoff: f64, mut f: impl FnMut([usize; 2], f64)) {
        let [columns, rows] = self.cells;
        let cutoff_squared = cutoff * cutoff;
        for cell in 0..columns * rows {
            for other in self.cells_near([cell % columns, cell / columns]) {
                for i in self.members_of(cell) {
                    for j in self.members_of(other).filter(|&j| j != i) {
                        let squared = self.squared_distance(self.sorted[i], j);
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
    /// is one of them, and its images are if the box is as narrow as `range`.
    pub(crate) fn for_each_image_near(
        &self,
        index: usize,
        range: f64,
        mut f: impl FnMut(usize, [i64; 2], DVec2),
    ) {
        let [columns, rows] = self.cells.map(|cells| cells as i64);
        let size = self.sides / DVec2::new(columns as f64, rows as f64);
        let place = self.places[index];
        let reach = DVec2::splat(range) + CELL_ROUNDING * size;
        let [left, bottom] = whole(((place - reach) / size).floor());
        let [right, top] = whole(((place + reach) / size).floor());
        for row in bottom..=top {
            for column in left..=right {
                let image = [column.div_euclid(columns), row.div_euclid(rows)];
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
                let squared = self.squared_distance(place, j);
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
    /// component of the distance is at most half a side.
    fn squared_distance(&self, place: DVec2, sorted: usize) -> f64 {
        let apart = (self.sorted[sorted] - place).abs();
        apart.min(self.sides - apart).length_squared()
    }

    /// The places in `members` of the bodies of a cell.
    fn members_of(&self, cell: usize) -> std::ops::Range<usize> {
        self.begins[cell]..self.begins[cell + 1]
    }
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
