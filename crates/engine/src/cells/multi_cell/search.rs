//! The earliest contact of a multi-cell body: candidates in the order of their lower bounds, each
//! searched up to the earliest event found so far.
//!
//! The broad phase has two steps. The first gives lower bounds for eight bodies at a time, from
//! their bounding circles and the molecule's rectangle ([`Detection::contact_time_lower_bounds`]).
//! The second gives a tighter bound for one disc, from the molecule's atoms, when its bound is the
//! lowest ([`Detection::contact_time_lower_bound`]). A disc in a covered cell tests the multi-cell
//! bodies of the cell one by one: by their bounding circles, then by their atoms.

use carom_detection::{DISC_LANES, Detection, DiscLanes, Outcome, QueryBody};
use carom_kinematics::RelativeMotion;
use glam::DVec2;

use super::{Listed, MultiCellBody, Pending, Surroundings};
use crate::{
    World,
    cells::{
        State,
        body_record::{BodyRecord, Kind},
        candidates::Candidate,
        simd::{self, Kernel},
    },
    scheduler::{ContactEvent, ordered},
};

/// The earliest event found so far for a body.
pub(in crate::cells) struct EarliestEvent {
    pub time: f64,
    kind: Kind,
    partner: u32,
    pending: Pending,
}

impl EarliestEvent {
    /// No contact found yet: without one, the event at `time` is of this kind.
    pub fn before(time: f64, kind: Kind) -> Self {
        Self { time, kind, partner: 0, pending: Pending::NOTHING }
    }

    /// Whether a contact with this lower bound (time from `now`) may precede the event.
    #[inline(always)]
    pub fn is_after(&self, now: f64, bound: f64) -> bool {
        // A contact at the same time may precede it: the partners decide.
        (now + bound <= self.time) & (bound < f64::INFINITY)
    }

    /// Whether a contact precedes the event: it is earlier, or at the same time with a partner
    /// inserted earlier.
    #[inline]
    pub(super) fn is_preceded_by(&self, time: f64, partner: u32) -> bool {
        let tie = (time == self.time) & (self.kind == Kind::MultiCell) & (partner < self.partner);
        (time < self.time) | tie
    }

    /// Replaces the event by a contact.
    #[inline]
    pub(super) fn set_contact(&mut self, time: f64, partner: u32, pending: Pending) {
        *self = Self { time, kind: Kind::MultiCell, partner, pending };
    }

    fn offer_recheck(&mut self, time: f64) {
        if time < self.time {
            (self.time, self.kind, self.partner) = (time, Kind::Recheck, 0);
        }
    }
}

impl State {
    /// Finds the earliest event of a multi-cell body: a contact, a re-check, or the exit from its
    /// shell.
    #[inline(always)]
    pub(in crate::cells) fn predict_multi_cell<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        body: u32,
        now: f64,
        except: Option<u32>,
    ) {
        let Some(index) = self.multi_cell.get(body) else { return };
        if self.multi_cell.list[index].fixed {
            self.records[body as usize].set_event(f64::INFINITY, Kind::Nothing, 0, 0);
            return;
        }
        let multi_cell_body = &self.multi_cell.list[index];
        let mut best = EarliestEvent::before(leaves_shell(multi_cell_body, now), Kind::Shell);
        if multi_cell_body.is_disc_among_discs {
            self.done.pairs +=
                self.search_discs_around(kernel, detection, multi_cell_body, now, except, &mut best);
            if self.multi_cell.are_large_discs() && detection.decides_discs_in_closed_form() {
                return self.store_event(body, &best);
            }
        }
        let mut around = std::mem::take(&mut self.multi_cell.around);
        around.clear();
        let multi_cell_body = &self.multi_cell.list[index];
        if !multi_cell_body.is_disc_among_discs {
            self.gather_discs(multi_cell_body, &mut around);
        }
        let in_closed_form = multi_cell_body.is_disc_among_discs && detection.decides_discs_in_closed_form();
        for neighbour in &multi_cell_body.neighbours {
            let other = &self.multi_cell.list[neighbour.index as usize];
            if !(in_closed_form && other.is_disc_among_discs) {
                around.seen.push(Listed { index: other.body, image: neighbour.image });
            }
        }
        let outline = world.bodies()[body as usize].kind.molecule.outline();
        let query_body = QueryBody::new(outline, &multi_cell_body.motion, now);
        let horizon = best.time - now;
        let query = self.multi_cell_query(body, now);
        let Surroundings { slots, seen, candidates } = &mut around;
        slots.resize(slots.len().next_multiple_of(DISC_LANES), self.dummy());
        for eight in slots.as_chunks::<DISC_LANES>().0 {
            let bounds = detection.contact_time_lower_bounds(
                &query_body,
                &kernel.lanes(&query, eight, false),
                horizon,
            );
            candidates.sift(
                bounds,
                |bound| best.is_after(now, bound),
                |lane| (Some(eight[lane]) != except).then_some(Listed { index: eight[lane], image: [0; 2] }),
            );
        }
        for some in seen.chunks(DISC_LANES) {
            let bounds = detection.contact_time_lower_bounds(
                &query_body,
                &self.lanes::<DISC_LANES>(body, some, now),
                horizon,
            );
            candidates.sift(
                bounds,
                |bound| best.is_after(now, bound),
                |lane| some.get(lane).copied().filter(|other| Some(other.index) != except),
            );
        }
        // Lowest bound first: most candidates then need no search.
        while let Some(candidate) = candidates.take_least(|listed| listed.index) {
            let Candidate { bound, item: other, is_tight } = candidate;
            if !best.is_after(now, bound) || now + bound >= self.limit {
                break;
            }
            if !is_tight && world.bodies()[other.index as usize].kind.molecule.is_disc() {
                let lanes = self.lanes::<1>(body, &[other], now);
                let tighter = detection.contact_time_lower_bound(&query_body, &lanes, horizon);
                if tighter > bound {
                    candidates.push(Candidate { bound: tighter, is_tight: true, ..candidate });
                    continue;
                }
            }
            self.search(world, detection, body, &candidate, now, &mut best);
        }
        self.multi_cell.around = around;
        self.store_event(body, &best);
    }

    /// Collects the discs around a multi-cell body from the neighbour lists of its tiles.
    fn gather_discs(&self, multi_cell_body: &MultiCellBody, around: &mut Surroundings) {
        for tile in &multi_cell_body.tiles {
            let list = self.neighbour_lists.list_of(tile.index);
            if tile.image == [0; 2] && !list.at_border {
                list.append_to(&mut around.slots);
            } else {
                around.seen.extend(self.seen_from(*tile));
            }
        }
    }

    /// The discs seen from a tile of a multi-cell body.
    pub(super) fn seen_from(&self, tile: Listed) -> impl Iterator<Item = Listed> {
        let [x, y] = tile.image;
        let seen = self.neighbour_lists.seen_from(tile.index);
        seen.map(move |(index, image)| Listed { index, image: [image[0] + x, image[1] + y] })
    }

    /// Finds contacts of a disc with the multi-cell bodies listed in its cell, all of them large
    /// discs, before its present event. Returns the time of its earliest event.
    #[inline(never)]
    pub(in crate::cells) fn search_large_discs(&mut self, disc: u32, cell: u32, now: f64) -> f64 {
        let mut best = self.stored_event(disc);
        for place in 0..self.multi_cell.covered.count(cell) {
            let Listed { index, image } = self.multi_cell.covered.get(cell, place);
            // `image` is that of the disc as seen from the large disc; the other way it has the
            // opposite sign.
            self.test_large_disc(disc, Listed { index, image: image.map(|boxes| -boxes) }, now, &mut best);
        }
        if best.kind == Kind::MultiCell {
            self.store_event(disc, &best);
        }
        best.time
    }

    /// Finds contacts of a disc with the multi-cell bodies listed in its cell, before its present
    /// event, and stores the earliest.
    #[cold]
    #[inline(never)]
    pub(in crate::cells) fn search_covered_cell<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        disc: u32,
        cell: u32,
        now: f64,
        except: Option<u32>,
    ) {
        simd::search_listed_bodies(self, world, detection, disc, cell, now, except);
    }

    /// Implementation of [`Self::search_covered_cell`] for one instruction set.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the kernel, of size 0, is the eighth")]
    pub(in crate::cells) fn search_listed_bodies<D: Detection, K: Kernel>(
        &mut self,
        _: K,
        world: &World,
        detection: &D,
        disc: u32,
        cell: u32,
        now: f64,
        except: Option<u32>,
    ) {
        let mut best = self.stored_event(disc);
        // One horizon for all bodies: the bounds must not depend on the order of the tests.
        let horizon = best.time - now;
        for place in 0..self.multi_cell.covered.count(cell) {
            let listed = self.multi_cell.covered.get(cell, place);
            let other = listed.index;
            if Some(other) == except {
                continue;
            }
            // `listed.image` is that of the disc as seen from the multi-cell body; the other way it
            // has the opposite sign.
            let image = listed.image.map(|boxes| -boxes);
            let multi_cell_body = &self.multi_cell.list[self.multi_cell.index_of[other as usize].index()];
            if multi_cell_body.is_disc_among_discs && detection.decides_discs_in_closed_form() {
                self.test_large_disc(disc, Listed { index: other, image }, now, &mut best);
            } else {
                let seen = [Listed { index: disc, image: listed.image }];
                let lanes = self.lanes::<1>(other, &seen, now);
                // Most are excluded by the bounding circle alone, which does not need the
                // molecule's rotation.
                let [entry] = lanes.entry_times();
                if !best.is_after(now, entry) {
                    continue;
                }
                let outline = world.bodies()[other as usize].kind.molecule.outline();
                let query_body = QueryBody::new(outline, &multi_cell_body.motion, now);
                let is_disc = world.bodies()[disc as usize].kind.molecule.is_disc();
                let tighter = if is_disc {
                    detection.contact_time_lower_bound(&query_body, &lanes, horizon)
                } else {
                    detection.contact_time_lower_bounds(&query_body, &lanes, horizon)[0]
                };
                let bound = if tighter > entry { tighter } else { entry };
                if best.is_after(now, bound) {
                    let candidate = Candidate { bound, item: Listed { index: other, image }, is_tight: true };
                    self.search(world, detection, disc, &candidate, now, &mut best);
                }
            }
        }
        if matches!(best.kind, Kind::MultiCell | Kind::Recheck) {
            self.store_event(disc, &best);
        }
    }

    /// Searches the first contact of a body with a candidate, up to the best event so far.
    pub(in crate::cells) fn search<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        body: u32,
        candidate: &Candidate<Listed>,
        now: f64,
        best: &mut EarliestEvent,
    ) {
        self.done.pairs += 1;
        let Candidate { bound, item: Listed { index: other, image: seen }, .. } = *candidate;
        // The body inserted first is A, so that ties between atoms do not depend on the order of
        // the query.
        let (pair, image) = ordered([body, other], seen.map(i64::from));
        let relative = self.relative_motion(world, pair, image, now);
        let outline = |body: u32| world.bodies()[body as usize].kind.molecule.outline();
        let (a, b) = (outline(pair[0]), outline(pair[1]));
        let horizon = best.time.min(self.limit) - now;
        match detection.first_contact_after(bound, a, b, &relative, horizon).outcome {
            Outcome::Free => {}
            Outcome::Contact(contact) => {
                let time = now + contact.time;
                if best.is_preceded_by(time, other) {
                    let image = self.path_image([body, other], seen);
                    best.set_contact(time, other, Pending { parts: contact.touch.into(), image });
                }
            }
            Outcome::FreeUntil(time) => best.offer_recheck((now + time).max(now.next_up())),
            // The pair is predicted again in the next epoch, which starts from other numbers.
            Outcome::OutOfRange => self.done.unresolved += 1,
            Outcome::Unresolved(time) => {
                self.done.unresolved += 1;
                best.offer_recheck((now + time).max(now.next_up()));
            }
        }
    }

    /// The present event of a body.
    #[inline]
    fn stored_event(&self, body: u32) -> EarliestEvent {
        let record = &self.records[body as usize];
        let kind = record.kind();
        let pending = match kind {
            Kind::MultiCell => self.multi_cell.pending[body as usize],
            _ => Pending::NOTHING,
        };
        EarliestEvent { time: record.time, kind, partner: record.partner(), pending }
    }

    pub(in crate::cells) fn store_event(&mut self, body: u32, best: &EarliestEvent) {
        let version = self.records[best.partner as usize].version;
        self.records[body as usize].set_event(best.time, best.kind, best.partner, version);
        self.multi_cell.pending[body as usize] = best.pending;
    }

    /// The contact that a body's event stands for.
    pub(in crate::cells) fn contact_of_multi_cell_body(
        &self,
        owner: u32,
        bodies: [u32; 2],
        time: f64,
    ) -> ContactEvent {
        let pending = self.multi_cell.pending[owner as usize];
        let [a, b] = bodies.map(|body| self.windings[body as usize]);
        let image =
            [0, 1].map(|axis| i64::from(pending.image[axis].wrapping_add(b[axis].wrapping_sub(a[axis]))));
        ContactEvent { time, bodies, image, parts: pending.parts }
    }

    /// The image of the second body, as seen from the one inserted first, along their paths without
    /// periodic wraps.
    pub(super) fn path_image(&self, pair: [u32; 2], image: [i32; 2]) -> [i16; 2] {
        let [asking, other] = pair.map(|body| self.windings[body as usize]);
        let seen =
            [0, 1].map(|axis| (image[axis] as i16).wrapping_sub(other[axis].wrapping_sub(asking[axis])));
        if pair[0] < pair[1] { seen } else { seen.map(i16::wrapping_neg) }
    }

    pub(super) fn relative_motion(
        &self,
        world: &World,
        pair: [u32; 2],
        image: [i64; 2],
        now: f64,
    ) -> RelativeMotion {
        let (a, b) = (self.motion(pair[0]), self.motion(pair[1]));
        RelativeMotion::between(&a, &b, world.bounds().shift(image), now)
    }

    /// Up to `N` bodies as seen from one, as discs of their bounding radii.
    #[inline(always)]
    pub(super) fn lanes<const N: usize>(&self, body: u32, others: &[Listed], now: f64) -> DiscLanes<N> {
        let own = &self.records[body as usize];
        let sides = self.sides;
        let dummy = BodyRecord::dummy();
        let mut lanes = DiscLanes {
            separation: [[0.0; N]; 2],
            velocity: [[0.0; N]; 2],
            cross: [0.0; N],
            contact_distance: [0.0; N],
            separation_error: self.separation_error,
            speed: own.flight[2].abs() + own.flight[3].abs(),
        };
        for lane in 0..N {
            let listed = others.get(lane);
            let record = listed.map_or(&dummy, |listed| &self.records[listed.index as usize]);
            let image = listed.map_or([0; 2], |listed| listed.image);
            let shift = DVec2::from_array([0, 1].map(|axis| f64::from(image[axis]) * sides[axis]));
            let start = record.origin() - own.origin() + shift;
            lanes.set_since(
                lane,
                start,
                record.velocity() - own.velocity(),
                now,
                record.radius() + own.radius(),
            );
        }
        lanes
    }
}

/// Time at which a body's centre leaves its shell (offset in the epoch): slightly early, never
/// late.
fn leaves_shell(multi_cell_body: &MultiCellBody, now: f64) -> f64 {
    let d = multi_cell_body.motion.position_at(now) - multi_cell_body.centre;
    let v = multi_cell_body.motion.velocity;
    let v_squared = v.length_squared();
    if v_squared == 0.0 {
        return f64::INFINITY;
    }
    let shell = multi_cell_body.shell * (1.0 - 1e-9);
    let b = d.dot(v);
    let inside = (shell * shell - d.length_squared()).max(0.0);
    let root = (b * b + v_squared * inside).sqrt();
    // The later root of |d + v t| = h, in the form without cancellation.
    let stay = if b > 0.0 { inside / (b + root) } else { (root - b) / v_squared };
    now + stay
}
