//! `structure-factor-map`: S(k_x, k_y) of the centres of mass of a group, or of two, `A,B`.

use std::f64::consts::TAU;

use anyhow::Result;
use carom::StructureFactorMap;
use carom_tables::{BlockMean, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    resumed,
};

/// Default of the largest component, in units of 2π by the diameter of the largest bodies: beyond
/// the first two peaks of a dense liquid.
const WAVES_PER_DIAMETER: f64 = 2.0;

/// Most wave vectors of a map whose size the scene does not give. More: a sample costs more, in
/// proportion.
const MAX_VECTORS: f64 = 1e4;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "structure-factor-map",
    summary: "map of the structure factor S(k_x, k_y): the diffraction pattern; with two tags, the partial S of both groups",
    of: Of::TwoGroups,
    span: Span::Measurement,
    parameters: &[Parameter::positive(
        "max",
        Default::FromScene("4π by the diameter of the largest bodies"),
        "largest k_x and k_y, of at most 40 000 wave vectors (1/length)",
    )],
    figures: &[],
    start: |selection| Ok(in_blocks(map(selection)?)),
    resume: resumed::<StructureFactorMap>,
};

fn map(selection: &Selection<'_>) -> Result<StructureFactorMap> {
    let (groups, bounds) = (selection.groups(), selection.view.bounds());
    let [one, other] = groups.map(|group| selection.largest_radius(group));
    let by_default = || {
        let limit = StructureFactorMap::largest_within(&bounds, MAX_VECTORS);
        let least = TAU / bounds.sides().min_element();
        (WAVES_PER_DIAMETER * TAU / (one + other))
            .min(limit)
            .max(least)
    };
    let largest = selection.given("max").unwrap_or_else(by_default);
    Ok(StructureFactorMap::new(groups, &bounds, largest)?)
}

impl Measured for StructureFactorMap {
    /// S at each wave vector of half the plane.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.points();
        let along = |axis: usize| points.iter().map(|point| point.wave_vector[axis]).collect();
        let mean = |place: Option<usize>| place.and_then(|place| means.get(place)).copied();
        let all: Vec<BlockMean> = self
            .places()
            .into_iter()
            .map(|place| mean(place).unwrap_or_default())
            .collect();
        let table = Table::new(
            context.table("structure-factor-map"),
            "Structure factor S(k_x, k_y)",
        )
        .abscissa("k_x", "1/length", along(0))
        .abscissa("k_y", "1/length", along(1))
        .means("s", "1", &all)
        .caption(
            "Of the centres of mass; 1 for independent positions. S(−k) = S(k); without k = 0. Of two groups: \
             Re ⟨ρ_a ρ_b*⟩/√(N_a N_b), 0 for independent positions.",
        );
        Results {
            tables: vec![table],
            ..Results::default()
        }
    }
}
