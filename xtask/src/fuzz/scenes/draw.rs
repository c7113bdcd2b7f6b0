//! Random scenes: bodies of all kinds, walls, elasticities, scales, and edits between runs.

use carom::engine::{
    AtomSpec, BumperSpec, GasSpec, MoleculeSpec, Quantity, Rotation, Scene, StartVelocities,
    WallMotionSpec, WallSpec,
};
use carom_geometry::{Molecule, Shape, gap_between};
use glam::DVec2;

use super::{
    bonds,
    case::{CaseEdit, RunStretch, SceneCase, drop_unknown_pairs},
    kinematics::{BodyOutline, BodyPair, Placed, along, for_each_image, length},
    laws::SceneRules,
    motions::{self, scale_motion},
    pistons::{self, PistonRoom},
    rules::{self, DISC_TAGS, Features, TAGS, elasticity, scale_elasticity, tags},
    sided::{ellipse_body, ellipse_gas, sided_body, sided_gas},
};
use crate::fuzz::{detection::case::exp2, random::FuzzDraw};

/// Attempts to place one body.
const TRIES: usize = 60;

/// A body that has been placed.
struct Standing {
    molecule: Molecule,
    outline: BodyOutline,
    placed: Placed,
    tags: Vec<String>,
}

/// A body to be placed.
struct Unplaced<'a> {
    molecule: &'a Molecule,
    outline: &'a BodyOutline,
    tags: &'a [String],
}

/// A scene under construction, in units of the box's width.
struct Sketch {
    sides: BodyPair,
    standing: Vec<Standing>,
    scene: Scene,
    features: Features,
    /// The rules for pairs of tags.
    rules: SceneRules,
}

/// Returns the case of a seed.
pub fn draw(seed: u64) -> SceneCase {
    let draw = &mut FuzzDraw::new(seed);
    let class = draw.one_of(&[
        "mixture",
        "mixture",
        "mixture",
        "mixture",
        "close bodies",
        "close bodies",
        "long run of few",
        "superelastic",
        "discs",
        "discs",
        "walls",
        "walls",
        "sides",
        "sides",
        "sides",
        "sides in walls",
        "sides in walls",
        "rough",
        "rough",
        "pairs",
        "pairs",
        "wells",
        "wells",
        "bonds",
        "bonds",
        "drag",
        "drag",
        "ellipses",
        "ellipses",
        "ellipses",
        "ellipses in walls",
        "ellipses in walls",
    ]);
    let mut sketch = Sketch::new(draw, class);
    let size = sketch.bodies(draw, class);
    sketch.gases(draw, class, size);
    if class == "bonds" || (class == "pairs" && draw.happens(0.2)) {
        bonds::tie(draw, &mut sketch.scene, sketch.features.falls());
    }
    let stretch = stretches(draw, class, &sketch);
    let duration: f64 = stretch.iter().map(|stretch| stretch.duration).sum();
    if sketch.features.drag {
        sketch.scene.bounds.drag = draw.scale(0.01, 5.0) / duration;
    }
    let kinds = sketch.features.motions();
    motions::move_walls(draw, &mut sketch.scene, &kinds, duration);
    pistons::add_springs(draw, &mut sketch.scene, duration);
    drop_unknown_pairs(&mut sketch.scene);
    let mut case = SceneCase {
        class: class.to_owned(),
        seed: draw.bits() >> 1,
        stretch,
        scene: sketch.scene,
    };
    scale(draw, &mut case);
    case
}

/// A gas of molecules, which `of_radius` describes, smaller than bodies of this size.
fn gas(
    draw: &mut FuzzDraw,
    size: f64,
    of_radius: impl Fn(&mut FuzzDraw, f64) -> GasSpec,
) -> GasSpec {
    let radius = draw.scale(0.1, 0.5) * size;
    GasSpec {
        tags: vec!["a".to_owned()],
        energy: draw.scale(1e-3, 1.0),
        count: Some(draw.integer(1, 30) as usize),
        velocities: draw.one_of(&[StartVelocities::EqualEnergy, StartVelocities::Maxwell]),
        ..of_radius(draw, radius)
    }
}

/// A random molecule of about this radius, and its scene description.
fn molecule(
    draw: &mut FuzzDraw,
    class: &str,
    features: Features,
    radius: f64,
) -> Option<(Molecule, MoleculeSpec)> {
    let radius = radius * draw.scale(0.3, 1.5);
    // Some molecules extend over most of the box.
    let radius = if class == "mixture" && draw.happens(0.03) {
        0.12
    } else {
        radius
    };
    let mass = draw.scale(0.1, 10.0);
    if class.starts_with("sides") && draw.happens(0.8) {
        return described(sided_body(draw, radius, mass));
    }
    if class.starts_with("ellipses") && draw.happens(0.6) {
        return described(ellipse_body(draw, radius, mass));
    }
    let discs = if class == "long run of few" { 0.8 } else { 0.3 };
    let kind = if ["discs", "wells"].contains(&class) || draw.happens(discs) {
        0
    } else {
        draw.integer(0, 8)
    };
    let shape = match kind {
        0 => Shape::Disc,
        1 => Shape::Dumbbell,
        2 => Shape::Tee,
        3 => Shape::Rod(draw.integer(2, 9) as usize),
        4 => Shape::Ring(draw.integer(3, 12) as usize),
        5 => Shape::Cross,
        6 => return described(sided_body(draw, radius, mass)),
        // Ellipses and walls that turn are refused together.
        7 if !features.turns() => return described(ellipse_body(draw, radius, mass)),
        _ => return described(blob(draw, radius, mass)),
    };
    let atom_radius = if kind == 0 { radius } else { 0.5 * radius };
    described(MoleculeSpec {
        shape: Some(shape.to_string()),
        atom_radius: Some(atom_radius),
        atom_mass: Some(mass),
        ..MoleculeSpec::default()
    })
}

/// A description with its molecule, if it is one.
fn described(spec: MoleculeSpec) -> Option<(Molecule, MoleculeSpec)> {
    Some((spec.molecule("molecule").ok()?, spec))
}

/// Atoms at random positions with random radii and masses.
fn blob(draw: &mut FuzzDraw, radius: f64, mass: f64) -> MoleculeSpec {
    let count = draw.integer(2, 18);
    let atom = |_| AtomSpec {
        at: [
            draw.between(-1.0, 1.0) * radius,
            draw.between(-1.0, 1.0) * radius,
        ],
        radius: draw.scale(0.05, 0.6) * radius,
        mass: draw.scale(0.1, 1.0) * mass,
    };
    MoleculeSpec {
        atoms: (0..count).map(atom).collect(),
        ..MoleculeSpec::default()
    }
}

/// Velocity and spin at a temperature of about 1.
fn move_it(draw: &mut FuzzDraw, molecule: &Molecule, spec: &mut MoleculeSpec, is_rough: bool) {
    if spec.fixed {
        return;
    }
    let thermal = 1.0 / molecule.mass().sqrt();
    if !draw.happens(0.1) {
        spec.velocity = [draw.normal() * thermal, draw.normal() * thermal];
    }
    // Discs turn where some contacts are rough.
    let turns = (is_rough || !molecule.is_disc()) && spec.rotation == Rotation::Free;
    if turns && !draw.happens(0.2) {
        let fast = if draw.happens(0.03) {
            draw.scale(1.0, 1e3)
        } else {
            1.0
        };
        spec.angular_velocity = fast * draw.normal() / molecule.moment_of_inertia().sqrt();
    }
}

impl Sketch {
    /// An empty box with the rules of a class.
    fn new(draw: &mut FuzzDraw, class: &str) -> Self {
        let sides = [1.0, draw.between(0.3, 2.0)];
        let features = Features::draw(draw, class);
        let mut scene = Scene::default();
        scene.bounds.sides = sides;
        scene.bounds.seed = draw.bits() >> 1;
        scene.elasticity = elasticity(draw, class, features.rough);
        if features.pairs {
            rules::add_pairs(draw, &mut scene);
            if class == "wells" || draw.happens(0.5) {
                scene.well = rules::wells(draw);
            }
        }
        scene.gravity.acceleration = features.gravity;
        Self {
            sides,
            standing: Vec::new(),
            features,
            rules: SceneRules::new(&scene),
            scene,
        }
    }

    fn anywhere(&self, draw: &mut FuzzDraw) -> BodyPair {
        [
            draw.between(0.0, self.sides[0]),
            draw.between(0.0, self.sides[1]),
        ]
    }

    /// A random wall: across the box, or between two points that may lie outside it; thin or thick.
    fn wall(&mut self, draw: &mut FuzzDraw) {
        let spec = WallSpec {
            tags: tags(draw, false, self.features),
            radius: thickness(draw),
            ..WallSpec::default()
        };
        let across = draw.index(5);
        self.wall_across(draw, (across < 2).then_some(across), spec);
    }

    /// Walls across the box in the way of gravity, which all bodies see.
    fn floors(&mut self, draw: &mut FuzzDraw) {
        for axis in 0..2 {
            if self.scene.gravity.acceleration[axis] != 0.0 {
                let spec = WallSpec {
                    radius: thickness(draw),
                    ..WallSpec::default()
                };
                self.wall_across(draw, Some(axis), spec);
            }
        }
    }

    /// Adds a wall across the box that stops bodies along an axis, or one between two points.
    fn wall_across(&mut self, draw: &mut FuzzDraw, axis: Option<usize>, mut spec: WallSpec) {
        let (middle, half) = match axis {
            Some(0) => {
                let x = draw.between(0.0, self.sides[0]);
                spec.x = Some(x);
                ([x, 0.5 * self.sides[1]], [0.0, 0.5 * self.sides[1]])
            }
            Some(_) => {
                let y = draw.between(0.0, self.sides[1]);
                spec.y = Some(y);
                ([0.5 * self.sides[0], y], [0.5 * self.sides[0], 0.0])
            }
            None => {
                let from = self.anywhere(draw);
                let far = if draw.happens(0.2) { 1.5 } else { 0.4 };
                let mut to = [0, 1]
                    .map(|axis| from[axis] + far * draw.between(-1.0, 1.0) * self.sides[axis]);
                match draw.index(6) {
                    0 => to[0] = from[0],
                    1 => to[1] = from[1],
                    // It ends on the border and touches its image there.
                    2 => to[0] = self.sides[0],
                    _ => {}
                }
                (spec.from, spec.to) = (Some(from), Some(to));
                (
                    [0, 1].map(|k| 0.5 * (from[k] + to[k])),
                    [0, 1].map(|k| 0.5 * (to[k] - from[k])),
                )
            }
        };
        let Ok(wall) = Molecule::wall(2.0 * DVec2::from(half), spec.radius) else {
            return;
        };
        let tags = spec.tags.clone();
        self.scene.wall.push(spec);
        self.add_standing_wall(wall, middle, tags);
    }

    /// Keeps the place of a wall or piston with its middle there (length).
    fn add_standing_wall(&mut self, wall: Molecule, middle: BodyPair, tags: Vec<String>) {
        self.standing.push(Standing {
            tags,
            outline: BodyOutline::new(&wall),
            molecule: wall,
            placed: Placed {
                place: middle,
                rotation: [1.0, 0.0],
            },
        });
    }

    /// A wall with end points that is short enough to turn.
    fn turning_wall(&mut self, draw: &mut FuzzDraw) {
        let from = self.anywhere(draw);
        let size = draw.scale(0.05, 0.9) * self.sides[0].min(self.sides[1]);
        let to = along(from, size, draw.direction().to_array());
        let spec = WallSpec {
            from: Some(from),
            to: Some(to),
            ..WallSpec::default()
        };
        let Ok(wall) = Molecule::wall(DVec2::from(to) - DVec2::from(from), spec.radius) else {
            return;
        };
        self.scene.wall.push(spec);
        let middle = along(from, 0.5, along(to, -1.0, from));
        self.add_standing_wall(wall, middle, vec![]);
    }

    /// Pistons along one axis, between the walls of the scene.
    fn pistons(&mut self, draw: &mut FuzzDraw) {
        let axis = draw.index(2);
        for _ in 0..self.features.pistons {
            let room = PistonRoom {
                axis,
                sides: self.sides,
                scene: &self.scene,
                tags: tags(draw, false, self.features),
            };
            let Some(spec) = room.piston(draw) else {
                continue;
            };
            let mut half = [0.0; 2];
            half[1 - axis] = 0.5 * self.sides[1 - axis];
            let Ok(wall) = Molecule::wall(2.0 * DVec2::from(half), spec.radius) else {
                continue;
            };
            let mut middle = half;
            middle[axis] = spec.x.or(spec.y).unwrap_or_default();
            let tags = spec.tags.clone();
            self.scene.piston.push(spec);
            self.add_standing_wall(wall, middle, tags);
        }
    }

    /// Smallest gap to the body's own images and to all placed bodies that see it. A body inside
    /// another overlaps it, unless that is hollow.
    fn gap(&self, body: &Unplaced<'_>, placed: &Placed) -> f64 {
        let (molecule, outline) = (body.molecule, body.outline);
        let mut least = self.sides[0].min(self.sides[1]) - 2.0 * outline.reach;
        let rotation = DVec2::from(placed.rotation);
        for other in &self.standing {
            let factor = self.rules.factor(body.tags, &other.tags);
            if factor == 0.0 {
                continue;
            }
            let [one, two] = [outline, &other.outline].map(|outline| outline.scaled(factor));
            let pair = [(&one, placed), (&two, &other.placed)];
            for_each_image(pair[0], pair[1], self.sides, |separation| {
                if factor != 1.0 {
                    least = least.min(length(separation) - (one.reach + two.reach));
                    return;
                }
                let turned = DVec2::from(other.placed.rotation);
                let (body, separation) = (&other.molecule, DVec2::from(separation));
                least = least.min(gap_between(molecule, rotation, body, turned, separation));
            });
        }
        least
    }

    /// A free position for a body; next to the last body if `close` and possible.
    fn free_position(
        &self,
        draw: &mut FuzzDraw,
        body: &Unplaced<'_>,
        rotation: BodyPair,
        close: bool,
    ) -> Option<BodyPair> {
        let at = |place: BodyPair| Placed { place, rotation };
        if close && let Some(last) = self.standing.last() {
            let (origin, reach) = (last.placed.place, last.outline.reach + body.outline.reach);
            let direction = draw.direction().to_array();
            // Bisection between the position of the last body (0) and separated circles; the gap is
            // between a rounding error and 1e-9.
            let requested = if draw.happens(0.1) {
                0.0
            } else {
                draw.scale(1e-17, 1e-9)
            };
            let factor = self.rules.factor(body.tags, &last.tags).max(1.0);
            let (mut near, mut far) = (0.0, 1.01 * factor * reach);
            for _ in 0..80 {
                let middle = 0.5 * (near + far);
                let gap = self.gap(body, &at(along(origin, middle, direction)));
                if gap < requested {
                    near = middle;
                } else {
                    far = middle;
                }
            }
            let place = along(origin, far, direction);
            if self.gap(body, &at(place)) >= requested {
                return Some(place);
            }
        }
        for _ in 0..TRIES {
            let place = self.anywhere(draw);
            if self.gap(body, &at(place)) > 1e-12 {
                return Some(place);
            }
        }
        None
    }

    /// Walls and single bodies of a class; returns the size of the bodies (length).
    fn bodies(&mut self, draw: &mut FuzzDraw, class: &str) -> f64 {
        self.floors(draw);
        if class == "walls" || class.ends_with("in walls") || draw.happens(0.15) {
            for _ in 0..draw.integer(1, 4) {
                self.wall(draw);
            }
        }
        if self.features.turns() {
            self.turning_wall(draw);
        } else if self.scene.wall.is_empty() && !self.features.motions().is_empty() {
            self.wall(draw);
        }
        if self.features.pistons > 0 {
            self.pistons(draw);
        }
        let count = match class {
            "long run of few" => draw.integer(2, 3),
            "close bodies" => draw.integer(2, 8),
            "discs" | "wells" => draw.integer(10, 40),
            _ => draw.integer(2, 40),
        };
        let size = draw.scale(0.15, 0.5) * (self.sides[1] / count as f64).sqrt();
        for _ in 0..count {
            let share = match class {
                "close bodies" => 1.0,
                "long run of few" => 0.5,
                "rough" | "pairs" | "ellipses" => 0.15,
                "wells" => 0.3,
                _ => 0.0,
            };
            let close = draw.happens(share);
            self.body(draw, class, size, close);
        }
        size
    }

    /// A gas of discs or of molecules with sides, in some scenes of some classes.
    fn gases(&mut self, draw: &mut FuzzDraw, class: &str, size: f64) {
        let may_have_gas = ["discs", "rough", "pairs", "wells", "drag", "bonds"].contains(&class);
        if may_have_gas && draw.happens(0.5) {
            let of_discs = |draw: &mut FuzzDraw, radius: f64| GasSpec {
                radius: Some(radius.into()),
                mass: Some(draw.scale(0.1, 10.0).into()),
                ..GasSpec::default()
            };
            let mut gas = gas(draw, size, of_discs);
            if self.features.pairs && draw.happens(0.5) {
                gas.tags = tags(draw, true, self.features);
            }
            self.scene.gas.push(gas);
        }
        if class == "sides" && draw.happens(0.5) {
            self.scene.gas.push(gas(draw, size, sided_gas));
        }
        if class.starts_with("ellipses") && draw.happens(0.5) {
            self.scene.gas.push(gas(draw, size, ellipse_gas));
        }
    }

    /// Returns true if fixed discs are refused: where there are a gravity and rules of diameters or
    /// wells.
    fn refuses_fixed_discs(&self) -> bool {
        let resizes = !self.scene.diameter.is_empty() || !self.scene.well.is_empty();
        self.features.falls() && resizes
    }

    /// Fixes a body, locks its rotation or sets it in motion.
    fn set_going(
        &self,
        draw: &mut FuzzDraw,
        class: &str,
        molecule: &Molecule,
        spec: &mut MoleculeSpec,
    ) {
        let has_spin = self.features.rough;
        let disc = molecule.is_disc();
        spec.fixed = draw.happens(0.08) && !(disc && self.refuses_fixed_discs());
        if (!disc || has_spin) && draw.happens(0.15) {
            spec.rotation = Rotation::Locked;
        }
        move_it(draw, molecule, spec, has_spin);
        if class == "long run of few"
            && draw.happens(0.7)
            && !spec.fixed
            && let Some(first) = self.scene.molecule.first()
        {
            // Head-on: the relative velocity is along the line of centres, as for bodies that
            // remain together after an inelastic contact.
            let speed = draw.between(0.5, 2.0);
            spec.velocity = along(first.velocity, speed, along(first.at, -1.0, spec.at));
        }
    }

    /// A body at a free position; next to the last one if `close`.
    fn body(&mut self, draw: &mut FuzzDraw, class: &str, size: f64, close: bool) {
        let Some((molecule, mut spec)) = molecule(draw, class, self.features, size) else {
            return;
        };
        let outline = BodyOutline::new(&molecule);
        let turns = draw.between(-0.5, 0.5);
        let (sin, cos) = libm::sincos(turns * std::f64::consts::TAU);
        let disc = molecule.is_disc();
        let tags = tags(draw, disc, self.features);
        let unplaced = Unplaced {
            molecule: &molecule,
            outline: &outline,
            tags: &tags,
        };
        let Some(place) = self.free_position(draw, &unplaced, [cos, sin], close) else {
            return;
        };
        let placed = Placed {
            place,
            rotation: [cos, sin],
        };
        if disc && !close && draw.happens(0.1) && !self.refuses_fixed_discs() {
            let radius = outline.atoms[0].1;
            self.scene.bumper.push(BumperSpec {
                tags: tags.clone(),
                radius,
                at: place,
            });
            self.standing.push(Standing {
                molecule,
                outline,
                placed,
                tags,
            });
            return;
        }
        spec.tags.clone_from(&tags);
        spec.at = place;
        if !disc || self.features.rough {
            spec.orientation_turns = Some(turns);
        }
        self.set_going(draw, class, &molecule, &mut spec);
        self.scene.molecule.push(spec);
        self.standing.push(Standing {
            molecule,
            outline,
            placed,
            tags,
        });
    }
}

/// Half the thickness of a wall (length).
fn thickness(draw: &mut FuzzDraw) -> f64 {
    if draw.happens(0.5) {
        0.0
    } else {
        draw.scale(1e-4, 0.02)
    }
}

fn stretches(draw: &mut FuzzDraw, class: &str, sketch: &Sketch) -> Vec<RunStretch> {
    if class == "long run of few" {
        return vec![RunStretch {
            duration: draw.scale(1e3, 3e4),
            edits: vec![],
        }];
    }
    let count = if draw.happens(0.5) {
        1
    } else {
        draw.integer(2, 5)
    };
    (0..count)
        .map(|index| RunStretch {
            duration: draw.scale(0.05, 2.0),
            edits: if index + 1 < count {
                (0..draw.integer(1, 2))
                    .map(|_| edit(draw, sketch))
                    .collect()
            } else {
                vec![]
            },
        })
        .collect()
}

fn edit(draw: &mut FuzzDraw, sketch: &Sketch) -> CaseEdit {
    let body = draw.index(64);
    feature_edit(draw, sketch, body).unwrap_or_else(|| body_edit(draw, sketch, body))
}

/// An edit that only scenes with some features have; mostly `None`.
fn feature_edit(draw: &mut FuzzDraw, sketch: &Sketch, body: usize) -> Option<CaseEdit> {
    let features = sketch.features;
    if features.pairs && draw.happens(0.2) {
        return Some(CaseEdit::Transparent(rules::transparent(draw)));
    }
    if !sketch.scene.well.is_empty() && draw.happens(0.3) {
        return Some(CaseEdit::Wells(rules::wells(draw)));
    }
    if features.drag && draw.happens(0.2) {
        let drag = draw.scale(0.01, 5.0);
        return Some(CaseEdit::Drag(if draw.happens(0.3) { 0.0 } else { drag }));
    }
    let kinds = features.motions();
    if !kinds.is_empty() && draw.happens(0.25) {
        let kind = draw.one_of(&kinds);
        let motion = motions::motion(draw, kind, sketch.sides, 1.0, true);
        let is_stopped = draw.happens(0.2);
        let motion = if is_stopped {
            WallMotionSpec::default()
        } else {
            motion
        };
        return Some(CaseEdit::MoveWall(body, Box::new(motion)));
    }
    if features.falls() && draw.happens(0.15) {
        let factor = draw.one_of(&[0.0, 0.5, -1.0]);
        return Some(CaseEdit::Gravity(features.gravity.map(|g| factor * g)));
    }
    if !sketch.scene.piston.is_empty() && draw.happens(0.25) {
        let force = if draw.happens(0.3) {
            0.0
        } else {
            pistons::force(draw, 1.0)
        };
        return Some(CaseEdit::Push(body, force));
    }
    None
}

/// An edit that all scenes have.
fn body_edit(draw: &mut FuzzDraw, sketch: &Sketch, body: usize) -> CaseEdit {
    let features = sketch.features;
    let tag = |draw: &mut FuzzDraw| {
        let own = features.pairs && draw.happens(0.3);
        draw.one_of(if own { &DISC_TAGS[..] } else { &TAGS })
            .to_owned()
    };
    match draw.index(11) {
        0 | 1 => added_molecule(draw, sketch),
        2 => added_wall(draw, sketch),
        3 => CaseEdit::Remove(body),
        4 => CaseEdit::Energy(body, draw.scale(1e-3, 1e3)),
        5 => CaseEdit::Reverse,
        6 => CaseEdit::Lock(body),
        7 => CaseEdit::Free(body),
        8 => {
            let class = draw.one_of(&["mixture", "superelastic"]);
            let is_rough = draw.happens(if features.rough { 0.7 } else { 0.15 });
            let mut spec = elasticity(draw, class, is_rough);
            spec.default = spec.default.min(2.0);
            CaseEdit::Elasticity(spec)
        }
        9 => CaseEdit::Tag(body, tag(draw)),
        _ => CaseEdit::Untag(body, tag(draw)),
    }
}

fn added_molecule(draw: &mut FuzzDraw, sketch: &Sketch) -> CaseEdit {
    match molecule(draw, "added", sketch.features, 0.03) {
        Some((molecule, mut spec)) => {
            spec.at = sketch.anywhere(draw);
            spec.tags = tags(draw, molecule.is_disc(), sketch.features);
            move_it(draw, &molecule, &mut spec, sketch.features.rough);
            CaseEdit::Add(Box::new(spec))
        }
        None => CaseEdit::Reverse,
    }
}

fn added_wall(draw: &mut FuzzDraw, sketch: &Sketch) -> CaseEdit {
    let from = sketch.anywhere(draw);
    let to = [
        from[0] + draw.between(-0.3, 0.3),
        from[1] + draw.between(-0.3, 0.3),
    ];
    CaseEdit::AddWall(Box::new(WallSpec {
        from: Some(from),
        to: Some(to),
        ..WallSpec::default()
    }))
}

/// Multiplies lengths, speeds and masses by powers of two: mostly 1, otherwise up to 1e±30, and
/// sometimes to the largest lengths and smallest speeds that are accepted.
fn scale(draw: &mut FuzzDraw, case: &mut SceneCase) {
    // Accelerations are refused beyond 10⁻⁶⁰ and 10⁶⁰.
    let scene = &case.scene;
    let moves = scene.wall.iter().any(|wall| wall.motion.is_some());
    // Energies of wells, too.
    let accelerates =
        !scene.gravity.is_none() || moves || !scene.piston.is_empty() || !scene.well.is_empty();
    let [length, speed, mass] = if draw.happens(0.5) {
        [0, 0, 0]
    } else if accelerates {
        [(); 3].map(|()| draw.integer(-50, 50))
    } else if draw.happens(0.06) {
        [draw.integer(0, 166), draw.integer(-199, 0), 0]
    } else {
        [
            draw.integer(-100, 100),
            draw.integer(-100, 100),
            draw.integer(-60, 60),
        ]
    }
    .map(|exponent| exp2(exponent as i32));
    let time = length / speed;
    let (scene, stretches) = (&mut case.scene, &mut case.stretch);
    scale_scene(scene, length, speed, mass);
    for stretch in stretches {
        stretch.duration *= time;
        for edit in &mut stretch.edits {
            match edit {
                CaseEdit::Add(spec) => scale_molecule(spec, length, speed, mass),
                CaseEdit::AddWall(spec) => scale_wall(spec, length, speed),
                CaseEdit::MoveWall(_, motion) => scale_motion(motion, length, speed),
                CaseEdit::Gravity(gravity) => *gravity = gravity.map(|g| g * (speed / time)),
                CaseEdit::Push(_, force) => *force *= mass * (speed / time),
                CaseEdit::Elasticity(spec) => scale_elasticity(spec, speed, mass),
                CaseEdit::Drag(drag) => *drag /= time,
                CaseEdit::Wells(wells) => rules::scale_wells(wells, mass * speed * speed),
                _ => {}
            }
        }
    }
}

fn scale_scene(scene: &mut Scene, length: f64, speed: f64, mass: f64) {
    scene.bounds.sides = scene.bounds.sides.map(|side| side * length);
    scene.bounds.drag *= speed / length;
    scale_elasticity(&mut scene.elasticity, speed, mass);
    bonds::scale(&mut scene.bond, length);
    rules::scale_wells(&mut scene.well, mass * speed * speed);
    scene
        .molecule
        .iter_mut()
        .for_each(|spec| scale_molecule(spec, length, speed, mass));
    scene
        .wall
        .iter_mut()
        .for_each(|spec| scale_wall(spec, length, speed));
    scene
        .piston
        .iter_mut()
        .for_each(|spec| pistons::scale_piston(spec, length, speed, mass));
    let gravity = &mut scene.gravity.acceleration;
    *gravity = gravity.map(|g| g * (speed * speed / length));
    for bumper in &mut scene.bumper {
        bumper.radius *= length;
        bumper.at = bumper.at.map(|x| x * length);
    }
    for gas in &mut scene.gas {
        gas.radius = scaled(gas.radius.as_ref(), length);
        gas.size = scaled(gas.size.as_ref(), length);
        gas.mass = scaled(gas.mass.as_ref(), mass);
        gas.energy *= mass * speed * speed;
    }
}

/// A quantity of a gas of equal molecules, times a factor.
fn scaled(given: Option<&Quantity>, factor: f64) -> Option<Quantity> {
    given
        .and_then(Quantity::number)
        .map(|number| (factor * number).into())
}

fn scale_molecule(spec: &mut MoleculeSpec, length: f64, speed: f64, mass: f64) {
    spec.at = spec.at.map(|x| x * length);
    spec.velocity = spec.velocity.map(|v| v * speed);
    spec.angular_velocity *= speed / length;
    spec.atom_radius = spec.atom_radius.map(|radius| radius * length);
    spec.atom_mass = spec.atom_mass.map(|one| one * mass);
    spec.size = spec.size.map(|size| size * length);
    spec.edge_radius = spec.edge_radius.map(|radius| radius * length);
    spec.mass = spec.mass.map(|one| one * mass);
    spec.density = spec.density.map(|one| one * mass / (length * length));
    for corner in &mut spec.polygon {
        *corner = corner.map(|x| x * length);
    }
    for atom in &mut spec.atoms {
        atom.at = atom.at.map(|x| x * length);
        atom.radius *= length;
        atom.mass *= mass;
    }
    for ellipse in &mut spec.ellipses {
        ellipse.at = ellipse.at.map(|x| x * length);
        ellipse.axes = ellipse.axes.map(|axis| axis * length);
        ellipse.mass *= mass;
    }
}

fn scale_wall(spec: &mut WallSpec, length: f64, speed: f64) {
    if let Some(motion) = &mut spec.motion {
        scale_motion(motion, length, speed);
    }
    let scaled = |point: Option<BodyPair>| point.map(|point| point.map(|x| x * length));
    (spec.from, spec.to) = (scaled(spec.from), scaled(spec.to));
    (spec.x, spec.y) = (spec.x.map(|x| x * length), spec.y.map(|y| y * length));
    spec.radius *= length;
}
