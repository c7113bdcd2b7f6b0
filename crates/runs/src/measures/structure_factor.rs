//! `structure-factor`: S(k) of the centres of mass of a group, or of two, `A,B`.

use carom::StructureFactor;
use carom_tables::{BlockMean, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Span, in_blocks, resumed,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "structure-factor",
    summary: "structure factor S(k) in the smallest shells of wave vectors; with two tags, the partial S of both groups",
    of: Of::TwoGroups,
    span: Span::Measurement,
    // More: a sample costs more, in proportion.
    parameters: &[Parameter::whole(
        "shells",
        Default::Number(200.0),
        "smallest shells of wave vectors",
    )],
    figures: &[],
    start: |selection| {
        Ok(in_blocks(StructureFactor::new(
            selection.groups(),
            &selection.view.bounds(),
            selection.whole("shells"),
        )?))
    },
    resume: resumed::<StructureFactor>,
};

impl Measured for StructureFactor {
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let table = Table::new(context.table("structure-factor"), "Structure factor S(k)")
            .abscissa("wave_number", "1/length", self.wave_numbers())
            .means("s", "1", means)
            .caption(
                "Of the centres of mass, averaged over the directions of k; 1 for independent positions. Of two groups: \
                 ⟨ρ_a ρ_b*⟩/√(N_a N_b), 0 for independent positions.",
            );
        Results {
            tables: vec![table],
            ..Results::default()
        }
    }
}
