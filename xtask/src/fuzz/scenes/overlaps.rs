//! The search for overlaps of any two bodies between two events.

use std::{borrow::Cow, collections::BTreeSet};

use carom::engine::BodyKey;
use carom_kinematics::EpochTime;

use super::{
    bounds::ROUNDINGS_OF_CLOCK,
    kinematics::{Placed, smallest_gap},
    tracked::{TrackedBody, outline_for},
    watcher::{RESOLUTION, Watcher},
};
use crate::fuzz::subject::exceeds;

/// Number of times between two events at which all pairs are examined, in scenes of few bodies.
const MOMENTS: usize = 2;

/// Number of times examined after a contact that may have been missed.
const LOOKS_AHEAD: i32 = 24;

/// Scenes of more bodies are not examined after every event.
const MAX_WATCHED_BODIES: usize = 12;

/// Distance at which walls may end a run by their meeting, in longer sides.
const CLOSE: f64 = 1e-5;

impl Watcher {
    /// The pairs of fixed bodies and pistons that are apart by more than rounding.
    pub(super) fn fixed_pairs_apart(&self, time: EpochTime) -> BTreeSet<[BodyKey; 2]> {
        let mut apart = BTreeSet::new();
        let has_pistons = self.bodies.values().any(|body| body.piston.is_some());
        if !self.rules.moves_walls && !has_pistons {
            return apart;
        }
        let barriers = self.bodies.iter().filter(|(_, body)| body.is_barrier());
        let fixed: Vec<_> = barriers.collect();
        for (index, (key, body)) in fixed.iter().enumerate() {
            for (earlier, other) in &fixed[..index] {
                let gap = self.gap_of_fixed([other, body], 0.0, time);
                if gap > self.gap_bound(&other.outline, &body.outline) {
                    apart.insert([**earlier, **key]);
                }
            }
        }
        apart
    }

    /// The smallest gap of two fixed bodies, which may be walls across the box, if walls were
    /// thicker by this (lengths).
    pub(super) fn gap_of_fixed(
        &self,
        pair: [&TrackedBody; 2],
        thicker: f64,
        time: EpochTime,
    ) -> f64 {
        let [one, two] = pair.map(|body| body.outline.with_ends().thickened(thicker));
        let [at_one, at_two] = pair.map(|body| body.state.at(time, self.sides));
        smallest_gap((&one, &at_one), (&two, &at_two), self.sides)
    }

    /// Checks that two bodies that have ended the run by their meeting are close to each other: the
    /// detector sees walls of which one turns meet a little before.
    pub fn check_meeting(&mut self, keys: [BodyKey; 2], time: EpochTime) {
        let [Some(a), Some(b)] = keys.map(|key| self.bodies.get(&key)) else {
            self.report.fail("bodies", "walls that meet are unknown");
            return;
        };
        // No gap is computed if the bounding circles do not meet.
        let thicker = CLOSE * self.longer_side();
        let gap = self.gap_of_fixed([a, b], thicker, time);
        if exceeds(gap, 0.0) {
            let detail = format!("they are apart by {gap:e} more than {thicker:e}");
            self.report.fail("walls meet", detail);
        }
    }

    /// Examines all pairs in all images at one time.
    pub(super) fn look_at_all(&mut self, time: EpochTime) {
        let placed: Vec<(BodyKey, &TrackedBody, Placed, f64)> = self
            .bodies
            .iter()
            .map(|(key, body)| {
                (
                    *key,
                    body,
                    body.state.at(time, self.sides),
                    self.error(body, time),
                )
            })
            .collect();
        let (mut worst, mut deepest) = (0.0f64, None);
        for (index, (key_a, a, at_a, error_a)) in placed.iter().enumerate() {
            for (key_b, b, at_b, error_b) in &placed[..index] {
                if a.is_barrier() && b.is_barrier() && !self.apart.contains(&[*key_b, *key_a]) {
                    continue;
                }
                let factor = self.rules.factor(&a.tags, &b.tags);
                if factor == 0.0 {
                    continue;
                }
                let [one, other] = [a, b].map(|body| match (a.is_barrier(), b.is_barrier()) {
                    (true, true) => Cow::Owned(body.outline.with_ends()),
                    _ => outline_for(body, factor),
                });
                let gap = smallest_gap((&one, at_a), (&other, at_b), self.sides);
                let bound = self.gap_bound(&one, &other) + error_a + error_b;
                worst = worst.max(-gap / bound);
                if exceeds(-gap, bound) {
                    deepest = Some((gap, bound, [*key_a, *key_b]));
                }
            }
        }
        self.report.count("moments", 1);
        self.report.keep_worst("overlap/bound", worst);
        if let Some((gap, bound, [one, other])) = deepest {
            let time = time.to_f64();
            self.report.fail(
                "overlap between events",
                format!("gap {gap:e} of {one:?} and {other:?} at {time:e}, allowed {bound:e}"),
            );
        }
    }

    /// Tests whether the engine missed a contact that its brute-force search finds `time` from now,
    /// before the next one at `next`: examines whether bodies overlap in between by more than
    /// rounding. The times of grazing contacts differ by more than the clock resolution. Walls may
    /// have met by then, at which the run ends.
    pub fn look_ahead(&mut self, now: EpochTime, time: f64, next: f64) {
        let apart = std::mem::take(&mut self.apart);
        for halvings in 0..LOOKS_AHEAD {
            let after = (next - time) * 0.5f64.powi(halvings);
            self.look_at_all(now.after(time + after));
        }
        self.apart = apart;
    }

    /// Examines all pairs at random times since the last event.
    pub(super) fn look_back(&mut self, time: EpochTime) {
        let since = time.since(self.last);
        // To the precision of a double-double, in which epochs are stored.
        let mut resolved = RESOLUTION * time.to_f64().abs();
        if self.rules.drag > 0.0 {
            resolved += ROUNDINGS_OF_CLOCK * f64::EPSILON * time.offset().abs();
        }
        if exceeds(-since, resolved) {
            self.report.fail(
                "time",
                format!("an event is {:e} earlier than the previous one", -since),
            );
            return;
        }
        let count = self.bodies.len();
        let looks = count <= MAX_WATCHED_BODIES
            || self
                .draw
                .happens(MAX_WATCHED_BODIES as f64 / count as f64 / 2.0);
        if since > 0.0 && looks {
            for _ in 0..MOMENTS {
                let moment = self.last.after(self.draw.between(0.0, 1.0) * since);
                self.look_at_all(moment);
            }
        }
        self.last = time;
        self.reflect_pistons(time);
    }

    /// Takes over the states of pistons after their last reflections before a time.
    fn reflect_pistons(&mut self, time: EpochTime) {
        let pistons = self.bodies.iter().filter(|(_, body)| body.piston.is_some());
        let keys: Vec<BodyKey> = pistons.map(|(key, _)| *key).collect();
        for key in keys {
            let before = &self.bodies[&key];
            let Some((state, flight)) = before.state.reflected(time) else {
                continue;
            };
            if flight.count == 0 {
                continue;
            }
            let [fallen, error] = self.fall(before, state.time);
            self.fallen += fallen;
            self.fallen_error += error;
            // The speed at a stop is off by what the work on the way there is off.
            self.lost += before.mass * flight.lost;
            self.work_error += error;
            self.entries += f64::from(flight.count);
            self.report
                .count("reflections at stops", flight.count.into());
            if let Some(piston) = self.bodies.get_mut(&key) {
                let (count, slowest) = piston.reflections;
                let count = count + f64::from(flight.count);
                piston.reflections = (count, slowest.min(flight.slowest));
                piston.state = state;
            }
        }
    }
}
