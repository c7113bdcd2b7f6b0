//! The bins of a field: the cells of a grid, or layers by the distance from a point or from a
//! straight wall.
//!
//! What a contact carries over the line from one centre to the other is divided among the bins that
//! the line crosses, in proportion to the length in each (Irving & Kirkwood 1950; Todd, Evans &
//! Daivis, Phys. Rev. E 52 (1995) 1627). The shares add up to 1, so that the sum over all bins is
//! what the whole box receives.
//!
//! Vectors and tensors have components along two axes. Those of a grid are x and y. By the distance
//! from a wall the first axis points away from the wall, the second along it (towards larger x or
//! y). By the distance from a point the first axis points away from the point, the second is the
//! first turned by 90° counterclockwise; both change along the line of a contact, over which their
//! products are integrated:
//! with l along the line from the foot of the perpendicular of length p, ρ² = l² + p²,
//! ∫ l²/ρ² dl = l − p atan(l/p), ∫ p l/ρ² dl = p ln ρ, ∫ l/ρ dl = ρ, ∫ p/ρ dl = p asinh(l/p).

use carom_geometry::{GeometryError, PeriodicBox};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::disc_area::{disc_below, disc_in_centred_rectangle, lens};

/// Distances and areas that differ by a smaller share are equal to rounding.
const ROUNDING: f64 = 1e-12;

/// The bins of a field.
///
/// ```
/// use carom_geometry::PeriodicBox;
/// use carom_observers::FieldBins;
/// use glam::DVec2;
///
/// let bounds = PeriodicBox::new(DVec2::new(2.0, 1.0))?;
/// let grid = FieldBins::grid(&bounds, [4, 2])?;
/// assert_eq!((grid.len(), grid.area(0)), (8, 0.25));
/// assert_eq!(grid.bin(DVec2::new(0.6, 0.9)), Some(5));
/// let rings = FieldBins::around_point(&bounds, DVec2::new(0.1, 0.1), 0.5, 5)?;
/// assert!((rings.area(4) - std::f64::consts::PI * (0.25 - 0.16)).abs() < 1e-12);
/// assert_eq!(rings.bin(DVec2::new(1.95, 0.1)), Some(1));
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FieldBins {
    bounds: PeriodicBox,
    layout: Layout,
    /// Area of each bin (length²).
    areas: Vec<f64>,
}

/// How bins are laid out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Layout {
    /// Columns and rows of equal cells; the first bin is at the origin, the next one at larger x.
    Grid([usize; 2]),
    /// Layers of this width (length) by the distance from a point.
    Point { centre: DVec2, width: f64 },
    /// Layers of this width (length) by the distance from the line with this coordinate along an
    /// axis: 0 for x, 1 for y.
    Wall { axis: usize, place: f64, width: f64 },
}

/// The part of what a contact carries that lies in one bin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactPart {
    pub(crate) bin: usize,
    /// r_a J_b for ab = 11, 12, 21, 22 (mass × length² / time).
    pub(crate) momentum: [f64; 4],
    /// r_a ΔE (mass × length³ / time²).
    pub(crate) energy: [f64; 2],
}

impl ContactPart {
    /// What carries this momentum and energy over a way, by components along the axes of the bin.
    fn new(bin: usize, way: DVec2, momentum: DVec2, energy: f64) -> Self {
        let ([x, y], [p, q]) = (way.to_array(), momentum.to_array());
        Self {
            bin,
            momentum: [x * p, x * q, y * p, y * q],
            energy: [x * energy, y * energy],
        }
    }
}

/// What a contact carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Carried {
    /// Where it begins (length).
    pub(crate) from: DVec2,
    /// The way to where it ends (length).
    pub(crate) way: DVec2,
    /// Momentum (mass × length / time).
    pub(crate) momentum: DVec2,
    /// Energy (mass × length² / time²).
    pub(crate) energy: f64,
}

impl FieldBins {
    /// A grid of columns and rows of equal cells over the whole box; `[bins, 1]` is a profile along
    /// x, `[1, bins]` along y.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if a number is 0.
    pub fn grid(bounds: &PeriodicBox, counts: [usize; 2]) -> Result<Self, GeometryError> {
        for count in counts {
            positive("the number of bins", count as f64)?;
        }
        let cells = counts[0] * counts[1];
        Ok(Self {
            bounds: *bounds,
            layout: Layout::Grid(counts),
            areas: vec![bounds.area() / cells as f64; cells],
        })
    }

    /// Layers by the distance from a point up to `longest` (length, positive): rings, which beyond
    /// half the shorter side of the box are cut where another periodic image of the point is
    /// nearer. A layer beyond the farthest place of the box has the area 0.
    ///
    /// # Errors
    /// [`GeometryError`] if the point is not finite, or `longest` or `bins` is not positive.
    pub fn around_point(
        bounds: &PeriodicBox,
        centre: DVec2,
        longest: f64,
        bins: usize,
    ) -> Result<Self, GeometryError> {
        finite("the point", centre.x)?;
        finite("the point", centre.y)?;
        let width = width(longest, bins)?;
        let half = (0.5 * bounds.sides()).to_array();
        let within = |bin: usize| disc_in_centred_rectangle(width * bin as f64, half);
        Ok(Self {
            bounds: *bounds,
            layout: Layout::Point {
                centre: bounds.wrap(centre).0,
                width,
            },
            areas: (0..bins).map(|bin| within(bin + 1) - within(bin)).collect(),
        })
    }

    /// Layers by the distance from the line of all points whose coordinate along `axis` (0 for x, 1
    /// for y) is `place` (length), on both of its sides, up to `longest` (length, positive).
    ///
    /// # Errors
    /// [`GeometryError`] if the place is not finite, or `longest` or `bins` is not positive.
    pub fn beside_wall(
        bounds: &PeriodicBox,
        axis: usize,
        place: f64,
        longest: f64,
        bins: usize,
    ) -> Result<Self, GeometryError> {
        finite("the place of the wall", place)?;
        let width = width(longest, bins)?;
        let axis = axis.min(1);
        let sides = bounds.sides();
        let within = |bin: usize| (width * bin as f64).min(0.5 * sides[axis]);
        let layer = |bin: usize| 2.0 * (within(bin + 1) - within(bin)) * sides[1 - axis];
        Ok(Self {
            bounds: *bounds,
            layout: Layout::Wall {
                axis,
                place: place.rem_euclid(sides[axis]),
                width,
            },
            areas: (0..bins).map(layer).collect(),
        })
    }

    /// Number of bins.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there is no bin: never, but of a damaged file.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Area of a bin (length²); 0 if there is no such bin.
    pub fn area(&self, bin: usize) -> f64 {
        self.areas.get(bin).copied().unwrap_or_default()
    }

    /// Columns and rows of a grid; `None` for layers.
    pub fn counts(&self) -> Option<[usize; 2]> {
        match self.layout {
            Layout::Grid(counts) => Some(counts),
            Layout::Point { .. } | Layout::Wall { .. } => None,
        }
    }

    /// Letters of both axes: x and y, away from a point and turned (r, t), or away from a wall and
    /// along it (n, t).
    pub fn axis_names(&self) -> [&'static str; 2] {
        match self.layout {
            Layout::Grid(_) => ["x", "y"],
            Layout::Point { .. } => ["r", "t"],
            Layout::Wall { .. } => ["n", "t"],
        }
    }

    /// The box.
    pub fn bounds(&self) -> &PeriodicBox {
        &self.bounds
    }

    /// The middle of a bin: x and y of a cell, or the distance of a layer and 0 (length).
    pub fn middle(&self, bin: usize) -> [f64; 2] {
        match self.layout {
            Layout::Grid([columns, _]) => {
                let cell = self.cell_sides();
                let (column, row) = (bin % columns.max(1), bin / columns.max(1));
                [(column as f64 + 0.5) * cell.x, (row as f64 + 0.5) * cell.y]
            }
            Layout::Point { width, .. } | Layout::Wall { width, .. } => {
                [(bin as f64 + 0.5) * width, 0.0]
            }
        }
    }

    /// The bin of a place (length); `None` beyond the last layer.
    pub fn bin(&self, place: DVec2) -> Option<usize> {
        match self.layout {
            Layout::Grid(_) => Some(self.cell(place)),
            Layout::Point { centre, width } => {
                self.layer(self.bounds.nearest_image(place - centre).length(), width)
            }
            Layout::Wall {
                axis,
                place: wall,
                width,
            } => self.layer(self.offset(axis, wall, place).abs(), width),
        }
    }

    /// The first of both axes at a place: a unit vector. The second is it turned by 90°
    /// counterclockwise, but beside a wall, see [`Self::components`].
    fn first_axis(&self, place: DVec2) -> DVec2 {
        match self.layout {
            Layout::Grid(_) => DVec2::X,
            Layout::Point { centre, .. } => {
                let away = self.bounds.nearest_image(place - centre);
                away.try_normalize().unwrap_or(DVec2::X)
            }
            Layout::Wall {
                axis, place: wall, ..
            } => {
                let sign = if self.offset(axis, wall, place) < 0.0 {
                    -1.0
                } else {
                    1.0
                };
                DVec2::AXES[axis] * sign
            }
        }
    }

    /// The components of a vector along both axes at a place.
    pub fn components(&self, place: DVec2, vector: DVec2) -> DVec2 {
        let first = self.first_axis(place);
        let second = match self.layout {
            Layout::Wall { axis, .. } => DVec2::AXES[1 - axis],
            Layout::Grid(_) | Layout::Point { .. } => first.perp(),
        };
        DVec2::new(first.dot(vector), second.dot(vector))
    }

    /// Adds the area of a disc (length²) to the bins that it covers: calls `add` with a bin and the
    /// area in it. By the distance from a point this is exact up to half the shorter side of the
    /// box; what lies beyond counts as a whole in the bin of the centre, or in the nearest one
    /// beyond that distance.
    pub(crate) fn cover(&self, centre: DVec2, radius: f64, add: impl FnMut(usize, f64)) {
        match self.layout {
            Layout::Grid(_) => self.cover_cells(centre, radius, add),
            Layout::Point {
                centre: point,
                width,
            } => {
                let away = self.bounds.nearest_image(centre - point);
                self.cover_rings(away, radius, width, add);
            }
            Layout::Wall { axis, place, width } => {
                let offset = self.offset(axis, place, centre);
                self.cover_layers(offset, radius, (axis, width), add);
            }
        }
    }

    /// Adds the area of a disc, `away` from the point, to the rings about it.
    fn cover_rings(&self, away: DVec2, radius: f64, width: f64, mut add: impl FnMut(usize, f64)) {
        let exact = self.exact_distance();
        let distance = away.length();
        let whole = std::f64::consts::PI * radius * radius;
        let within = |reach: f64| self.area_within(away, radius, reach);
        let first = (((distance - radius).max(0.0) / width) as usize).min(self.len());
        // Near half a side an image of the disc may reach farther in.
        let first = if distance + radius <= exact { first } else { 0 };
        let last = ((distance + radius).min(exact) / width) as usize;
        let mut before = within(first as f64 * width);
        for bin in first..=last.min(self.len().saturating_sub(1)) {
            let here = within(((bin + 1) as f64 * width).min(exact));
            if here > before {
                add(bin, here - before);
            }
            before = here;
        }
        let rest = whole - within(exact);
        let has_bins_beyond = exact < (1.0 - ROUNDING) * width * self.len() as f64;
        if has_bins_beyond
            && distance + radius > exact
            && rest > ROUNDING * whole
            && let Some(bin) = self.layer(distance.max(exact), width)
        {
            add(bin, rest);
        }
    }

    /// Half the shorter side of the box: a point has no image within this distance (length).
    fn exact_distance(&self) -> f64 {
        0.5 * self.bounds.sides().min_element()
    }

    /// The area that all images of a disc, of which the nearest is `away` from a point, have within
    /// `reach` of it (length²).
    fn area_within(&self, away: DVec2, radius: f64, reach: f64) -> f64 {
        let distance = away.length();
        if distance + radius <= self.exact_distance() {
            return lens([radius, reach], distance);
        }
        let image = |x: i32, y: i32| {
            let shift = self.bounds.shift([x.into(), y.into()]);
            lens([radius, reach], (away + shift).length())
        };
        let images = [-1, 0, 1].map(|x| [-1, 0, 1].map(|y| image(x, y)));
        images.iter().flatten().sum()
    }

    /// Adds the area of a disc at this offset from the nearest image of the wall to the layers of
    /// this width on both sides of it.
    fn cover_layers(
        &self,
        offset: f64,
        radius: f64,
        (axis, width): (usize, f64),
        mut add: impl FnMut(usize, f64),
    ) {
        let side = self.bounds.sides()[axis];
        // The part on the other side of the wall, and that beyond half the box.
        let strip = |from: f64, to: f64| {
            disc_below(radius, to - offset, radius) - disc_below(radius, from - offset, radius)
        };
        let layers = |from: f64, to: f64| {
            let images = [-side, 0.0, side];
            let both =
                |shift: f64| strip(from + shift, to + shift) + strip(shift - to, shift - from);
            images.iter().map(|&shift| both(shift)).sum::<f64>()
        };
        let reach = offset.abs();
        let turn = reach + radius > 0.5 * side;
        let first = if turn {
            ((side - reach - radius).min(reach - radius).max(0.0) / width) as usize
        } else {
            ((reach - radius).max(0.0) / width) as usize
        };
        let last = ((reach + radius) / width) as usize;
        for bin in first..=last.min(self.len().saturating_sub(1)) {
            let [from, to] = [bin, bin + 1].map(|edge| (edge as f64 * width).min(0.5 * side));
            let area = layers(from, to);
            if area > 0.0 {
                add(bin, area);
            }
        }
    }

    fn cover_cells(&self, centre: DVec2, radius: f64, mut add: impl FnMut(usize, f64)) {
        let cell = self.cell_sides();
        let [low, high] = [centre - radius, centre + radius].map(|corner| (corner / cell).floor());
        if low == high {
            add(self.cell(centre), std::f64::consts::PI * radius * radius);
            return;
        }
        let (low, high) = (low.as_i64vec2(), high.as_i64vec2());
        for column in low.x..=high.x {
            let [left, right] = [column, column + 1].map(|edge| edge as f64 * cell.x - centre.x);
            let strip = |top: f64| disc_below(radius, right, top) - disc_below(radius, left, top);
            let mut before = 0.0;
            for row in low.y..=high.y {
                let here = strip((row + 1) as f64 * cell.y - centre.y);
                if here > before {
                    add(self.cell_of([column, row]), here - before);
                }
                before = here;
            }
        }
    }

    /// Divides what a contact carries among the bins.
    pub(crate) fn divide(&self, carried: &Carried, add: impl FnMut(ContactPart)) {
        match self.layout {
            Layout::Grid(_) => self.divide_cells(carried, add),
            Layout::Point { centre, width } => self.divide_rings(carried, centre, width, add),
            Layout::Wall { axis, place, width } => {
                self.divide_layers(carried, axis, place, width, add);
            }
        }
    }

    fn divide_cells(&self, carried: &Carried, mut add: impl FnMut(ContactPart)) {
        let cell = self.cell_sides();
        let Carried { from, way, .. } = *carried;
        let [begin, end] = [from, from + way].map(|place| (place / cell).floor());
        let mut cuts = Cuts::default();
        for axis in [0, 1] {
            let (first, last) = (begin[axis].min(end[axis]), begin[axis].max(end[axis]));
            cuts.lines(from[axis], way[axis], cell[axis], [first + 1.0, last]);
        }
        cuts.pieces(|share, middle| {
            let place = from + middle * way;
            let (momentum, energy) = (share * carried.momentum, share * carried.energy);
            add(ContactPart::new(self.cell(place), way, momentum, energy));
        });
    }

    fn divide_layers(
        &self,
        carried: &Carried,
        axis: usize,
        wall: f64,
        width: f64,
        mut add: impl FnMut(ContactPart),
    ) {
        let side = self.bounds.sides()[axis];
        let offset = self.offset(axis, wall, carried.from);
        let step = carried.way[axis];
        let mut cuts = Cuts::default();
        let [low, high] = [offset.min(offset + step), offset.max(offset + step)];
        // Each image of the wall, the middles between two, and the layers between them.
        let (first, last) = ((low / side).floor(), (high / side).ceil());
        let mut image = first;
        while image <= last {
            let at = image * side;
            cuts.at(offset, step, at);
            cuts.at(offset, step, at + 0.5 * side);
            for sign in [-1.0, 1.0] {
                let [near, far] = [low - at, high - at].map(|place| sign * place);
                let (near, far) = (near.min(far).max(0.0), near.max(far).min(0.5 * side));
                let mut layer = (near / width).floor().max(1.0);
                let end = (far / width).floor().min(self.len() as f64);
                while layer <= end {
                    cuts.at(offset, step, at + sign * layer * width);
                    layer += 1.0;
                }
            }
            image += 1.0;
        }
        cuts.pieces(|share, middle| {
            let place = carried.from + middle * carried.way;
            let Some(bin) = self.bin(place) else { return };
            let way = self.components(place, carried.way);
            let momentum = self.components(place, share * carried.momentum);
            add(ContactPart::new(bin, way, momentum, share * carried.energy));
        });
    }

    fn divide_rings(
        &self,
        carried: &Carried,
        centre: DVec2,
        width: f64,
        mut add: impl FnMut(ContactPart),
    ) {
        let Carried { from, way, .. } = *carried;
        let length = way.length();
        if length <= 0.0 {
            return;
        }
        let along = way / length;
        let momentum = [
            along.dot(carried.momentum),
            along.perp().dot(carried.momentum),
        ];
        self.cuts_between_images(from - centre, way)
            .pieces(|share, middle| {
                let [begin, end] = [middle - 0.5 * share, middle + 0.5 * share];
                let place = from + middle * way;
                let away = self.bounds.nearest_image(place - centre);
                let (foot, across) = (away.dot(along), along.perp().dot(away));
                let [start, stop] = [begin, end].map(|at| foot + (at - middle) * length);
                let passing = PassingWay {
                    across,
                    start,
                    stop,
                    momentum,
                    energy: carried.energy,
                };
                passing
                    .cuts_at_rings(width, self.len())
                    .pieces(|share, middle| {
                        let distance = passing.distance(passing.at(middle));
                        if let Some(bin) = self.layer(distance, width) {
                            add(passing.part(bin, share, middle));
                        }
                    });
            });
    }

    /// Cuts a way that begins at this place relative to a point at the lines on which two images of
    /// the point are equally near.
    fn cuts_between_images(&self, from: DVec2, way: DVec2) -> Cuts {
        let sides = self.bounds.sides();
        let mut cuts = Cuts::default();
        for axis in [0, 1] {
            let offset = from[axis] - 0.5 * sides[axis];
            let ends = [offset, offset + way[axis]].map(|place| (place / sides[axis]).floor());
            let (first, last) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            cuts.lines(offset, way[axis], sides[axis], [first + 1.0, last]);
        }
        cuts
    }

    /// Distance from the nearest image of a line, positive towards larger coordinates (length).
    fn offset(&self, axis: usize, line: f64, place: DVec2) -> f64 {
        let side = self.bounds.sides()[axis];
        let offset = place[axis] - line;
        offset - side * (offset / side).round()
    }

    fn layer(&self, distance: f64, width: f64) -> Option<usize> {
        let bin = (distance / width) as usize;
        (bin < self.len()).then_some(bin)
    }

    fn cell_sides(&self) -> DVec2 {
        let [columns, rows] = self.counts().unwrap_or([1, 1]);
        self.bounds.sides() / DVec2::new(columns as f64, rows as f64)
    }

    fn cell(&self, place: DVec2) -> usize {
        let cell = (place / self.cell_sides()).floor().as_i64vec2();
        self.cell_of([cell.x, cell.y])
    }

    fn cell_of(&self, [column, row]: [i64; 2]) -> usize {
        let [columns, rows] = self.counts().unwrap_or([1, 1]);
        let wrapped = |place: i64, count: usize| place.rem_euclid(count.max(1) as i64) as usize;
        wrapped(row, rows) * columns + wrapped(column, columns)
    }
}

/// Where a line from 0 to 1 is cut.
#[derive(Debug, Default)]
struct Cuts(Vec<f64>);

impl Cuts {
    /// Cuts a line that begins at `from` and goes `way` at the coordinate `at`, if it passes there.
    fn at(&mut self, from: f64, way: f64, at: f64) {
        let share = (at - from) / way;
        if share > 0.0 && share < 1.0 {
            self.0.push(share);
        }
    }

    /// Cuts it at the multiples of `spacing` from the first to the last number.
    fn lines(&mut self, from: f64, way: f64, spacing: f64, [first, last]: [f64; 2]) {
        let mut line = first;
        while line <= last {
            self.at(from, way, line * spacing);
            line += 1.0;
        }
    }

    /// Calls `piece` with the share and the middle of each piece.
    fn pieces(mut self, mut piece: impl FnMut(f64, f64)) {
        self.0.sort_by(f64::total_cmp);
        let mut before = 0.0;
        for cut in self.0.into_iter().chain([1.0]) {
            if cut > before {
                piece(cut - before, 0.5 * (before + cut));
                before = cut;
            }
        }
    }
}

/// What is carried along a straight way that passes a point, in the frame of the point and the
/// way.
struct PassingWay {
    /// The distance from the point to the line, positive to the left of it (length).
    across: f64,
    /// Where the way begins and ends along the line; 0 is nearest to the point (length).
    start: f64,
    stop: f64,
    /// Momentum along the way and across it (mass × length / time).
    momentum: [f64; 2],
    /// Energy (mass × length² / time²).
    energy: f64,
}

impl PassingWay {
    /// The place along the line at a share of the way (length).
    fn at(&self, share: f64) -> f64 {
        self.start + share * (self.stop - self.start)
    }

    /// The distance from the point at a place along the line (length).
    fn distance(&self, l: f64) -> f64 {
        l.hypot(self.across)
    }

    /// Cuts the way where it passes from one ring about the point to the next.
    fn cuts_at_rings(&self, width: f64, rings: usize) -> Cuts {
        let Self {
            across,
            start,
            stop,
            ..
        } = *self;
        let mut cuts = Cuts::default();
        let least = if start < 0.0 && stop > 0.0 {
            across.abs()
        } else {
            self.distance(start).min(self.distance(stop))
        };
        let most = self.distance(start).max(self.distance(stop));
        let mut ring = (least / width).floor().max(1.0);
        let end = (most / width).floor().min(rings as f64);
        while ring <= end {
            let radius = ring * width;
            let chord = (radius - across.abs()) * (radius + across.abs());
            if chord > 0.0 {
                for l in [-chord.sqrt(), chord.sqrt()] {
                    cuts.at(start, stop - start, l);
                }
            }
            ring += 1.0;
        }
        cuts
    }

    /// What a piece of the way, given by its share and its middle, carries along the directions
    /// from the point and across them, which turn along the way: an integral over the piece.
    fn part(&self, bin: usize, share: f64, middle: f64) -> ContactPart {
        let (across, [own, other]) = (self.across, self.momentum);
        let piece = share * (self.stop - self.start);
        let centre = self.at(middle);
        let [from, to] = [centre - 0.5 * piece, centre + 0.5 * piece];
        let [near, far] = [from, to].map(|l| self.distance(l));
        let (angle, logarithm, asinh) = if across == 0.0 {
            (0.0, 0.0, 0.0)
        } else {
            (
                across * ((to / across).atan() - (from / across).atan()),
                across * (far / near).ln(),
                across * ((to / across.abs()).asinh() - (from / across.abs()).asinh()),
            )
        };
        let lengthwise = piece - angle;
        ContactPart {
            bin,
            momentum: [
                lengthwise * own + logarithm * other,
                lengthwise * other - logarithm * own,
                -logarithm * own - angle * other,
                angle * own - logarithm * other,
            ],
            energy: [(far - near) * self.energy, -asinh * self.energy],
        }
    }
}

fn width(longest: f64, bins: usize) -> Result<f64, GeometryError> {
    positive("the longest distance", longest)?;
    positive("the number of bins", bins as f64)?;
    let width = longest / bins as f64;
    positive("the width of a bin", width)?;
    Ok(width)
}

fn positive(name: &'static str, value: f64) -> Result<(), GeometryError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(GeometryError::NotPositive { name, value })
}

fn finite(name: &'static str, value: f64) -> Result<(), GeometryError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(GeometryError::OutOfRange { name, value })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn bounds() -> PeriodicBox {
        PeriodicBox::new(DVec2::new(2.0, 1.0)).unwrap()
    }

    fn parts(bins: &FieldBins, carried: &Carried) -> Vec<ContactPart> {
        let mut parts = Vec::new();
        bins.divide(carried, |part| parts.push(part));
        parts
    }

    #[test]
    fn a_contact_across_the_border_is_divided_among_the_cells_on_both_sides() {
        let grid = FieldBins::grid(&bounds(), [4, 2]).unwrap();
        let carried = Carried {
            from: DVec2::new(1.9, 0.25),
            way: DVec2::new(0.4, 0.0),
            momentum: DVec2::new(3.0, 1.0),
            energy: 2.0,
        };
        let found = parts(&grid, &carried);
        assert_eq!(
            found.iter().map(|part| part.bin).collect::<Vec<_>>(),
            [3, 0]
        );
        for (part, share) in found.iter().zip([0.25, 0.75]) {
            assert!((part.momentum[0] - share * 1.2).abs() < 1e-14, "{part:?}");
            assert!((part.momentum[1] - share * 0.4).abs() < 1e-14);
            assert!((part.energy[0] - share * 0.8).abs() < 1e-14);
            assert_eq!(part.momentum[2..], [0.0; 2]);
        }
        // Through a corner region: three cells.
        let oblique = Carried {
            from: DVec2::new(0.4, 0.3),
            way: DVec2::new(0.3, 0.3),
            ..carried
        };
        let cells: Vec<usize> = parts(&grid, &oblique).iter().map(|part| part.bin).collect();
        assert_eq!(cells, [0, 1, 5]);
    }

    /// All layouts: the parts add up to the whole; in rings the trace does, and numerical
    /// quadrature along the line gives each component.
    #[test]
    fn parts_add_up_to_the_whole() {
        let all = [
            FieldBins::grid(&bounds(), [7, 5]).unwrap(),
            FieldBins::around_point(&bounds(), DVec2::new(0.3, 0.2), 1.2, 9).unwrap(),
            FieldBins::beside_wall(&bounds(), 0, 0.4, 1.0, 8).unwrap(),
            FieldBins::beside_wall(&bounds(), 1, 0.1, 0.5, 3).unwrap(),
        ];
        let mut turn = 0.1_f64;
        for _ in 0..200 {
            turn += 0.7;
            let carried = Carried {
                from: DVec2::new(1.0 + 1.3 * turn.sin(), 0.5 + 0.7 * (1.7 * turn).cos()),
                way: DVec2::new((2.3 * turn).cos(), 0.8 * (3.1 * turn).sin()),
                momentum: DVec2::new((5.0 * turn).sin(), (7.0 * turn).cos()),
                energy: 1.5,
            };
            for bins in &all {
                let found = parts(bins, &carried);
                let trace: f64 = found
                    .iter()
                    .map(|part| part.momentum[0] + part.momentum[3])
                    .sum();
                let expected = carried.way.dot(carried.momentum);
                assert!(
                    (trace - expected).abs() < 1e-13,
                    "{trace} {expected} {bins:?}"
                );
                // Quadrature over the bins.
                let steps = 4000;
                let mut sums = vec![[0.0; 6]; bins.len()];
                for step in 0..steps {
                    let share = 1.0 / f64::from(steps);
                    let place = carried.from + (f64::from(step) + 0.5) * share * carried.way;
                    let bin = bins.bin(place).unwrap();
                    let way = bins.components(place, carried.way) * share;
                    let momentum = bins.components(place, carried.momentum);
                    for (sum, value) in sums[bin].iter_mut().zip([
                        way.x * momentum.x,
                        way.x * momentum.y,
                        way.y * momentum.x,
                        way.y * momentum.y,
                        way.x * carried.energy,
                        way.y * carried.energy,
                    ]) {
                        *sum += value;
                    }
                }
                for part in found {
                    let values = part.momentum.iter().chain(&part.energy);
                    for (sum, value) in sums[part.bin].iter_mut().zip(values) {
                        *sum -= value;
                    }
                }
                let worst = sums
                    .iter()
                    .flatten()
                    .fold(0.0_f64, |worst, value| worst.max(value.abs()));
                assert!(worst < 3e-3, "{worst} {carried:?} {bins:?}");
            }
        }
    }

    #[test]
    fn rings_that_leave_the_box_have_their_exact_areas() {
        let rings = FieldBins::around_point(&bounds(), DVec2::new(1.9, 0.9), 1.2, 12).unwrap();
        let total: f64 = (0..12).map(|bin| rings.area(bin)).sum();
        assert!((total - 2.0).abs() < 1e-13, "{total}");
        assert!((rings.area(2) - PI * (0.09 - 0.04)).abs() < 1e-14);
        // 0.6 to 0.7 is cut above and below: points counted on a fine grid.
        let count = 2000;
        let mut found = 0;
        for i in 0..count {
            for j in 0..count {
                let place = DVec2::new(
                    2.0 * (f64::from(i) + 0.5) / f64::from(count),
                    (f64::from(j) + 0.5) / f64::from(count),
                );
                found += u32::from(rings.bin(place) == Some(6));
            }
        }
        let counted = 2.0 * f64::from(found) / f64::from(count * count);
        assert!(
            (rings.area(6) - counted).abs() < 1e-3,
            "{} {counted}",
            rings.area(6)
        );
    }

    #[test]
    fn a_disc_covers_each_bin_by_its_exact_part() {
        let radius = 0.13;
        let all = [
            FieldBins::grid(&bounds(), [9, 6]).unwrap(),
            FieldBins::around_point(&bounds(), DVec2::new(0.3, 0.2), 0.5, 9).unwrap(),
            FieldBins::beside_wall(&bounds(), 0, 0.4, 1.0, 16).unwrap(),
            FieldBins::beside_wall(&bounds(), 1, 0.1, 0.5, 3).unwrap(),
        ];
        for bins in &all {
            for centre in [
                DVec2::new(0.01, 0.98),
                DVec2::new(0.31, 0.22),
                DVec2::new(0.4, 0.6),
                DVec2::new(0.6, 0.4),
                DVec2::new(1.42, 0.1),
                DVec2::new(0.3, 0.68),
            ] {
                let mut covered = vec![0.0; bins.len()];
                bins.cover(centre, radius, |bin, area| covered[bin] += area);
                let steps = 1000;
                for i in 0..steps {
                    for j in 0..steps {
                        let place = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5)
                            * (2.0 * radius / f64::from(steps))
                            - radius;
                        if place.length() < radius
                            && let Some(bin) = bins.bin(centre + place)
                        {
                            covered[bin] -= (2.0 * radius / f64::from(steps)).powi(2);
                        }
                    }
                }
                let worst = covered
                    .iter()
                    .fold(0.0_f64, |worst, value| worst.max(value.abs()));
                assert!(worst < 2e-4, "{worst} {centre} {bins:?}");
            }
        }
    }

    #[test]
    fn what_is_no_number_of_bins_is_refused() {
        assert!(FieldBins::grid(&bounds(), [0, 3]).is_err());
        assert!(FieldBins::around_point(&bounds(), DVec2::ZERO, 0.5, 0).is_err());
        assert!(FieldBins::around_point(&bounds(), DVec2::NAN, 0.5, 3).is_err());
        assert!(FieldBins::beside_wall(&bounds(), 0, 0.0, -1.0, 3).is_err());
    }
}
