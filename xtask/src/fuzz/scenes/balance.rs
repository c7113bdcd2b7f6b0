//! The balance of energy and momentum: the ledger against the sum of all reports.

use carom::engine::View;
use carom_kinematics::EpochTime;
use carom_testkit::oracle::Number as _;

use super::{
    kinematics::{BodyPair, dot, length},
    tracked::{TrackedBody, energy},
    watcher::Watcher,
};
use crate::fuzz::subject::exceeds;

impl Watcher {
    pub(super) fn keep_largest_entry(&mut self, view: &View<'_>) {
        let ledger = view.ledger();
        let entries = [
            view.energy(),
            ledger.initial,
            ledger.lost,
            ledger.put_in,
            ledger.heat,
            ledger.dragged,
            ledger.work,
            ledger.fallen,
            ledger.wells,
            // Sums of m a·x over all bodies less the energies of springs, of which an entry is the
            // difference.
            self.largest_potential_energy(),
        ];
        self.largest_entry = entries
            .into_iter()
            .map(f64::abs)
            .fold(self.largest_entry, f64::max);
    }

    /// The work of gravity on a body, and of the force and the spring of a piston, since its last
    /// report, and a bound on its error (mass × length² / time²).
    pub(super) fn fall(&self, body: &TrackedBody, time: EpochTime) -> [f64; 2] {
        let largest = body.state.top_acceleration();
        if largest == 0.0 {
            return [0.0; 2];
        }
        let way = body.state.displacement(time).map(|way| way.value());
        let error = self.error(body, time) + 4.0 * f64::EPSILON * length(way);
        let mean = body.state.mean_acceleration(way);
        [dot(mean, way), largest * error].map(|work| body.mass * work)
    }

    /// The total momentum at a time after all events so far.
    pub(super) fn total_momentum(&self, time: EpochTime) -> BodyPair {
        let axis_of = |body: &TrackedBody| body.piston.map(|piston| piston.stops.axis);
        let sum = |axis: usize| {
            // Stops and forces change the momentum along the axis of a piston.
            if self.bodies.values().any(|body| axis_of(body) == Some(axis)) {
                return 0.0;
            }
            self.bodies
                .values()
                .map(|body| body.mass * body.state.velocity[axis] * body.state.slowing(time))
                .sum::<f64>()
        };
        [sum(0), sum(1)]
    }

    /// The number of epochs, each of which adds roundings to all sums if there is a drag, a
    /// gravity, a force or a spring.
    pub(super) fn rounding_epochs(&self) -> f64 {
        let falls = self
            .bodies
            .values()
            .any(|body| body.state.top_acceleration() > 0.0);
        if self.rules.drag == 0.0 && !falls {
            0.0
        } else {
            self.epochs as f64
        }
    }

    pub(super) fn compare_sums(&mut self, view: &View<'_>) {
        self.keep_largest_entry(view);
        let scale = self.largest_entry.max(self.largest_energy);
        if scale > 1e-280 {
            self.compare_energies(view, scale);
        }
        self.compare_momentum(view);
    }

    /// Compares the energy of the view and the ledger with the reports, where `scale` is the
    /// largest energy so far (mass × length² / time²).
    fn compare_energies(&mut self, view: &View<'_>, scale: f64) {
        let epochs = self.rounding_epochs();
        let allowed = 16.0 * f64::EPSILON * (self.entries + epochs) * scale;
        let fallen = self.total_fall(view.time());
        self.compare_ledger(view, fallen, allowed);
        // The motions of the view have been compared one by one.
        let own: f64 = view.bodies().map(|body| energy(&body)).sum();
        let rounding = 16.0 * f64::EPSILON * (16.0 + view.len() as f64) * own;
        if exceeds((view.energy() - own).abs(), rounding) {
            self.report.fail(
                "energy of the view",
                format!("it is {:e}, that of the bodies {own:e}", view.energy()),
            );
        }
        if self.rules.drag == 0.0 {
            self.compare_balance(own, fallen, allowed + rounding);
        }
    }

    /// The work of gravity, forces and springs on all bodies from the last edit to `time`, and a
    /// bound on its error (mass × length² / time²).
    fn total_fall(&self, time: EpochTime) -> [f64; 2] {
        self.bodies.values().map(|body| self.fall(body, time)).fold(
            [self.fallen, self.fallen_error],
            |[sum, errors], [work, error]| [sum + work, errors + error],
        )
    }

    /// Compares the entries of the ledger since the last edit with the sums over all reports, and
    /// its total with the energy of the view.
    fn compare_ledger(&mut self, view: &View<'_>, [fallen, fallen_error]: [f64; 2], allowed: f64) {
        let ledger = view.ledger();
        let (lost, work) = (
            ledger.lost - self.lost_before,
            ledger.work - self.work_before,
        );
        let fall = ledger.fallen - self.fallen_before;
        let gain = ledger.wells - self.gained_before;
        let of_forces = "work of gravity, forces and springs";
        for (name, entry, own, error) in [
            ("loss", lost, self.lost, self.work_error),
            ("work", work, self.work, self.work_error),
            (of_forces, fall, fallen, fallen_error),
            ("gain in wells", gain, self.gained, 0.0),
        ] {
            if exceeds((entry - own).abs(), allowed + error) {
                self.report.fail(
                    "ledger",
                    format!("the ledger has a {name} of {entry:e}, the reports of {own:e}"),
                );
            }
        }
        let (energy, booked) = (view.energy(), ledger.booked());
        if exceeds((energy - booked).abs(), allowed) {
            self.report.fail(
                "ledger",
                format!("the energy is {energy:e}, the ledger has {booked:e}"),
            );
        }
    }

    /// Compares the growth of the kinetic energy to `own` since the last edit with the work of
    /// walls and of gravity and the gain in wells, less the losses. `allowed` is the bound on the
    /// rounding errors of the sums.
    fn compare_balance(&mut self, own: f64, [fallen, fallen_error]: [f64; 2], allowed: f64) {
        let given = self.work + fallen + self.gained - self.lost;
        let off = (own - self.energy_before - given).abs();
        let allowed = allowed + 2.0 * self.work_error + fallen_error;
        self.report.keep_worst("balance/bound", off / allowed);
        if exceeds(off, allowed) {
            self.report.fail(
                "balance",
                format!(
                    "the energy grew from {:e} to {own:e} with {:e} from walls, {fallen:e} from \
                     gravity, forces and springs and a loss of {:e}: {off:e} is missing, allowed \
                     {allowed:e}",
                    self.energy_before, self.work, self.lost
                ),
            );
        }
    }

    pub(super) fn compare_momentum(&mut self, view: &View<'_>) {
        let epochs = self.rounding_epochs();
        if let Some((before, start)) = self.momentum {
            let now = self.total_momentum(view.time());
            let left = libm::exp(-self.rules.drag * view.time().since(start));
            let before = before.map(|momentum| left * momentum);
            let scale: f64 = self
                .bodies
                .values()
                .map(|body| body.mass * length(body.state.velocity))
                .sum::<f64>()
                + length(before);
            let contacts = self.contacts as f64 + epochs + 16.0;
            let most = scale.max((2.0 * self.largest_energy * self.total_mass()).sqrt());
            let off = length([now[0] - before[0], now[1] - before[1]]);
            if exceeds(off, 16.0 * f64::EPSILON * contacts * most) {
                self.report.fail(
                    "total momentum",
                    format!("it deviates by {off:e} of {most:e}"),
                );
            }
        }
    }

    /// The mass of all bodies that are not fixed.
    fn total_mass(&self) -> f64 {
        let free = self.bodies.values().filter(|body| !body.fixed);
        free.map(|body| body.mass).sum()
    }

    /// The sum over all bodies of the work of their constant accelerations along the longer side,
    /// and of the largest energies of springs (mass × length² / time²).
    fn largest_potential_energy(&self) -> f64 {
        let free = self.bodies.values().filter(|body| !body.fixed);
        let energies = free.map(|body| {
            let of_spring = body.piston.and_then(|piston| {
                let spring = piston.spring?;
                Some(spring.largest_energy(piston.stops.ends))
            });
            let of_fall = length(body.state.gravity) * self.longer_side();
            body.mass * (of_fall + of_spring.unwrap_or_default())
        });
        energies.sum()
    }
}
