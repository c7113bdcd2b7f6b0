//! Names of files in the folder of a run.

/// The file that every run writes first.
pub const MANIFEST: &str = "manifest.json";

/// The checkpoint.
pub const CHECKPOINT: &str = "checkpoint";

/// A growth in progress.
pub const GROWTH: &str = "growth";

/// Pictures of the initial and the final state.
pub const PICTURES: [&str; 2] = ["start.svg", "end.svg"];

/// Snapshots.
pub const TRAJECTORY: &str = "trajectory.extxyz";

/// What the method saves and gets wrong.
pub const PRICE: &str = "price.json";

/// Sums from which means of several runs are computed.
pub const SUMS: &str = "sums";

/// Files with fixed names, and what they hold.
pub const KNOWN: [(&str, &str); 18] = [
    ("animation.json", "the moving picture"),
    (
        "config.toml",
        "the scene, or the settings, with all options",
    ),
    ("density.svg", "map of the area fraction in the last state"),
    ("end.extxyz", "the last state, for OVITO and ASE"),
    ("end.svg", "picture of the last state"),
    (
        "flights.csv",
        "flights of the moving picture, with all digits",
    ),
    (
        "manifest.json",
        "program, machine, command, random numbers, time taken",
    ),
    ("order.svg", "map of the sixfold order in the last state"),
    (PRICE, "what the method saves and gets wrong"),
    ("runs.csv", "the merged runs"),
    (
        "start-state",
        "the state of another run from which this one starts",
    ),
    ("start.extxyz", "the first state, for OVITO and ASE"),
    ("start.svg", "picture of the first state"),
    (
        "summary.json",
        "figures with errors and predictions, totals, checks",
    ),
    (
        "tables.json",
        "columns of the tables: units, roles, sources of predictions",
    ),
    (
        SUMS,
        "sums from which carom merge computes means and errors",
    ),
    (
        TRAJECTORY,
        "snapshots, for OVITO and ASE; carom convert writes other formats",
    ),
    ("events.csv", "contacts, one a row"),
];
