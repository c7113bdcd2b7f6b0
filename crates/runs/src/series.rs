//! Tables of the series that a run samples.

use carom::observers::{
    Impulse, LedgerPoint, LoggedContact, PressurePoint, RatePoint, RunningPoint, SegmentCrossing,
};

use carom_tables::fifteen_digits;
use serde::Serialize;

use crate::append_file::SeriesFormat;

/// `energy.csv`.
pub const ENERGY: SeriesFormat<LedgerPoint> = SeriesFormat {
    name: "energy.csv",
    header: &[
        "time",
        "energy",
        "booked_energy",
        "momentum_x",
        "momentum_y",
    ],
    row: |csv, point| {
        csv.serialize((
            fifteen_digits(point.time),
            point.energy,
            point.booked,
            point.momentum.x,
            point.momentum.y,
        ))
    },
};

/// `collision-rate.csv`.
pub const RATES: SeriesFormat<RatePoint> = SeriesFormat {
    name: "collision-rate.csv",
    header: &["time", "collisions", "rate_per_body"],
    row: |csv, point| csv.serialize((fifteen_digits(point.time), point.collisions, point.rate)),
};

/// `pressure.csv`.
pub const PRESSURE: SeriesFormat<PressurePoint> = SeriesFormat {
    name: "pressure.csv",
    header: &["time", "pressure", "ideal", "virial", "momentum_flux"],
    row: |csv, point| {
        let (pressure, flux) = (point.pressure(), point.momentum_flux());
        csv.serialize((
            fifteen_digits(point.time),
            pressure,
            point.ideal,
            point.virial,
            flux,
        ))
    },
};

/// Names and columns of the files to which a run appends a row at each sample, for series that a
/// saved run continues.
pub(crate) const GROWING: [(&str, &[&str]); 3] = [
    (ENERGY.name, ENERGY.header),
    (RATES.name, RATES.header),
    (PRESSURE.name, PRESSURE.header),
];

/// `running-average.csv`.
pub const AVERAGES: SeriesFormat<RunningPoint> = SeriesFormat {
    name: "running-average.csv",
    header: &["time", "force_x", "force_y", "velocity_x", "velocity_y"],
    row: |csv, point| {
        let (force, velocity) = (point.momentum, point.velocity);
        csv.serialize((
            fifteen_digits(point.time),
            force.x,
            force.y,
            velocity.x,
            velocity.y,
        ))
    },
};

/// The columns of `events.csv`, those of edges at the end.
const EVENT_COLUMNS: [&str; 16] = [
    "time",
    "body_a",
    "atom_a",
    "body_b",
    "atom_b",
    "x",
    "y",
    "normal_x",
    "normal_y",
    "impulse_x",
    "impulse_y",
    "relative_velocity_x",
    "relative_velocity_y",
    "elasticity",
    "edge_a",
    "edge_b",
];

/// The columns of `impulses.csv`, that of edges at the end.
const IMPULSE_COLUMNS: [&str; 10] = [
    "time",
    "atom",
    "other_body",
    "normal_x",
    "normal_y",
    "impulse_x",
    "impulse_y",
    "impulse_body_x",
    "impulse_body_y",
    "edge",
];

/// `events.csv`: every contact, with the first body the one inserted earlier; the normal points to
/// the second body, and the impulse acts on it.
pub const EVENTS: SeriesFormat<LoggedContact> = SeriesFormat {
    name: "events.csv",
    header: EVENT_COLUMNS.split_at(14).0,
    row: |csv, contact| csv.serialize(contact_cells(contact)),
};

/// As [`EVENTS`], in a system of bodies with straight edges: a body that is touched between the
/// ends of an edge has the number of the edge in place of that of an atom; a wall has edge 0.
pub const EVENTS_OF_EDGES: SeriesFormat<LoggedContact> = SeriesFormat {
    name: EVENTS.name,
    header: &EVENT_COLUMNS,
    row: |csv, contact| csv.serialize((contact_cells(contact), contact.edges)),
};

/// `impulses.csv`: normals and impulses in the frame of the box, then the impulse in the body
/// frame.
pub const IMPULSES: SeriesFormat<Impulse> = SeriesFormat {
    name: "impulses.csv",
    header: IMPULSE_COLUMNS.split_at(9).0,
    row: |csv, kick| csv.serialize(impulse_cells(kick)),
};

/// As [`IMPULSES`], for a body with straight edges: a contact between the ends of an edge has the
/// number of the edge in place of that of an atom.
pub const IMPULSES_OF_EDGES: SeriesFormat<Impulse> = SeriesFormat {
    name: IMPULSES.name,
    header: &IMPULSE_COLUMNS,
    row: |csv, kick| csv.serialize((impulse_cells(kick), kick.edge)),
};

/// `crossings-log.csv`: every crossing of a segment, with the place on it and the velocity along
/// and across it.
pub const CROSSINGS: SeriesFormat<SegmentCrossing> = SeriesFormat {
    name: "crossings-log.csv",
    header: &["time", "body", "forward", "place", "along", "across"],
    row: |csv, crossing| {
        csv.serialize((
            crossing.time,
            crossing.body,
            u8::from(crossing.is_forward),
            crossing.place,
            crossing.along,
            crossing.across,
        ))
    },
};

fn contact_cells(contact: &LoggedContact) -> impl Serialize + use<> {
    let LoggedContact {
        point,
        normal,
        impulse,
        relative_velocity: velocity,
        ..
    } = contact;
    let ([a, b], [atom_a, atom_b]) = (contact.bodies, contact.atoms);
    let vectors = [point, normal, impulse, velocity].map(|vector| [vector.x, vector.y]);
    (
        contact.time,
        a,
        atom_a,
        b,
        atom_b,
        vectors,
        contact.elasticity,
    )
}

fn impulse_cells(kick: &Impulse) -> impl Serialize + use<> {
    let Impulse {
        normal,
        impulse,
        in_body_frame,
        ..
    } = kick;
    let vectors = [
        normal.x,
        normal.y,
        impulse.x,
        impulse.y,
        in_body_frame.x,
        in_body_frame.y,
    ];
    (kick.time, kick.atom, kick.other, vectors)
}
