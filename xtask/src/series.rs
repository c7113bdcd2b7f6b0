//! Series over the standbys of a run, as tables.

use anyhow::Result;
use carom::observers::{LedgerPoint, PressurePoint, RatePoint};

use crate::output::Folder;

/// Writes `energy.csv`.
///
/// # Errors
/// It cannot be written.
pub fn write_energy(folder: &Folder, series: &[LedgerPoint]) -> Result<()> {
    let row =
        |point: &LedgerPoint| (point.time, point.energy, point.booked, point.momentum.x, point.momentum.y);
    let header = ["time", "energy", "booked_energy", "momentum_x", "momentum_y"];
    folder.write_table("energy.csv", &header, series.iter().map(row))
}

/// Writes `collision-rate.csv`.
///
/// # Errors
/// It cannot be written.
pub fn write_rates(folder: &Folder, series: &[RatePoint]) -> Result<()> {
    let row = |point: &RatePoint| (point.time, point.collisions, point.rate);
    folder.write_table("collision-rate.csv", &["time", "collisions", "rate_per_body"], series.iter().map(row))
}

/// Writes `pressure.csv`.
///
/// # Errors
/// It cannot be written.
pub fn write_pressure(folder: &Folder, series: &[PressurePoint]) -> Result<()> {
    let row = |point: &PressurePoint| (point.time, point.pressure(), point.kinetic, point.virial);
    folder.write_table("pressure.csv", &["time", "pressure", "kinetic", "virial"], series.iter().map(row))
}
