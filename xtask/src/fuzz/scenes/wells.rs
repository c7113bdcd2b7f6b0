//! The steps of discs in their wells, against an independent record of the shell of each pair.

use std::collections::BTreeMap;

use carom::engine::{BodyKey, CollisionReport, PairInWell, View};
use carom_kinematics::EpochTime;

use super::{
    contact::{MeasuredContact, relative_rate, separation},
    kinematics::{BodyPair, cross, distance_in_box, dot, length},
    tracked::KnownShell,
    vectors::U,
    watcher::Watcher,
};
use crate::fuzz::subject::exceeds;

impl Watcher {
    /// Takes over the shells of all pairs from their places at a time.
    pub(super) fn sort_into_shells(&mut self, time: EpochTime) {
        self.shells.clear();
        if self.rules.well.is_empty() {
            return;
        }
        let placed: Vec<(BodyKey, BodyPair)> = (self.bodies.iter())
            .map(|(key, body)| (*key, body.state.at(time, self.sides).place))
            .collect();
        for (n, (a, at_a)) in placed.iter().enumerate() {
            for (b, at_b) in &placed[n + 1..] {
                let Some(borders) = self.borders([*a, *b]) else {
                    continue;
                };
                let distance = distance_in_box(*at_a, *at_b, self.sides);
                let bound = self.bound_of_step([*a, *b], time);
                let is_border = |border: &f64| (distance - border).abs() <= bound;
                let shell = if borders.iter().any(is_border) {
                    Some(KnownShell::AtBorder)
                } else {
                    let within = borders.iter().position(|border| distance < *border);
                    within.map(KnownShell::Within)
                };
                if let Some(shell) = shell {
                    self.shells.insert([*a, *b], shell);
                }
            }
        }
    }

    /// Compares the pairs within their wells, and their energies, with those on record.
    pub(super) fn compare_shells(&mut self, view: &View<'_>) {
        let listed: BTreeMap<[BodyKey; 2], PairInWell> = view
            .pairs_in_wells()
            .map(|pair| (pair.bodies, pair))
            .collect();
        for (pair, known) in &self.shells {
            let KnownShell::Within(step) = *known else {
                continue;
            };
            let tags = pair.map(|key| self.bodies.get(&key).map(|body| &body.tags));
            let [Some(a), Some(b)] = tags else {
                continue;
            };
            let steps = self.rules.steps(a, b).unwrap_or_default();
            let expected = steps.get(step).map(|[_, energy]| (step, *energy));
            let found = listed.get(pair).map(|pair| (pair.step, pair.energy));
            if found != expected {
                self.report.fail(
                    "well",
                    format!("a pair is in the step {found:?} of its well, not in {expected:?}"),
                );
            }
        }
        if let Some(pair) = listed.keys().find(|pair| !self.shells.contains_key(*pair)) {
            self.report.fail(
                "well",
                format!("{pair:?} are listed in their well, but outside"),
            );
        }
        let own: f64 = listed.values().map(|pair| pair.energy).sum();
        let sizes: f64 = listed.values().map(|pair| pair.energy.abs()).sum();
        let allowed = f64::EPSILON * listed.len() as f64 * sizes;
        if exceeds((view.energy_of_wells() - own).abs(), allowed) {
            self.report.fail(
                "well",
                format!(
                    "the energy of wells is {:e}, that of the pairs {own:e}",
                    view.energy_of_wells()
                ),
            );
        }
    }

    /// The ranges of the well of two bodies, if they have one (length).
    fn borders(&self, pair: [BodyKey; 2]) -> Option<Vec<f64>> {
        let [a, b] = [self.bodies.get(&pair[0])?, self.bodies.get(&pair[1])?];
        if a.fixed && b.fixed {
            return None;
        }
        let steps = self.rules.steps(&a.tags, &b.tags)?;
        let contact = self.rules.factor(&a.tags, &b.tags) * (a.outline.reach + b.outline.reach);
        Some(steps.iter().map(|[range, _]| range * contact).collect())
    }

    /// Bound on the error of the distance of a pair (length).
    fn bound_of_step(&self, pair: [BodyKey; 2], time: EpochTime) -> f64 {
        let bodies = pair.map(|key| self.bodies.get(&key));
        let [Some(a), Some(b)] = bodies else {
            return 0.0;
        };
        self.gap_bound(&a.outline, &b.outline) + self.error(a, time) + self.error(b, time)
    }

    /// Returns true if two bodies have a well.
    pub(super) fn have_well(&self, contact: &CollisionReport<'_>) -> bool {
        self.borders(contact.sides.each_ref().map(|side| side.body.key()))
            .is_some()
    }

    /// Checks that two discs that touch are in the innermost shell of their well.
    pub(super) fn check_touching_in_well(&mut self, contact: &CollisionReport<'_>) {
        let pair = contact.sides.each_ref().map(|side| side.body.key());
        match self.shells.get(&pair) {
            Some(KnownShell::AtBorder | KnownShell::Within(0)) => {
                self.shells.insert(pair, KnownShell::Within(0));
            }
            other => self.report.fail(
                "well",
                format!("discs touch that are in the shell {other:?} of their well"),
            ),
        }
    }

    /// Checks the arrival of two discs at a step of their well.
    pub(super) fn check_step(&mut self, contact: &CollisionReport<'_>) -> MeasuredContact {
        let pair = contact.sides.each_ref().map(|side| side.body.key());
        let tags = pair.map(|key| self.bodies.get(&key).map(|body| body.tags.clone()));
        let [Some(tags_a), Some(tags_b)] = tags else {
            return MeasuredContact::default();
        };
        let (Some(borders), Some(steps)) = (self.borders(pair), self.rules.steps(&tags_a, &tags_b))
        else {
            self.report.fail(
                "well",
                format!("discs without a well reach a step: {contact:?}"),
            );
            return MeasuredContact::default();
        };
        let energies: Vec<f64> = steps.iter().map(|[_, energy]| *energy).collect();
        let arrival = self.arrival(contact, &borders);
        self.check_range(&arrival);
        let rates = Rates::new(contact, &arrival);
        self.check_approach(contact, &rates, arrival.inwards);
        // The shell on the side from which the pair comes, and that beyond.
        let border = arrival.border;
        let beyond = (border + 1 < borders.len()).then_some(border + 1);
        let (from, to) = if arrival.inwards {
            (beyond, Some(border))
        } else {
            (Some(border), beyond)
        };
        self.check_shell(pair, from);
        let energy = |shell: Option<usize>| shell.map_or(0.0, |shell| energies[shell]);
        let gain = energy(from) - energy(to);
        let bounced = self.check_outcome(contact, &rates, (arrival.inwards, gain));
        let shell = if bounced { from } else { to };
        if !bounced {
            self.gained += gain;
        }
        match shell {
            Some(shell) => self.shells.insert(pair, KnownShell::Within(shell)),
            None => self.shells.remove(&pair),
        };
        self.report.count("steps of wells", 1);
        MeasuredContact {
            approach: rates.approach(arrival.inwards),
            speed: rates.speed,
            distance: arrival.distance,
            ..MeasuredContact::default()
        }
    }

    /// Where a pair arrives whose well has these ranges (length).
    fn arrival(&self, contact: &CollisionReport<'_>, borders: &[f64]) -> Arrival {
        let between = separation(contact, self.sides);
        let distance = length(between);
        let direction = between.map(|x| x / distance);
        let nearest = |one: &usize, other: &usize| {
            let off = |border: usize| (distance - borders[border]).abs();
            off(*one).total_cmp(&off(*other))
        };
        let border = (0..borders.len()).min_by(nearest).unwrap_or(0);
        let pair = contact.sides.each_ref().map(|side| side.body.key());
        Arrival {
            distance,
            direction,
            border,
            off: (distance - borders[border]).abs(),
            bound: self.bound_of_step(pair, contact.time) + 8.0 * U * distance,
            inwards: dot(contact.normal.to_array(), direction) > 0.0,
        }
    }

    /// Checks that a pair arrives at the range of a step.
    fn check_range(&mut self, arrival: &Arrival) {
        let Arrival {
            distance,
            off,
            bound,
            ..
        } = *arrival;
        self.report.keep_worst("step/bound", off / bound);
        if exceeds(off, bound) {
            self.report.fail(
                "well",
                format!("a step at {distance:e}, {off:e} from the range: allowed {bound:e}"),
            );
        }
    }

    /// Checks that a pair does not move away from a step that it reaches.
    fn check_approach(&mut self, contact: &CollisionReport<'_>, rates: &Rates, inwards: bool) {
        if exceeds(-rates.approach(inwards), rates.error) {
            self.report.fail(
                "well",
                format!("a pair leaves the step that it reaches: {contact:?}"),
            );
        }
    }

    /// Checks that a pair comes from the shell on record.
    fn check_shell(&mut self, pair: [BodyKey; 2], from: Option<usize>) {
        let known = self.shells.get(&pair).copied();
        let fits = match known {
            Some(KnownShell::AtBorder) => true,
            Some(KnownShell::Within(shell)) => from == Some(shell),
            None => from.is_none(),
        };
        if !fits {
            self.report.fail(
                "well",
                format!("a pair in the shell {known:?} reaches a step from {from:?}"),
            );
        }
    }

    /// Checks the energy along the line of centres after a step, and that nothing else changes;
    /// returns true if the pair has bounced back.
    fn check_outcome(
        &mut self,
        contact: &CollisionReport<'_>,
        rates: &Rates,
        (inwards, gain): (bool, f64),
    ) -> bool {
        let Rates {
            before,
            after,
            direction,
            share,
            error,
            ..
        } = *rates;
        let [radial, radial_after] = [dot(before, direction), dot(after, direction)];
        let sides = &contact.sides;
        let inverse: f64 = (sides.iter())
            .map(|side| side.body.inertia().inverse_mass)
            .sum();
        let along_line = |rate: f64| 0.5 * rate * rate / inverse;
        let (old, new) = (along_line(radial), along_line(radial_after));
        let allowed = (256.0 * U + 8.0 * share) * (old.max(new) + gain.abs())
            + error * (radial.abs() + radial_after.abs() + error) / inverse;
        let bounced = (radial_after > 0.0) == inwards;
        let changed = if bounced { 0.0 } else { gain };
        let wrong =
            bounced && exceeds(old + gain, allowed) || !bounced && exceeds(-(old + gain), allowed);
        if wrong || exceeds((new - old - changed).abs(), allowed) {
            self.report.fail(
                "well",
                format!(
                    "the energy along the line of centres changes from {old:e} to {new:e} at a step that gives \
                     {gain:e}, bounced: {bounced}, allowed {allowed:e}"
                ),
            );
        }
        let across = (cross(direction, after) - cross(direction, before)).abs();
        if exceeds(
            across,
            error + (64.0 * U + 4.0 * share) * radial_after.abs(),
        ) {
            self.report.fail(
                "well",
                format!("a step changes the velocity across by {across:e}"),
            );
        }
        for side in sides {
            if side.before.angular_velocity != side.after.angular_velocity {
                self.report.fail("well", "a step turns a disc".to_owned());
            }
        }
        bounced
    }
}

/// Where a pair arrives at a step of its well.
struct Arrival {
    distance: f64,
    /// The line of centres.
    direction: BodyPair,
    /// The index of the nearest range.
    border: usize,
    /// How far the distance is from that range (length).
    off: f64,
    /// Bound on the error of the distance (length).
    bound: f64,
    /// Whether the pair comes from outside.
    inwards: bool,
}

/// The relative velocities at a step (length per time).
struct Rates {
    before: BodyPair,
    after: BodyPair,
    /// The line of centres.
    direction: BodyPair,
    /// The error of the distance by the distance.
    share: f64,
    /// Sum of the speeds of both bodies.
    speed: f64,
    /// Bound on the error of a velocity along the line of centres.
    error: f64,
}

impl Rates {
    fn new(contact: &CollisionReport<'_>, arrival: &Arrival) -> Self {
        let [before, after] =
            [false, true].map(|after| relative_rate(contact, [[0.0; 2]; 2], after));
        let speeds = contact
            .sides
            .each_ref()
            .map(|side| side.before.velocity.length());
        let speed = speeds[0] + speeds[1];
        let share = arrival.bound / arrival.distance;
        Self {
            before,
            after,
            direction: arrival.direction,
            share,
            speed,
            error: (64.0 * U + 4.0 * arrival.bound / arrival.distance) * speed,
        }
    }

    /// The speed at which the pair comes to the step (length per time).
    fn approach(&self, inwards: bool) -> f64 {
        let radial = dot(self.before, self.direction);
        if inwards { -radial } else { radial }
    }
}
