//! The region that an ellipse excludes, by arcs of circles.
//!
//! Its boundary is the curve parallel to the ellipse at the radius r of the probe. A piece between
//! two directions of the normal is replaced by an arc with the same normals at its ends, the same
//! length, and the same point in its middle. Lengths, and with them the shares of directions, are
//! therefore those of the ellipse; places are off by about 10⁻⁵ of its size or less.

use std::f64::consts::TAU;

use glam::DVec2;

use super::ExcludedRegion;
use crate::{Ellipse, Support, exposed_arc::ExposedArc};

/// Number of arcs. Fewer: less accurate places. More: larger pages.
const ARCS: u32 = 720;

impl ExcludedRegion {
    /// The region that an ellipse about the centre of mass excludes for the centre of a round probe
    /// of this radius (length, 0 or more).
    pub(crate) fn of_ellipse(ellipse: &Ellipse, probe_radius: f64) -> Self {
        let arcs = (0..ARCS).map(|step| arc(ellipse, probe_radius, step));
        let inner = ellipse.axes()[1] + probe_radius;
        Self {
            circles: vec![(DVec2::ZERO, inner)],
            edges: 0,
            arcs: arcs.collect(),
            sides: Vec::new(),
            hidden_arcs: Vec::new(),
            hidden_sides: Vec::new(),
        }
    }
}

/// The arc between two steps of the eccentric angle.
fn arc(ellipse: &Ellipse, probe_radius: f64, step: u32) -> ExposedArc {
    let share = |half_steps: u32| f64::from(half_steps) / f64::from(2 * ARCS);
    let turn = libm::atan2(ellipse.along().y, ellipse.along().x);
    let [start, middle, end] = [0, 1, 2].map(|k| angle(ellipse, share(2 * step + k)));
    let [a, b] = ellipse.axes();
    // ds = √(a² sin² t + b² cos² t) dt for the eccentric angle t, by Simpson's rule.
    let speed = |k: u32| {
        let (sin, cos) = libm::sincos(TAU * share(2 * step + k));
        (a * a * sin * sin + b * b * cos * cos).sqrt()
    };
    let width = TAU / f64::from(ARCS);
    let of_ellipse = width / 6.0 * (speed(0) + 4.0 * speed(1) + speed(2));
    let radius = of_ellipse / (end - start) + probe_radius;
    let (sin, cos) = libm::sincos(middle + turn);
    let normal = DVec2::new(cos, sin);
    let point = ellipse.at(normal).place(normal) + probe_radius * normal;
    let start_turned = (start + turn).rem_euclid(TAU);
    ExposedArc {
        atom: 0,
        start: start_turned,
        end: start_turned + (end - start),
        radius,
        centre: point - radius * normal,
    }
}

/// The direction of the normal at a share of the eccentric angle, relative to the longer axis
/// (radians), growing from 0 to 2π.
fn angle(ellipse: &Ellipse, share: f64) -> f64 {
    let [a, b] = ellipse.axes();
    let (sin, cos) = libm::sincos(TAU * share);
    let angle = libm::atan2(a * sin, b * cos);
    if share > 0.5 && share <= 1.0 && angle <= 0.0 {
        angle + TAU
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoundaryPoint, ExcludedRegion, Molecule};
    use std::f64::consts::PI;

    #[test]
    fn the_region_of_an_ellipse_has_the_area_and_perimeter_of_steiner() {
        for ratio in [1.5, 4.0, 20.0] {
            let ellipse = Molecule::ellipse([ratio, 1.0], 1.0).unwrap();
            for radius in [0.0, 0.5] {
                let region = ExcludedRegion::new(&ellipse, radius).unwrap();
                let (area, perimeter) = (ellipse.area(), ellipse.perimeter());
                let expected = perimeter + 2.0 * PI * radius;
                assert!(
                    (region.perimeter() / expected - 1.0).abs() < 1e-9,
                    "{ratio}"
                );
                let expected = area + perimeter * radius + PI * radius * radius;
                assert!(
                    (region.area() / expected - 1.0).abs() < 2e-4,
                    "{ratio}: {}",
                    region.area()
                );
                // The angles of all arcs are a whole turn, and no contact turns the ellipse on
                // average.
                assert!((region.exposed_angle(0) - TAU).abs() < 1e-12);
                assert!(region.integral(BoundaryPoint::lever).abs() < 1e-9 * expected);
                assert!(region.unreachable().is_empty());
                assert!(region.contains(DVec2::new(0.98 * ratio, 0.0)));
                assert!(!region.contains(DVec2::new(0.0, 1.02 + radius)));
            }
        }
    }

    /// The share of the directions about the shorter axis is that of the chord.
    #[test]
    fn shares_of_directions_are_those_of_the_curvature() {
        let ellipse = Molecule::ellipse([3.0, 1.0], 1.0).unwrap();
        let region = ExcludedRegion::new(&ellipse, 0.25).unwrap();
        let sectors = 16;
        let shares = region.direction_shares(sectors);
        let shape = ellipse.ellipses()[0];
        for (sector, share) in shares.iter().enumerate() {
            // ∫ (R + r) dφ over the sector, opposite to the impulse.
            let steps = 2000;
            let length: f64 = (0..steps)
                .map(|step| {
                    let turn = (sector as f64 + (f64::from(step) + 0.5) / f64::from(steps)) / 16.0;
                    let normal = -DVec2::from_angle(TAU * turn);
                    shape.at(normal).curvature_radius + 0.25
                })
                .sum::<f64>()
                * TAU
                / 16.0
                / f64::from(steps);
            let expected = length / region.perimeter();
            assert!(
                (share - expected).abs() < 2e-5,
                "{sector}: {share} {expected}"
            );
        }
    }
}
