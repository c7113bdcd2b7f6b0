//! Bodies for the tests.

use std::f64::consts::TAU;

use proptest::prelude::*;

use super::*;

impl Union {
    /// Whether the body contains a point, from the distances to its parts.
    pub fn holds(&self, point: DVec2) -> bool {
        let in_circle = |&(centre, radius): &(DVec2, f64)| centre.distance(point) < radius;
        let in_bar = |bar: &Bar| {
            let [a, b] = bar.ends.map(|end| self.circles[end as usize].0);
            let along = (point - a).dot(b - a) / (b - a).length_squared();
            a.lerp(b, along.clamp(0.0, 1.0)).distance(point) < bar.radius
        };
        self.circles.iter().any(in_circle) || self.bars.iter().any(in_bar) || self.fills(point)
    }

    /// The body rotated by an angle (radians) about the origin and then moved.
    pub fn placed(&self, angle: f64, shift: DVec2) -> Self {
        let turn = DVec2::from_angle(angle);
        let circle = |&(centre, radius): &(DVec2, f64)| (turn.rotate(centre) + shift, radius);
        Self {
            circles: self.circles.iter().map(circle).collect(),
            ..self.clone()
        }
    }

    /// Distance of the farthest point from the origin (length).
    pub fn reach(&self) -> f64 {
        self.circles
            .iter()
            .map(|(centre, radius)| centre.length() + radius)
            .fold(0.0, f64::max)
    }
}

/// A chain of bars and discs of one radius through these points.
pub(crate) fn chain(points: &[(f64, f64)], radius: f64) -> Union {
    let bar = |index: u32| Bar {
        ends: [index, index + 1],
        radius,
    };
    Union {
        circles: points
            .iter()
            .map(|&(x, y)| (DVec2::new(x, y), radius))
            .collect(),
        bars: (0..points.len() as u32 - 1).map(bar).collect(),
        rings: Vec::new(),
    }
}

/// A closed chain that is hollow.
pub(crate) fn hollow(points: &[(f64, f64)], radius: f64) -> Union {
    let mut ring = chain(points, radius);
    ring.bars.push(Bar {
        ends: [points.len() as u32 - 1, 0],
        radius,
    });
    ring
}

/// A filled polygon with rounded corners, counter-clockwise.
pub(crate) fn solid(points: &[(f64, f64)], radius: f64) -> Union {
    Union {
        rings: vec![(0..points.len() as u32).collect()],
        ..hollow(points, radius)
    }
}

/// The corners of a star of `tips` tips, whose notches lie at the distance `notch`; a regular
/// polygon of twice as many corners if that is 1.
pub(crate) fn star(tips: usize, notch: f64) -> Vec<(f64, f64)> {
    let corner = |index: usize| {
        let radius = if index.is_multiple_of(2) { 1.0 } else { notch };
        let (sin, cos) = (TAU * index as f64 / (2 * tips) as f64).sin_cos();
        (radius * cos, radius * sin)
    };
    (0..2 * tips).map(corner).collect()
}

/// The corners of a regular polygon on the unit circle.
pub(crate) fn regular(corners: usize) -> Vec<(f64, f64)> {
    let corner = |index: usize| {
        let (sin, cos) = (TAU * index as f64 / corners as f64).sin_cos();
        (cos, sin)
    };
    (0..corners).map(corner).collect()
}

/// A square of side 1 about the origin.
pub(crate) const SQUARE: [(f64, f64); 4] = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];

/// A filled L of area 3 with a notch at (1, 1).
pub(crate) fn ell(radius: f64) -> Union {
    let corners = [
        (0.0, 0.0),
        (2.0, 0.0),
        (2.0, 1.0),
        (1.0, 1.0),
        (1.0, 2.0),
        (0.0, 2.0),
    ];
    solid(&corners, radius)
}

/// Two crossing bars of length 2 that share no disc.
pub(crate) fn plus(radius: f64) -> Union {
    let bar = |ends| Bar { ends, radius };
    Union {
        bars: vec![bar([0, 1]), bar([2, 3])],
        ..chain(&[(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)], radius)
    }
}

/// Two discs of radius 1 at distance 4, joined by a thinner bar.
pub(crate) fn dumbbell(radius: f64) -> Union {
    let mut dumbbell = chain(&[(-2.0, 0.0), (2.0, 0.0)], 1.0);
    dumbbell.bars[0].radius = radius;
    dumbbell
}

/// Discs at random, bars between some of them, and triangles of bars, hollow or filled.
pub(crate) fn unions() -> impl Strategy<Value = Union> {
    let disc = (-2.0..2.0f64, -2.0..2.0f64, 0.1..0.6f64);
    let bar = (0..100u32, 0..100u32, 0.1..=1.0f64);
    let triangles = prop::collection::vec((0..100u32, any::<bool>()), 0..3);
    (
        prop::collection::vec(disc, 3..10),
        prop::collection::vec(bar, 0..6),
        triangles,
    )
        .prop_map(|(discs, bars, triangles)| {
            let mut union = Union::of_discs(
                discs
                    .iter()
                    .map(|&(x, y, radius)| (DVec2::new(x, y), radius))
                    .collect(),
            );
            let count = discs.len() as u32;
            for (first, step, share) in bars {
                join(
                    &mut union,
                    [first % count, (first + 1 + step % (count - 1)) % count],
                    share,
                );
            }
            for (first, is_solid) in triangles {
                let mut corners = [0, 1, 2].map(|step| (first + step) % count);
                let [a, b, c] = corners.map(|corner| union.circles[corner as usize].0);
                if (b - a).perp_dot(c - a) < 0.0 {
                    corners.reverse();
                }
                for index in 0..3 {
                    join(&mut union, [corners[index], corners[(index + 1) % 3]], 0.5);
                }
                if is_solid {
                    union.rings.push(corners.to_vec());
                }
            }
            union
        })
}

/// Polygons around the origin, mostly concave, with atoms of up to twice the radius of the edges at
/// the corners; hollow or filled.
pub(crate) fn polygons() -> impl Strategy<Value = Union> {
    let corner = (0.2..1.0f64, 1.0..=2.0f64);
    (
        prop::collection::vec(corner, 3..40),
        -9.0..-3.0f64,
        any::<bool>(),
    )
        .prop_map(|(corners, exponent, is_solid)| {
            let edge = 10f64.powf(exponent);
            let turn = TAU / corners.len() as f64;
            let at = |(index, &(distance, _)): (usize, &(f64, f64))| {
                let (sin, cos) = (turn * index as f64).sin_cos();
                (distance * cos, distance * sin)
            };
            let points: Vec<_> = corners.iter().enumerate().map(at).collect();
            let mut body = if is_solid {
                solid(&points, edge)
            } else {
                hollow(&points, edge)
            };
            for (circle, (_, share)) in body.circles.iter_mut().zip(corners) {
                circle.1 *= share;
            }
            body
        })
}

/// Discs and bars of two radii on a lattice, so that many lines coincide, touch, or meet three at a
/// point.
pub(crate) fn lattice_unions() -> impl Strategy<Value = Union> {
    let radius = prop::sample::select(vec![0.25, 0.5]);
    let disc = (0..4i32, 0..4i32, radius.clone());
    let bar = (0..100u32, 0..100u32, radius);
    (
        prop::collection::vec(disc, 2..8),
        prop::collection::vec(bar, 1..7),
    )
        .prop_map(|(discs, bars)| {
            let mut circles: Vec<(DVec2, f64)> = Vec::new();
            for (x, y, radius) in discs {
                let centre = DVec2::new(f64::from(x), f64::from(y));
                if circles.iter().all(|(other, _)| *other != centre) {
                    circles.push((centre, radius));
                }
            }
            let count = circles.len() as u32;
            let bar = |(first, step, radius): (u32, u32, f64)| {
                let ends = [
                    first % count,
                    (first + 1 + step % (count - 1).max(1)) % count,
                ];
                let [a, b] = ends.map(|end| circles[end as usize].1);
                Bar {
                    ends,
                    radius: radius.min(a).min(b),
                }
            };
            Union {
                bars: bars.into_iter().map(bar).collect(),
                circles,
                rings: Vec::new(),
            }
        })
}

/// Adds a bar of a share of the smaller radius.
fn join(union: &mut Union, ends: [u32; 2], share: f64) {
    let [a, b] = ends.map(|end| union.circles[end as usize].1);
    union.bars.push(Bar {
        ends,
        radius: share * a.min(b),
    });
}
