//! `wall-pressure`: pressure of a gas on walls across the box, and its density over the distance.

use anyhow::ensure;
use carom::{CollisionReport, Observer, View, engine::Body, observers::WallPressure};
use carom_tables::{BlockMean, Table};
use serde::{Deserialize, Serialize};

use super::{
    Context, Default, HardDiscs, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    hard_discs::LIU_BULK, in_blocks, resumed,
};

/// Layers of the profile, and the distance from the walls, in diameters of the largest body, from
/// which the gas counts as undisturbed. Fewer diameters: the layers at a wall in a dense gas reach
/// into the density of the bulk.
const LAYERS: f64 = 100.0;
const FAR: f64 = 10.0;

/// Name of the figure of the density where walls do not disturb it; without it if bodies fall.
pub(crate) const FAR_DENSITY: &str = "density far from the walls";

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "wall-pressure",
    summary: "pressure on parallel walls across the box by momentum, and the density over the distance from them",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::whole(
            "bins",
            Default::Number(LAYERS),
            "layers up to the middle between the walls",
        ),
        Parameter::positive(
            "far",
            Default::FromScene("10 diameters of the largest body"),
            "distance from which the density far from the walls is taken (length)",
        ),
    ],
    figures: &[
        "pressure on the walls",
        "net force on the walls per length",
        FAR_DENSITY,
    ],
    start: |selection| Ok(in_blocks(OfGas::new(selection)?)),
    resume: resumed::<OfGas>,
};

/// The walls, and the gas to which theory applies.
#[derive(Serialize, Deserialize)]
struct OfGas {
    walls: WallPressure,
    /// Diameter of equal discs; `None` if there are other bodies.
    diameter: Option<f64>,
    /// Sum of kT over the samples, and their number.
    temperature: [f64; 2],
}

impl OfGas {
    fn new(selection: &Selection<'_>) -> anyhow::Result<Self> {
        let view = selection.view;
        let moving = || view.bodies().filter(|body| body.body.is_free());
        let radii = || moving().map(|body| body.body.molecule().bounding_radius());
        let far = selection
            .given("far")
            .unwrap_or(FAR * 2.0 * radii().fold(0.0, f64::max));
        let walls = WallPressure::new(view, selection.group, selection.whole("bins"), far)?;
        ensure!(moving().next().is_some(), "nothing moves");
        let is_wall = |body: &Body| body.is_wall() && selection.group.contains(body);
        let radius = radii().next();
        let are_equal = moving().all(|body| {
            body.body.molecule().is_disc() && Some(body.body.molecule().bounding_radius()) == radius
        });
        let are_alone = view
            .bodies()
            .filter(|body| body.body.is_fixed())
            .all(|body| is_wall(body.body));
        let diameter = radius
            .filter(|_| are_equal && are_alone && !view.has_pair_rules())
            .map(|radius| 2.0 * radius);
        Ok(Self {
            walls,
            diameter,
            temperature: [0.0; 2],
        })
    }
}

impl Observer for OfGas {
    fn watches_any(&self) -> bool {
        self.walls.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.walls.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.walls.start(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.walls.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.walls.sample(view);
        if let Some(temperature) = view.temperature() {
            self.temperature[0] += temperature;
            self.temperature[1] += 1.0;
        }
    }
}

impl Measured for OfGas {
    /// Pressure, net force per length, density far from the walls, and density of each layer.
    fn sums(&self) -> Vec<[f64; 2]> {
        let layers = self
            .walls
            .layers()
            .into_iter()
            .map(|layer| [layer.count as f64, layer.area]);
        let walls = &self.walls;
        [
            walls.momentum(),
            walls.net_momentum(),
            walls.far_from_walls(),
        ]
        .into_iter()
        .chain(layers)
        .collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let [pressure, force, far, layers @ ..] = means else {
            return Results::default();
        };
        let [sum, samples] = self.temperature;
        let gas = self
            .diameter
            .filter(|_| context.is_equilibrium && samples > 0.0)
            .zip(far.value);
        let predicted = gas.and_then(|(diameter, density)| {
            let pressure = HardDiscs::bulk_pressure(density, diameter, sum / samples)?;
            Some((pressure, pressure * samples / sum))
        });
        let found = self.walls.layers();
        let table = Table::new(
            context.table("wall-pressure"),
            "Density over the distance from the walls",
        )
        .abscissa(
            "distance",
            "length",
            found.iter().map(|layer| layer.distance).collect(),
        )
        .counts("centres", found.iter().map(|layer| layer.count).collect())
        .means("density", "1/length²", layers)
        .level(
            "p/kT",
            predicted.map(|(_, contact)| contact),
            "contact theorem, pressure of Liu (2021)",
        )
        .caption("Centres of the moving bodies per area, by the distance from the nearest wall.");
        let of_walls = context.figure("pressure on the walls", "mass/time²", pressure);
        let of_walls = of_walls
            .map(|figure| figure.predicted(predicted.map(|(pressure, _)| pressure), LIU_BULK));
        let force = context.figure("net force on the walls per length", "mass/time²", force);
        let far = context
            .figure(FAR_DENSITY, "1/length²", far)
            .filter(|_| !context.falls);
        Results {
            tables: vec![table],
            figures: of_walls.into_iter().chain(force).chain(far).collect(),
            ..Results::default()
        }
    }
}
