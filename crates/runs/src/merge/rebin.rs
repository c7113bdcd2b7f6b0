//! Distributions of several runs in bins that all of them have.
//!
//! Where the range of the bins follows the data, runs differ in the widths, which are powers of
//! two, so that each bin of one run lies inside a bin of another or contains some of its bins.
//! Joining bins is then exact, for densities and for the sums of every block.

use carom_tables::{BlockMean, Column, Figure, Role, RunSums, Sums, Table};

use crate::record::MeasureRecord;

/// A measure of several runs with common bins in every table of a distribution. `None` if a run
/// lacks a table.
pub(super) fn with_common_bins(parts: &[&MeasureRecord]) -> Option<Vec<MeasureRecord>> {
    let first = parts.first()?;
    let names = first
        .tables
        .iter()
        .filter(|table| edges(table).is_some())
        .map(|table| &table.name);
    let mut targets = Vec::new();
    for name in names {
        let of_part =
            |part: &&MeasureRecord| edges(part.tables.iter().find(|table| table.name == *name)?);
        let all: Vec<Vec<f64>> = parts.iter().map(of_part).collect::<Option<_>>()?;
        targets.push((name.as_str(), common(&all)));
    }
    parts.iter().map(|part| rebinned(part, &targets)).collect()
}

/// The edges of the bins of a table, if it is one of a distribution; empty without values.
fn edges(table: &Table) -> Option<Vec<f64>> {
    let of = |role: Role| table.columns.iter().find(|column| column.role == role);
    let (centres, widths) = (of(Role::Abscissa)?, of(Role::Width)?);
    let bins: Vec<(f64, f64)> = centres
        .values
        .iter()
        .zip(&widths.values)
        .map(|(&c, &w)| c.zip(w))
        .collect::<Option<_>>()?;
    let Some(&(last, last_width)) = bins.last() else {
        return Some(Vec::new());
    };
    let lower = bins.iter().map(|(centre, width)| centre - 0.5 * width);
    Some(lower.chain([last + 0.5 * last_width]).collect())
}

/// The edges that lie inside no bin of any run, in ascending order.
fn common(all: &[Vec<f64>]) -> Vec<f64> {
    let mut edges: Vec<f64> = all.concat();
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    let is_inside = |edge: f64, of_run: &Vec<f64>| {
        let after = of_run.partition_point(|&other| other <= edge);
        (1..of_run.len()).contains(&after) && of_run[after - 1] < edge
    };
    edges.retain(|&edge| !all.iter().any(|of_run| is_inside(edge, of_run)));
    edges
}

/// A part of each wider bin: the row of the run's own table and its width.
type Parts = Vec<Vec<(usize, f64)>>;

/// The rows of a table that make up each bin between `target` edges.
fn parts_of(own: &[f64], target: &[f64]) -> Option<Parts> {
    let mut parts: Parts = vec![Vec::new(); target.len().saturating_sub(1)];
    for (row, bin) in own.windows(2).enumerate() {
        let at = target
            .partition_point(|&edge| edge <= bin[0])
            .checked_sub(1)?;
        let is_inside = at + 1 < target.len() && bin[1] <= target[at + 1];
        parts
            .get_mut(at)
            .filter(|_| is_inside)?
            .push((row, bin[1] - bin[0]));
    }
    Some(parts)
}

/// A measure of one run with these bins. Quantities that belong to no bin come first among its
/// sums, then those of the bins, in the order of tables and columns.
fn rebinned(part: &MeasureRecord, targets: &[(&str, Vec<f64>)]) -> Option<MeasureRecord> {
    let is_binned = |quantity: usize| {
        let binned = part.tables.iter().filter(|table| edges(table).is_some());
        binned
            .flat_map(|table| &table.columns)
            .any(|column| column.quantities.contains(&Some(quantity)))
    };
    let mut sources: Vec<Source> = (0..part.sums.total.len())
        .filter(|&quantity| !is_binned(quantity))
        .map(Source::Quantity)
        .collect();
    let mut tables = rebinned_tables(&part.tables, targets, &mut sources)?;
    let figures: Vec<(Figure, Option<usize>)> = part
        .figures
        .iter()
        .map(|(figure, quantity)| (figure.clone(), new_place(&sources, *quantity)))
        .collect();
    let of = |sums: &Sums| sources.iter().map(|source| source.sums(sums)).collect();
    let sums = RunSums {
        total: of(&part.sums.total),
        blocks: part.sums.blocks.iter().map(of).collect(),
    };
    // Errors of joined bins do not follow from those of their parts.
    let means = sums.means();
    for (table, before) in tables.iter_mut().zip(&part.tables) {
        if edges(table) != edges(before) {
            set_errors(table, &means);
        }
    }
    Some(MeasureRecord {
        span: part.span,
        sums,
        tables,
        figures,
        // Measures of curves have no bins, so that their sums keep their numbers.
        coefficients: part.coefficients.clone(),
        of_curves: part.of_curves.clone(),
        drawings: part.drawings.clone(),
    })
}

/// Tables with these bins. The sources of their sums are added to those of the quantities that
/// belong to no bin.
fn rebinned_tables(
    before: &[Table],
    targets: &[(&str, Vec<f64>)],
    sources: &mut Vec<Source>,
) -> Option<Vec<Table>> {
    let bins_of = |table: &Table| {
        let (_, target) = targets.iter().find(|(name, _)| *name == table.name)?;
        Some((target, parts_of(&edges(table)?, target)))
    };
    let mut tables = Vec::new();
    for table in before {
        let mut table = table.clone();
        match bins_of(&table) {
            None => {
                for quantity in table
                    .columns
                    .iter_mut()
                    .flat_map(|column| &mut column.quantities)
                {
                    *quantity = new_place(sources, *quantity);
                }
            }
            Some((target, parts)) => {
                let parts = parts?;
                for column in &mut table.columns {
                    *column = joined(column, target, &parts, sources);
                }
            }
        }
        tables.push(table);
    }
    Some(tables)
}

/// The place of a quantity of the run among the sources.
fn new_place(sources: &[Source], old: Option<usize>) -> Option<usize> {
    sources
        .iter()
        .position(|source| matches!(source, Source::Quantity(q) if Some(*q) == old))
}

/// Sets the errors of all columns that are means, where there were errors.
fn set_errors(table: &mut Table, means: &[BlockMean]) {
    for index in 1..table.columns.len() {
        let [value, error] = &mut table.columns[index - 1..=index] else {
            continue;
        };
        if error.role == Role::StandardError {
            for (cell, quantity) in error.values.iter_mut().zip(&value.quantities) {
                let mean = quantity.and_then(|quantity| means.get(quantity));
                *cell = cell.and_then(|_| mean?.standard_error);
            }
        }
    }
}

/// Where the sums of a quantity come from.
enum Source {
    /// A quantity of the run.
    Quantity(usize),
    /// The density in a bin: those of its parts, with their shares of its width, and a quantity
    /// with its weight, the number of all values; `None` for a run without values.
    Bin(Vec<(usize, f64)>, Option<usize>),
}

impl Source {
    fn sums(&self, sums: &Sums) -> [f64; 2] {
        let of = |quantity: usize| sums.get(quantity).copied().unwrap_or_default();
        match self {
            Self::Quantity(quantity) => of(*quantity),
            Self::Bin(parts, weight) => {
                let density = parts
                    .iter()
                    .map(|&(quantity, share)| of(quantity)[0] * share)
                    .sum();
                [density, weight.map_or(0.0, |quantity| of(quantity)[1])]
            }
        }
    }
}

/// A column with wider bins. A density is 0 in a bin where the run has no value.
fn joined(column: &Column, target: &[f64], parts: &Parts, sources: &mut Vec<Source>) -> Column {
    let widths: Vec<f64> = target.windows(2).map(|bin| bin[1] - bin[0]).collect();
    let cell = |row: usize| column.values.get(row).copied().flatten();
    let covered = |parts: &[(usize, f64)]| parts.iter().map(|(_, width)| width).sum::<f64>();
    let integral = |parts: &[(usize, f64)]| {
        parts
            .iter()
            .map(|&(row, width)| Some(cell(row)? * width))
            .sum::<Option<f64>>()
    };
    let of_bin = |(bin, parts): (usize, &Vec<(usize, f64)>)| match column.role {
        Role::Abscissa => Some(target[bin] + 0.5 * widths[bin]),
        Role::Width => Some(widths[bin]),
        Role::Value => Some(integral(parts)? / widths[bin]),
        Role::Count => parts.iter().map(|&(row, _)| cell(row)).sum(),
        // Only whether there is one.
        Role::StandardError => parts.iter().map(|&(row, _)| cell(row)).sum(),
        Role::Undrawn | Role::Derived | Role::Prediction { .. } => integral(parts)
            .filter(|_| !parts.is_empty())
            .map(|sum| sum / covered(parts)),
    };
    let values = parts.iter().enumerate().map(of_bin).collect();
    let mut quantities = Vec::new();
    if column.role == Role::Value {
        let weight = column.quantities.iter().copied().flatten().next();
        for (bin, parts) in parts.iter().enumerate() {
            let of = |&(row, width): &(usize, f64)| {
                Some((
                    column.quantities.get(row).copied().flatten()?,
                    width / widths[bin],
                ))
            };
            quantities.push(Some(sources.len()));
            sources.push(Source::Bin(parts.iter().filter_map(of).collect(), weight));
        }
    }
    Column {
        values,
        quantities,
        ..column.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run with counts in bins between edges, after a quantity of no bin.
    fn run(edges: &[f64], counts: &[f64]) -> MeasureRecord {
        let total: f64 = counts.iter().sum();
        let bin = |(bin, &count): (&[f64], &f64)| [count / (bin[1] - bin[0]), total];
        let sums: Sums = [[3.0, 1.0]]
            .into_iter()
            .chain(edges.windows(2).zip(counts).map(bin))
            .collect();
        let means: Vec<BlockMean> = (1..sums.len())
            .map(|quantity| BlockMean {
                value: Some(sums[quantity][0] / sums[quantity][1]),
                standard_error: None,
                quantity: Some(quantity),
            })
            .collect();
        let table = Table::new("t", "T")
            .bins("x", "1", edges)
            .means("density", "1", &means);
        let figure = (Figure::new("f", 3.0, "1"), Some(0));
        let sums = RunSums {
            blocks: vec![sums.clone()],
            total: sums,
        };
        MeasureRecord {
            sums,
            tables: vec![table],
            figures: vec![figure],
            ..MeasureRecord::default()
        }
    }

    #[test]
    fn bins_are_joined_to_those_that_all_runs_have() {
        let fine = run(&[0.0, 0.5, 1.0, 1.5, 2.0, 3.0], &[1.0, 2.0, 3.0, 4.0, 6.0]);
        let coarse = run(&[0.0, 1.0, 2.0, 3.0, 4.0, 6.0], &[5.0, 0.0, 1.0, 1.0, 3.0]);
        for parts in [[&fine, &coarse], [&coarse, &fine]] {
            let found = with_common_bins(&parts).unwrap();
            for (part, before) in found.iter().zip(parts) {
                let bins = edges(&part.tables[0]).unwrap();
                assert_eq!(bins, [0.0, 1.0, 2.0, 3.0, 4.0, 6.0]);
                // Each run keeps its number of values, and has 0 where it has none.
                let total = before.sums.total[1][1];
                let counts: Vec<f64> = part.sums.total[1..]
                    .iter()
                    .zip(bins.windows(2))
                    .map(|(s, b)| s[0] * (b[1] - b[0]))
                    .collect();
                assert_eq!(counts.iter().sum::<f64>(), total);
                assert!(part.sums.total[1..].iter().all(|sums| sums[1] == total));
                assert_eq!(
                    (part.sums.total[0], part.figures[0].1),
                    ([3.0, 1.0], Some(0))
                );
                assert_eq!(part.sums.blocks, std::slice::from_ref(&part.sums.total));
                let density = &part.tables[0].columns[2];
                assert_eq!(
                    density.values[4],
                    Some(if before == &fine { 0.0 } else { 0.15 })
                );
            }
        }
        let found = with_common_bins(&[&run(&[], &[]), &fine]).unwrap();
        assert_eq!(found[0].sums.total.len(), found[1].sums.total.len());
        assert_eq!(found[0].sums.total[1..], [[0.0; 2]; 5]);
        assert_eq!(found[1].sums.total, fine.sums.total);
        // Bins that overlap in part are joined, too.
        let shifted = run(&[0.25, 1.25, 2.25], &[1.0, 1.0]);
        let found = with_common_bins(&[&coarse, &shifted]).unwrap();
        assert_eq!(edges(&found[1].tables[0]).unwrap(), [0.0, 3.0, 4.0, 6.0]);
        assert_eq!(found[1].sums.total[1], [2.0 / 3.0, 2.0]);
    }
}
