//! Grid of the bodies in the box: finds the body nearest to a given position while a box is filled
//! or edited.

use carom_geometry::{Molecule, PeriodicBox};
use carom_kinematics::Motion;
use glam::DVec2;
use smallvec::SmallVec;

use crate::world::{
    World,
    index_or_none::IndexOrNone,
    pair_table::gap_with_factor,
    tags::Tags,
    wall::{StandingWall, folded},
};

/// Ranges of cells are computed for lengths larger by this factor, so that rounding omits no cell.
const MARGIN: f64 = 1.0 + 1e-9;

/// The contents of the box: bodies of a world, and circles reserved for molecules still to be
/// added.
///
/// The area of a cell is about the area per body. A small body is listed in the cell of its centre,
/// a large one in each cell that its bounding circle touches, a wall in each cell that it passes.
/// So a query costs O(1) for a small molecule, and the construction O(N), for any mixture of sizes.
#[derive(Debug)]
pub(crate) struct Sites {
    counts: [i64; 2],
    side: DVec2,
    /// The first entry of each cell.
    heads: Vec<IndexOrNone>,
    entries: Vec<Entry>,
    circles: Vec<Circle>,
    /// The largest radius among bodies listed by their centre alone (length).
    largest: f64,
    /// The number of bodies for which the cells were chosen.
    planned: usize,
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    standing: Standing,
    /// The image of the box in which this cell touches the body, in boxes.
    image: [i32; 2],
    next: IndexOrNone,
    /// Whether other cells may list the same body.
    is_repeated: bool,
}

/// A place reserved for a molecule.
#[derive(Debug)]
struct Circle {
    centre: DVec2,
    radius: f64,
    /// Tags of the molecule that rules for pairs read.
    tags: Tags,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Standing {
    Body(u32),
    Circle(u32),
}

impl Sites {
    /// Creates cells for the bodies of a world, without listing any.
    pub(crate) fn new(world: &World) -> Self {
        Self::with_more(world, std::iter::empty())
    }

    /// Creates cells for the bodies of a world and more molecules, given as pairs of radius
    /// (length) and count.
    pub(crate) fn with_more(world: &World, more: impl Iterator<Item = (f64, usize)>) -> Self {
        let bounds = world.bounds();
        let bodies = world.bodies().iter().map(|body| (body.reach(), 1));
        let (planned, squares) =
            bodies
                .chain(more)
                .fold((0, 0.0), |(sum, squares), (radius, count)| {
                    (sum + count, squares + count as f64 * radius * radius)
                });
        let planned = planned.max(1);
        // At least the mean size: overlapping fixed bodies would be listed in too many cells.
        let cell = (bounds.area().max(4.0 * squares) / planned as f64).sqrt();
        let most = planned as f64;
        let counts = (bounds.sides() / cell)
            .floor()
            .clamp(DVec2::ONE, DVec2::splat(most));
        let counts = [counts.x as i64, counts.y as i64];
        Self {
            counts,
            side: bounds.sides() / DVec2::new(counts[0] as f64, counts[1] as f64),
            heads: vec![IndexOrNone::NONE; (counts[0] * counts[1]) as usize],
            entries: Vec::new(),
            circles: Vec::new(),
            largest: 0.0,
            planned,
        }
    }

    /// Whether so many more bodies than planned are listed that other cells would be faster.
    pub(crate) fn is_crowded(&self, bodies: usize) -> bool {
        bodies > 4 * self.planned
    }

    /// Lists a body of the world.
    pub(crate) fn add(&mut self, world: &World, index: usize) {
        self.add_with_radius(
            world,
            index,
            world.bodies()[index].kind.molecule.bounding_radius(),
        );
    }

    /// Lists a body of the world that may have this bounding radius (length) when it is found; a
    /// wall keeps its size.
    pub(crate) fn add_with_radius(&mut self, world: &World, index: usize, radius: f64) {
        let is_repeated = world.bodies()[index].is_wall() || !self.is_small(radius);
        for (cell, image) in self.cells_of(world, index, radius) {
            self.put(cell, image, Standing::Body(index as u32), is_repeated);
        }
        if !world.bodies()[index].is_wall() {
            self.note_radius(radius);
        }
    }

    /// Removes a body of the world from the lists; it must have been listed with its present
    /// motion.
    pub(crate) fn remove(&mut self, world: &World, index: usize) {
        let radius = world.bodies()[index].kind.molecule.bounding_radius();
        for (cell, _) in self.cells_of(world, index, radius) {
            let mut before: Option<usize> = None;
            let mut rest = self.heads[cell];
            while let Some(at) = rest.get() {
                let Entry { standing, next, .. } = self.entries[at];
                if standing == Standing::Body(index as u32) {
                    match before {
                        Some(before) => self.entries[before].next = next,
                        None => self.heads[cell] = next,
                    }
                } else {
                    before = Some(at);
                }
                rest = next;
            }
        }
    }

    /// Reserves a circle for a molecule with these tags.
    pub(crate) fn add_circle(
        &mut self,
        bounds: &PeriodicBox,
        place: DVec2,
        molecule: &Molecule,
        tags: &Tags,
    ) {
        let (place, _) = bounds.wrap(place);
        let radius = molecule.bounding_radius();
        let standing = Standing::Circle(self.circles.len() as u32);
        self.circles.push(Circle {
            centre: place,
            radius,
            tags: tags.clone(),
        });
        let is_repeated = !self.is_small(radius);
        for (cell, image) in self.cells_of_circle(place, radius) {
            self.put(cell, image, standing, is_repeated);
        }
        self.note_radius(radius);
    }

    fn put(&mut self, cell: usize, image: [i32; 2], standing: Standing, is_repeated: bool) {
        let next = std::mem::replace(&mut self.heads[cell], IndexOrNone::new(self.entries.len()));
        self.entries.push(Entry {
            standing,
            image,
            next,
            is_repeated,
        });
    }

    fn is_small(&self, radius: f64) -> bool {
        radius <= self.side.min_element()
    }

    fn note_radius(&mut self, radius: f64) {
        if self.is_small(radius) {
            self.largest = self.largest.max(radius);
        }
    }

    fn cells_of(
        &self,
        world: &World,
        index: usize,
        radius: f64,
    ) -> SmallVec<[(usize, [i32; 2]); 1]> {
        let (body, motion) = (&world.bodies()[index], &world.motions()[index]);
        if let Some(wall) = StandingWall::new(body, motion) {
            let cells = wall.cells_within(0.0, self.side);
            return cells.into_iter().map(|cell| self.cell_at(cell)).collect();
        }
        self.cells_of_circle(motion.position, radius)
    }

    fn cells_of_circle(&self, place: DVec2, radius: f64) -> SmallVec<[(usize, [i32; 2]); 1]> {
        if self.is_small(radius) {
            let [x, y] = self.cell(place);
            return SmallVec::from_elem(((y * self.counts[0] + x) as usize, [0; 2]), 1);
        }
        let reach = radius * MARGIN;
        let own = self.cell(place);
        // At most two boxes each way: the grid refuses bodies that reach farther.
        let range = [0, 1].map(|axis| {
            let cell = |place: f64| (place / self.side[axis]).floor() as i64;
            let most = 2 * self.counts[axis];
            let (low, high) = (own[axis] - most, own[axis] + most);
            cell(place[axis] - reach).max(low)..=cell(place[axis] + reach).min(high)
        });
        let [columns, rows] = range;
        let cells = rows.flat_map(|y| columns.clone().map(move |x| [x, y]));
        cells.map(|cell| self.cell_at(cell)).collect()
    }

    /// The index of a cell of an image, and the image in boxes.
    fn cell_at(&self, cell: [i64; 2]) -> (usize, [i32; 2]) {
        let ([x, y], image) = folded(cell, self.counts);
        ((y * self.counts[0] + x) as usize, image)
    }

    /// Column and row of the cell of a position in the box.
    fn cell(&self, place: DVec2) -> [i64; 2] {
        [0, 1].map(|axis| ((place[axis] / self.side[axis]) as i64).clamp(0, self.counts[axis] - 1))
    }

    /// The body whose surface is nearest to (or deepest inside) a molecule with these tags, among
    /// the bodies that it sees and whose bounding circles overlap its own, and the gap (length,
    /// negative for an overlap). Reserved circles have the index `usize::MAX`.
    pub(crate) fn nearest(
        &self,
        world: &World,
        molecule: &Molecule,
        motion: &Motion,
        tags: &Tags,
    ) -> Option<(usize, f64)> {
        self.nearest_of(world, molecule, motion, tags, |_| true)
    }

    /// The body nearest to (or deepest inside) a body of the world that is not listed itself, among
    /// the bodies whose bounding circles overlap its own, and the gap (length, negative for an
    /// overlap). A fixed body is compared with moving bodies only, each body with those it sees.
    pub(crate) fn nearest_to_body(&self, world: &World, index: usize) -> Option<(usize, f64)> {
        let (body, motion) = (&world.bodies()[index], &world.motions()[index]);
        let moves = |index: usize| !world.bodies()[index].is_fixed();
        if let Some(wall) = StandingWall::new(body, motion) {
            return self.nearest_to_wall(world, &wall, index);
        }
        let counts = |index| !body.is_fixed() || moves(index);
        self.nearest_of(world, body.molecule(), motion, &body.kind.tags, counts)
    }

    /// The moving body nearest to (or deepest inside) a wall, among those in the cells that the
    /// wall passes.
    fn nearest_to_wall(
        &self,
        world: &World,
        wall: &StandingWall,
        index: usize,
    ) -> Option<(usize, f64)> {
        let (body, motion) = (&world.bodies()[index], &world.motions()[index]);
        let turned = motion.orientation.cos_sin();
        let found = wall
            .cells_within(self.largest, self.side)
            .into_iter()
            .flat_map(|cell| {
                let (cell, away) = self.cell_at(cell);
                self.standing_in(cell).filter_map(
                    move |Entry {
                              standing, image, ..
                          }| {
                        let Standing::Body(index) = standing else {
                            return None;
                        };
                        let other = &world.bodies()[index as usize];
                        let image =
                            [0, 1].map(|axis| i64::from(away[axis]) - i64::from(image[axis]));
                        let counts =
                            other.is_free() && world.pairs.sees(&body.kind.tags, &other.kind.tags);
                        counts.then_some((index as usize, image))
                    },
                )
            });
        let gap = |(other, image): (usize, [i64; 2])| {
            let there = &world.motions()[other];
            let separation = there.position - motion.position + world.bounds().shift(image);
            let molecule = &world.bodies()[other].kind.molecule;
            let rotation = there.orientation.cos_sin();
            let molecules = [&**molecule, body.molecule()];
            (
                other,
                gap_with_factor(1.0, molecules, [rotation, turned], -separation),
            )
        };
        found
            .map(gap)
            .min_by(|one, other| one.1.total_cmp(&other.1))
    }

    fn standing_in(&self, cell: usize) -> impl Iterator<Item = Entry> {
        let entry = |at: IndexOrNone| at.get().map(|at| self.entries[at]);
        std::iter::successors(entry(self.heads[cell]), move |before| entry(before.next))
    }

    /// The index of the body, `usize::MAX` for a circle, with its radius (length) and tags.
    fn described<'a>(&'a self, world: &'a World, standing: Standing) -> (usize, f64, &'a Tags) {
        match standing {
            Standing::Circle(circle) => {
                let Circle { radius, tags, .. } = &self.circles[circle as usize];
                (usize::MAX, *radius, tags)
            }
            Standing::Body(index) => {
                let kind = &world.bodies()[index as usize].kind;
                (index as usize, kind.molecule.bounding_radius(), &kind.tags)
            }
        }
    }

    fn nearest_of(
        &self,
        world: &World,
        molecule: &Molecule,
        motion: &Motion,
        tags: &Tags,
        counts: impl Fn(usize) -> bool,
    ) -> Option<(usize, f64)> {
        let bounds = world.bounds();
        let (place, _) = bounds.wrap(motion.position);
        let rotation = motion.orientation.cos_sin();
        let mut nearest: Option<(usize, f64)> = None;
        // A pair whose contact distance is longer by a factor may overlap beyond its circles.
        let factor = world.pairs.largest_factor();
        let radius = factor * molecule.bounding_radius() + (factor - 1.0) * self.largest;
        self.for_each_near(place, radius, |standing, image| {
            let (index, radius, other_tags) = self.described(world, standing);
            let factor = world.pairs.factor_of_tags(tags, other_tags);
            if factor == 0.0 || !counts(index) {
                return;
            }
            let shift = bounds.shift(image);
            let gap = match standing {
                Standing::Circle(circle) => {
                    let centre = self.circles[circle as usize].centre;
                    let distance = (centre - place + shift).length();
                    distance - factor * radius - factor * molecule.bounding_radius()
                }
                Standing::Body(_) => {
                    let other = &world.bodies()[index].kind.molecule;
                    let there = &world.motions()[index];
                    let separation = there.position - place + shift;
                    let reach = factor * (molecule.bounding_radius() + radius);
                    if !other.is_wall() && separation.length_squared() > reach * reach {
                        return;
                    }
                    gap_with_factor(
                        factor,
                        [molecule, other],
                        [rotation, there.orientation.cos_sin()],
                        separation,
                    )
                }
            };
            if nearest.is_none_or(|(_, least)| gap < least) {
                nearest = Some((index, gap));
            }
        });
        nearest
    }

    /// Calls `visit` for each body whose circle may overlap one of this radius (length) about a
    /// place in the box, with its index and the separation from the place to its image (length).
    pub(crate) fn for_each_body_near(
        &self,
        world: &World,
        place: DVec2,
        radius: f64,
        mut visit: impl FnMut(usize, DVec2),
    ) {
        self.for_each_near(place, radius, |standing, image| {
            if let Standing::Body(index) = standing {
                let there = world.motions()[index as usize].position;
                visit(index as usize, there - place + world.bounds().shift(image));
            }
        });
    }

    /// Calls `visit` once for each image of a body or circle that may overlap a circle of this
    /// radius (length) about a place in the box.
    fn for_each_near(&self, place: DVec2, radius: f64, mut visit: impl FnMut(Standing, [i64; 2])) {
        if self.entries.is_empty() {
            return;
        }
        let [x, y] = self.cell(place);
        let reach = (radius + self.largest) * MARGIN;
        let [columns, rows] = [0, 1].map(|axis| {
            ((reach / self.side[axis]) as i64)
                .saturating_add(1)
                .min(2 * self.counts[axis])
        });
        // A body listed in several cells is visited once.
        let mut seen = SmallVec::<[(Standing, [i64; 2]); 8]>::new();
        for v in y - rows..=y + rows {
            for u in x - columns..=x + columns {
                let (cell, away) = self.cell_at([u, v]);
                for Entry {
                    standing,
                    image,
                    is_repeated,
                    ..
                } in self.standing_in(cell)
                {
                    let image = [0, 1].map(|axis| i64::from(away[axis]) - i64::from(image[axis]));
                    if is_repeated {
                        if seen.contains(&(standing, image)) {
                            continue;
                        }
                        seen.push((standing, image));
                    }
                    visit(standing, image);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scene::{MoleculeSpec, Scene, WallSpec, atom_spec::AtomSpec, gas_spec::GasSpec},
        start::single_bodies,
        world::tags::TagNames,
    };
    use carom_geometry::gap_between;
    use carom_kinematics::Orientation;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Overlapping fixed discs of very different sizes, molecules and walls, in a box with these
    /// sides.
    fn crowd(random: &mut Pcg64, sides: [f64; 2], count: usize) -> World {
        let mut world = World::new(PeriodicBox::new(DVec2::from(sides)).unwrap());
        let mut names = TagNames::default();
        let side = sides[0].min(sides[1]);
        for number in 0..count {
            let at = [
                sides[0] * random.random::<f64>(),
                sides[1] * random.random::<f64>(),
            ];
            if number % 50 == 0 {
                let to = [
                    at[0] + sides[0] * random.random::<f64>(),
                    at[1] + side * random.random::<f64>(),
                ];
                let wall = WallSpec {
                    from: Some(at),
                    to: Some(to),
                    ..WallSpec::default()
                };
                single_bodies::add_wall(&mut world, &mut names, &wall, "wall").unwrap();
                continue;
            }
            let radius = 0.2 * side * random.random::<f64>().powi(12);
            let atom = |x| AtomSpec {
                at: [x, 0.0],
                radius,
                mass: 1.0,
            };
            let atoms = if number % 3 == 0 {
                vec![atom(-radius), atom(radius)]
            } else {
                vec![atom(0.0)]
            };
            let orientation_turns = Some(random.random());
            let molecule = MoleculeSpec {
                atoms,
                at,
                orientation_turns,
                fixed: true,
                ..MoleculeSpec::default()
            };
            single_bodies::add_molecule(&mut world, &mut names, &molecule, "molecule").unwrap();
        }
        world
    }

    /// The deepest overlap over all bodies in all images (length, negative); `None` if there is
    /// none.
    fn deepest(
        world: &World,
        listed: &[bool],
        molecule: &Molecule,
        motion: &Motion,
    ) -> Option<f64> {
        let (place, _) = world.bounds().wrap(motion.position);
        let gaps = (0..world.bodies().len())
            .filter(|&index| listed[index])
            .flat_map(|index| {
                let (other, there) = (
                    &world.bodies()[index].kind.molecule,
                    &world.motions()[index],
                );
                (0..49).map(move |image| {
                    let separation = there.position - place
                        + world.bounds().shift([image % 7 - 3, image / 7 - 3]);
                    let rotations = [motion, there].map(|motion| motion.orientation.cos_sin());
                    gap_between(molecule, rotations[0], other, rotations[1], separation)
                })
            });
        gaps.reduce(f64::min).filter(|&gap| gap < 0.0)
    }

    #[test]
    fn the_nearest_body_agrees_with_brute_force_over_all_images() {
        let mut random = Pcg64::seed_from_u64(19);
        let mut overlaps = 0;
        for (sides, count) in [
            ([1.0, 1.0], 300),
            ([40.0, 1.0], 300),
            ([1.0, 7.0], 60),
            ([1.0, 1.0], 2),
        ] {
            let world = crowd(&mut random, sides, count);
            let mut sites = Sites::new(&world);
            (0..count).for_each(|index| sites.add(&world, index));
            let mut listed = vec![true; count];
            for query in 0..400 {
                // Some bodies are removed from the lists between the queries.
                if query % 4 == 3 && listed[query / 4 * 7 % count] {
                    sites.remove(&world, query / 4 * 7 % count);
                    listed[query / 4 * 7 % count] = false;
                }
                let radius = 0.2 * random.random::<f64>().powi(8);
                let molecule = Molecule::named("tee".parse().unwrap(), radius, 1.0).unwrap();
                let place = DVec2::from(sides) * DVec2::new(random.random(), random.random());
                let motion = Motion {
                    orientation: Orientation::from_turns(random.random()),
                    ..Motion::at_rest(place)
                };
                let found = sites
                    .nearest(&world, &molecule, &motion, &Tags::default())
                    .map(|(_, gap)| gap);
                let expected = deepest(&world, &listed, &molecule, &motion);
                let found = found.filter(|&gap| gap < 0.0);
                let agree = match (found, expected) {
                    (Some(found), Some(expected)) => (found - expected).abs() < 1e-14 * sides[0],
                    (None, None) => true,
                    _ => false,
                };
                assert!(
                    agree,
                    "{sides:?}, query {query}: {found:?} for {expected:?}"
                );
                overlaps += usize::from(expected.is_some());
            }
        }
        assert!((200..1500).contains(&overlaps), "{overlaps}");
    }

    #[test]
    fn a_large_body_among_many_small_ones_is_listed_at_most_once_per_cell() {
        let gas = GasSpec {
            radius: Some((1e-3).into()),
            mass: Some(1.0.into()),
            energy: 1.0,
            count: Some(20_000),
            ..GasSpec::default()
        };
        let large = MoleculeSpec {
            atoms: vec![AtomSpec {
                at: [0.0; 2],
                radius: 0.3,
                mass: 1.0,
            }],
            at: [0.5; 2],
            ..MoleculeSpec::default()
        };
        let scene = Scene {
            molecule: vec![large],
            gas: vec![gas],
            ..Scene::default()
        };
        let simulation = crate::Simulation::new(&scene).unwrap();
        let world = &simulation.world;
        let mut sites = Sites::new(world);
        (0..world.bodies().len()).for_each(|index| sites.add(world, index));
        assert!(sites.heads.len() <= world.bodies().len());
        assert!(
            sites.entries.len() <= 3 * world.bodies().len(),
            "{}",
            sites.entries.len()
        );
        // A small disc is compared with its adjacent cells only, for any size of the other bodies.
        assert!(sites.largest < 0.01 && sites.side.min_element() > 1e-3);
    }
}
