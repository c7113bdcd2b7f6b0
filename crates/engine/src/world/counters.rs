//! Counters of events, and the energy ledger.

use std::ops::Add;

use serde::{Deserialize, Serialize};

/// Counts of events since the system was built; edits do not reset them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Counters {
    /// Contacts between two bodies, including fixed ones.
    pub collisions: u64,
    /// Of these, contacts with a fixed body.
    pub fixed_collisions: u64,
    /// Contacts with a wall that has a temperature
    /// ([`WallSpec::temperature`](crate::WallSpec::temperature)).
    pub thermal_collisions: u64,
    /// Contacts of bodies between which a reaction was possible
    /// ([`ReactionSpec`](crate::ReactionSpec)), whatever their energy.
    pub reactive_collisions: u64,
    /// Reactions that have taken place at such contacts.
    pub reactions: u64,
    /// Contacts whose impulse the guard against inelastic collapse has changed
    /// ([`ElasticitySpec::contact_time`](crate::ElasticitySpec::contact_time)), by any amount.
    /// Their energy is in [`Ledger::spared`]. Contacts of a response that ignores the raised
    /// elasticity are not counted.
    pub guarded_collisions: u64,
    /// Contacts of two bodies at several points at one instant, with one joint impulse.
    pub joint_collisions: u64,
    /// Events at which a bond has reached one of its bounds; they count among the collisions.
    pub bond_collisions: u64,
    /// Events at which two discs have reached a step of their well; they count among the
    /// collisions.
    pub step_collisions: u64,
    /// Contacts that follow another contact of one of their bodies at the same instant. They are
    /// resolved one after the other, and the result depends on their order.
    pub simultaneous_collisions: u64,
    /// Epochs begun: periods at the start of which all events are predicted anew.
    pub epochs: u64,
    /// Work of the scheduler.
    pub scheduler: SchedulerCounters,
}

impl Counters {
    /// Contacts counted for each body that moves: twice, but once with a fixed body.
    ///
    /// ```
    /// use carom_engine::{Scene, Simulation};
    ///
    /// let gas = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20\n";
    /// let mut simulation = Simulation::new(&Scene::from_toml(gas)?)?;
    /// simulation.run_until(1.0)?;
    /// let counters = simulation.view().counters();
    /// // No body is fixed.
    /// assert_eq!(counters.collisions_of_moving(), 2 * counters.collisions);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn collisions_of_moving(&self) -> u64 {
        (2 * self.collisions).saturating_sub(self.fixed_collisions)
    }

    /// The largest count, including those of the scheduler.
    pub(crate) fn largest_count(&self) -> u64 {
        let Self {
            collisions,
            fixed_collisions,
            thermal_collisions,
            reactive_collisions,
            reactions,
            guarded_collisions,
            joint_collisions,
            bond_collisions,
            step_collisions,
            simultaneous_collisions,
            epochs,
            scheduler,
        } = *self;
        let counts = [
            collisions,
            fixed_collisions,
            thermal_collisions,
            reactive_collisions,
            reactions,
            guarded_collisions,
            joint_collisions,
            bond_collisions,
            step_collisions,
            simultaneous_collisions,
            epochs,
        ];
        counts.into_iter().fold(scheduler.largest_count(), u64::max)
    }
}

/// Work of a scheduler in finding the contacts.
///
/// These counts depend on the scheduler, not on the trajectory alone. They show the cause of high
/// cost: with many crossings the cells are too small; with many stale predictions the gas is dense;
/// with many re-checks molecules fly for long at a small gap.
///
/// In tiles, the work of a window that is run ahead of frequent stops is added at its end; if an
/// edit ends it, it is not counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SchedulerCounters {
    /// Entries of a body into another cell. Multi-cell bodies of
    /// [`CellScheduler`](crate::CellScheduler) are not counted.
    pub crossings: u64,
    /// Predictions that reached the front of the queue after a change of the partner's motion.
    /// [`HeapScheduler`](crate::HeapScheduler) has one prediction per pair and drops stale ones;
    /// [`CellScheduler`](crate::CellScheduler) has one per body and predicts the body anew.
    pub stale: u64,
    /// Continuations of searches that had ended "certified free until" or without certainty. Fewer
    /// than such searches: a body that has another contact first is predicted anew in any case.
    pub rechecks: u64,
    /// Searches that ended without certainty; always 0 with the exact detector.
    pub unresolved: u64,
    /// Pairs searched for their first contact (narrow phase). Pairs in the loop over small discs of
    /// [`CellScheduler`](crate::CellScheduler) are not counted, since counting them would take a
    /// noticeable share of the time of the search.
    pub pairs: u64,
}

impl SchedulerCounters {
    fn largest_count(self) -> u64 {
        let Self {
            crossings,
            stale,
            rechecks,
            unresolved,
            pairs,
        } = self;
        let counts = [crossings, stale, rechecks, unresolved, pairs];
        counts.into_iter().fold(0, u64::max)
    }
}

impl Add for SchedulerCounters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            crossings: self.crossings + other.crossings,
            stale: self.stale + other.stale,
            rechecks: self.rechecks + other.rechecks,
            unresolved: self.unresolved + other.unresolved,
            pairs: self.pairs + other.pairs,
        }
    }
}

/// Energy lost and put in since the system was built (mass × length² / time²).
///
/// At any time the kinetic energy is `initial − lost + put_in + heat + work + fallen + sheared +
/// wells − dragged`, to rounding: each contact and each edit may add an error of some roundings of
/// the largest energy and of the largest entry so far. After a large energy has been put in and
/// taken out again, the error may exceed the energy left.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Ledger {
    /// Energy at the start.
    pub initial: f64,
    /// Energy lost in contacts, less energy added by contacts. Includes all contacts, at any
    /// elasticity, for which `Response::conserves_energy` is false, and stops of pistons.
    pub lost: f64,
    /// Energy that the guard against inelastic collapse has saved: the energy after each guarded
    /// contact, less the energy after the same contact at the elasticity of the table. For
    /// information; not a term of [`Self::booked`].
    pub spared: f64,
    /// Energy put in by energy resets and by adding, removing or locking bodies, also by reactions.
    pub put_in: f64,
    /// Energy received from walls that have a temperature, less energy given to them
    /// ([`WallSpec::temperature`](crate::WallSpec::temperature)). Observers see each contact, and
    /// can sum it by wall.
    pub heat: f64,
    /// Work of the walls that move ([`WallSpec::motion`](crate::WallSpec::motion)) on the bodies
    /// that touch them: the sum of J · w over these contacts, with the impulse J on the body and
    /// the velocity w of the wall at the point of contact.
    pub work: f64,
    /// Energy taken by the drag of all bodies
    /// ([`Simulation::set_drag`](crate::Simulation::set_drag)).
    pub dragged: f64,
    /// Work of gravity on all bodies and of the forces on pistons: the loss of potential energy.
    #[doc(alias = "potential energy")]
    pub fallen: f64,
    /// Work of the shear ([`BoxSpec::shear_rate`](crate::BoxSpec::shear_rate)): the energy that
    /// bodies gain where they pass through the seam of the box, and where they touch through it. In
    /// the mean it is −γ A p_xy a unit of time.
    #[doc(alias = "viscous heating")]
    pub sheared: f64,
    /// Kinetic energy gained at the steps of wells ([`WellSpec`](crate::WellSpec)): their loss of
    /// potential energy while the rules remain.
    pub wells: f64,
    /// `dragged` at the start of the epoch.
    pub(crate) dragged_before: f64,
    /// What contacts have taken in this epoch, each at the share 1 − (1 − γ s)² that the drag had
    /// taken of it before, so that it is not counted twice.
    pub(crate) dragged_from_lost: f64,
    /// `fallen` at the start of the epoch.
    pub(crate) fallen_before: f64,
    /// Σ m a·x over all bodies at the start of the epoch.
    pub(crate) fell_from: f64,
}

impl Ledger {
    /// The kinetic energy according to the ledger: `initial − lost + put_in + heat + work +
    /// fallen + sheared + wells − dragged`.
    pub fn booked(&self) -> f64 {
        let given = self.put_in + self.heat + self.work + self.fallen + self.sheared + self.wells;
        self.initial - self.lost + given - self.dragged
    }

    /// Books an energy lost in a contact, at the velocities of the epoch's clock, when the drag has
    /// slowed all bodies to this share.
    pub(crate) fn book_loss(&mut self, lost: f64, slowing: f64) {
        self.lost += self.slowed(lost, slowing);
    }

    /// Books the heat of a contact with a wall that has a temperature, like [`Self::book_loss`].
    pub(crate) fn book_heat(&mut self, heat: f64, slowing: f64) {
        self.heat -= self.slowed(-heat, slowing);
    }

    /// Books the true energy gained at a step of a well; the drag takes it at the velocities of the
    /// epoch's clock, like [`Self::book_loss`].
    pub(crate) fn book_step(&mut self, gain: f64, slowing: f64) {
        let of_clock = gain / (slowing * slowing);
        self.wells -= self.slowed(-of_clock, slowing);
    }

    /// The true value of an energy that a contact has taken, of which the drag had taken the rest.
    fn slowed(&mut self, lost: f64, slowing: f64) -> f64 {
        let squared = slowing * slowing;
        self.dragged_from_lost += lost * (1.0 - squared);
        lost * squared
    }

    /// Books what the drag has taken in this epoch up to now, when it has slowed all bodies to this
    /// share, from the energy at the velocities of the epoch's clock.
    ///
    /// With that energy E and true energies E f², f = 1 − γ s, the drag takes −∫ E d(f²) =
    /// E (1 − f²) + Σ δₖ (1 − fₖ²), of which the sum is over the energies δₖ lost in contacts.
    pub(crate) fn book_drag(&mut self, energy: f64, slowing: f64) {
        let taken = energy * (1.0 - slowing * slowing) + self.dragged_from_lost;
        self.dragged = self.dragged_before + taken;
    }

    /// Begins an epoch.
    pub(crate) fn restart_drag(&mut self) {
        (self.dragged_before, self.dragged_from_lost) = (self.dragged, 0.0);
    }

    /// Books the work of gravity in this epoch up to now, from Σ m a·x over all bodies.
    pub(crate) fn book_gravity(&mut self, sum: f64) {
        self.fallen = self.fallen_before + (sum - self.fell_from);
    }

    /// Begins an epoch with this sum of m a·x.
    pub(crate) fn restart_gravity(&mut self, sum: f64) {
        (self.fallen_before, self.fell_from) = (self.fallen, sum);
    }

    /// All entries, to be checked.
    pub(crate) fn entries(&self) -> [f64; 14] {
        let Self {
            initial,
            lost,
            spared,
            put_in,
            heat,
            work,
            dragged,
            dragged_before,
            dragged_from_lost,
            fallen,
            sheared,
            wells,
            fallen_before,
            fell_from,
        } = *self;
        [
            initial,
            lost,
            spared,
            put_in,
            heat,
            work,
            dragged,
            dragged_before,
            dragged_from_lost,
            fallen,
            sheared,
            wells,
            fallen_before,
            fell_from,
        ]
    }
}
