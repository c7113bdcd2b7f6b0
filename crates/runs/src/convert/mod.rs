//! `carom convert`: trajectories in the formats of other programs.
//!
//! The input is the extended XYZ file that `carom run` writes with `run.snapshots = "extxyz"`. It
//! is read and written frame by frame. The output is a GSD file with the schema of HOOMD (`.gsd`),
//! a text dump of LAMMPS (`.lammpstrj`, `.dump`) or a data file of its last frame (`.data`), or a
//! structured array of NumPy (`.npy`). A table of a run, such as `events.csv`, becomes an array
//! too.

mod body_shapes;
mod frames;
mod gsd;
pub(crate) mod hoomd;
mod lammps;
mod lammps_data;
mod npy;

use std::{
    fs::File,
    io::{BufReader, BufWriter, Write as _},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail, ensure};
use carom_tables::Verdict;
use clap::Args;

use crate::{console::put, output::write_streamed, print_line, progress::Progress};
use frames::{Frames, TrajectoryFrame};

/// Options of `carom convert`.
#[derive(Debug, Clone, Args)]
pub struct ConvertOptions {
    /// Trajectory of a run, extended XYZ; or a table of numbers, .csv, for an array
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Output file; its ending selects the format: .gsd (HOOMD), .lammpstrj or .dump (LAMMPS text),
    /// .data (LAMMPS, the last frame), .npy (NumPy)
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
}

/// Converts a trajectory and prints the number of its frames.
///
/// # Errors
/// See [`convert`].
pub fn run(options: &ConvertOptions) -> Result<Verdict> {
    let frames = convert(&options.input, &options.output)?;
    put("frames", &frames);
    put("output", &options.output);
    let unit = if is_table(&options.input) {
        "row"
    } else {
        "frame"
    };
    let plural = if frames == 1 { "" } else { "s" };
    print_line(&format!(
        "{}: {frames} {unit}{plural}",
        options.output.display()
    ));
    Ok(Verdict::Passed)
}

/// Whether a file is a table of numbers.
fn is_table(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
}

/// Writes the trajectory `input` (extended XYZ of a run) to `output` in the format of its ending,
/// `gsd`, `lammpstrj`, `dump`, `data` or `npy`, and returns the number of frames; or a table of
/// numbers, `csv`, as an array, `npy`, and returns the number of rows.
///
/// GSD holds single precision: positions keep seven digits of the box. A dump keeps every digit. An
/// existing file is replaced at the end.
///
/// # Errors
/// An unknown ending; invalid input, with file and line; a number beyond single precision for GSD;
/// a file that cannot be read or written.
pub fn convert(input: &Path, output: &Path) -> Result<u64> {
    let ending = output
        .extension()
        .map(|ending| ending.to_string_lossy().to_lowercase());
    let format = match ending.as_deref() {
        Some("gsd") => Format::Gsd,
        Some("lammpstrj" | "dump") => Format::Lammps,
        Some("data") => Format::LammpsData,
        Some("npy") => Format::Npy,
        _ => bail!(
            "{}: expected an ending .gsd, .lammpstrj, .dump, .data or .npy",
            output.display()
        ),
    };
    ensure!(
        !is_table(input) || matches!(format, Format::Npy),
        "{}: a CSV table can only be converted to .npy",
        input.display()
    );
    let is_same = matches!((input.canonicalize(), output.canonicalize()), (Ok(a), Ok(b)) if a == b);
    ensure!(!is_same, "{} is both input and output", input.display());
    ensure!(
        !input.is_dir(),
        "{} is a folder: name a trajectory in it, such as {}",
        input.display(),
        input.join("trajectory.extxyz").display()
    );
    let file = File::open(input).with_context(|| format!("cannot read {}", input.display()))?;
    let input_file = BufReader::new(file);
    let mut count = 0;
    if is_table(input) {
        write_streamed(output, |out| {
            count = npy::of_table(input_file, out).with_context(|| input.display().to_string())?;
            Ok(out.flush()?)
        })?;
        return Ok(count);
    }
    let mut frames = Frames::new(input_file);
    write_streamed(output, |out| {
        count = format
            .write(&mut frames, out)
            .with_context(|| input.display().to_string())?;
        Ok(())
    })?;
    Ok(count)
}

/// A format of the output.
#[derive(Debug, Clone, Copy)]
enum Format {
    Gsd,
    Lammps,
    LammpsData,
    Npy,
}

impl Format {
    /// Writes all frames and returns their number.
    fn write(self, frames: &mut Frames<BufReader<File>>, out: &mut BufWriter<File>) -> Result<u64> {
        let mut frame = TrajectoryFrame::default();
        let mut count = 0;
        let progress = Progress::items("frames", None);
        match self {
            Self::Lammps => {
                while frames.read(&mut frame)? {
                    lammps::write(&frame, count, out)?;
                    count += 1;
                    progress.count(1);
                }
            }
            Self::LammpsData => {
                while frames.read(&mut frame)? {
                    count += 1;
                    progress.count(1);
                }
                if count > 0 {
                    lammps_data::write(&frame, out)?;
                }
            }
            Self::Npy => {
                let mut array = npy::Array::new(out, &npy::ATOMS)?;
                while frames.read(&mut frame)? {
                    array.frame(&frame, count)?;
                    count += 1;
                    progress.count(1);
                }
                array.end()?;
            }
            Self::Gsd => {
                let mut trajectory = hoomd::Trajectory::new(out)?;
                while frames.read(&mut frame)? {
                    trajectory
                        .write(&frame)
                        .with_context(|| format!("frame {count}"))?;
                    count += 1;
                    progress.count(1);
                }
                trajectory.end()?;
            }
        }
        out.flush()?;
        ensure!(count > 0, "the file is empty");
        Ok(count)
    }
}

#[cfg(test)]
mod edged_tests;
#[cfg(test)]
mod tests;
