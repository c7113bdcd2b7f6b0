//! The settings: the exact run first, then variations of one parameter at a time.

use anyhow::Result;
use carom::{
    CellsPerSide, Checkpoint, Instructions, View,
    detection::{Exact, FixedStep, GoldenSecant, tolerance::MOST_FIXED_STEPS},
    engine::Rotation,
};
use carom_methods::{AnyDetector, AnySimulation, Method, Order};

/// One setting of all parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Index in [`FAMILIES`].
    pub family: usize,
    /// Description.
    pub name: String,
    /// Detector and scheduler.
    pub method: Method,
    /// Contacts of each body in an epoch, instead of the scheduler's own number.
    pub contacts_per_epoch: Option<u64>,
    /// True if all rotation is locked.
    pub locked: bool,
    /// Time between samples in mean times between two collisions of a body; `None` for no samples.
    pub sample_interval: Option<f64>,
}

/// Groups of settings.
pub const FAMILIES: [&str; 5] = ["Exact", "GoldenSecant", "FixedStep", "coarser model", "order of events"];

/// Indices of [`FAMILIES`].
const EXACT: usize = 0;
const GOLDEN: usize = 1;
const STEP: usize = 2;
/// Settings of another model: their missed contacts are not errors of the search.
pub const MODEL: usize = 3;
const ORDER: usize = 4;

/// The exact run, the reference of all settings.
pub fn exact() -> Setting {
    Setting {
        family: EXACT,
        name: "default".to_owned(),
        method: Method::default(),
        contacts_per_epoch: None,
        locked: false,
        sample_interval: None,
    }
}

/// The settings that apply to the bodies of a view.
pub fn settings(view: &View<'_>, finest_step: i32) -> Vec<Setting> {
    let default = exact();
    let mut settings = vec![default.clone()];
    let mut add = |family, name: String, change: &dyn Fn(&mut Setting)| {
        let mut setting = Setting { family, name, ..default.clone() };
        change(&mut setting);
        settings.push(setting);
    };
    let turns = view.bodies().any(|view| !view.body.molecule().is_disc() && !view.body.is_fixed());
    let detector = |detector: AnyDetector| move |setting: &mut Setting| setting.method.detector = detector;
    if turns {
        for most_steps in [4, 16] {
            add(EXACT, format!("{most_steps} steps"), &detector(AnyDetector::Exact(Exact { most_steps })));
        }
    }
    let golden = GoldenSecant::default();
    for (crop_factor, name) in [(0.5, "crop ½"), (1.0, "crop 1"), (2.0, "crop 2"), (4.0, "crop 4")] {
        // Discs need no crop of the time window.
        if turns || crop_factor == golden.crop_factor {
            add(
                GOLDEN,
                name.to_owned(),
                &detector(AnyDetector::GoldenSecant(GoldenSecant { crop_factor, ..golden })),
            );
        }
    }
    for exponent in [12, 9, 6, 3] {
        let tolerance = 10f64.powi(-exponent);
        add(
            GOLDEN,
            format!("tol 1e-{exponent}"),
            &detector(AnyDetector::GoldenSecant(GoldenSecant { tolerance, ..golden })),
        );
    }
    for exponent in 2..=finest_step {
        let most_steps = MOST_FIXED_STEPS.max(100 * 10u32.pow(exponent as u32));
        let fixed = FixedStep { step: 10f64.powi(-exponent), most_steps };
        add(STEP, format!("step 1e-{exponent}"), &detector(AnyDetector::FixedStep(fixed)));
    }
    if turns {
        add(MODEL, "bounding circles".to_owned(), &detector(AnyDetector::BoundingCircles));
        add(MODEL, "rotation locked".to_owned(), &|setting| setting.locked = true);
    }
    let order = |order: Order| move |setting: &mut Setting| setting.method.order = order;
    add(ORDER, "CellScheduler, portable".to_owned(), &order(Order::Cells(Instructions::Portable)));
    for contacts in [1, 8, 512] {
        add(ORDER, format!("epochs of {contacts}"), &|setting| setting.contacts_per_epoch = Some(contacts));
    }
    for (share, name) in [(0.01, "sample each τ/100"), (1.0, "sample each τ")] {
        add(ORDER, name.to_owned(), &|setting| setting.sample_interval = Some(share));
    }
    add(ORDER, "HeapScheduler".to_owned(), &order(Order::Heap(CellsPerSide::Automatic)));
    let finest_safe = finest_safe(view);
    for factor in [1.0, 1.2, 1.5, 2.0] {
        let cells = (f64::from(finest_safe) * factor).round() as u32;
        let name = format!("grid × {factor} ({cells})");
        add(ORDER, name, &order(Order::Heap(CellsPerSide::Unchecked(cells))));
    }
    add(ORDER, "grid 50, the thesis's".to_owned(), &order(Order::Heap(CellsPerSide::Unchecked(50))));
    settings
}

/// The largest number of cells a side that is safe: no cell is shorter than the sum of the largest
/// bounding radius of a moving body and that of any other body.
fn finest_safe(view: &View<'_>) -> u32 {
    let radius = |fixed: bool| {
        let radii = view.bodies().filter(move |view| fixed || !view.body.is_fixed());
        let mut radii: Vec<f64> = radii.map(|view| view.body.molecule().bounding_radius()).collect();
        radii.sort_by(|a, b| b.total_cmp(a));
        radii
    };
    let (moving, all) = (radius(false), radius(true));
    let reach = moving.first().copied().unwrap_or(0.0) + all.get(1).or(all.first()).copied().unwrap_or(0.0);
    let side = view.bounds().sides().min_element();
    // A quotient that is an integer up to rounding counts as an integer.
    ((side / reach * (1.0 + 8.0 * f64::EPSILON)) as u32).clamp(1, 2000)
}

impl Setting {
    /// Description of the setting with its family.
    pub fn title(&self) -> String {
        format!("{}, {}", FAMILIES[self.family], self.name)
    }

    /// Returns true if no contact may be wrong: the certified detector and a safe grid.
    pub fn is_exact(&self) -> bool {
        self.method.is_exact() && !self.locked
    }

    /// The simulation with this setting from a state on.
    ///
    /// # Errors
    /// The bodies do not suit the setting.
    pub fn resume(&self, state: &Checkpoint) -> Result<AnySimulation> {
        let mut simulation = AnySimulation::resume(state, &self.method)?;
        if let Some(contacts) = self.contacts_per_epoch {
            simulation.set_contacts_per_epoch(contacts);
        }
        if self.locked {
            let moving = simulation.view();
            let moving = moving.bodies().filter(|view| !view.body.is_fixed());
            let keys: Vec<_> = moving.map(|view| view.body.key()).collect();
            for key in keys {
                simulation.set_rotation(key, Rotation::Locked)?;
            }
        }
        Ok(simulation)
    }
}
