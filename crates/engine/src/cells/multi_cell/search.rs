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

use super::{Covering, Listed, Pending, Surroundings};
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
pub(in crate::cells) struct Soonest {
    pub time: f64,
    kind: Kind,
    partner: u32,
    pending: Pending,
}

impl Soonest {
    /// No contact yet, before an event that is certain.
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
    pub(super) fn is_beaten_by(&self, time: f64, partner: u32) -> bool {
        let tie = (time == self.time) & (self.kind == Kind::MultiCell) & (partner < self.partner);
        (time < self.time) | tie
    }

    /// Replaces the event by a contact.
    #[inline]
    pub(super) fn take(&mut self, time: f64, partner: u32, pending: Pending) {
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
        let covering = &self.multi_cell.list[index];
        let mut best = Soonest::before(leaves_shell(covering, now), Kind::Shell);
        if covering.is_disc_among_discs {
            self.done.pairs += self.meet_discs_around(kernel, detection, covering, now, except, &mut best);
            if self.multi_cell.are_large_discs() && detection.decides_discs_in_closed_form() {
                return self.store_event(body, &best);
            }
        }
        let mut around = std::mem::take(&mut self.multi_cell.around);
        around.clear();
        let covering = &self.multi_cell.list[index];
        if !covering.is_disc_among_discs {
            self.gather_discs(covering, &mut around);
        }
        let by_form = covering.is_disc_among_discs && detection.decides_discs_in_closed_form();
        for neighbour in &covering.neighbours {
            let other = &self.multi_cell.list[neighbour.who as usize];
            if !(by_form && other.is_disc_among_discs) {
                around.seen.push(Listed { who: other.body, image: neighbour.image });
            }
        }
        let outline = world.bodies()[body as usize].kind.molecule.outline();
        let query_body = QueryBody::new(outline, &covering.motion, now);
        let horizon = best.time - now;
        let query = self.question_of_covering(body, now);
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
                |lane| (Some(eight[lane]) != except).then_some(Listed { who: eight[lane], image: [0; 2] }),
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
                |lane| some.get(lane).copied().filter(|other| Some(other.who) != except),
            );
        }
        // Lowest bound first: most candidates then need no search.
        while let Some(candidate) = candidates.take_least(|listed| listed.who) {
            let Candidate { bound, who: other, is_close } = candidate;
            if !best.is_after(now, bound) || now + bound >= self.limit {
                break;
            }
            if !is_close && world.bodies()[other.who as usize].kind.molecule.is_disc() {
                let lanes = self.lanes::<1>(body, &[other], now);
                let closer = detection.contact_time_lower_bound(&query_body, &lanes, horizon);
                if closer > bound {
                    candidates.push(Candidate { bound: closer, is_close: true, ..candidate });
                    continue;
                }
            }
            self.search(world, detection, body, &candidate, now, &mut best);
        }
        self.multi_cell.around = around;
        self.store_event(body, &best);
    }

    /// Collects the discs around a multi-cell body from the neighbour lists of its tiles.
    fn gather_discs(&self, covering: &Covering, around: &mut Surroundings) {
        for tile in &covering.tiles {
            let list = self.neighbour_lists.list_of(tile.who);
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
        let seen = self.neighbour_lists.seen_from(tile.who);
        seen.map(move |(who, image)| Listed { who, image: [image[0] + x, image[1] + y] })
    }

    /// Finds contacts of a disc with the multi-cell bodies listed in its cell, all of them large
    /// discs, before its present event. Returns the time of its earliest event.
    #[inline(never)]
    pub(in crate::cells) fn meet_large_discs(&mut self, disc: u32, cell: u32, now: f64) -> f64 {
        let mut best = self.soonest_so_far(disc);
        for place in 0..self.multi_cell.covered.count(cell) {
            let Listed { who, image } = self.multi_cell.covered.get(cell, place);
            // `image` is that of the disc as seen from the large disc; the other way it has the
            // opposite sign.
            self.ask_large_disc(disc, Listed { who, image: image.map(|boxes| -boxes) }, now, &mut best);
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
    pub(in crate::cells) fn meet_coverings<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        disc: u32,
        cell: u32,
        now: f64,
        except: Option<u32>,
    ) {
        simd::meet_listed(self, world, detection, disc, cell, now, except);
    }

    /// Implementation of [`Self::search_covered_cell`] for one instruction set.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the kernel, of size 0, is the eighth")]
    pub(in crate::cells) fn meet_listed<D: Detection, K: Kernel>(
        &mut self,
        _: K,
        world: &World,
        detection: &D,
        disc: u32,
        cell: u32,
        now: f64,
        except: Option<u32>,
    ) {
        let mut best = self.soonest_so_far(disc);
        // One horizon for all bodies: the bounds must not depend on the order of the tests.
        let horizon = best.time - now;
        for place in 0..self.multi_cell.covered.count(cell) {
            let listed = self.multi_cell.covered.get(cell, place);
            let other = listed.who;
            if Some(other) == except {
                continue;
            }
            // `listed.image` is that of the disc as seen from the multi-cell body; the other way it
            // has the opposite sign.
            let image = listed.image.map(|boxes| -boxes);
            let covering = &self.multi_cell.list[self.multi_cell.index_of[other as usize] as usize];
            if covering.is_disc_among_discs && detection.decides_discs_in_closed_form() {
                self.ask_large_disc(disc, Listed { who: other, image }, now, &mut best);
            } else {
                let seen = [Listed { who: disc, image: listed.image }];
                let lanes = self.lanes::<1>(other, &seen, now);
                // Most are excluded by the bounding circle alone, which does not need the
                // molecule's rotation.
                let [entry] = lanes.entry_times();
                if !best.is_after(now, entry) {
                    continue;
                }
                let outline = world.bodies()[other as usize].kind.molecule.outline();
                let query_body = QueryBody::new(outline, &covering.motion, now);
                let is_disc = world.bodies()[disc as usize].kind.molecule.is_disc();
                let closer = if is_disc {
                    detection.contact_time_lower_bound(&query_body, &lanes, horizon)
                } else {
                    detection.contact_time_lower_bounds(&query_body, &lanes, horizon)[0]
                };
                let bound = if closer > entry { closer } else { entry };
                if best.is_after(now, bound) {
                    let candidate = Candidate { bound, who: Listed { who: other, image }, is_close: true };
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
        best: &mut Soonest,
    ) {
        self.done.pairs += 1;
        let Candidate { bound, who: Listed { who: other, image: seen }, .. } = *candidate;
        // The body inserted first is A, so that ties between atoms do not depend on the order of
        // the query.
        let (pair, image) = ordered([body, other], seen);
        let relative = self.relative_motion(world, pair, image, now);
        let outline = |body: u32| world.bodies()[body as usize].kind.molecule.outline();
        let (a, b) = (outline(pair[0]), outline(pair[1]));
        let horizon = best.time.min(self.limit) - now;
        match detection.first_contact_after(bound, a, b, &relative, horizon).outcome {
            Outcome::Free => {}
            Outcome::Contact(contact) => {
                let time = now + contact.time;
                if best.is_beaten_by(time, other) {
                    let image = self.path_image([body, other], seen);
                    best.take(time, other, Pending { parts: contact.touch.into(), image });
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
    fn soonest_so_far(&self, body: u32) -> Soonest {
        let record = &self.records[body as usize];
        let kind = record.kind();
        let pending = match kind {
            Kind::MultiCell => self.multi_cell.pending[body as usize],
            _ => Pending::NOTHING,
        };
        Soonest { time: record.time, kind, partner: record.partner(), pending }
    }

    pub(in crate::cells) fn store_event(&mut self, body: u32, best: &Soonest) {
        let version = self.records[best.partner as usize].version;
        self.records[body as usize].set_event(best.time, best.kind, best.partner, version);
        self.multi_cell.pending[body as usize] = best.pending;
    }

    /// The contact that a body's event stands for.
    pub(in crate::cells) fn contact_of_covering(
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
        image: [i32; 2],
        now: f64,
    ) -> RelativeMotion {
        let (a, b) = (self.motion(pair[0]), self.motion(pair[1]));
        RelativeMotion::between(&a, &b, world.bounds().shift(image.map(i64::from)), now)
    }

    /// Up to `N` bodies as seen from one, as discs of their bounding radii.
    #[inline(always)]
    pub(super) fn lanes<const N: usize>(&self, body: u32, others: &[Listed], now: f64) -> DiscLanes<N> {
        let me = &self.records[body as usize];
        let sides = self.sides;
        let dummy = BodyRecord::dummy();
        let mut lanes = DiscLanes {
            separation: [[0.0; N]; 2],
            velocity: [[0.0; N]; 2],
            cross: [0.0; N],
            contact_distance: [0.0; N],
            separation_error: self.separation_error,
            speed: me.flight[2].abs() + me.flight[3].abs(),
        };
        for lane in 0..N {
            let listed = others.get(lane);
            let record = listed.map_or(&dummy, |listed| &self.records[listed.who as usize]);
            let image = listed.map_or([0; 2], |listed| listed.image);
            let shift = DVec2::from_array([0, 1].map(|axis| f64::from(image[axis]) * sides[axis]));
            let start = record.origin() - me.origin() + shift;
            lanes.set_since(lane, start, record.velocity() - me.velocity(), now, record.radius + me.radius);
        }
        lanes
    }
}

/// Time at which a body's centre leaves its shell (offset in the epoch): slightly early, never
/// late.
fn leaves_shell(covering: &Covering, now: f64) -> f64 {
    let d = covering.motion.position_at(now) - covering.centre;
    let v = covering.motion.velocity;
    let v_squared = v.length_squared();
    if v_squared == 0.0 {
        return f64::INFINITY;
    }
    let shell = covering.shell * (1.0 - 1e-9);
    let b = d.dot(v);
    let inside = (shell * shell - d.length_squared()).max(0.0);
    let root = (b * b + v_squared * inside).sqrt();
    // The later root of |d + v t| = h, in the form without cancellation.
    let stay = if b > 0.0 { inside / (b + root) } else { (root - b) / v_squared };
    now + stay
}
