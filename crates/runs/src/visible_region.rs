//! The part of a large system that a page shows: the bodies around a chosen one, as many as a page
//! can hold.
//!
//! A page above ten megabytes opens slowly, and single discs are invisible in a picture of a
//! million. Of a large system only the surroundings of one body are drawn.

use carom::{
    View,
    engine::{Body, BodyView},
    observers::{MAX_CIRCLES, close_up, picture},
};
use glam::DVec2;

/// Systems with at most this many bodies or atoms are shown in full. More: larger pages, 50 bytes
/// an atom in each picture.
const MAX_BODIES: usize = 10_000;
const MAX_ATOMS: usize = 40_000;

/// Least half side of a part, as a share of the shorter side of the box. Without it, the part has
/// no size where many bodies cover one place.
const MIN_HALF: f64 = 1e-3;

/// Of larger systems, this share of the two limits is shown; the rest is a margin from which bodies
/// may enter the picture.
const SHOWN: f64 = 0.4;

/// A square part of the box.
#[derive(Debug, Clone)]
pub struct VisibleRegion {
    /// Its centre (length).
    pub centre: DVec2,
    /// Half of its side (length).
    pub half: f64,
    /// Least distance that an unlisted body must travel before it can be visible (length).
    pub margin: f64,
    /// Numbers of the visible bodies and of those in the margin, in ascending order.
    pub bodies: Vec<u64>,
}

impl VisibleRegion {
    /// Whether a page shows the whole system.
    pub fn is_all(view: &View<'_>) -> bool {
        view.len() <= MAX_BODIES
            && view.bodies().map(|body| weight(body.body)).sum::<usize>() <= MAX_ATOMS
    }

    /// Chooses the part of a system that a page shows; `None` for the whole system.
    pub fn new(view: &View<'_>) -> Option<Self> {
        if Self::is_all(view) {
            return None;
        }
        // The centre is the first moving body if no other body has the same tags and number of
        // atoms, else the middle body of the list.
        let middle = view.bodies().nth(view.len() / 2)?;
        let first = view
            .bodies()
            .find(|body| body.body.is_free())
            .unwrap_or(middle);
        let is_like = |other: &BodyView<'_>| {
            weight(other.body) == weight(first.body) && tags(other) == tags(&first)
        };
        let is_alone = view.bodies().filter(is_like).take(2).count() == 1;
        let chosen = if is_alone { first } else { middle };
        let part = Self::around(view, chosen.motion.position);
        let reach = chosen.body.molecule().bounding_radius();
        if part.half >= 2.0 * reach || chosen.body.is_wall() {
            return Some(part);
        }
        // The body would fill the picture, so the part is centred on its rim.
        Some(Self::around(
            view,
            chosen.motion.position + reach * DVec2::X,
        ))
    }

    fn around(view: &View<'_>, centre: DVec2) -> Self {
        let mut near: Vec<(f64, usize, u64)> = view
            .bodies()
            .map(|body| {
                (
                    distance(view, &body, centre),
                    weight(body.body),
                    body.body.id(),
                )
            })
            .collect();
        let by_distance =
            |one: &(f64, usize, u64), other: &(f64, usize, u64)| one.0.total_cmp(&other.0);
        if near.len() > MAX_BODIES + 1 {
            near.select_nth_unstable_by(MAX_BODIES, by_distance);
            near.truncate(MAX_BODIES + 1);
        }
        near.sort_unstable_by(by_distance);
        // Distance of the nearest body that does not fit when this share of the limits is used.
        let fit = |share: f64| {
            let mut atoms = 0;
            let most = (share * MAX_ATOMS as f64) as usize;
            let room = |&&(_, weight, _): &&(f64, usize, u64)| {
                atoms += weight;
                atoms <= most
            };
            let count = near
                .iter()
                .take((share * MAX_BODIES as f64) as usize)
                .take_while(room)
                .count()
                .max(1);
            (
                count,
                near.get(count).map_or(f64::INFINITY, |first| first.0),
            )
        };
        let ((kept, outer), (_, inner)) = (fit(1.0), fit(SHOWN));
        let shorter = view.bounds().sides().min_element();
        let half = inner.clamp(MIN_HALF * shorter, 0.5 * shorter);
        let mut bodies: Vec<u64> = near[..kept].iter().map(|body| body.2).collect();
        bodies.sort_unstable();
        Self {
            centre: view.bounds().wrap(centre).0,
            half,
            margin: (outer - half).max(0.0),
            bodies,
        }
    }

    /// Returns true if the body is visible or in the margin.
    pub fn has(&self, body: &Body) -> bool {
        self.bodies.binary_search(&body.id()).is_ok()
    }

    /// Lower left corner, width and height (length).
    pub fn window(&self) -> [f64; 4] {
        let corner = self.centre - self.half;
        [corner.x, corner.y, 2.0 * self.half, 2.0 * self.half]
    }
}

/// Returns an SVG picture of the system, or of a part of it that a leading comment describes.
pub fn picture_of(view: &View<'_>, size: u32) -> String {
    let Some(part) = VisibleRegion::new(view) else {
        return picture(view, size);
    };
    let VisibleRegion { centre, half, .. } = part;
    let svg = close_up(view, centre, 2.0 * half, size);
    format!(
        "<!--{} of {} bodies: a square of side {:.4e} around ({:.4e}, {:.4e})-->\n{svg}",
        PART,
        view.len(),
        2.0 * half,
        centre.x,
        centre.y
    )
}

/// Beginning of that comment.
const PART: &str = "A part of the box";

/// Returns a sentence on the part of the box that a picture shows; empty if it shows all.
pub fn caption_of(picture: &str) -> String {
    let comment = picture
        .strip_prefix("<!--")
        .and_then(|rest| rest.split_once("-->"));
    comment
        .filter(|(text, _)| text.starts_with(PART))
        .map_or_else(String::new, |(text, _)| format!(" {text}."))
}

/// Largest number of circles, or of pieces of the boundary, that draw a body.
fn weight(body: &Body) -> usize {
    let molecule = body.molecule();
    (molecule.atoms().len() + molecule.edges().len()).min(MAX_CIRCLES)
}

fn tags<'a>(body: &BodyView<'a>) -> &'a [carom::engine::Tag] {
    body.body.tags()
}

/// Distance along x or y, the larger of the two, from a place to the nearest point of a body
/// (length).
fn distance(view: &View<'_>, body: &BodyView<'_>, place: DVec2) -> f64 {
    let nearest = |point: DVec2| {
        view.bounds()
            .nearest_image(point - place)
            .abs()
            .max_element()
    };
    if !body.body.is_wall() {
        return nearest(body.motion.position) - body.body.molecule().bounding_radius();
    }
    // The distance changes by at most the distance moved along the wall, so small steps come close
    // to the minimum.
    let of_piece = |[from, to]: [DVec2; 2]| {
        let (steps, along) = (256, to - from);
        let apart =
            (0..=steps).map(|step| nearest(from + along * (f64::from(step) / f64::from(steps))));
        apart.fold(f64::INFINITY, f64::min) - 0.5 * along.length() / f64::from(steps)
    };
    body.wall_segments()
        .map(of_piece)
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{
        Scene,
        engine::{AtomSpec, BumperSpec, MoleculeSpec},
    };
    use carom_methods::AnySimulation;

    fn simulation(scene: &str) -> AnySimulation {
        AnySimulation::new(&Scene::from_toml(scene).unwrap()).unwrap()
    }

    #[test]
    fn a_small_system_is_shown_whole() {
        let small = simulation("[[gas]]\nradius = 0.001\nmass = 1.0\nenergy = 1.0\ncount = 10000");
        assert!(VisibleRegion::new(&small.view()).is_none());
        assert_eq!(caption_of(&picture_of(&small.view(), 100)), "");
    }

    #[test]
    fn bodies_with_edges_are_paths_also_in_a_close_up() {
        let simulation = simulation(
            "[[molecule]]\nshape = \"square\"\nsize = 0.2\nmass = 1.0\nat = [0.3, 0.5]\n\
             [[molecule]]\nshape = \"capsule:2\"\nsize = 0.1\nmass = 1.0\nat = [0.95, 0.5]\n",
        );
        let svg = picture_of(&simulation.view(), 1000);
        assert!(
            svg.contains(
                "<path d=\"M200.000 600.000L400.000 600.000L400.000 400.000L200.000 400.000Z\"/>"
            ) || svg.contains("L400.000 600.000L400.000 400.000L200.000 400.000L200.000 600.000Z"),
            "{svg}"
        );
        // The capsule reaches across the right border.
        assert_eq!(
            (svg.matches("<path").count(), svg.matches("<circle").count()),
            (3, 0)
        );
        assert_eq!(svg.matches("A50.000 50.000").count(), 2 * 4);
        let close = close_up(&simulation.view(), DVec2::new(0.0, 0.5), 0.1, 100);
        assert_eq!(close.matches("<path").count(), 1);
    }

    /// Atoms on a spiral, very many for one molecule.
    fn spiral(count: u32) -> Vec<AtomSpec> {
        let atom = |k: u32| {
            let angle =
                40.0 * f64::from(k).sqrt() / f64::from(count).sqrt() * std::f64::consts::TAU;
            let at = 0.2 * angle / (40.0 * std::f64::consts::TAU) * DVec2::from_angle(angle);
            AtomSpec {
                at: at.to_array(),
                radius: 1e-4,
                mass: 1.0 / f64::from(count),
            }
        };
        (0..count).map(atom).collect()
    }

    #[test]
    fn a_body_of_any_number_of_atoms_makes_a_small_picture() {
        let body = |x: f64| MoleculeSpec {
            atoms: spiral(24_000),
            at: [x, 0.5],
            ..MoleculeSpec::default()
        };
        let drawn = |molecule: Vec<MoleculeSpec>| {
            let simulation = AnySimulation::new(&Scene {
                molecule,
                ..Scene::default()
            })
            .unwrap();
            // The whole box is shown.
            assert!(VisibleRegion::new(&simulation.view()).is_none());
            picture_of(&simulation.view(), 720)
        };
        let (one, two) = (drawn(vec![body(0.25)]), drawn(vec![body(0.25), body(0.75)]));
        let circles = one.matches("<circle").count();
        assert!((5_000..=MAX_CIRCLES).contains(&circles), "{circles}");
        assert!(
            one.len() < 1_000_000 && two.len() < 2_000_000,
            "{} {}",
            one.len(),
            two.len()
        );
    }

    #[test]
    fn a_part_where_many_bodies_overlap_has_a_size() {
        let bumper = |k: u32| {
            let at = [0.5, 0.5].map(|x| x + 1e-6 * f64::from(k));
            BumperSpec {
                tags: vec![],
                radius: 0.2,
                at,
            }
        };
        let scene = Scene {
            bumper: (0..11_000).map(bumper).collect(),
            ..Scene::default()
        };
        let simulation = AnySimulation::new(&scene).unwrap();
        let part = VisibleRegion::new(&simulation.view()).unwrap();
        assert!(
            part.half > 0.0 && part.margin >= 0.0,
            "{} {}",
            part.half,
            part.margin
        );
        let [_, _, width, height] = part.window();
        assert_eq!(width / height, 1.0);
    }

    #[test]
    fn every_visible_body_is_listed_and_no_other_is_nearer_than_the_margin() {
        let gas = "[[gas]]\nradius = 0.001\nmass = 1.0\nenergy = 1.0\ncount = 30000\n";
        let tee = "[[molecule]]\nshape = \"tee\"\natom_radius = 0.04\natom_mass = 1.0\nat = [0.98, 0.5]\n[[wall]]\ny = 0.0\n";
        for scene in [gas.to_owned(), format!("{tee}{gas}")] {
            let simulation = simulation(&scene);
            let view = simulation.view();
            let part = VisibleRegion::new(&view).unwrap();
            assert!(
                (4000..=10_000).contains(&part.bodies.len()),
                "{}",
                part.bodies.len()
            );
            assert!(part.half > 0.1 && part.margin > 0.01, "{part:?}");
            for body in view.bodies().filter(|body| !body.body.is_wall()) {
                let sides = view.bounds().sides();
                let apart = body.motion.position - part.centre;
                let apart = (apart - sides * (apart / sides).round()).abs() - part.half;
                let gap = apart.max_element() - body.body.molecule().bounding_radius();
                assert!(
                    part.has(body.body) || gap >= part.margin * (1.0 - 1e-12),
                    "{gap} {}",
                    part.margin
                );
            }
            let svg = picture_of(&view, 720);
            let circles = svg.matches("<circle").count();
            assert!(
                (3000..4300).contains(&circles) && svg.len() < 300_000,
                "{circles} in {}",
                svg.len()
            );
            assert!(caption_of(&svg).starts_with(" A part of the box"));
        }
    }
}
