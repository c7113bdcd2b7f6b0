//! `viscosity` and `heat-conductivity`: from the Helfand moments of the stress and of the energy.

use carom::{CollisionReport, Observer, View, engine::Body, observers::HelfandMoment};
use carom_tables::{BlockMean, Sums, Table};
use serde::{Deserialize, Serialize};

use crate::curves::{Coefficient, Reading};

use super::{
    Context, HardDiscs, MAX_LAG, MeasureKind, Measured, Of, Results, Selection, Span,
    hard_discs::SONINE, in_blocks, resumed,
};

/// The coefficient is the slope of the mean square between these lags (mean free times). Shorter:
/// the stress has not decayed. Longer: larger errors.
const BETWEEN: [f64; 2] = [5.0, 20.0];

/// A measurement of so many mean free times has an error of the coefficient: lags have errors up to
/// a sixteenth of it.
pub(crate) const FREE_TIMES_FOR_TRANSPORT: f64 = 16.0 * BETWEEN[1];

/// Whether a measure of this name has a coefficient that needs long lags.
pub(crate) fn is_transport(name: &str) -> bool {
    [VISCOSITY.name, HEAT_CONDUCTIVITY.name].contains(&name)
}

pub(super) const VISCOSITY: MeasureKind = MeasureKind {
    name: "viscosity",
    summary: "shear viscosity of the whole system from the Helfand moment of the stress",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[MAX_LAG],
    figures: &["shear viscosity, from lags … to …"],
    start: |selection| {
        let (interval, longest) = lags(selection);
        let moment = HelfandMoment::new(interval, longest)?;
        Ok(in_blocks(Helfand::new(moment, Transported::Momentum)))
    },
    resume: resumed::<Helfand>,
};

pub(super) const HEAT_CONDUCTIVITY: MeasureKind = MeasureKind {
    name: "heat-conductivity",
    summary: "heat conductivity of the whole system from the Helfand moment of the energy",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[MAX_LAG],
    figures: &["heat conductivity λ/k, from lags … to …"],
    start: |selection| {
        let (interval, longest) = lags(selection);
        let moment = HelfandMoment::of_energy(interval, longest)?;
        Ok(in_blocks(Helfand::new(moment, Transported::Heat)))
    },
    resume: resumed::<Helfand>,
};

/// The spacing of the samples and the longest lag (time).
fn lags(selection: &Selection<'_>) -> (f64, f64) {
    (selection.interval(), selection.longest_lag())
}

/// A Helfand moment, with what its slope is divided by.
#[derive(Serialize, Deserialize)]
struct Helfand {
    of: Transported,
    moment: HelfandMoment,
    /// Sum of kT over the samples (mass × length² / time²), and their number.
    temperatures: [f64; 2],
    /// Contacts of bodies that move, without those at bonds and steps, and time, at the first and
    /// at the last sample.
    contacts: Option<[(u64, f64); 2]>,
    /// The box and the bodies at the first sample.
    system: Option<System>,
}

/// What flows: a gas has a viscosity for momentum, and a conductivity for heat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Transported {
    Momentum,
    Heat,
}

/// The box and the bodies of a run.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct System {
    /// Area of the box (length²).
    area: f64,
    /// Number of bodies that move.
    moving: usize,
    /// Whether momentum is conserved along both axes.
    conserves_momentum: bool,
    /// Whether all bodies are of one kind.
    is_pure: bool,
    /// Whether some are tied to each other.
    has_bonds: bool,
}

impl System {
    fn new(view: &View<'_>) -> Self {
        let molecules = || {
            let free = view.bodies().filter(|body| body.body.is_free());
            free.map(|body| body.body.molecule())
        };
        let first = molecules().next();
        Self {
            area: view.bounds().area(),
            moving: molecules().count(),
            conserves_momentum: view.centre_of_mass_frame().conserves_momentum() == [true; 2],
            is_pure: molecules().all(|molecule| Some(molecule) == first),
            has_bonds: view.bonds().len() > 0,
        }
    }
}

impl Helfand {
    fn new(moment: HelfandMoment, of: Transported) -> Self {
        Self {
            of,
            moment,
            temperatures: [0.0; 2],
            contacts: None,
            system: None,
        }
    }

    /// Contacts of a body that moves by time; `None` before the second sample.
    fn collision_rate(&self) -> Option<f64> {
        let [(first, start), (last, end)] = self.contacts?;
        let rate = (last - first) as f64 / (self.system?.moving as f64 * (end - start));
        (rate.is_finite() && rate > 0.0).then_some(rate)
    }

    /// Why the slope of the mean square is no coefficient of the system, if it is none.
    fn obstacle(&self, context: &Context<'_>) -> Option<&'static str> {
        let system = self.system?;
        if !system.conserves_momentum {
            return Some("fixed bodies or walls take up momentum");
        }
        if !context.is_equilibrium {
            return Some("the system is not left alone at equilibrium");
        }
        if system.has_bonds {
            return Some("bodies are tied, and their stress decays later than that of free ones");
        }
        let is_heat = self.of == Transported::Heat;
        (is_heat && !system.is_pure).then_some("the bodies differ, so that they carry enthalpy")
    }

    /// The coefficient from the slope of the mean square, once it is known between which lags.
    fn coefficient(&self, context: &Context<'_>) -> Option<Coefficient> {
        let rate = self.collision_rate()?;
        let [sum, samples] = self.temperatures;
        let (kt, area) = (sum / samples, self.system?.area);
        let viscosity: fn(&HardDiscs) -> f64 = HardDiscs::viscosity;
        let (named, per_slope, theory) = match self.of {
            Transported::Momentum => (("shear viscosity", "mass/time"), 2.0 * area * kt, viscosity),
            Transported::Heat => (
                ("heat conductivity λ/k", "1/time"),
                2.0 * area * kt * kt,
                HardDiscs::heat_conductivity as fn(&HardDiscs) -> f64,
            ),
        };
        let between = Reading::SlopeBetween(BETWEEN.map(|times| times / rate));
        let reading = (between, 1.0 / per_slope);
        let coefficient =
            Coefficient::new(named, reading, 0, &self.moment.lags(), context.of_curves());
        Some(coefficient.predicted(context.gas().map(theory), SONINE))
    }

    /// The table of the mean square, without its caption.
    fn table(&self, lags: &[f64], means: &[BlockMean], context: &Context<'_>) -> Table {
        let (name, title, unit) = match self.of {
            Transported::Momentum => (
                VISCOSITY.name,
                "Mean squared Helfand moment of the shear stress",
                "mass²·length⁴/time²",
            ),
            Transported::Heat => (
                HEAT_CONDUCTIVITY.name,
                "Mean squared Helfand moment of the energy",
                "mass²·length⁶/time⁴",
            ),
        };
        let points = self.moment.points();
        Table::new(context.table(name), title)
            .logarithmic()
            .abscissa("lag", "time", lags.to_vec())
            .counts(
                "origins",
                points.iter().map(|point| point.origins).collect(),
            )
            .means("mean_square", unit, means)
    }
}

impl Observer for Helfand {
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.moment.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.moment.start(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.moment.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.moment.sample(view);
        self.system.get_or_insert_with(|| System::new(view));
        if let Some(kt) = view.temperature() {
            self.temperatures[0] += kt;
            self.temperatures[1] += 1.0;
        }
        let counters = view.counters();
        let others = 2 * (counters.bond_collisions + counters.step_collisions);
        let contacts = counters.collisions_of_moving().saturating_sub(others);
        let now = (contacts, view.time().to_f64());
        self.contacts.get_or_insert([now; 2])[1] = now;
    }
}

impl Measured for Helfand {
    fn sums(&self) -> Sums {
        self.moment.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.moment.points();
        let lags: Vec<f64> = points.iter().map(|point| point.lag).collect();
        let means = context.resolved(means, &lags);
        let table = self.table(&lags, &means, context);
        if let Some(obstacle) = self.obstacle(context) {
            let caption = format!("Its slope is no coefficient of the system: {obstacle}.");
            let name = match self.of {
                Transported::Momentum => "viscosity",
                Transported::Heat => "heat conductivity",
            };
            return Results {
                tables: vec![table.caption(caption)],
                reasons: vec![format!("No {name} of the system: {obstacle}.")],
                ..Results::default()
            };
        }
        let caption = match self.of {
            Transported::Momentum => "Its slope over 2 A kT is the shear viscosity.",
            Transported::Heat => "Its slope over 2 A (kT)² is the heat conductivity by k.",
        };
        Results {
            tables: vec![table.caption(caption)],
            coefficients: self.coefficient(context).into_iter().collect(),
            ..Results::default()
        }
    }
}
