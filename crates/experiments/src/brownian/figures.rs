//! Figures of the experiment, with errors and predictions.

use carom::{
    DirectionHistogram,
    observers::{Block, Drift, RunningPoint},
};
use carom_report::molecule_picture::name;
use carom_tables::{Check, Figure};
use glam::DVec2;

use super::{
    dilute::{self, FewDiscs},
    group::{Group, impulse_error},
    pooled::{MIN_BLOCKS, Pooled},
    results::{SECTORS, increments},
};

const ENSKOG: &str = "Enskog with the contact value of hard discs (virial series of Clisby and McCoy 2006; \
                      Henderson 1975), accurate to 0.3 %; the area of the molecule is neglected";
const FEW_DISCS: &str = "ideal gas, n √(kT / 2π) ∮ μ^(−1/2) ds and n kT P, with the free area of so few \
                         discs, at fixed energy; accurate to 0.3 %";

const POCKETS: &str = "area of pockets inside the molecule, which the gas cannot enter";

/// A value that is exact at equilibrium and deviates by more standard errors is a fault, not
/// chance: with 30 blocks, chance exceeds this once in 600 000 findings (Student's t). Smaller:
/// correct runs would fail. Larger: faults would pass.
pub const BROKEN: f64 = 6.0;

impl Group<'_> {
    /// Checks: no kicks on unreachable atoms, equipartition, and the exposed arcs in a dilute gas.
    pub fn checks(&self) -> Vec<Check> {
        let hits = |atom: &usize| self.kicks.by_atom[*atom];
        let unreachable: u64 = self.prediction.boundary.unreachable().iter().map(hits).sum();
        let mut checks = vec![Check::at_most("hits on unreachable atoms", unreachable as f64, 0.0)];
        checks.extend(dilute::checks(self));
        for Figure { name, value, standard_error, prediction, .. } in self.equipartition_figures() {
            if let (Some(error), Some(prediction)) = (standard_error, prediction) {
                checks.push(Check::at_most(
                    &format!("{name}, standard errors from equipartition"),
                    ((value - prediction) / error).abs(),
                    BROKEN,
                ));
            }
        }
        checks
    }

    /// All figures.
    pub fn figures(&self) -> Vec<Figure> {
        let mut figures = self.overall_figures();
        figures.extend(self.atom_figures());
        let exposed = |atom: usize| {
            let degrees = self.prediction.boundary.exposed_angle(atom).to_degrees();
            Figure::new(format!("exposed angle of atom {}", name(atom)), degrees, "degree")
        };
        figures.extend((0..self.molecule().atoms().len()).map(exposed));
        figures
    }

    /// Figures of the molecule as a whole.
    pub fn overall_figures(&self) -> Vec<Figure> {
        let mut figures = vec![self.temperature_figure()];
        figures.extend(self.rate_figure());
        figures.extend(self.hit_figures());
        figures.extend(self.equipartition_figures());
        figures.extend(self.symmetry_figure());
        figures.extend(self.region_figures());
        let times = self.relaxation_times();
        for (time, what) in times
            .into_iter()
            .zip(["velocity", "rotation"])
            .filter(|(time, _)| *time > 0.0 && time.is_finite())
        {
            figures.push(Figure::new(format!("relaxation time of its {what}, from the kicks"), time, "time"));
        }
        figures
    }

    /// Lengths and areas that follow from the atoms alone, without errors.
    fn region_figures(&self) -> Vec<Figure> {
        let region = &self.prediction.boundary;
        let mut figures = vec![
            Figure::new("perimeter of the excluded region", region.perimeter(), "length"),
            Figure::new("area of the excluded region", region.area(), "length²"),
        ];
        if !region.hidden_arcs().is_empty() {
            figures.push(Figure::new(POCKETS, region.pocket_area(), "length²"));
        }
        figures
    }

    fn temperature_figure(&self) -> Figure {
        let booked = self.runs.iter().map(|run| run.booked_temperature).sum::<f64>() / self.runs.len() as f64;
        Figure::new("temperature kT", self.temperature(), "mass·length²/time²")
            .predicted(booked, "initial energy divided by all degrees of freedom")
    }

    fn rate_figure(&self) -> Option<Figure> {
        let rates: Vec<(f64, f64)> = self.runs.iter().filter_map(|run| run.rate).collect();
        let count = rates.len() as f64;
        let value = rates.iter().map(|rate| rate.0).sum::<f64>() / count;
        let error = rates.iter().map(|rate| rate.1 * rate.1).sum::<f64>().sqrt() / count;
        let figure = Figure::new("collisions per body", value, "1/time").error(error);
        let (predicted, source) = if dilute::is_dilute(self) {
            (FewDiscs::of(self).collisions, FEW_DISCS)
        } else {
            (self.prediction.collision_rate(self.density(), self.temperature()), ENSKOG)
        };
        let predicted = self.setting.is_open().then_some(predicted);
        (!rates.is_empty()).then(|| figure.predicted(predicted, source))
    }

    fn hit_figures(&self) -> Vec<Figure> {
        let (hits, duration) = (self.kicks.hits(), self.duration());
        let (density, temperature) = (self.density(), self.temperature());
        let rate = Figure::new("kicks of the molecule", self.hit_rate(), "1/time").error(self.kick_error(
            |block| (block.observed.hits() as f64, block.duration),
            (hits as f64).sqrt() / duration,
        ));
        let impulse = self.kicks.total_impulse();
        let force_error = self.kick_error(
            |block| (block.observed.total_impulse(), block.duration),
            impulse_error(impulse, hits) / duration,
        );
        let ideal = self.prediction.ideal_impulse(density, temperature);
        let contact =
            Figure::new("gas density at the molecule's rim", impulse / duration / ideal, "mean density")
                .error(force_error / ideal);
        if dilute::is_dilute(self) {
            let few = FewDiscs::of(self);
            return vec![rate.predicted(few.kicks, FEW_DISCS), contact.predicted(few.rim, FEW_DISCS)];
        }
        if self.is_mixed() {
            // The mean density at the rim has no meaning for discs of different reach.
            return vec![rate];
        }
        if !self.is_round() || !self.setting.is_open() {
            return vec![rate, contact];
        }
        let radius = self.molecule().bounding_radius();
        let value = self.prediction.contact_density_of_disc(radius, density);
        let source = "Jenkins and Mancini (1987), for hard discs of two sizes; approximate, accurate to 1 %";
        let rate_value = value * self.prediction.ideal_rate(density, temperature);
        vec![rate.predicted(rate_value, source), contact.predicted(value, source)]
    }

    /// Twice the mean energy in each degree of freedom of the molecule: kT for any mass and
    /// density.
    fn equipartition_figures(&self) -> Vec<Figure> {
        let molecule = self.molecule();
        let mean = |energy: &dyn Fn(&Drift) -> f64| {
            let pair = |block: &Block<Drift>| (energy(&block.observed), block.observed.samples() as f64);
            Pooled::of(self.runs, |run| &run.drift, pair)
        };
        let shares = self.thermal_shares();
        let mut energies = vec![
            ("along x′", shares.x, mean(&|drift| molecule.mass() * drift.velocity_squares().x)),
            ("along y′", shares.y, mean(&|drift| molecule.mass() * drift.velocity_squares().y)),
        ];
        if self.turns() {
            let turning = mean(&|drift| molecule.moment_of_inertia() * drift.spin_squares());
            energies.push(("turning", 1.0, turning));
        }
        let equal = "equipartition: kT is twice the total energy divided by the degrees of freedom";
        let of_all = "equipartition relative to the centre of mass of all bodies, whose momentum is conserved: \
                      less than kT by the molecule's part of the mass";
        let long = self.has_long_blocks();
        let figure = |(name, share, energy): (&str, f64, Pooled)| {
            let source = if share < 1.0 { of_all } else { equal };
            Figure::new(format!("kT of the molecule {name}"), energy.mean(), "mass·length²/time²")
                .error(energy.standard_error().filter(|_| long))
                .predicted(share * self.temperature(), source)
        };
        energies.into_iter().map(figure).collect()
    }

    /// Standard error of a ratio of two sums over the kicks, from the scatter of the blocks; with
    /// too few blocks, the value for independent kicks.
    pub fn kick_error(
        &self,
        pair: impl Fn(&Block<DirectionHistogram>) -> (f64, f64),
        independent: f64,
    ) -> f64 {
        Pooled::of(self.runs, |run| &run.directions, pair).standard_error().unwrap_or(independent)
    }

    /// Standard error of the time average in one run, along the axis with the larger error, from
    /// the scatter of the blocks of all runs; `None` with too few blocks.
    pub fn error_of_one_run(&self, sum: impl Fn(&Drift) -> DVec2) -> Option<f64> {
        let along = |axis: usize| {
            let pair = |block: &Block<Drift>| (sum(&block.observed)[axis], block.duration);
            Pooled::of(self.runs, |run| &run.drift, pair).standard_error()
        };
        let of_all = along(0)?.max(along(1)?);
        Some(of_all * (self.runs.len() as f64).sqrt())
    }

    /// Standard errors of the mean force along x′ and y′ over `duration`, in one run or in all
    /// together.
    ///
    /// In a frame that does not rotate, the kicks sum to P(t) − P(0), of variance 2MkT for each
    /// run. In a rotating frame they diffuse, and the blocks give the diffusion constant; with too
    /// few blocks, the sums between samples do.
    pub fn force_errors(&self, duration: f64) -> Option<DVec2> {
        if !self.turns() {
            let runs = (duration / self.runs[0].duration).max(1.0);
            let mass = self.molecule().mass();
            return Some(DVec2::splat((2.0 * mass * self.temperature() * runs).sqrt() / duration));
        }
        if let Some(error) = self.error_of_one_run(Drift::impulse) {
            return Some(DVec2::splat(error * (self.runs[0].duration / duration).sqrt()));
        }
        let all: Vec<DVec2> = self.runs.iter().flat_map(|run| increments(&run.averages, self.from)).collect();
        if all.len() < 4 {
            return None;
        }
        let squares: DVec2 = all.iter().map(|increment| *increment * *increment).sum();
        let diffusion = squares / self.duration();
        Some(DVec2::new((diffusion.x / duration).sqrt(), (diffusion.y / duration).sqrt()))
    }

    /// χ² per degree of freedom of the molecule's mirror symmetry, which holds at any density: each
    /// direction against its mirror image, with errors from the scatter of the blocks, because
    /// kicks in one direction are correlated. A disc is tested by its harmonics, see
    /// [`equilibrium`](super::equilibrium).
    fn symmetry_figure(&self) -> Option<Figure> {
        let pairs = self.mirror.as_ref().filter(|_| !self.is_round())?.sectors(SECTORS)?;
        let counts = &self.kicks.counts;
        let deviation = |(one, other): (usize, usize)| {
            let (here, there) = (counts[one] as f64, counts[other] as f64);
            let error = self.duration()
                * self.kick_error(
                    |block| {
                        let counts = block.observed.counts();
                        (counts[one] as f64 - counts[other] as f64, block.duration)
                    },
                    (here + there).sqrt() / self.duration(),
                );
            (here + there > 0.0).then(|| (here - there) / error)
        };
        let deviations: Vec<f64> = pairs.into_iter().filter_map(deviation).collect();
        let freedom = deviations.len().max(1) as f64;
        let squares: f64 = deviations.iter().map(|deviation| deviation * deviation).sum();
        // With errors from b blocks the deviations follow Student's t, whose mean square is (b −
        // 1)/(b − 3).
        let blocks = self.runs.iter().map(|run| run.directions.complete().len()).sum::<usize>() as f64;
        let judged = blocks >= MIN_BLOCKS as f64;
        let expected = if judged { (blocks - 1.0) / (blocks - 3.0) } else { 1.0 };
        Some(
            Figure::new("mirror symmetry of the kicks, χ² per degree of freedom", squares / freedom, "1")
                .error(expected * (2.0 / freedom).sqrt())
                .predicted(expected, "mirror symmetry of the molecule; Student's t for errors from blocks"),
        )
    }

    /// Share of the kicks on each atom; none for a disc or without kicks.
    pub fn atom_figures(&self) -> Vec<Figure> {
        let hits = self.kicks.hits() as f64;
        if self.molecule().is_disc() || hits == 0.0 {
            return Vec::new();
        }
        let shares = self.prediction.atom_shares();
        self.kicks
            .by_atom
            .iter()
            .zip(shares)
            .enumerate()
            .map(|(atom, (&count, predicted))| {
                let share = count as f64 / hits;
                let source = if predicted == 0.0 {
                    "geometry: the gas discs cannot reach it"
                } else if dilute::is_dilute(self) {
                    "exposed arcs, with weight μ^(−1/2)"
                } else {
                    "dilute gas: exposed arcs; in this dense gas the density is larger in the corners"
                };
                // What the smallest disc cannot reach, no other can.
                let is_known = predicted == 0.0 || self.has_arcs();
                Figure::new(format!("share of kicks on atom {}", name(atom)), share, "1")
                    .error(self.kick_error(
                        |block| {
                            let on_atom = block.observed.atom_counts().get(atom).copied().unwrap_or(0);
                            (on_atom as f64, block.observed.hits() as f64)
                        },
                        (share * (1.0 - share) / hits).sqrt(),
                    ))
                    .predicted(is_known.then_some(predicted), source)
            })
            .collect()
    }
}

/// The running averages of a run: time since the start of the measurement, and force.
pub fn force_series(averages: &[RunningPoint], from: f64) -> Vec<(f64, DVec2)> {
    averages.iter().map(|point| (point.time - from, point.momentum)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_sums_of_impulses() {
        assert_eq!(impulse_error(1.0, 0), 0.0);
        // One Rayleigh-distributed impulse: the root mean square is √(4/π) times the mean.
        assert!((impulse_error(2.0, 1) - 2.0 * std::f64::consts::FRAC_2_SQRT_PI).abs() < 1e-15);
    }
}
