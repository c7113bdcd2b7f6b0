//! `contact-density:TAG`: contacts of the discs of a gas along the boundary of one body.

use anyhow::{Context as _, Result, ensure};
use carom::{ContactDensity, engine::BodyView, observers::ContactPoint};
use carom_report::molecule_picture;
use carom_tables::{BlockMean, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    resumed,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "contact-density",
    summary: "contacts of the discs of a gas along the boundary of the only body with the tag",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[Parameter::whole(
        "bins",
        Default::Number(72.0),
        "bins of the whole turn around each atom",
    )],
    figures: &["force from the contact density"],
    start: |selection| Ok(in_blocks(observer(selection)?)),
    resume: resumed::<ContactDensity>,
};

/// The contacts of a body with the discs of a gas, all of one radius.
pub(super) fn observer(selection: &Selection<'_>) -> Result<ContactDensity> {
    let body = selection.only_body()?;
    let edges = body.body.molecule().edges();
    ensure!(
        body.body.is_wall() || edges.is_empty(),
        "the body has straight edges, and bins exist around atoms only; `kicks` measures the shares of the edges"
    );
    let is_of_a_gas = |other: &BodyView<'_>| {
        let disc = other.body.molecule().is_disc() && other.body.is_free();
        disc && other.body.key() != body.body.key()
    };
    let mut radii = selection
        .view
        .bodies()
        .filter(is_of_a_gas)
        .map(|other| other.body.molecule().bounding_radius());
    let disc = radii.next().context("the scene has no gas of discs")?;
    ensure!(
        radii.all(|radius| radius == disc),
        "the discs of the gas have several radii"
    );
    Ok(ContactDensity::new(
        body.body,
        disc,
        selection.whole("bins"),
    )?)
}

impl Measured for ContactDensity {
    /// The force along both axes of the body, −∮ kT ρ_c n̂ ds: with ρ_c constant in a bin of the
    /// width 2α, the mean of n̂ is that of its middle times sin α/α. Then the pressure kT ρ_c in
    /// each bin of each atom.
    fn sums(&self) -> Vec<[f64; 2]> {
        let half = std::f64::consts::PI / self.turn_bins() as f64;
        let force = self.points().iter().fold([0.0; 2], |[x, y], point| {
            let (sin, cos) = point.angle.sin_cos();
            let weight = self.impulse(point.atom, point.bin) * half.sin() / half;
            [x - weight * cos, y - weight * sin]
        });
        let force = force.map(|force| [force, self.duration()]);
        let bins =
            || (0..self.atoms()).flat_map(|atom| (0..self.turn_bins()).map(move |bin| (atom, bin)));
        let pressure = |(atom, bin): (usize, usize)| match self.arc(atom, bin) {
            arc if arc > 0.0 => [self.impulse(atom, bin) / arc, self.duration()],
            _ => [0.0; 2],
        };
        force.into_iter().chain(bins().map(pressure)).collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let bins = self.turn_bins();
        let (forces, pressures) = means.split_at(means.len().min(2));
        let mean = |atom: usize, bin: usize| {
            pressures
                .get(atom * bins + bin)
                .copied()
                .unwrap_or_default()
        };
        let points = self.points();
        let error = |point: &ContactPoint| {
            mean(point.atom, point.bin)
                .standard_error
                .unwrap_or(f64::NAN)
        };
        let errors = points.iter().map(error).collect();
        let all = boundary_table(context.table("contact-density"), &points, errors);
        let angle = |bin: usize| (bin as f64 + 0.5) * std::f64::consts::TAU / bins as f64;
        let name = context.table("contact-density.by-angle");
        let mut by_angle = Table::new(
            name,
            "Pressure of the contacts along the boundary of each atom",
        )
        .abscissa("angle", "radian", (0..bins).map(angle).collect())
        .caption("In the frame of the body.");
        let atoms = points.iter().map(|point| point.atom + 1).max().unwrap_or(0);
        for atom in 0..atoms {
            let of_atom: Vec<BlockMean> = (0..bins).map(|bin| mean(atom, bin)).collect();
            by_angle = by_angle
                .means(&format!("atom_{atom}"), "mass/time²", &of_atom)
                .labelled(&format!("atom {}", molecule_picture::name(atom)));
        }
        let names = [
            "force from the contact density along x′",
            "force from the contact density along y′",
        ];
        let figures = names
            .into_iter()
            .zip(forces)
            .filter_map(|(name, mean)| context.figure(name, "mass·length/time²", mean));
        Results {
            tables: vec![all, by_angle],
            figures: figures.collect(),
            ..Results::default()
        }
    }
}

/// A table with this name of the contacts in all bins, with the standard errors of the pressure.
fn boundary_table(name: String, points: &[ContactPoint], errors: Vec<f64>) -> Table {
    let column = |of: fn(&ContactPoint) -> f64| points.iter().map(of).collect::<Vec<_>>();
    Table::new(name, "Contacts along the boundary")
        .counts(
            "atom",
            points.iter().map(|point| point.atom as u64).collect(),
        )
        .undrawn("angle", "radian", column(|point| point.angle))
        .undrawn("arc", "length", column(|point| point.arc))
        .counts(
            "contacts",
            points.iter().map(|point| point.contacts).collect(),
        )
        .undrawn("pressure", "mass/time²", column(|point| point.pressure))
        .undrawn("standard_error", "mass/time²", errors)
}
