//! A frame: where each visible body is, as a binary message.
//!
//! Layout, little-endian:
//!
//! | bytes | content |
//! | --- | --- |
//! | 0 to 3 | `u32` 1 |
//! | 4 to 7 | `u32` version of the list of bodies |
//! | 8 to 15 | `f64` time |
//! | 16 to 31 | 2 `f64` middle of the window (length) |
//! | 32 to 35 | `u32` number of the frame |
//! | 36 to 39 | `u32` number n of bodies |
//! | 40 to 43 | `u32` flags: 1 indices, 2 orientations, 4 values, 8 walls |
//! | 44 to 47 | `u32` number k of contacts of the chosen body, the last first |
//! | from 48 | `u32` n indices in that list, if some bodies are left out; `f32` n places x, then y, relative to the middle (length); `f32` n orientations (radians); `f32` n values; then k times 5 `f32`: age, place relative to the present one, and impulse; then, if a wall is not where the list has it, for each wall of the list 4 `f32`: its ends relative to the middle (length) |
//!
//! Places are those of the nearest image to the middle of the window, so that a page resolves its
//! pixels at any magnification.

use carom::{View, observers::local_orders};
use glam::DVec2;

use crate::{
    body_list::BodyList,
    follower::Kick,
    protocol::{BodyColour, VisibleWindow},
};

/// Bytes before the arrays.
pub const HEAD: usize = 48;

/// The number of a frame, and what it belongs to.
#[derive(Debug, Clone, Copy)]
pub struct FrameLabel<'a> {
    /// Number of the frame.
    pub number: u32,
    /// The list of the bodies.
    pub body_list: &'a BodyList,
}

/// Encodes the bodies in a window.
pub fn encode(
    view: &View<'_>,
    label: FrameLabel<'_>,
    window: &VisibleWindow,
    kicks: &[Kick],
) -> Vec<u8> {
    let FrameLabel { number, body_list } = label;
    let centre = middle(view, window);
    let ShownBodies {
        is_whole,
        indices,
        xs,
        ys,
        angles,
        values,
    } = ShownBodies::new(view, body_list, window, centre);
    let walls: Vec<[DVec2; 2]> = if body_list.walls.is_empty() {
        Vec::new()
    } else {
        view.bodies()
            .flat_map(|body| body.wall_segments())
            .collect()
    };
    let has_moved = walls != body_list.walls;
    let flags = u32::from(!is_whole)
        + 2 * u32::from(body_list.turns)
        + 4 * u32::from(window.colour != BodyColour::Kind)
        + 8 * u32::from(has_moved);
    let mut bytes = Vec::with_capacity(HEAD + 4 * (5 * xs.len() + 5 * kicks.len()));
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(body_list.version.to_le_bytes());
    for number in [view.time().to_f64(), centre.x, centre.y] {
        bytes.extend(number.to_le_bytes());
    }
    for number in [number, xs.len() as u32, flags, kicks.len() as u32] {
        bytes.extend(number.to_le_bytes());
    }
    append(&mut bytes, &indices, u32::to_le_bytes);
    for numbers in [xs, ys, angles, values] {
        append(&mut bytes, &numbers, f32::to_le_bytes);
    }
    for Kick {
        age,
        place,
        impulse,
    } in kicks
    {
        let row = [*age, place.x, place.y, impulse.x, impulse.y];
        bytes.extend(row.iter().flat_map(|number| (*number as f32).to_le_bytes()));
    }
    if has_moved {
        let ends = walls.into_iter().flatten();
        let ends = ends.flat_map(|end| (end - centre).to_array());
        bytes.extend(ends.flat_map(|number| (number as f32).to_le_bytes()));
    }
    bytes
}

/// The middle of a window (length), in the box: where the followed body is, if there is one.
fn middle(view: &View<'_>, window: &VisibleWindow) -> DVec2 {
    let followed = window
        .follow
        .and_then(|id| view.body(carom::BodyKey::of_id(id)));
    let centre = followed.map_or(DVec2::from(window.centre), |body| body.motion.position);
    view.bounds().wrap(centre).0
}

/// The bodies that a window shows, in the order of the list.
struct ShownBodies {
    /// Whether the window shows the whole box, so that no body is left out.
    is_whole: bool,
    /// Indices in the list; none if no body is left out.
    indices: Vec<u32>,
    /// Places relative to the middle of the window (length).
    xs: Vec<f32>,
    ys: Vec<f32>,
    /// Orientations (radians); none if no shape has one.
    angles: Vec<f32>,
    /// What the colours show; none if they show the kind.
    values: Vec<f32>,
}

impl ShownBodies {
    /// The bodies in a window with its middle at `centre`, which is in the box.
    fn new(view: &View<'_>, body_list: &BodyList, window: &VisibleWindow, centre: DVec2) -> Self {
        let sides = view.bounds().sides();
        // Bodies whose nearest image is outside may reach in with another one.
        let shows_all = DVec2::from(window.half) + body_list.reach;
        let is_whole = shows_all.cmpge(0.5 * sides).all();
        let orders = if window.colour == BodyColour::Order {
            local_orders(view)
        } else {
            Vec::new()
        };
        let expected = if is_whole { view.len() } else { 0 };
        let mut indices = Vec::new();
        let [mut xs, mut ys] = [(); 2].map(|()| Vec::with_capacity(expected));
        let (mut angles, mut values) = (Vec::new(), Vec::new());
        for (index, body) in view
            .bodies()
            .filter(|body| !body.body.is_wall())
            .enumerate()
        {
            let away = body.motion.position - centre;
            // Both places are in the box.
            let nearest = DVec2::new(nearest(away.x, sides.x), nearest(away.y, sides.y));
            if !is_whole {
                // A window wider than the box along one axis shows all of that axis.
                let is_out = nearest.abs().cmpgt(shows_all) & shows_all.cmplt(0.5 * sides);
                if is_out.any() {
                    continue;
                }
                indices.push(index as u32);
            }
            xs.push(nearest.x as f32);
            ys.push(nearest.y as f32);
            if body_list.turns {
                let turns = body.motion.orientation.turns().fract();
                angles.push((turns * std::f64::consts::TAU) as f32);
            }
            match window.colour {
                BodyColour::Kind => {}
                BodyColour::Speed => values.push(body.motion.velocity.length() as f32),
                BodyColour::Energy => values.push(body.energy() as f32),
                BodyColour::Order => values.push(orders[index] as f32),
            }
        }
        Self {
            is_whole,
            indices,
            xs,
            ys,
            angles,
            values,
        }
    }
}

/// The shortest of a displacement within the box and its images along one axis (length).
fn nearest(away: f64, side: f64) -> f64 {
    if away > 0.5 * side {
        away - side
    } else if away < -0.5 * side {
        away + side
    } else {
        away
    }
}

/// Appends words; the compiler turns this loop into a copy.
fn append<T: Copy>(bytes: &mut Vec<u8>, words: &[T], encoded: impl Fn(T) -> [u8; 4]) {
    let begin = bytes.len();
    bytes.resize(begin + 4 * words.len(), 0);
    for (place, &word) in bytes[begin..].as_chunks_mut::<4>().0.iter_mut().zip(words) {
        *place = encoded(word);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Scene, Simulation};

    fn word(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    fn float(bytes: &[u8], at: usize) -> f32 {
        f32::from_bits(word(bytes, at))
    }

    fn window(centre: [f64; 2], half: f64, colour: BodyColour) -> VisibleWindow {
        VisibleWindow {
            centre,
            half: [half; 2],
            colour,
            follow: None,
        }
    }

    #[test]
    fn a_frame_has_the_walls_where_they_are_once_one_has_moved() {
        let scene = Scene::from_toml(
            "[[wall]]\nx = 0.0\n[[piston]]\nx = 0.5\nmass = 1.0\nvelocity = 0.25\n\
             stops = [0.25, 0.75]\n",
        )
        .unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let list = BodyList::new(1, "piston", None, &simulation.view());
        // It has turned back at its stop.
        simulation.run_until(1.5).unwrap();
        let label = FrameLabel {
            number: 1,
            body_list: &list,
        };
        let around = window([0.5, 0.5], 0.5, BodyColour::Kind);
        let bytes = encode(&simulation.view(), label, &around, &[]);
        assert_eq!((word(&bytes, 40), bytes.len()), (8, HEAD + 32));
        let ends: Vec<f32> = (0..8)
            .map(|place| float(&bytes, HEAD + 4 * place))
            .collect();
        assert_eq!([ends[0], ends[2]], [-0.5; 2], "{ends:?}");
        assert_eq!([ends[4], ends[6]], [0.125; 2], "{ends:?}");
    }

    #[test]
    fn a_frame_has_the_bodies_of_the_window_at_their_nearest_images() {
        let scene = Scene::from_toml(
            "[[wall]]\nx = 0.4\n[[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 2.0\nat = [0.98, 0.5]\n\
             velocity = [3.0, 4.0]\n[[molecule]]\nshape = \"disc\"\natom_radius = 0.01\natom_mass = 2.0\nat = [0.5, 0.5]\n",
        )
        .unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let view = simulation.view();
        let body_list = BodyList::new(5, "two", None, &view);
        assert_eq!(
            (
                word(&body_list.bytes, 4),
                word(&body_list.bytes, 12),
                body_list.turns
            ),
            (5, 2, false)
        );
        let label = FrameLabel {
            number: 9,
            body_list: &body_list,
        };
        // Around the corner of the box, with one of the two discs.
        let bytes = encode(
            &view,
            label,
            &window([0.0, 0.5], 0.1, BodyColour::Speed),
            &[],
        );
        assert_eq!(
            [4, 32, 36, 40, 44].map(|at| word(&bytes, at)),
            [5, 9, 1, 5, 0]
        );
        assert_eq!(word(&bytes, HEAD), 0, "the index of the first disc");
        assert!((float(&bytes, HEAD + 4) + 0.02).abs() < 1e-7);
        assert!(float(&bytes, HEAD + 8).abs() < 1e-7);
        assert_eq!((float(&bytes, HEAD + 12), bytes.len()), (5.0, HEAD + 16));
        // The whole box, by energy; the second disc is at rest.
        let bytes = encode(
            &view,
            label,
            &window([0.5, 0.5], 0.5, BodyColour::Energy),
            &[],
        );
        assert_eq!([36, 40].map(|at| word(&bytes, at)), [2, 4]);
        assert_eq!([16, 20].map(|at| float(&bytes, HEAD + at)), [25.0, 0.0]);
        // In the middle of the second disc.
        let followed = VisibleWindow {
            follow: Some(1),
            ..window([0.0, 0.0], 1e-9, BodyColour::Kind)
        };
        let kick = Kick {
            age: 1.0,
            place: DVec2::new(2.0, 3.0),
            impulse: DVec2::new(4.0, 5.0),
        };
        let bytes = encode(&view, label, &followed, &[kick]);
        assert_eq!([36, 44].map(|at| word(&bytes, at)), [1, 1]);
        assert_eq!(bytes[16..24], 0.5_f64.to_le_bytes());
        assert_eq!(
            [12, 16, 28].map(|at| float(&bytes, HEAD + at)),
            [1.0, 2.0, 5.0]
        );
    }
}
