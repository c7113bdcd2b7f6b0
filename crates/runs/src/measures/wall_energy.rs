//! `wall-heat` and `wall-work`: heat that bodies receive from walls with a temperature, and work of
//! walls that move.

use anyhow::{Result, ensure};
use carom::observers::{FromWalls, HeatFromWalls, WallEnergy, WorkOfWalls};
use carom_tables::{BlockMean, Table};

use super::{
    Context, Measure, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed,
    selection::Selection,
};

pub(super) const HEAT: MeasureKind = kind::<HeatFromWalls>();
pub(super) const WORK: MeasureKind = kind::<WorkOfWalls>();

/// How an energy from walls is named.
struct Words {
    /// Name of the measure and of its table.
    measure: &'static str,
    summary: &'static str,
    /// Why there is no such measure in a scene.
    missing: &'static str,
    title: &'static str,
    /// Name of the column.
    column: &'static str,
    caption: &'static str,
    /// Names of the energy and of the contacts, both per time.
    figures: &'static [&'static str; 2],
}

trait Named: FromWalls + Send + 'static {
    const WORDS: Words;
}

impl Named for HeatFromWalls {
    const WORDS: Words = Words {
        measure: "wall-heat",
        summary: "heat received from walls that have a temperature, all or those with the tag",
        missing: "no such wall has a temperature",
        title: "Heat received from walls",
        column: "heat",
        caption: "Sums since the start of the measurement. Negative: the walls have cooled the gas.",
        figures: &["heat received from walls", "contacts with thermal walls"],
    };
}

impl Named for WorkOfWalls {
    const WORDS: Words = Words {
        measure: "wall-work",
        summary: "work of walls that move on the bodies that touch them, all walls or those with the tag",
        missing: "there is no such wall",
        title: "Work of walls",
        column: "work",
        caption: "Sums since the start of the measurement. Negative: the gas has done work on the walls.",
        figures: &["power of walls", "contacts with walls"],
    };
}

const fn kind<K: Named>() -> MeasureKind {
    MeasureKind {
        name: K::WORDS.measure,
        summary: K::WORDS.summary,
        of: Of::Group,
        span: Span::Measurement,
        parameters: &[],
        figures: K::WORDS.figures,
        start: start::<K>,
        resume: resumed::<WallEnergy<K>>,
    }
}

fn start<K: Named>(selection: &Selection<'_>) -> Result<Box<dyn Measure>> {
    let is_wall = |body: carom::engine::BodyView<'_>| {
        K::is_given_by(body.body) && selection.group.contains(body.body)
    };
    let missing = K::WORDS.missing;
    ensure!(selection.view.bodies().any(is_wall), "{missing}");
    Ok(in_blocks(WallEnergy::<K>::new(selection.group)))
}

impl<K: Named> Measured for WallEnergy<K> {
    const OF_INTERVALS: bool = true;

    /// Energy and contacts, both per time.
    fn sums(&self) -> Vec<[f64; 2]> {
        vec![
            [self.energy(), self.duration()],
            [self.contacts() as f64, self.duration()],
        ]
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let (words, points) = (K::WORDS, self.series());
        let energy = points.iter().map(|point| Some(point.energy)).collect();
        let table = Table::new(context.table(words.measure), words.title)
            .abscissa(
                "time",
                "time",
                points.iter().map(|point| point.time).collect(),
            )
            .counts(
                "contacts",
                points.iter().map(|point| point.contacts).collect(),
            )
            .value(words.column, "mass·length²/time²", energy)
            .caption(words.caption);
        let [power, contacts] = *words.figures;
        let names = [
            (power, "mass·length²/time³", None),
            (contacts, "1/time", None),
        ];
        let figures = context.figures(names, means, "");
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }
}
