//! `kicks:TAG`: the impulses on one body from the gas around it, and whether they drive it.
//!
//! At equilibrium no body is driven, whatever its shape: the means of its velocity and of the force
//! on it along its own axes are 0. The boundary that the body shows to the discs of a gas gives the
//! shares of the kicks by direction, by atom and by straight edge in a dilute gas.

mod few_discs;
mod figures;
mod fixed_energy;
mod from_gas;
mod mirror;
mod prediction;
mod surroundings;

pub use self::figures::NEEDED;
use anyhow::{Result, ensure};
use carom::{
    BodyKey, CollisionReport, ContactDensity, DirectionHistogram, Molecule, Observer, View,
    engine::Body,
    geometry::ExcludedRegion,
    observers::{AdaptiveHistogram, Drift},
};
use carom_report::molecule_picture::name;
use carom_tables::BlockMean;
use serde::{Deserialize, Serialize};

pub use self::{few_discs::DILUTE, fixed_energy::mean_speed};
use self::{
    figures::KickParts, from_gas::FromGas, mirror::Mirror, prediction::Prediction,
    surroundings::Surroundings,
};
use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    contact_density, directions, in_blocks, projections::Projections, resumed,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "kicks",
    summary: "kicks of the only body with the tag by bodies that move: directions, atoms, pressure along its \
              boundary, and its drift",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[Parameter::whole(
        "bins",
        Default::Number(72.0),
        "sectors of the whole turn, and bins of the components",
    )],
    figures: &[
        "kicks",
        "gas density",
        "velocity along",
        "angular velocity",
        "force along",
        "torque",
        "kT ",
        "relaxation time",
        "measurement that",
        "share of",
        "perimeter",
        "area of",
        "mirror symmetry",
        "isotropy",
        "impulse by direction",
    ],
    start: |selection| Ok(in_blocks(Kicks::new(selection)?)),
    resume: resumed::<Kicks>,
};

/// The kicks of one body, and its motion.
#[derive(Serialize, Deserialize)]
struct Kicks {
    body: BodyKey,
    shape: Shape,
    /// As of the start of the measurement; `None` before, or if nothing else moves.
    around: Option<Surroundings>,
    /// Impulse and pressure of an ideal gas on the boundary of the body (mass × length / time²);
    /// `None` without surroundings.
    ideal_impulse: Option<f64>,
    /// Kicks by bodies that move: directions, components and, in a gas of equal discs, places on
    /// the boundary.
    from_gas: FromGas<(DirectionHistogram, Projections, Option<ContactDensity>)>,
    /// All impulses on the body, and its motion.
    drift: Drift,
}

/// What the body is.
#[derive(Serialize, Deserialize)]
struct Shape {
    molecule: Molecule,
    is_fixed: bool,
    can_turn: bool,
    /// The parts on both sides of an axis of mirror symmetry; none without such an axis.
    sides: [Vec<usize>; 2],
}

impl Shape {
    /// The number of its atoms and straight edges.
    fn parts(&self) -> usize {
        self.molecule.atoms().len() + self.molecule.edges().len()
    }

    /// The name of a part: the letter of an atom, or "edge" and a number.
    fn part_name(&self, part: usize) -> String {
        match part.checked_sub(self.molecule.atoms().len()) {
            None => name(part),
            Some(edge) => format!("edge {edge}"),
        }
    }
}

impl Kicks {
    /// The only body of a selection.
    fn new(selection: &Selection<'_>) -> Result<Self> {
        let body = selection.only_body()?.body;
        ensure!(
            !body.is_wall(),
            "a wall has no kicks by direction; `wall-pressure` measures impulses on walls"
        );
        let key = body.key();
        let directions = DirectionHistogram::new(key, selection.whole("bins"));
        // A mixture has no single boundary.
        let places = contact_density::observer(selection).ok();
        let molecule = body.molecule().clone();
        let sides = Mirror::new(&molecule)
            .filter(|_| !molecule.is_round())
            .map(|mirror| mirror.sides());
        let shape = Shape {
            molecule,
            is_fixed: body.is_fixed(),
            can_turn: body.can_turn(),
            sides: sides.unwrap_or_default(),
        };
        Ok(Self {
            body: key,
            shape,
            around: None,
            ideal_impulse: None,
            from_gas: FromGas::new(key, (directions, Projections::new(selection)?, places)),
            drift: Drift::new(key),
        })
    }

    fn directions(&self) -> &DirectionHistogram {
        &self.from_gas.observer.0
    }

    /// Degrees of freedom of the body.
    fn freedom(&self) -> f64 {
        match (self.shape.is_fixed, self.shape.can_turn) {
            (true, _) => 0.0,
            (false, false) => 2.0,
            (false, true) => 3.0,
        }
    }

    /// The number of kicks of each atom, and then of each straight edge.
    fn by_part(&self) -> Vec<u64> {
        let molecule = &self.shape.molecule;
        let mut atoms = self.directions().atom_counts().to_vec();
        let mut edges = self.directions().edge_counts().to_vec();
        atoms.resize(molecule.atoms().len(), 0);
        edges.resize(molecule.edges().len(), 0);
        [atoms, edges].concat()
    }
}

impl Observer for Kicks {
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.drift.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        if self.around.is_none() {
            self.around = Surroundings::new(view, self.body);
            self.ideal_impulse = self.around.as_ref().and_then(|around| {
                let boundary = ExcludedRegion::new(&self.shape.molecule, around.probe).ok()?;
                Some(around.density() * around.temperature * boundary.perimeter())
            });
        }
        self.from_gas.start(view);
        self.drift.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.from_gas.pause(view);
        self.drift.pause(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.from_gas.collision(report);
        self.drift.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.from_gas.sample(view);
        self.drift.sample(view);
    }
}

impl Measured for Kicks {
    /// See [`KickParts`].
    fn sums(&self) -> Vec<[f64; 2]> {
        let (drift, directions) = (&self.drift, self.directions());
        let (hits, time, samples) = (
            directions.hits() as f64,
            drift.duration(),
            drift.samples() as f64,
        );
        let (force, path, squares) = (drift.impulse(), drift.path(), drift.velocity_squares());
        let (mass, moment) = (
            self.shape.molecule.mass(),
            self.shape.molecule.moment_of_inertia(),
        );
        let rim = self
            .ideal_impulse
            .map_or([0.0; 2], |ideal| [directions.total_impulse() / ideal, time]);
        let by_part: Vec<f64> = self
            .by_part()
            .into_iter()
            .map(|count| count as f64)
            .collect();
        let on = |side: &[usize]| side.iter().map(|&part| by_part[part]).sum::<f64>();
        let [left, right] = self.shape.sides.each_ref().map(|side| on(side));
        let whole = [
            [hits, time],
            rim,
            [force.x, time],
            [force.y, time],
            [drift.angular_impulse(), time],
            [path.x, time],
            [path.y, time],
            [drift.turn(), time],
            [mass * squares.x, samples],
            [mass * squares.y, samples],
            [moment * drift.spin_squares(), samples],
            [left - right, hits],
        ];
        let (of_directions, of_components, of_places) = {
            let (directions, components, places) = &self.from_gas.observer;
            (
                directions::sums(directions),
                components.sums(),
                places.as_ref().map_or_else(Vec::new, Measured::sums),
            )
        };
        let parts = by_part.into_iter().map(|count| [count, hits]);
        let whole = whole.into_iter().chain(parts);
        whole
            .chain(of_directions)
            .chain(of_places)
            .chain(of_components)
            .collect()
    }

    fn distributions(&self) -> Vec<Vec<&AdaptiveHistogram>> {
        self.from_gas.observer.1.distributions()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        figures::results(self, &KickParts::new(self, means), context)
    }
}

#[cfg(test)]
mod tests;
