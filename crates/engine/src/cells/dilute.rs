//! The loop of a dilute gas of like discs: after a crossing only the three new cells are looked at.
//!
//! Far apart, discs cross many cells between two contacts. So each keeps its soonest contact also while a crossing goes
//! before it, and after the crossing asks only those it could not see before. The rule that nothing is missed stands:
//! the contact kept is the soonest with all that were related when the disc was last predicted in full; whoever has become
//! related since was asked at the crossing that made it so, or crossed over itself and asked then; whoever has changed its
//! motion since has asked. If the partner of the contact kept has changed since, its time is still a lower bound of
//! all those, and the full prediction is made when it comes up.

use std::hint::select_unpredictable as select;

use carom_detection::{DISC_LANES, Detection};

use super::{
    State,
    line::{INDEX_BITS, INDEX_MASK, Kind},
    roster::{AHEAD, AROUND},
    vector::{Kernel, Question},
};

impl State {
    /// Finds the soonest event of a disc whose motion has changed, or whose contact came up stale.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub(super) fn foresee_among_few<D: Detection, K: Kernel>(
        &mut self,
        detection: &D,
        disc: u32,
        now: f64,
    ) -> f64 {
        let (soonest, partner) = self.ask_cells::<D, K>(detection, disc, &AROUND, now);
        let version = self.lines[partner as usize].version;
        self.settle_among_few(disc, now, now + soonest, partner, version)
    }

    /// Moves a disc into the next cell, and finds its soonest event.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub(super) fn cross_among_few<D: Detection, K: Kernel>(
        &mut self,
        detection: &D,
        disc: u32,
        kind: Kind,
        now: f64,
    ) -> f64 {
        self.done.crossings += 1;
        let (axis, direction) = kind.direction();
        let from = self.lines[disc as usize].cell();
        let mut to = from;
        let next = i32::from(from[axis]) + direction;
        let is_inside = (0..self.grid.counts()[axis] as i32).contains(&next);
        to[axis] = if is_inside { next as u16 } else { self.wrap_place(disc, axis, direction) };
        self.lines[disc as usize].set_cell(to);
        self.rosters.leave(disc, from);
        self.rosters.enter(disc, to, self.lines[disc as usize].flight);
        let ahead = &AHEAD[axis][usize::from(direction > 0)];
        let (soonest, partner) = self.ask_cells::<D, K>(detection, disc, ahead, now);
        let contact_time = now + soonest;
        let line = &self.lines[disc as usize];
        let version = self.lines[partner as usize].version;
        // Of two contacts at one time that with the disc inserted first.
        let sooner = (contact_time < line.later())
            | ((contact_time == line.later()) & (contact_time < f64::INFINITY) & (partner < line.partner()));
        let time = select(sooner, contact_time, line.later());
        let partner = select(sooner, partner, line.partner());
        let version = select(sooner, version, line.partner_version);
        self.settle_among_few(disc, now, time, partner, version)
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    fn settle_among_few(
        &mut self,
        disc: u32,
        now: f64,
        contact_time: f64,
        partner: u32,
        version: u32,
    ) -> f64 {
        let line = &self.lines[disc as usize];
        let (crossing_time, crossing) = self.crossing(line, now);
        let meets = contact_time <= crossing_time;
        let time = if crossing_time < contact_time { crossing_time } else { contact_time };
        let kind = select(meets, Kind::Discs, crossing);
        let line = &mut self.lines[disc as usize];
        line.set_event(time, kind, partner, version);
        line.set_later(contact_time);
        time
    }

    /// The soonest contact (from now on) with the discs of some cells around a disc's own, and with whom. Of contacts at
    /// one time it is that with the disc inserted first.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    fn ask_cells<D: Detection, K: Kernel>(
        &self,
        detection: &D,
        disc: u32,
        numbers: &[usize],
        now: f64,
    ) -> (f64, u32) {
        let question = self.question(disc, now);
        let from = question.from;
        let Some(like) = self.like else { unreachable!("discs of a dilute gas that are not alike") };
        let (mut time, mut partner) = (f64::INFINITY, 0);
        let mut offer = |(other_time, other): (f64, u32)| {
            let tie = (other_time == time) & (other < partner) & (time < f64::INFINITY);
            if (other_time < time) | tie {
                (time, partner) = (other_time, other);
            }
        };
        let around = self.rosters.around(from.cell());
        for &number in numbers {
            let slot = around[number];
            let shift = self.shifts[(slot >> INDEX_BITS) as usize];
            for block in self.rosters.blocks(slot) {
                let in_closed_form = detection.decides_discs_in_closed_form();
                let soonest = if in_closed_form {
                    K::in_block(&from.flight, now, &like, self.rosters.flights(block), shift)
                } else {
                    None
                };
                match soonest {
                    Some(soonest) if !soonest.is_doubtful() => {
                        let lane = (soonest.slots.trailing_zeros() & 7) as usize;
                        offer((soonest.time, self.rosters.discs(block)[lane]));
                    }
                    // Nearly always nobody comes near.
                    None if in_closed_form => {}
                    _ => offer(look_closer(&question, detection, slot, self.rosters.discs(block))),
                }
            }
        }
        (time, partner)
    }
}

/// The soonest contact with the discs of a block, and with whom, as the detector decides it.
#[cold]
#[inline(never)]
fn look_closer<D: Detection>(
    question: &Question<'_>,
    detection: &D,
    slot: u32,
    discs: &[u32; DISC_LANES],
) -> (f64, u32) {
    let seen = discs.map(|disc| disc | slot & !INDEX_MASK);
    question.look_closer(detection, &seen, true)
}
