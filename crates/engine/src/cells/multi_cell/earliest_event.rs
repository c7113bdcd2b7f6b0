//! The earliest event of a body that searches its candidates one by one, and the search of one
//! pair.

use carom_detection::{Detection, DiscLanes, Outcome};
use carom_kinematics::RelativeMotion;
use glam::DVec2;

use super::{Listed, Pending};
use crate::{
    cells::{
        body_record::{BodyRecord, RecordKind},
        candidates::Candidate,
        frame::{CellFrame, Numbering},
        state::CellState,
    },
    scheduler::{ContactEvent, TouchingParts, ordered},
    world::{World, shear::Seam},
};

/// The earliest event found so far for a body.
pub(in crate::cells) struct EarliestEvent {
    pub time: f64,
    pub kind: RecordKind,
    partner: u32,
    pending: Pending,
}

impl EarliestEvent {
    /// No contact found yet: without one, the event at `time` is of this kind.
    pub fn before(time: f64, kind: RecordKind) -> Self {
        Self {
            time,
            kind,
            partner: 0,
            pending: Pending::NOTHING,
        }
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
    pub(in crate::cells) fn is_preceded_by(&self, time: f64, partner: u32) -> bool {
        let tie =
            (time == self.time) & (self.kind == RecordKind::MultiCell) & (partner < self.partner);
        (time < self.time) | tie
    }

    /// Replaces the event by a contact.
    #[inline]
    pub(in crate::cells) fn set_contact(&mut self, time: f64, partner: u32, pending: Pending) {
        *self = Self {
            time,
            kind: RecordKind::MultiCell,
            partner,
            pending,
        };
    }

    fn offer_recheck(&mut self, time: f64) {
        if time < self.time {
            (self.time, self.kind, self.partner) = (time, RecordKind::Recheck, 0);
        }
    }
}

impl<F: CellFrame> CellState<F> {
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
        self.count_pairs(body, 1);
        let Candidate {
            bound,
            item: Listed {
                index: other,
                image: seen,
            },
            ..
        } = *candidate;
        // The body inserted first is A, so that ties between atoms do not depend on the order of
        // the query.
        let (pair, image) = ordered([body, other], seen.map(i64::from));
        let relative = self.relative_motion(world, pair, image, now);
        let outlines = pair.map(|body| self.molecule(world, body).outline());
        let times = [bound, best.time.min(self.limit) - now];
        let among_all = pair.map(|body| self.bodies.among_all(body));
        let answer = world.first_contact(detection, among_all, outlines, &relative, now, times);
        let outcome = answer.outcome.map(TouchingParts::from);
        self.offer(body, (other, seen), outcome, now, best);
    }

    /// Replaces the best event of a body by what the search of it and an image of another has
    /// found, if that precedes it.
    #[inline]
    pub(in crate::cells) fn offer(
        &mut self,
        body: u32,
        (other, seen): (u32, [i32; 2]),
        outcome: Outcome<TouchingParts>,
        now: f64,
        best: &mut EarliestEvent,
    ) {
        match outcome {
            Outcome::Free => {}
            Outcome::Contact(contact) => {
                let time = now + contact.time;
                if best.is_preceded_by(time, other) {
                    let (parts, image) = (contact.touch, self.path_image([body, other], seen));
                    best.set_contact(time, other, Pending { parts, image });
                }
            }
            Outcome::FreeUntil(time) => best.offer_recheck((now + time).max(now.next_up())),
            // The pair is predicted again in the next epoch, which starts from other numbers.
            Outcome::OutOfRange => self.count_unresolved(body),
            Outcome::Unresolved(time) => {
                self.count_unresolved(body);
                best.offer_recheck((now + time).max(now.next_up()));
            }
        }
    }

    /// The present event of a body.
    #[inline]
    pub(in crate::cells) fn stored_event(&self, body: u32) -> EarliestEvent {
        let record = &self.records[body as usize];
        let kind = record.kind();
        let pending = match kind {
            RecordKind::MultiCell => self.multi_cell.pending[body as usize],
            _ => Pending::NOTHING,
        };
        EarliestEvent {
            time: record.time,
            kind,
            partner: record.partner(),
            pending,
        }
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
        let image = [0, 1]
            .map(|axis| i64::from(pending.image[axis].wrapping_add(b[axis].wrapping_sub(a[axis]))));
        ContactEvent {
            time,
            bodies,
            image,
            parts: pending.parts,
        }
    }

    /// The image of the second body, as seen from the one inserted first, along their paths without
    /// periodic wraps.
    pub(in crate::cells) fn path_image(&self, pair: [u32; 2], image: [i32; 2]) -> [i16; 2] {
        let [asking, other] = pair.map(|body| self.windings[body as usize]);
        let seen = [0, 1]
            .map(|axis| (image[axis] as i16).wrapping_sub(other[axis].wrapping_sub(asking[axis])));
        if pair[0] < pair[1] {
            seen
        } else {
            seen.map(i16::wrapping_neg)
        }
    }

    pub(super) fn relative_motion(
        &self,
        world: &World,
        pair: [u32; 2],
        image: [i64; 2],
        now: f64,
    ) -> RelativeMotion {
        let (a, b) = (self.motion(pair[0]), self.motion(pair[1]));
        let among_all = pair.map(|body| self.bodies.among_all(body));
        world.relative_motion(among_all, [&a, &b], image, now)
    }

    /// The discs seen from a tile of a multi-cell body.
    pub(super) fn seen_from(&self, tile: Listed) -> impl Iterator<Item = Listed> {
        let [x, y] = tile.image;
        let seen = self.neighbour_lists.seen_from(tile.index);
        seen.map(move |(index, image)| Listed {
            index,
            image: [image[0] + x, image[1] + y],
        })
    }

    /// Up to `N` bodies as seen from one, as discs of their bounding radii.
    #[inline(always)]
    pub(in crate::cells) fn lanes<const N: usize>(
        &self,
        body: u32,
        others: &[Listed],
        now: f64,
    ) -> DiscLanes<N> {
        let own = &self.records[body as usize];
        let sides = self.sides;
        let dummy = BodyRecord::dummy();
        let mut lanes = DiscLanes {
            separation: [[0.0; N]; 2],
            velocity: [[0.0; N]; 2],
            cross: [0.0; N],
            contact_distance: [0.0; N],
            separation_error: self.separation_error,
            speed: own.flight[2].abs()
                + own.flight[3].abs()
                + self.seam.as_ref().map_or(0.0, Seam::speed),
        };
        for lane in 0..N {
            let listed = others.get(lane);
            let record = listed.map_or(&dummy, |listed| &self.records[listed.index as usize]);
            let image = listed.map_or([0; 2], |listed| listed.image);
            let (shift, faster) = match &self.seam {
                None => {
                    let shift = [0, 1].map(|axis| f64::from(image[axis]) * sides[axis]);
                    (DVec2::from_array(shift), DVec2::ZERO)
                }
                Some(seam) => seam.shift(image).into(),
            };
            let start = record.origin() - own.origin() + shift;
            lanes.set_since(
                lane,
                start,
                record.velocity() - own.velocity() + faster,
                now,
                record.radius() + own.radius(),
            );
        }
        lanes
    }
}
