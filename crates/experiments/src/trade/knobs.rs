//! The knobs: the exact run first, then variations of one parameter at a time, and those that do
//! not apply to a scene, with the reason.

use carom::{
    CellsPerSide, Instructions, View,
    detection::{Exact, FixedStep, GoldenSecant, tolerance::MAX_FIXED_STEPS},
    engine::{BodyView, MethodSpec},
};
use carom_methods::{AnyDetector, Method, Order};
use carom_runs::price::Setting;

/// One setting of all parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Knob {
    /// Index in [`FAMILIES`].
    pub family: usize,
    /// Description.
    pub name: String,
    /// How the scene is computed.
    pub setting: Setting,
    /// For a family whose settings become slower by a factor from one to the next: this factor.
    pub slower: Option<f64>,
}

/// Groups of settings.
pub const FAMILIES: [&str; 5] = [
    "Exact",
    "GoldenSecant",
    "FixedStep",
    "coarser model",
    "order of events",
];

/// Indices of [`FAMILIES`].
const EXACT: usize = 0;
const GOLDEN: usize = 1;
const STEP: usize = 2;
/// Settings of another model: their wrong contacts are differences of the model.
pub const MODEL: usize = 3;
const ORDER: usize = 4;

/// A knob that does not apply to a scene, and the reason.
pub type LeftOutKnob = (String, String);

/// The exact run, the reference of all settings.
pub fn exact() -> Knob {
    Knob {
        family: EXACT,
        name: "default".to_owned(),
        setting: Setting::default(),
        slower: None,
    }
}

/// The method that a scene names, if it is not the default.
pub fn of_scene(method: Method) -> Option<Knob> {
    let family = match (method.detector, method.order) {
        (AnyDetector::GoldenSecant(_), _) => GOLDEN,
        (AnyDetector::FixedStep(_), _) => STEP,
        (AnyDetector::BoundingCircles, _) => MODEL,
        (AnyDetector::Exact(_), Order::Heap(_)) => ORDER,
        (AnyDetector::Exact(exact), _) => {
            if exact == Exact::default() {
                ORDER
            } else {
                EXACT
            }
        }
    };
    let knob = Knob {
        family,
        name: "the scene's [method]".to_owned(),
        setting: method.into(),
        slower: None,
    };
    (method != Method::default()).then_some(knob)
}

/// A grid of the thesis's scheduler with this number of cells a side, safe or not.
fn grid(name: String, cells: u32) -> Knob {
    let method = Method {
        order: Order::Heap(CellsPerSide::Unchecked(cells)),
        ..Method::default()
    };
    Knob {
        family: ORDER,
        name,
        setting: method.into(),
        slower: None,
    }
}

/// Negative decimal exponent of the finest fixed step (natural times).
const MIN_STEP: i32 = 4;

/// The knobs that apply to the bodies of a view, and those that do not.
pub fn knobs(view: &View<'_>) -> (Vec<Knob>, Vec<LeftOutKnob>) {
    let mut moving = view.bodies().filter(|body| body.body.is_free()).peekable();
    let turns = moving.any(|body| !body.body.molecule().is_round() && !body.body.is_locked());
    let has_shapes = view
        .bodies()
        .any(|body| !body.body.molecule().is_disc() && !body.body.is_wall());
    let mut knobs = vec![exact()];
    let mut left_out = Vec::new();
    detectors(turns || has_shapes, &mut knobs);
    if turns || has_shapes {
        knobs.push(Knob {
            family: MODEL,
            name: "bounding circles".to_owned(),
            setting: Method {
                detector: AnyDetector::BoundingCircles,
                ..Method::default()
            }
            .into(),
            slower: None,
        });
    } else {
        let discs = |knob: &str, reason: &str| (knob.to_owned(), reason.to_owned());
        left_out.extend([
            discs(
                "bounding circles",
                "all bodies are discs, which are their bounding circles",
            ),
            discs(
                "steps of the exact detector",
                "discs are decided in closed form",
            ),
            discs(
                "crop of the golden-section search",
                "discs need no crop of the time window",
            ),
        ]);
    }
    if turns {
        let setting = Setting {
            locked: true,
            ..Setting::default()
        };
        knobs.push(Knob {
            family: MODEL,
            name: "rotation locked".to_owned(),
            setting,
            slower: None,
        });
    } else {
        left_out.push((
            "rotation locked".to_owned(),
            "no body that is not round turns".to_owned(),
        ));
    }
    orders(view, &mut knobs, &mut left_out);
    (knobs, left_out)
}

/// The detectors with their parameters.
fn detectors(has_shapes: bool, knobs: &mut Vec<Knob>) {
    let mut add = |family, name: String, detector: AnyDetector, slower| {
        let setting = Method {
            detector,
            ..Method::default()
        }
        .into();
        knobs.push(Knob {
            family,
            name,
            setting,
            slower,
        });
    };
    if has_shapes {
        for most_steps in [4, 16] {
            add(
                EXACT,
                format!("{most_steps} steps"),
                AnyDetector::Exact(Exact { most_steps }),
                None,
            );
        }
    }
    for (name, detector) in golden_secants(has_shapes) {
        add(GOLDEN, name, AnyDetector::GoldenSecant(detector), None);
    }
    for exponent in 1..=MIN_STEP {
        let most_steps = MAX_FIXED_STEPS.max(100 * 10u32.pow(exponent as u32));
        let fixed = FixedStep {
            step: 10f64.powi(-exponent),
            most_steps,
        };
        add(
            STEP,
            format!("step 1e-{exponent}"),
            AnyDetector::FixedStep(fixed),
            Some(10.0),
        );
    }
}

/// The golden-section search with several crops of the time window, then with several tolerances.
fn golden_secants(has_shapes: bool) -> Vec<(String, GoldenSecant)> {
    let golden = GoldenSecant::default();
    let mut searches = Vec::new();
    for (crop_factor, name) in [
        (0.5, "crop ½"),
        (1.0, "crop 1"),
        (2.0, "crop 2"),
        (4.0, "crop 4"),
    ] {
        // Discs need no crop of the time window.
        if has_shapes || crop_factor == golden.crop_factor {
            let search = GoldenSecant {
                crop_factor,
                ..golden
            };
            searches.push((name.to_owned(), search));
        }
    }
    for exponent in [12, 9, 6, 3] {
        let search = GoldenSecant {
            tolerance: 10f64.powi(-exponent),
            ..golden
        };
        searches.push((format!("tol 1e-{exponent}"), search));
    }
    searches
}

/// Schedulers, instructions, epochs, samples, and grids.
fn orders(view: &View<'_>, knobs: &mut Vec<Knob>, left_out: &mut Vec<LeftOutKnob>) {
    let mut add = |name: String, setting: Setting| {
        knobs.push(Knob {
            family: ORDER,
            name,
            setting,
            slower: None,
        });
    };
    let method = |order: Order| {
        Setting::from(Method {
            order,
            ..Method::default()
        })
    };
    let best = Instructions::Widest.on_this_processor();
    for (instructions, name) in [
        (Instructions::Avx2, "AVX2"),
        (Instructions::Portable, "portable"),
    ] {
        if instructions.on_this_processor() == best
            || instructions.on_this_processor() != instructions
        {
            let reason = "the processor has no others, or not these".to_owned();
            left_out.push((format!("instructions: {name}"), reason));
        } else {
            add(
                format!("CellScheduler, {name}"),
                method(Order::Cells(instructions)),
            );
        }
    }
    for contacts in [1, 8, 512] {
        let setting = Setting {
            contacts_per_epoch: Some(contacts),
            ..Setting::default()
        };
        add(format!("epochs of {contacts}"), setting);
    }
    for (share, name) in [(0.01, "sample each τ/100"), (1.0, "sample each τ")] {
        add(
            name.to_owned(),
            Setting {
                sample_interval: Some(share),
                ..Setting::default()
            },
        );
    }
    add(
        "HeapScheduler".to_owned(),
        method(Order::Heap(CellsPerSide::Automatic)),
    );
    let finest_safe = finest_safe(view);
    for factor in [1.0, 1.2, 1.5, 2.0] {
        let cells = (f64::from(finest_safe) * factor).round() as u32;
        knobs.push(grid(format!("grid × {factor} ({cells})"), cells));
    }
}

/// Most cells a side: twice as many are allowed.
const MAX_CELLS: u32 = 2000;

/// The largest number of cells a side that is safe: no cell is shorter than the sum of the largest
/// bounding radius of a moving body and that of any other body.
pub fn finest_safe(view: &View<'_>) -> u32 {
    let radius = |fixed: bool| {
        let is_listed =
            move |view: &BodyView<'_>| !view.body.is_wall() && (fixed || view.body.is_free());
        let radii = view.bodies().filter(is_listed);
        let mut radii: Vec<f64> = radii
            .map(|view| view.body.molecule().bounding_radius())
            .collect();
        radii.sort_by(|a, b| b.total_cmp(a));
        radii
    };
    let (moving, all) = (radius(false), radius(true));
    let largest = moving.first().copied().unwrap_or(0.0);
    // The largest body may be fixed; else the second largest is the other one, or an image of a
    // body that is alone.
    let other = all.iter().copied().find(|&radius| radius > largest);
    let other = other.or(all.get(1).copied()).unwrap_or(largest);
    let reach = (largest + other).max(f64::MIN_POSITIVE);
    let side = view.bounds().sides().min_element();
    // A quotient that is an integer up to rounding counts as an integer.
    ((side / reach * (1.0 + 8.0 * f64::EPSILON)) as u32).clamp(1, MAX_CELLS)
}

impl Knob {
    /// Description of the setting with its family.
    pub fn title(&self) -> String {
        format!("{}, {}", FAMILIES[self.family], self.name)
    }

    /// How a scene, or else a program, sets it.
    pub fn how(&self) -> String {
        let written =
            |method: &Method| toml::to_string(&MethodSpec::from(method)).unwrap_or_default();
        let usual = written(&Method::default());
        let text = written(&self.setting.method);
        let changed: Vec<&str> = text
            .lines()
            .filter(|line| !usual.lines().any(|one| one == *line))
            .collect();
        let mut parts = Vec::new();
        if !changed.is_empty() {
            parts.push(format!("[method] {}", changed.join(", ")));
        }
        if let Some(contacts) = self.setting.contacts_per_epoch {
            parts.push(format!(
                "in a program only: set_contacts_per_epoch({contacts})"
            ));
        }
        if self.setting.locked {
            parts.push("rotation = \"locked\" of each [[molecule]] and [[gas]]".to_owned());
        }
        if self.setting.sample_interval.is_some() {
            parts.push("[run] sample_interval".to_owned());
        }
        if parts.is_empty() {
            "the default".to_owned()
        } else {
            parts.join("; ")
        }
    }

    /// Whether its wrong contacts are differences of the model.
    pub fn is_model(&self) -> bool {
        self.family == MODEL
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Scene, Simulation};

    /// The words are keys of a scene file, from which the same method is read.
    #[test]
    fn what_a_knob_says_of_a_scene_gives_the_setting_of_the_knob() {
        let scene = "[[gas]]\nshape = \"dumbbell\"\natom_radius = 0.01\natom_mass = 1.0\nenergy = 1.0\ncount = 20\n";
        let simulation: Simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let (knobs, _) = knobs(&simulation.view());
        let mut read = 0;
        for knob in knobs {
            let how = knob.how();
            let Some(keys) = how.strip_prefix("[method] ") else {
                assert_eq!(knob.setting.method, Method::default(), "{how}");
                continue;
            };
            let spec: MethodSpec = toml::from_str(&keys.replace(", ", "\n")).unwrap();
            assert_eq!(
                Method::try_from(&spec).unwrap(),
                knob.setting.method,
                "{how}"
            );
            read += 1;
        }
        assert!(read > 10, "{read}");
        assert_eq!(exact().how(), "the default");
    }
}
