//! Random rules of a scene: coefficients of contacts, roughness, and pairs of tags.

use carom::engine::{
    DiameterSpec, ElasticityRule, ElasticitySpec, Restitution, Scene, TransparentSpec, WellSpec,
};

use super::{
    motions::{MotionKind, gravity},
    vectors::BodyPair,
};
use crate::fuzz::random::FuzzDraw;

/// Tags of all bodies.
pub const TAGS: [&str; 3] = ["a", "b", "c"];

/// Tags of discs, to which rules of diameters apply.
pub const DISC_TAGS: [&str; 2] = ["d", "e"];

/// Features of scenes that are drawn in some cases.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Features {
    /// Some contacts are rough, and some restitutions depend on the speed.
    pub rough: bool,
    /// Some pairs do not see each other, or touch at another distance.
    pub pairs: bool,
    /// There is a drag.
    pub drag: bool,
    /// The kinds of motions of walls; if some walls turn, there are no ellipses.
    pub motions: [Option<MotionKind>; 4],
    /// The largest number of pistons; with any, no walls turn.
    pub pistons: usize,
    /// Acceleration by gravity (length per time²).
    pub gravity: BodyPair,
}

impl Features {
    /// The features of a scene of a class; two of them meet in some scenes.
    pub fn draw(draw: &mut FuzzDraw, class: &str) -> Self {
        let is_new = ["rough", "pairs", "wells", "drag", "ellipses"].contains(&class);
        let mut has = |name: &str| class == name || (is_new && draw.happens(0.25));
        let [rough, pairs, drag] = ["rough", "pairs", "drag"].map(&mut has);
        let pairs = pairs || class == "wells";
        // A drag excludes the motions of walls and gravity; in a long run walls meet.
        let is_driven = !drag && class != "long run of few";
        let has_ellipses = class.starts_with("ellipses");
        // The contacts of pistons are smooth.
        let has_pistons = is_driven && !rough && draw.happens(0.3);
        let pistons = if has_pistons { 1 + draw.index(3) } else { 0 };
        let motions = [
            MotionKind::Uniform,
            MotionKind::Turning,
            MotionKind::Oscillating,
            MotionKind::Table,
        ]
        .map(|kind| {
            let turns = kind == MotionKind::Turning;
            let share = if turns { 0.35 } else { 0.2 };
            let is_refused = (has_ellipses || has_pistons) && turns;
            (is_driven && draw.happens(share) && !is_refused).then_some(kind)
        });
        let falls = is_driven && draw.happens(0.25);
        Self {
            rough,
            pairs,
            drag,
            motions,
            pistons,
            gravity: if falls { gravity(draw) } else { [0.0; 2] },
        }
    }

    /// The kinds of motions of walls.
    pub fn motions(&self) -> Vec<MotionKind> {
        self.motions.into_iter().flatten().collect()
    }

    /// Returns true if some walls turn.
    pub fn turns(&self) -> bool {
        self.motions.contains(&Some(MotionKind::Turning))
    }

    /// Returns true if there is a gravity.
    pub fn falls(&self) -> bool {
        self.gravity != [0.0; 2]
    }
}

/// Random tags of a body; a disc has at most one of its own in scenes with pairs.
pub fn tags(draw: &mut FuzzDraw, is_disc: bool, features: Features) -> Vec<String> {
    let mut tags: Vec<String> = TAGS
        .iter()
        .filter(|_| draw.happens(0.25))
        .map(|&tag| tag.to_owned())
        .collect();
    if is_disc && features.pairs && draw.happens(0.7) {
        tags.push(draw.one_of(&DISC_TAGS).to_owned());
    }
    tags
}

/// Random coefficients of contacts.
pub fn elasticity(draw: &mut FuzzDraw, class: &str, is_rough: bool) -> ElasticitySpec {
    let default = match class {
        "superelastic" => draw.scale(1.0, 1e6),
        "long run of few" => draw.one_of(&[0.0, 0.0, 1e-3, 0.5, 1.0]),
        _ => draw.one_of(&[1.0, 1.0, 1.0, 1.0, 0.0, 1e-3, 0.5, 0.9, 1.1]),
    };
    let mut spec = ElasticitySpec {
        default,
        ..ElasticitySpec::default()
    };
    if draw.happens(0.2) {
        spec.contact_time = draw.scale(1e-5, 1.0);
    }
    let share = if is_rough { 0.5 } else { 0.2 };
    if draw.happens(share) {
        let between = vec!["a".to_owned(), "b".to_owned()];
        spec.pair.push(ElasticityRule {
            between,
            coefficient: draw.one_of(&[0.0, 0.5, 1.0, 1.2]).into(),
            ..ElasticityRule::default()
        });
    }
    if draw.happens(share) {
        let between = vec!["c".to_owned()];
        spec.pair.push(ElasticityRule {
            between,
            coefficient: draw.one_of(&[0.0, 0.8, 1.0]).into(),
            ..ElasticityRule::default()
        });
    }
    if is_rough {
        roughen(draw, &mut spec);
    }
    spec
}

/// Makes the contacts of most rules rough, and the restitution of some depend on the speed.
fn roughen(draw: &mut FuzzDraw, spec: &mut ElasticitySpec) {
    if spec.pair.is_empty() || draw.happens(0.7) {
        (spec.tangential, spec.friction) = surfaces(draw);
    }
    for rule in &mut spec.pair {
        if draw.happens(0.7) {
            (rule.tangential, rule.friction) = surfaces(draw);
        }
        if draw.happens(0.2) {
            rule.kick = 0.3 * draw.normal();
        }
        if draw.happens(0.3) {
            rule.coefficient = by_speed(draw);
        }
    }
}

/// Tangential restitution and friction.
fn surfaces(draw: &mut FuzzDraw) -> (f64, Option<f64>) {
    let tangential = match draw.index(6) {
        0 => 0.0,
        1 | 2 => 1.0,
        _ => draw.between(-1.0, 1.0),
    };
    let friction = match draw.index(4) {
        0 | 1 => None,
        2 => Some(draw.scale(1e-2, 3.0)),
        _ => Some(draw.one_of(&[0.0, 0.1, 0.5, 1.0])),
    };
    (tangential, friction)
}

/// A restitution that depends on the speed of approach.
fn by_speed(draw: &mut FuzzDraw) -> Restitution {
    if draw.happens(0.5) {
        return Restitution::Power {
            power: draw.one_of(&[-2.0, -0.25, -0.2, 0.5, 1.0, 3.0]),
            at: draw.scale(1e-2, 10.0),
        };
    }
    let (mut speeds, mut speed) = (vec![], 0.0);
    for _ in 0..draw.integer(1, 4) {
        speed += draw.scale(1e-2, 3.0);
        speeds.push(speed);
    }
    let values = speeds.iter().map(|_| draw.between(0.0, 1.05)).collect();
    Restitution::Table { speeds, values }
}

/// Random pairs that do not see each other.
pub fn transparent(draw: &mut FuzzDraw) -> Vec<TransparentSpec> {
    let count = draw.integer(0, 2);
    let rule = |_| {
        let tags: &[&str] = match draw.index(6) {
            0 => &["a"],
            1 => &["b"],
            2 => &["a", "b"],
            3 => &["a", "c"],
            4 => &["d", "a"],
            _ => &["e"],
        };
        TransparentSpec {
            between: tags.iter().map(|&tag| tag.to_owned()).collect(),
        }
    };
    (0..count).map(rule).collect()
}

/// Adds random rules for pairs of tags to a scene.
pub fn add_pairs(draw: &mut FuzzDraw, scene: &mut Scene) {
    scene.transparent = transparent(draw);
    let none = scene.transparent.is_empty();
    for tags in [&["d", "e"][..], &["d"]] {
        if draw.happens(0.4) || (none && tags.len() == 2) {
            scene.diameter.push(DiameterSpec {
                between: tags.iter().map(|&tag| tag.to_owned()).collect(),
                factor: draw.scale(0.2, 2.0),
            });
        }
    }
}

/// Random wells of discs.
pub fn wells(draw: &mut FuzzDraw) -> Vec<WellSpec> {
    let mut wells = Vec::new();
    for tags in [&["d", "e"][..], &["d"]] {
        if draw.happens(0.6) {
            let mut range = 1.0;
            let steps = (0..draw.integer(1, 4)).map(|_| {
                range += draw.scale(1e-3, 0.5);
                let energy = if draw.happens(0.1) {
                    0.0
                } else {
                    draw.normal()
                };
                [range, energy]
            });
            let steps = steps.collect();
            wells.push(WellSpec {
                between: tags.iter().map(|&tag| tag.to_owned()).collect(),
                steps,
            });
        }
    }
    wells
}

/// Multiplies the energies of wells by a power of two.
pub fn scale_wells(wells: &mut [WellSpec], energy: f64) {
    for step in wells.iter_mut().flat_map(|well| &mut well.steps) {
        step[1] *= energy;
    }
}

/// Multiplies speeds and masses in coefficients of contacts by powers of two.
pub fn scale_elasticity(spec: &mut ElasticitySpec, speed: f64, mass: f64) {
    for rule in &mut spec.pair {
        rule.kick *= mass * speed;
        match &mut rule.coefficient {
            Restitution::Number(_) => {}
            Restitution::Power { at, .. } => *at *= speed,
            Restitution::Table { speeds, .. } => {
                for point in speeds {
                    *point *= speed;
                }
            }
        }
    }
}
