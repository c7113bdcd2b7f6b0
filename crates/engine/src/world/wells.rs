//! Pairs of discs within the range of their wells, and the next step of one.
//!
//! The steps of a well divide the distance of two discs into shells, numbered from 0 at contact
//! outwards. A pair within the last range has its shell in a list, because rounding may put a
//! pair that is at the range of a step on either side of it. Such a pair is a tether between the
//! two borders of its shell; all other pairs meet at the last range like discs of that size.
//!
//! # Lemma
//! No step is missed. *Proof.* A pair outside its well meets the last range as a contact at that
//! distance, by the lemmas of the scheduler. A pair in a shell is searched with every prediction of
//! one of the two, like a bond, in the image that is nearest: two discs within a range of less than
//! half a side have one such image, which the pair cannot leave without crossing a step.

use carom_detection::{Outcome, Tether, TetherBound};
use carom_kinematics::Motion;
use glam::DVec2;
use smallvec::SmallVec;

use crate::world::{
    World,
    body::BodyKey,
    contact_event::{ContactEvent, TouchingParts},
    heat::exact_sum,
    near_pairs::each_near_pair,
    rounding_bound::rounding_bound,
    view::{BodyView, View, body_at},
};

/// A shell of a pair of discs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WellShell {
    /// Its number, from 0 at contact outwards.
    pub number: u8,
    /// The distances of the centres at its borders (length).
    pub borders: [f64; 2],
}

impl WellShell {
    /// A tether between the borders.
    fn tether(&self) -> Option<Tether> {
        Tether::new([DVec2::ZERO; 2], self.borders).ok()
    }

    /// Whether a distance of the centres is within the borders, up to a rounding (length).
    fn holds(&self, distance: f64, rounding: f64) -> bool {
        let [inner, outer] = self.borders;
        (inner - rounding..=outer + rounding).contains(&distance)
    }
}

/// A disc within the range of a well of another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct InWell {
    /// The other disc, by its index.
    pub partner: u32,
    /// The shell of the pair.
    pub shell: WellShell,
}

/// The shells of all pairs within the ranges of their wells.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Shells(Vec<SmallVec<[InWell; 6]>>);

impl Shells {
    /// The discs in whose wells a disc is.
    #[inline]
    pub fn at(&self, body: u32) -> &[InWell] {
        self.0.get(body as usize).map_or(&[], SmallVec::as_slice)
    }

    /// The shell of a pair; `None` beyond the last range.
    #[inline]
    pub fn of_pair(&self, [a, b]: [u32; 2]) -> Option<WellShell> {
        // Both have the pair in their lists; that of a large disc may be long.
        let (of_a, of_b) = (self.at(a), self.at(b));
        let (list, partner) = if of_a.len() <= of_b.len() {
            (of_a, b)
        } else {
            (of_b, a)
        };
        let found = list.iter().find(|entry| entry.partner == partner)?;
        Some(found.shell)
    }

    /// Sets the shell of a pair.
    pub fn set(&mut self, [a, b]: [u32; 2], shell: Option<WellShell>) {
        let bodies = a.max(b) as usize + 1;
        if self.0.len() < bodies {
            self.0.resize_with(bodies, SmallVec::new);
        }
        for (body, partner) in [(a, b), (b, a)] {
            let list = &mut self.0[body as usize];
            let place = list.iter().position(|entry| entry.partner == partner);
            match (place, shell) {
                (Some(place), Some(shell)) => list[place].shell = shell,
                (Some(place), None) => {
                    list.swap_remove(place);
                }
                (None, Some(shell)) => list.push(InWell { partner, shell }),
                (None, None) => {}
            }
        }
    }

    /// All pairs and their shells, in order.
    pub fn pairs(&self) -> Vec<([u32; 2], WellShell)> {
        let mut pairs = Vec::new();
        for (body, list) in (0..).zip(&self.0) {
            let begin = pairs.len();
            let later = list.iter().filter(|entry| entry.partner > body);
            pairs.extend(later.map(|entry| ([body, entry.partner], entry.shell)));
            pairs[begin..].sort_unstable_by_key(|(bodies, _)| *bodies);
        }
        pairs
    }

    /// The shells that are left when only some bodies remain: `number` gives the new index of each.
    pub fn renumbered(&self, number: impl Fn(u32) -> Option<u32>) -> Self {
        let mut left = Self::default();
        for (bodies, shell) in self.pairs() {
            if let [Some(a), Some(b)] = bodies.map(&number) {
                left.set([a, b], Some(shell));
            }
        }
        left
    }

    pub fn heap_bytes(&self) -> usize {
        let spilled = self.0.iter().filter(|list| list.spilled());
        self.0.capacity() * size_of::<SmallVec<[InWell; 6]>>()
            + spilled
                .map(|list| list.capacity() * size_of::<InWell>())
                .sum::<usize>()
    }
}

/// The shell beyond a step, and the energy gained there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepAhead {
    /// The shell beyond the step; `None` outside the well.
    pub shell: Option<WellShell>,
    /// Kinetic energy that the pair gains by the step (mass × length² / time²).
    pub gain: f64,
}

impl World {
    /// Whether discs have wells.
    #[inline]
    pub fn has_wells(&self) -> bool {
        self.pairs.has_wells()
    }

    /// The discs in whose wells a disc is, by their indices.
    pub fn in_wells_of(&self, body: u32) -> impl Iterator<Item = u32> {
        self.shells.at(body).iter().map(|entry| entry.partner)
    }

    /// The next event of a pair within the range of its well, from `now` (offset in the epoch) up
    /// to `horizon` (time from now), with the present motions of the two, and the image of the
    /// second that it concerns.
    pub fn first_step(
        &self,
        bodies: [u32; 2],
        motions: [&Motion; 2],
        now: f64,
        horizon: f64,
    ) -> (Outcome<TouchingParts>, [i64; 2]) {
        match self.shells.of_pair(bodies) {
            Some(shell) => self.first_step_from(shell, bodies, motions, now, horizon),
            None => (Outcome::Free, [0; 2]),
        }
    }

    /// The next event of a pair in a shell, like [`Self::first_step`].
    pub(crate) fn first_step_from(
        &self,
        shell: WellShell,
        bodies: [u32; 2],
        motions: [&Motion; 2],
        now: f64,
        horizon: f64,
    ) -> (Outcome<TouchingParts>, [i64; 2]) {
        let here = motions.map(|motion| motion.position_at(now));
        let image = self.nearest_image(here);
        if self.stay_between(shell.borders, motions, here, image, horizon) {
            return (Outcome::Free, image);
        }
        let Some(tether) = shell.tether() else {
            return (Outcome::Free, image);
        };
        let relative = self.relative_motion(bodies, motions, image, now);
        let outcome = tether.first_event(&relative, horizon);
        let parts = |bound| match bound {
            TetherBound::Shortest if shell.number == 0 => TouchingParts::Discs,
            _ => TouchingParts::Step(bound),
        };
        (outcome.map(parts), image)
    }

    /// A tether between the borders of the shell of a pair.
    pub(crate) fn shell_as_tether(&self, bodies: [u32; 2]) -> Option<Tether> {
        self.shells.of_pair(bodies)?.tether()
    }

    /// The shell of a pair with this number; `None` for two fixed discs.
    fn shell(&self, bodies: [u32; 2], number: u8) -> Option<WellShell> {
        let [a, b] = bodies.map(|body| &self.bodies[body as usize]);
        if a.is_fixed() && b.is_fixed() {
            return None;
        }
        let steps = self.pairs.steps(a, b)?;
        let contact = self.pairs.factor(a, b)
            * (a.molecule().bounding_radius() + b.molecule().bounding_radius());
        let range = |step: usize| Some(contact * steps.get(step)?[0]);
        let step = usize::from(number);
        let inner = if step == 0 { contact } else { range(step - 1)? };
        let borders = [inner, range(step)?];
        Some(WellShell { number, borders })
    }

    /// All shells of a pair, from the inside outwards; none without a well.
    pub(crate) fn shells_of(&self, bodies: [u32; 2]) -> impl Iterator<Item = WellShell> {
        (0..=u8::MAX).map_while(move |number| self.shell(bodies, number))
    }

    /// The parts of a contact that a scheduler has found: two discs outside their well meet its
    /// last range.
    #[inline]
    pub(crate) fn parts_of(&self, contact: &ContactEvent) -> TouchingParts {
        let [a, b] = contact.bodies.map(|body| &self.bodies[body as usize]);
        let is_outside = contact.parts == TouchingParts::Discs
            && self.pairs.steps(a, b).is_some()
            && self.shells.of_pair(contact.bodies).is_none();
        if is_outside {
            TouchingParts::Step(TetherBound::Shortest)
        } else {
            contact.parts
        }
    }

    /// Returns the shell beyond the step that a pair reaches, and the gain.
    pub(crate) fn step_ahead(&self, bodies: [u32; 2], bound: TetherBound) -> StepAhead {
        let [a, b] = bodies.map(|body| &self.bodies[body as usize]);
        let steps = self.pairs.steps(a, b).unwrap_or_default();
        let energy = |shell: Option<u8>| {
            let step = shell.and_then(|shell| steps.get(usize::from(shell)));
            step.map_or(0.0, |step| step[1])
        };
        let here = self.shells.of_pair(bodies).map(|shell| shell.number);
        let last = steps.len().saturating_sub(1) as u8;
        let shell = match (here, bound) {
            (None, _) => Some(last),
            (Some(shell), TetherBound::Shortest) => Some(shell.saturating_sub(1)),
            (Some(shell), TetherBound::Longest) => (shell < last).then_some(shell + 1),
        };
        StepAhead {
            shell: shell.and_then(|number| self.shell(bodies, number)),
            gain: energy(here) - energy(shell),
        }
    }

    /// Sorts all pairs into the shells of their wells by their places; pairs whose distance is that
    /// of a border to rounding stay in the shell in which they have been. Motions are those stored
    /// at the start of an epoch.
    pub(crate) fn sort_into_shells(&mut self) {
        let before = std::mem::take(&mut self.shells);
        if !self.has_wells() {
            return;
        }
        let mut found = Vec::new();
        let sides = self.bounds.sides();
        let mut placed: Vec<BodyView<'_>> = (0..self.bodies.len())
            .map(|index| body_at(self, index, 0.0))
            .collect();
        each_near_pair(self, 0.0, &mut placed, |[a, b], pair, shift| {
            let bodies = [a, b];
            let [one, other] = pair.map(|body| body.motion.position);
            let between = (other - one) + shift;
            let distance = between.length();
            let rounding = rounding_bound(sides, distance);
            let stays = before.of_pair(bodies).and_then(|shell| {
                let now = self.shell(bodies, shell.number)?;
                now.holds(distance, rounding).then_some(now)
            });
            // A pair that is not on record, and is at the last range to rounding, is outside.
            let by_distance = || {
                let inside = |shell: &WellShell| distance < shell.borders[1];
                let shell = self.shells_of(bodies).find(inside)?;
                let is_last = self.shell(bodies, shell.number + 1).is_none();
                (!is_last || distance < shell.borders[1] - rounding).then_some(shell)
            };
            if let Some(shell) = stays.or_else(by_distance) {
                found.push((bodies, shell));
            }
        });
        for (bodies, shell) in found {
            self.shells.set(bodies, Some(shell));
        }
    }

    /// The distance of the centres of two bodies in their nearest images, at an offset in the epoch
    /// (time).
    fn nearest_distance(&self, bodies: [usize; 2], offset: f64) -> f64 {
        let [a, b] = bodies.map(|body| self.motions[body].at(offset));
        (b.position - a.position + self.nearest_shift([&a, &b])).length()
    }

    /// The first pair of discs whose distance, at an offset in the epoch (time), is not that of its
    /// shell on record to rounding, and the distance (length). The cost is O(N²) for N bodies.
    pub(crate) fn first_outside_shell(&self, offset: f64) -> Option<(usize, usize, f64)> {
        if !self.has_wells() {
            return None;
        }
        let sides = self.bounds.sides();
        let pairs = (0..self.bodies.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        for (a, b) in pairs {
            let bodies = [a as u32, b as u32];
            let Some(last) = self.shells_of(bodies).last() else {
                continue;
            };
            let distance = self.nearest_distance([a, b], offset);
            let rounding = rounding_bound(sides, last.borders[1]);
            let is_right = match self.shells.of_pair(bodies) {
                None => distance >= last.borders[1] - rounding,
                Some(shell) => shell.holds(distance, rounding),
            };
            if !is_right {
                return Some((a, b, distance));
            }
        }
        None
    }

    /// Takes over the shells of a stored state.
    ///
    /// # Errors
    /// The index of the first pair that is out of order, is not of two discs with a well, or is not
    /// at the distance of its shell.
    pub(crate) fn restore_shells(&mut self, saved: &[([u32; 2], u8)]) -> Result<(), usize> {
        let sides = self.bounds.sides();
        for (number, &(bodies, shell)) in saved.iter().enumerate() {
            let [a, b] = bodies.map(|body| body as usize);
            if a >= b || b >= self.bodies.len() {
                return Err(number);
            }
            let distance = self.nearest_distance([a, b], 0.0);
            let fits = |shell: &WellShell| shell.holds(distance, rounding_bound(sides, distance));
            let shell = self.shell(bodies, shell).filter(fits).ok_or(number)?;
            self.shells.set(bodies, Some(shell));
        }
        Ok(())
    }
}

/// A pair of discs within the range of their well, in a view.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PairInWell {
    /// The two discs, the one inserted earlier first.
    pub bodies: [BodyKey; 2],
    /// The step of the well within whose range they are, and not within that of the one before.
    pub step: usize,
    /// Their energy (mass × length² / time²).
    pub energy: f64,
}

impl<'a> View<'a> {
    /// Whether discs have wells ([`WellSpec`](crate::WellSpec)).
    pub fn has_wells(&self) -> bool {
        self.world.has_wells()
    }

    /// The pairs within the ranges of their wells ([`WellSpec`](crate::WellSpec)).
    pub fn pairs_in_wells(&self) -> impl Iterator<Item = PairInWell> + use<'a> {
        let world = self.world;
        world
            .shells
            .pairs()
            .into_iter()
            .map(move |(bodies, shell)| {
                let [a, b] = bodies.map(|body| &world.bodies[body as usize]);
                let step = usize::from(shell.number);
                let steps = world.pairs.steps(a, b).unwrap_or_default();
                PairInWell {
                    bodies: [a.key(), b.key()],
                    step,
                    energy: steps.get(step).map_or(0.0, |step| step[1]),
                }
            })
    }

    /// The largest energy that two discs exchange at a step of a well (mass × length² / time²); 0
    /// without wells.
    pub fn largest_step(&self) -> f64 {
        self.world.pairs.largest_step()
    }

    /// The potential energy of all wells (mass × length² / time²).
    pub fn energy_of_wells(&self) -> f64 {
        exact_sum(self.pairs_in_wells().map(|pair| pair.energy))
    }
}
