//! Figures and tables of the kicks, with their predictions.

use std::f64::consts::PI;

use carom::observers::Isotropy;
use carom_report::molecule_picture;
use carom_tables::{BlockMean, Estimate, Figure, MIN_BLOCKS, Table, chi_square::ChiSquare};

use super::{
    super::{
        Context, Drawing, Measured as _, Results,
        directions::{self, Shares},
    },
    Kicks, Prediction,
    few_discs::{self, FewDiscs},
    mirror::{Mirror, directions_of_sides},
    surroundings::Surroundings,
};

/// First words of the name of a figure with the duration of a measurement that would give errors
/// (time).
pub const NEEDED: &str = "measurement that a verdict needs";

/// Least duration of a block in relaxation times of the body, for errors of its motion. Blocks of
/// three give errors of means that are too small by a fifth. Smaller: a body that has not yet
/// forgotten its rotation would seem to be driven. Larger: runs must be longer for a verdict.
const MIN_BLOCK: f64 = 3.0;

/// Number of harmonics in the test that the kicks of a round body are isotropic.
const HARMONICS: usize = 6;

/// Least mean number of kicks in a sector for which χ² has Gaussian errors.
const MIN_KICKS: u64 = 20;

/// Number of quantities before those of the atoms and edges.
const WHOLE: usize = 12;

const EQUILIBRIUM: &str = "equilibrium";
const MIRROR: &str = "mirror symmetry of the body";
const EQUIPARTITION: &str = "equipartition";
const OF_ALL: &str =
    "equipartition relative to the centre of mass of all bodies, whose momentum is conserved";
const UNREACHABLE: &str = "geometry: the gas discs cannot reach it";
const ARCS: &str = "exposed boundary, with weight μ^(−1/2)";
const TWO_SIZES: &str = "Jenkins and Mancini (1987), for hard discs of two sizes; accurate to 1 %";

/// The means by the quantities of [`Kicks`]: rate, density at the rim, force along x′ and y′,
/// torque, velocity along x′ and y′, angular velocity, kT along x′ and y′ and of the rotation, the
/// share of kicks on one side of a mirror axis less that on the other; the share of each atom and
/// each edge; and those of the directions, of the places on the boundary, and of the components.
pub(super) struct KickParts<'a> {
    whole: &'a [BlockMean],
    parts: &'a [BlockMean],
    directions: &'a [BlockMean],
    places: &'a [BlockMean],
    densities: &'a [BlockMean],
}

impl<'a> KickParts<'a> {
    pub(super) fn new(kicks: &Kicks, means: &'a [BlockMean]) -> Self {
        let (directions, components, places) = &kicks.from_gas.observer;
        let lengths = [
            WHOLE,
            kicks.shape.parts(),
            2 * directions.counts().len(),
            places.as_ref().map_or(0, |places| places.sums().len()),
            components.sums().len(),
        ];
        let mut rest = means;
        let [whole, parts, directions, places, _] = lengths.map(|length| {
            let (part, after) = rest.split_at(length.min(rest.len()));
            rest = after;
            part
        });
        Self {
            whole,
            parts,
            directions,
            places,
            densities: rest,
        }
    }
}

/// The kicks with what theory predicts for them.
struct Theory<'a> {
    kicks: &'a Kicks,
    around: &'a Surroundings,
    prediction: Prediction,
    /// Rates in a dilute gas, if it is one.
    few: Option<FewDiscs>,
}

impl<'a> Theory<'a> {
    fn new(kicks: &'a Kicks) -> Option<Self> {
        let around = kicks.around.as_ref()?;
        let shape = &kicks.shape;
        let gas = [around.probe, around.mean[1]];
        let prediction =
            Prediction::with(&shape.molecule, [!shape.is_fixed, shape.can_turn], gas).ok()?;
        let few = FewDiscs::new(&prediction, around, kicks.freedom());
        Some(Self {
            kicks,
            around,
            prediction,
            few,
        })
    }

    /// Whether the distribution of the kicks in a dilute gas is known: that of the exposed
    /// boundary, or the isotropic one on a round body.
    fn has_arcs(&self) -> bool {
        self.around.is_one_gas || self.kicks.shape.molecule.is_round()
    }

    /// The prediction of the shares by direction.
    fn shares(&self) -> Option<Shares> {
        let sectors = self.kicks.directions().counts().len();
        let parts = [
            self.prediction.count_shares(sectors),
            self.prediction.impulse_shares(sectors),
        ];
        let is_round = self.kicks.shape.molecule.is_round();
        let (label, source) = match self.few {
            _ if is_round => ("isotropic", "symmetry"),
            Some(_) => ("exposed boundary", ARCS),
            None => (
                "dilute gas: exposed boundary",
                "exposed boundary; in a dense gas the density is larger in corners",
            ),
        };
        self.has_arcs().then_some(Shares {
            parts,
            label,
            source,
        })
    }

    /// Relaxation times of the velocity and of the rotation (time) at this rate of kicks; 0 for a
    /// motion that contacts do not change.
    fn relaxation_times(&self, rate: f64) -> [f64; 2] {
        let shape = &self.kicks.shape;
        let prediction = if self.around.is_one_gas {
            self.prediction.forgotten_at_a_contact()
        } else {
            // An estimate: all bodies as discs of the mean area and mass.
            let moves = [!shape.is_fixed, shape.can_turn];
            Prediction::with(&shape.molecule, moves, self.around.mean)
                .map_or([0.0; 2], |theory| theory.forgotten_at_a_contact())
        };
        prediction.map(|share| {
            if share > 0.0 {
                1.0 / (share * rate)
            } else {
                0.0
            }
        })
    }
}

/// Tables and figures.
pub(super) fn results(kicks: &Kicks, parts: &KickParts<'_>, context: &Context<'_>) -> Results {
    let theory = Theory::new(kicks).filter(|_| context.is_equilibrium);
    let theory = theory.as_ref();
    let mut figures = rates(parts, theory, context);
    figures.extend(motion(kicks, parts, theory, context));
    figures.extend(symmetry(kicks, parts, context));
    figures.extend(against_arcs(kicks, theory, context));
    figures.extend(of_parts(kicks, parts, theory, context));
    figures.extend(of_geometry(kicks, context));
    let drawings = drawing(kicks, context).into_iter().collect();
    Results {
        tables: tables(kicks, parts, theory, context),
        figures,
        drawings,
        ..Results::default()
    }
}

/// The body with the boundary that it shows to the gas.
fn drawing(kicks: &Kicks, context: &Context<'_>) -> Option<Drawing> {
    let Theory {
        prediction, around, ..
    } = Theory::new(kicks)?;
    let disc = if around.is_one_gas {
        "a gas disc"
    } else {
        "the smallest disc around it"
    };
    let caption = format!(
        "The body in its own frame (x′, y′). The line bounds the region that the centre of {disc} (dashed) cannot \
         enter; each arc belongs to the touched atom{}. An atom with a dashed outline cannot be touched.",
        if kicks.shape.molecule.edges().is_empty() {
            ""
        } else {
            ", each straight side to the touched edge"
        }
    );
    let svg = molecule_picture::svg(&kicks.shape.molecule, &prediction.boundary, around.probe);
    Some(Drawing {
        file: context.label.file("kicks-body.svg"),
        caption,
        svg,
    })
}

/// The rate of the kicks, and the density of the gas at the boundary.
fn rates(parts: &KickParts<'_>, theory: Option<&Theory<'_>>, context: &Context<'_>) -> Vec<Figure> {
    let [rate, rim, ..] = parts.whole else {
        return Vec::new();
    };
    let predicted = theory.and_then(|theory| {
        let around = theory.around;
        if let Some(few) = theory.few {
            return Some(([few.kicks, few.rim], few_discs::SOURCE));
        }
        let molecule = &theory.kicks.shape.molecule;
        (molecule.is_disc() && around.is_open()).then(|| {
            let density = around.density();
            let rim = theory
                .prediction
                .contact_density_of_disc(molecule.bounding_radius(), density);
            (
                [
                    rim * theory.prediction.ideal_rate(density, around.temperature),
                    rim,
                ],
                TWO_SIZES,
            )
        })
    });
    let figure = |index: usize, name: &str, unit: &str, mean: &BlockMean| {
        let figure = context.figure(name, unit, mean)?;
        Some(match predicted {
            Some((values, source)) => figure.predicted(values[index], source),
            None => figure,
        })
    };
    let is_one_gas = theory.is_some_and(|theory| theory.around.is_one_gas);
    let rim = is_one_gas
        .then(|| figure(1, "gas density at the rim", "mean density", rim))
        .flatten();
    figure(0, "kicks", "1/time", rate)
        .into_iter()
        .chain(rim)
        .collect()
}

/// Force, velocities and energies of the body along its own axes.
fn motion(
    kicks: &Kicks,
    parts: &KickParts<'_>,
    theory: Option<&Theory<'_>>,
    context: &Context<'_>,
) -> Vec<Figure> {
    let first = parts.whole.first().and_then(|mean| mean.value);
    let times = theory.map(|theory| theory.relaxation_times(first.unwrap_or(0.0)));
    // Blocks that are too short give no error; without theory their length is taken to be enough.
    let is_long = times.is_none_or(|times| context.block >= MIN_BLOCK * times[0].max(times[1]));
    let mean = |index: usize| {
        let mean = parts.whole.get(index).copied().unwrap_or_default();
        BlockMean {
            standard_error: mean.standard_error.filter(|_| is_long),
            ..mean
        }
    };
    let times_of_motion = times.filter(|_| !kicks.shape.is_fixed);
    let mut figures = forces_and_velocities(kicks, context, mean);
    figures.extend(energies(kicks, theory, context, mean));
    figures.extend(relaxation_times(times, parts.whole.first(), context));
    figures.extend(needed(times_of_motion, context));
    figures
}

/// Means that vanish at equilibrium.
fn forces_and_velocities(
    kicks: &Kicks,
    context: &Context<'_>,
    mean: impl Fn(usize) -> BlockMean,
) -> Vec<Figure> {
    let shape = &kicks.shape;
    let (moves, turns) = (!shape.is_fixed, shape.can_turn);
    let is_zero = context.is_equilibrium && moves;
    // Without a fixed body, a locked one drifts with all others.
    let rests = kicks.around.as_ref().is_some_and(|around| around.rests) || turns;
    let is_uneven = !shape.molecule.is_round();
    let (force, velocity) = ("mass·length/time²", "length/time");
    let names = [
        (5, "velocity along x′", velocity, is_zero && rests, moves),
        (6, "velocity along y′", velocity, is_zero && rests, moves),
        (7, "angular velocity", "radian/time", is_zero, turns),
        (2, "force along x′", force, is_zero, true),
        (3, "force along y′", force, is_zero, true),
        (4, "torque", "mass·length²/time²", is_zero, is_uneven),
    ];
    let mut figures = Vec::new();
    for (index, name, unit, is_zero, is_measured) in names {
        let Some(figure) = context
            .figure(name, unit, &mean(index))
            .filter(|_| is_measured)
        else {
            continue;
        };
        let figure = figure.predicted(is_zero.then_some(0.0), EQUILIBRIUM);
        // In a frame that does not turn the impulses sum to a change of momentum, and the torques
        // on a body that turns to one of its angular momentum: both are bounded, also if a steady
        // force drives the body.
        let is_bounded = index < 4 && !turns || index == 4 && turns;
        figures.push(if is_bounded { figure } else { figure.test() });
    }
    figures
}

/// Energies along the axes of the body, and of its rotation.
fn energies(
    kicks: &Kicks,
    theory: Option<&Theory<'_>>,
    context: &Context<'_>,
    mean: impl Fn(usize) -> BlockMean,
) -> Vec<Figure> {
    let shape = &kicks.shape;
    let around = theory.map(|theory| theory.around);
    let share = |axis: usize| around.map(|around| around.thermal_shares[axis]);
    let names = [
        (8, "kT along x′", share(0), !shape.is_fixed),
        (9, "kT along y′", share(1), !shape.is_fixed),
        (10, "kT turning", around.map(|_| 1.0), shape.can_turn),
    ];
    let mut figures = Vec::new();
    for (index, name, share, is_measured) in names {
        let figure = context.figure(name, "mass·length²/time²", &mean(index));
        let Some(figure) = figure.filter(|_| is_measured) else {
            continue;
        };
        let is_part = share.is_some_and(|share| share < 1.0);
        let source = if is_part { OF_ALL } else { EQUIPARTITION };
        let predicted = share
            .zip(around)
            .map(|(share, around)| share * around.temperature);
        figures.push(figure.predicted(predicted, source));
    }
    figures
}

/// The times in which velocity and rotation are forgotten, with the error of the rate of the kicks.
fn relaxation_times(
    times: Option<[f64; 2]>,
    rate: Option<&BlockMean>,
    context: &Context<'_>,
) -> Vec<Figure> {
    let share = rate.and_then(|rate| Some(rate.standard_error? / rate.value?));
    let named = times
        .into_iter()
        .flat_map(|times| times.into_iter().zip(["velocity", "rotation"]));
    let finite = named.filter(|(time, _)| *time > 0.0 && time.is_finite());
    let figure = |(time, what): (f64, &str)| {
        let name = format!("relaxation time of the {what}, from the kicks");
        Figure::new(context.named(&name), time, "time").error(share.map(|share| share * time))
    };
    finite.map(figure).collect()
}

/// The duration of a measurement that gives errors of the motion, if this one is too short.
fn needed(times: Option<[f64; 2]>, context: &Context<'_>) -> Option<Figure> {
    let [velocity, rotation] = times.filter(|_| context.is_equilibrium)?;
    let (least, blocks) = (MIN_BLOCK * velocity.max(rotation), context.blocks.len());
    let is_short = blocks < MIN_BLOCKS || context.block < least;
    // Twice as many blocks are joined in pairs.
    let block = if blocks < MIN_BLOCKS {
        context.block
    } else {
        0.0
    };
    let enough = MIN_BLOCKS as f64 * block.max(2.0 * least);
    (is_short && enough.is_finite()).then(|| Figure::new(context.named(NEEDED), enough, "time"))
}

/// Mirror symmetry of the body, or isotropy of the kicks of a round one: both hold at any density.
fn symmetry(kicks: &Kicks, parts: &KickParts<'_>, context: &Context<'_>) -> Vec<Figure> {
    let shape = &kicks.shape;
    if shape.molecule.is_round() {
        return isotropy(kicks, context).into_iter().collect();
    }
    let [left, right] = shape.sides.each_ref().map(|side| {
        let names: Vec<String> = side.iter().map(|&part| shape.part_name(part)).collect();
        names.join(", ")
    });
    let sides =
        (!left.is_empty()).then(|| format!("share of kicks on {left} less that on {right}"));
    let figure = |name: String| {
        Some(
            context
                .figure(&name, "1", parts.whole.get(WHOLE - 1)?)?
                .predicted(0.0, MIRROR)
                .test(),
        )
    };
    sides
        .and_then(figure)
        .into_iter()
        .chain(mirror_of_directions(kicks, context))
        .collect()
}

/// The sums of the sectors in each block: the number of kicks in each, and of all.
fn counts_of_blocks<'a>(
    kicks: &Kicks,
    context: &Context<'a>,
) -> impl Iterator<Item = &'a [[f64; 2]]> + Clone {
    let begin = WHOLE + kicks.shape.parts();
    let end = begin + kicks.directions().counts().len();
    context
        .blocks
        .iter()
        .filter_map(move |block| block.get(begin..end))
}

/// χ² per degree of freedom of each direction against its mirror image, with errors from the
/// scatter of the blocks, because kicks in one direction are correlated.
fn mirror_of_directions(kicks: &Kicks, context: &Context<'_>) -> Option<Figure> {
    let mirror = Mirror::new(&kicks.shape.molecule)?;
    let blocks = counts_of_blocks(kicks, context);
    let count = blocks.clone().count();
    if count < MIN_BLOCKS {
        return None;
    }
    let square = |[group, image]: [Vec<usize>; 2]| {
        let number = |block: &[[f64; 2]], group: &[usize]| {
            group.iter().map(|&sector| block[sector][0]).sum::<f64>()
        };
        let differences = blocks.clone().map(|block| {
            let difference = number(block, &group) - number(block, &image);
            (difference, block[group[0]][1])
        });
        let Estimate {
            mean,
            standard_error,
        } = Estimate::of_ratio(differences)?;
        (standard_error > 0.0).then(|| (mean / standard_error).powi(2))
    };
    let sides = directions_of_sides(&kicks.shape.molecule);
    let pairs = mirror.sectors(kicks.directions().counts().len(), &sides)?;
    let squares: Vec<f64> = pairs.into_iter().filter_map(square).collect();
    let freedom = squares.len().max(1) as f64;
    // With errors from b blocks the deviations follow Student's t, whose mean square is (b − 1)/(b
    // − 3).
    let expected = (count as f64 - 1.0) / (count as f64 - 3.0);
    let name = context.named("mirror symmetry of the kicks, χ² per degree of freedom");
    Some(
        Figure::new(name, squares.iter().sum::<f64>() / freedom, "1")
            .error(expected * (2.0 / freedom).sqrt())
            .predicted(expected, MIRROR),
    )
}

/// Fisher's F of the harmonics of the directions, with the covariance of the blocks.
fn isotropy(kicks: &Kicks, context: &Context<'_>) -> Option<Figure> {
    let counts = |block: &[[f64; 2]]| block.iter().map(|sums| sums[0] as u64).collect();
    let blocks: Vec<Vec<u64>> = counts_of_blocks(kicks, context).map(counts).collect();
    let enough = blocks.len() >= MIN_BLOCKS;
    let found =
        Isotropy::of_counts(blocks.iter().map(Vec::as_slice), HARMONICS).filter(|_| enough)?;
    let [one, other] =
        [2 * found.harmonics, found.blocks - 2 * found.harmonics].map(|count| count as f64);
    let mean = other / (other - 2.0);
    let variance = 2.0 * mean * mean * (one + other - 2.0) / (one * (other - 4.0));
    let name = context.named("isotropy of the kicks, Fisher's F");
    let figure = Figure::new(name, found.ratio, "1").error(variance.sqrt());
    Some(figure.predicted(
        context.is_equilibrium.then_some(mean),
        "symmetry of a round body",
    ))
}

/// χ² per degree of freedom of the shares by direction, by number and by impulse, and by part,
/// against the exposed boundary; none in a dense gas or with few kicks.
fn against_arcs(kicks: &Kicks, theory: Option<&Theory<'_>>, context: &Context<'_>) -> Vec<Figure> {
    let Some(theory) = theory.filter(|theory| theory.few.is_some()) else {
        return Vec::new();
    };
    let directions = kicks.directions();
    let sectors = directions.counts().len();
    if directions.hits() < MIN_KICKS * sectors as u64 {
        return Vec::new();
    }
    let shares = theory.prediction.count_shares(sectors);
    let by_count = ChiSquare::new(directions.counts(), &shares);
    let of_impulse = theory.prediction.impulse_shares(sectors);
    let (hits, total) = (directions.hits() as f64, directions.total_impulse());
    let term = |((impulse, of_impulse), share): ((&f64, f64), &f64)| {
        let expected = total * of_impulse;
        let error = impulse_error(expected, hits * share);
        (expected > 0.0).then(|| ((impulse - expected) / error).powi(2))
    };
    let terms: Vec<f64> = directions
        .impulse()
        .iter()
        .zip(of_impulse)
        .zip(&shares)
        .filter_map(term)
        .collect();
    let by_impulse = ChiSquare {
        value: terms.iter().sum(),
        freedom: terms.len().saturating_sub(1),
    };
    let by_part = ChiSquare::new(&kicks.by_part(), &theory.prediction.part_shares());
    let of_parts = if kicks.shape.molecule.edges().is_empty() {
        "kicks by atom"
    } else {
        "kicks by atom and edge"
    };
    let all = [
        ("kicks by direction", by_count),
        ("impulse by direction", by_impulse),
        (of_parts, by_part),
    ];
    // A single atom receives all kicks in any case.
    all.into_iter()
        .filter_map(|(what, chi)| directions::chi_square(what, chi, ARCS, context))
        .collect()
}

/// Standard error of a sum of `count` Rayleigh-distributed impulse magnitudes, as ⟨J²⟩/⟨J⟩² = 4/π.
fn impulse_error(sum: f64, count: f64) -> f64 {
    sum * (4.0 / (PI * count)).sqrt()
}

/// The share of the kicks on each atom and each edge; none for a body of one atom. In a dense gas
/// only those that it cannot reach are predicted.
fn of_parts(
    kicks: &Kicks,
    parts: &KickParts<'_>,
    theory: Option<&Theory<'_>>,
    context: &Context<'_>,
) -> Vec<Figure> {
    if kicks.shape.molecule.is_disc() {
        return Vec::new();
    }
    let shares = theory.map(|theory| theory.prediction.part_shares());
    let atoms = kicks.shape.molecule.atoms().len();
    let figure = |(part, mean): (usize, &BlockMean)| {
        let name = format!("share of kicks on {}", directions::part_name(part, atoms));
        let figure = context.figure(&name, "1", mean)?;
        let share = shares.as_ref().and_then(|shares| shares.get(part).copied());
        let is_dilute = theory.is_some_and(|theory| theory.few.is_some());
        let source = if share == Some(0.0) {
            UNREACHABLE
        } else {
            ARCS
        };
        Some(figure.predicted(share.filter(|&share| share == 0.0 || is_dilute), source))
    };
    parts.parts.iter().enumerate().filter_map(figure).collect()
}

/// Lengths and areas that follow from the atoms alone, without errors.
fn of_geometry(kicks: &Kicks, context: &Context<'_>) -> Vec<Figure> {
    let Some(theory) = Theory::new(kicks) else {
        return Vec::new();
    };
    let region = &theory.prediction.boundary;
    let figure = |name: &str, value, unit| Figure::new(context.named(name), value, unit);
    let mut figures = vec![
        figure(
            "perimeter of the excluded region",
            region.perimeter(),
            "length",
        ),
        figure("area of the excluded region", region.area(), "length²"),
    ];
    if region.has_pockets() {
        figures.push(figure(
            "area of pockets that the gas cannot enter",
            region.pocket_area(),
            "length²",
        ));
    }
    figures
}

/// The tables: shares by atom and edge, directions, components, and places on the boundary.
fn tables(
    kicks: &Kicks,
    parts: &KickParts<'_>,
    theory: Option<&Theory<'_>>,
    context: &Context<'_>,
) -> Vec<Table> {
    let (directions, components, places) = &kicks.from_gas.observer;
    let shares = theory.and_then(Theory::shares);
    let variance = theory
        .filter(|theory| theory.around.is_one_gas)
        .and_then(|theory| {
            let molecule = &kicks.shape.molecule;
            let inverse = if kicks.shape.is_fixed {
                0.0
            } else {
                1.0 / molecule.mass()
            };
            let reduced = 1.0 / (inverse + 1.0 / theory.prediction.gas_mass);
            molecule
                .is_round()
                .then_some(4.0 * reduced * theory.around.temperature)
        });
    let mut tables = vec![
        directions::table(directions, parts.directions, context, shares.as_ref()),
        components.table(parts.densities, context, variance),
    ];
    if let Some(places) = places {
        let ideal = theory.map(|theory| theory.around.density() * theory.around.temperature);
        let of_places = places.results(parts.places, context).tables;
        tables.extend(
            of_places
                .into_iter()
                .map(|table| table.level("n kT, dilute gas", ideal, "ideal gas")),
        );
    }
    for table in &mut tables {
        table.name = format!("kicks-{}", table.name);
    }
    tables.insert(0, by_part(kicks, parts, theory, context));
    tables
}

/// The table of the shares of the atoms, and of the edges after them.
fn by_part(
    kicks: &Kicks,
    parts: &KickParts<'_>,
    theory: Option<&Theory<'_>>,
    context: &Context<'_>,
) -> Table {
    let counts = kicks.by_part();
    let (title, column) = if kicks.shape.molecule.edges().is_empty() {
        ("Kicks by atom", "atom")
    } else {
        ("Kicks by atom and edge", "part")
    };
    let names = (0..parts.parts.len()).map(|part| kicks.shape.part_name(part));
    let table = Table::new(context.table("kicks"), title)
        .abscissa(
            column,
            "1",
            (0..counts.len()).map(|part| part as f64).collect(),
        )
        .counts("kicks", counts)
        .named(names.collect());
    // Each side of an edge is exposed in one direction: it has no angle.
    let exposed = |part: usize, theory: &Theory<'_>| {
        theory.prediction.boundary.exposed_angle(part).to_degrees()
    };
    let all = 0..parts.parts.len();
    let table = match theory {
        Some(theory) => table.undrawn(
            "exposed_angle",
            "°",
            all.map(|part| exposed(part, theory)).collect(),
        ),
        None => table,
    };
    let table = table.means("share_of_kicks", "1", parts.parts);
    let Some(theory) = theory else { return table };
    let is_dilute = theory.few.is_some();
    let label = if is_dilute {
        "exposed boundary"
    } else {
        "dilute gas: exposed boundary"
    };
    // What the smallest disc cannot reach, no other can.
    let known = |share: f64| (share == 0.0 || theory.has_arcs()).then_some(share);
    table.prediction(
        label,
        theory
            .prediction
            .part_shares()
            .into_iter()
            .map(known)
            .collect(),
        ARCS,
    )
}
