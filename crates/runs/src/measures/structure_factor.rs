//! `structure-factor`: S(k) of the centres of mass of a group.

use carom::StructureFactor;
use carom_tables::{BlockMean, Table};

use super::{Context, Kind, Measured, Of, Results, in_blocks, resumed};

/// Number of shells of wave vectors. More: a sample costs more, in proportion.
const SHELLS: usize = 200;

pub(super) const KIND: Kind = Kind {
    name: "structure-factor",
    summary: "structure factor S(k) in the 200 smallest shells of wave vectors",
    of: Of::Group,
    begin: |selection| Ok(in_blocks(StructureFactor::new(selection.group, selection.view.bounds(), SHELLS)?)),
    resume: resumed::<StructureFactor>,
};

impl Measured for StructureFactor {
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let table = Table::new(format!("structure-factor{}", context.suffix), "Structure factor S(k)")
            .abscissa("wave_number", "1/length", self.wave_numbers())
            .means("s", "1", means)
            .caption(
                "Of the centres of mass, averaged over the directions of k; 1 for independent positions.",
            );
        Results { tables: vec![table], figures: Vec::new() }
    }
}
