//! Convex parts by their support function, and the gap between two of them.
//!
//! The support function h(n) of a convex part is the distance of its tangent with the outward
//! normal n from its centre. With the angle φ of n, the part touches that tangent at the point
//! h n + h' n^⊥, where its radius of curvature is R = h + h'' (Santaló, Integral Geometry and
//! Geometric Probability (1976), chapter 1).
//!
//! # Lemmas
//! d leads from the centre of part A to that of part B, and f(n) = n·d − h_A(n) − h_B(−n).
//!
//! 1. **Any direction is a certificate.** f(n) ≤ g, the gap between the parts, for every n.
//!    *Proof.* Both parts lie on their sides of two lines across n that are f(n) apart.
//! 2. **Maximum.** If the parts are apart, g is the maximum of f, and f has no other local maximum
//!    at which it is positive. *Proof.* y·d − h_A(y) − h_B(−y), with h extended to vectors y in
//!    proportion to their length, is concave. Where it is positive its maximum over |y| ≤ 1 is on
//!    the circle, and unique.
//! 3. **Newton's method.** f_φ = n^⊥·d − h_A' − h_B' and −f_φφ = f + R_A + R_B = F. Near the
//!    maximum g exceeds f(n) by f_φ²/2F.

use glam::DVec2;

/// A convex part of a body by its support function, in the frame of its body and about the centre
/// of the part.
///
/// The support function must have a third derivative between any two directions, with these bounds.
/// This excludes corners and straight sides, which edges with rounded ends describe, and flat
/// points, as those of superellipses with exponents above 2, whose curvature vanishes there.
///
/// ```
/// use carom_geometry::{Support, SupportPoint};
/// use glam::DVec2;
///
/// /// A disc of radius 2 about a point beside its centre.
/// struct Cam;
///
/// impl Support for Cam {
///     fn at(&self, normal: DVec2) -> SupportPoint {
///         SupportPoint { distance: 2.0 + normal.x, slope: -normal.y, curvature_radius: 2.0 }
///     }
///     fn reach(&self) -> f64 { 3.0 }
///     fn max_bend(&self) -> f64 { 1.0 }
///     fn max_third(&self) -> f64 { 1.0 }
/// }
/// assert_eq!(Cam.at(DVec2::X).distance, 3.0);
/// ```
pub trait Support {
    /// The support function and its derivatives for the unit vector `normal`.
    fn at(&self, normal: DVec2) -> SupportPoint;

    /// The largest distance of a point of the part from its centre (length).
    fn reach(&self) -> f64;

    /// An upper bound on h'' (length, at least 0).
    fn max_bend(&self) -> f64;

    /// An upper bound on |h'''| (length).
    fn max_third(&self) -> f64;

    /// The entries xx, xy and yy of a matrix M with h² near to n·M n (length²), for the part turned
    /// by `rotation`, (cos θ, sin θ): the search for the direction in which two parts are nearest
    /// starts from these. Default: that of the circle of [`Self::reach`].
    fn matrix(&self, _rotation: DVec2) -> [f64; 3] {
        let squared = self.reach() * self.reach();
        [squared, 0.0, squared]
    }

    /// A direction for each share from 0 to 1 of the boundary, so that a few of equal distance come
    /// near to every normal with its weight in the boundary. Default: equal angles.
    fn normal_at(&self, share: f64) -> DVec2 {
        DVec2::from_angle(std::f64::consts::TAU * share)
    }
}

/// A support function and its derivatives for one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SupportPoint {
    /// h (length).
    pub distance: f64,
    /// h' (length per radian).
    pub slope: f64,
    /// R = h + h'', the radius of curvature of the boundary (length).
    pub curvature_radius: f64,
}

impl SupportPoint {
    /// h'' (length).
    pub fn bend(&self) -> f64 {
        self.curvature_radius - self.distance
    }

    /// The point of the boundary with this outward normal, relative to the centre of the part
    /// (length).
    pub fn place(&self, normal: DVec2) -> DVec2 {
        self.distance * normal + self.slope * normal.perp()
    }
}

/// Two convex parts at rest: with the directions (cos θ, sin θ) of their bodies, and d.
#[derive(Debug, Clone, Copy)]
pub struct FacingParts<'a, A, B> {
    /// The part A.
    pub a: &'a A,
    /// The part B.
    pub b: &'a B,
    /// (cos θ, sin θ) of the two bodies.
    pub rotations: [DVec2; 2],
    /// From the centre of A to the centre of B (length).
    pub d: DVec2,
}

/// Two tangents across one direction, of A and of B, that face each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacingTangents {
    /// n, from A to B.
    pub normal: DVec2,
    /// f, their distance (length); negative where the parts overlap in this direction.
    pub gap: f64,
    /// f_φ (length per radian).
    pub slope: f64,
    /// The points of A and B on them.
    pub points: [SupportPoint; 2],
}

/// Most rounds of Newton's method for one direction.
const MAX_ROUNDS: u32 = 64;

/// Most halvings of one round.
const MAX_HALVINGS: u32 = 40;

/// The largest turn of one round (radians).
const MAX_TURN: f64 = 0.5;

/// Directions of each part that are tried where the parts overlap.
const SCANNED: u32 = 32;

/// How far below the gap a direction may be, as a share of the error of the gap.
const SHARE: f64 = 1.0 / 64.0;

/// How far below the gap a direction may be where the parts are far apart, as a share of the gap.
/// Smaller: more steps of Newton's method. Larger: the bound on the rate of the gap is wider, and
/// the steps of a search are shorter.
const SHARE_OF_GAP: f64 = 1e-2;

/// Parts whose gap is at most this many errors of it touch.
const TOUCHING: f64 = 64.0;

/// Most steps of Newton's method in which the gap no longer grows beyond rounding.
const MAX_POLISHINGS: u32 = 4;

/// A unit vector turned counter-clockwise by the angle with this tangent.
///
/// ```
/// use carom_geometry::turned;
/// use glam::DVec2;
///
/// let diagonal = turned(DVec2::X, 1.0);
/// assert!((diagonal - DVec2::splat(0.5f64.sqrt())).length() < 1e-15);
/// ```
#[inline]
pub fn turned(unit: DVec2, tangent: f64) -> DVec2 {
    let vector = unit + tangent * unit.perp();
    let squared = tangent * tangent;
    if squared < 1e-4 {
        // The series of 1/√(1 + t²), of which the next term is below 10⁻¹⁶.
        return vector * (1.0 - squared * (0.5 - squared * (0.375 - squared * 0.3125)));
    }
    vector * (1.0 / (vector.x * vector.x + vector.y * vector.y).sqrt())
}

impl FacingTangents {
    /// F = −f_φφ (length).
    #[inline]
    pub fn stiffness(&self) -> f64 {
        self.gap + (self.points[0].curvature_radius + self.points[1].curvature_radius)
    }
}

impl<A: Support, B: Support> FacingParts<'_, A, B> {
    /// The tangents across a unit vector.
    #[inline]
    pub fn across(&self, normal: DVec2) -> FacingTangents {
        let back = |rotation: DVec2| DVec2::new(rotation.x, -rotation.y);
        let [to_a, to_b] = self.rotations.map(back);
        let points = [
            self.a.at(to_a.rotate(normal)),
            self.b.at(to_b.rotate(-normal)),
        ];
        FacingTangents {
            normal,
            gap: normal.dot(self.d) - (points[0].distance + points[1].distance),
            slope: normal.perp().dot(self.d) - (points[0].slope + points[1].slope),
            points,
        }
    }

    /// A direction near to that in which the parts are nearest, from which to search it: for two
    /// ellipses with the matrices M of h² = n·M n, that of (M_A + M_B)⁻¹ d. It is the best one of
    /// parallel ellipses of one shape.
    #[inline]
    pub fn towards(&self) -> DVec2 {
        let (a, b) = (
            self.a.matrix(self.rotations[0]),
            self.b.matrix(self.rotations[1]),
        );
        let [xx, xy, yy] = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let DVec2 { x, y } = self.d;
        let direction = DVec2::new(yy * x - xy * y, xx * y - xy * x);
        let inverse = 1.0 / (direction.x * direction.x + direction.y * direction.y).sqrt();
        if inverse.is_finite() && inverse > 0.0 {
            direction * inverse
        } else {
            DVec2::X
        }
    }

    /// The tangents whose distance is the gap between the parts, less a small share of `error`
    /// (length). If the parts overlap, the tangents of the direction in which they overlap least.
    pub fn farthest(&self, error: f64) -> FacingTangents {
        self.polished(self.farthest_beyond(self.towards(), error, f64::INFINITY))
    }

    /// Tangents whose distance is near to the gap between the parts, from a direction near to
    /// theirs. Where the parts are at most `far` (length) apart it is less than the gap by a small
    /// share of `error` (length), else by up to a hundredth of the gap, which takes fewer steps. If
    /// the parts overlap, the tangents of the direction in which they overlap least.
    pub fn farthest_beyond(&self, start: DVec2, error: f64, far: f64) -> FacingTangents {
        let found = self.climb(self.across(start), error, far);
        if found.gap >= -error {
            return found;
        }
        let of_a = |share| self.rotations[0].rotate(self.a.normal_at(share));
        let of_b = |share| -self.rotations[1].rotate(self.b.normal_at(share));
        let mut best = found;
        for step in 0..SCANNED {
            let share = f64::from(step) / f64::from(SCANNED);
            for normal in [of_a(share), of_b(share)] {
                let here = self.across(normal);
                if here.gap > best.gap {
                    best = here;
                }
            }
        }
        self.climb(best, error, far)
    }

    /// The nearest local maximum of f, by Newton's method with steps that are halved where f falls.
    fn climb(&self, start: FacingTangents, error: f64, far: f64) -> FacingTangents {
        let mut here = start;
        for _ in 0..MAX_ROUNDS {
            let stiffness = here.stiffness();
            let mut loss = SHARE * error;
            if here.gap > far {
                loss += SHARE_OF_GAP * here.gap;
            }
            let is_near = here.slope * here.slope <= 2.0 * loss * stiffness;
            if is_near || here.slope.is_nan() {
                break;
            }
            let turn = if stiffness > 0.0 {
                (here.slope / stiffness).clamp(-MAX_TURN, MAX_TURN)
            } else {
                MAX_TURN.copysign(here.slope)
            };
            let Some(higher) = self.higher(&here, turn) else {
                break;
            };
            here = higher;
        }
        if here.gap.abs() <= TOUCHING * error {
            self.polished(here)
        } else {
            here
        }
    }

    /// The direction in which f_φ is 0 to rounding. The rate of the gap, which decides whether
    /// parts that touch close, and the point of contact are then those of the best direction.
    fn polished(&self, mut here: FacingTangents) -> FacingTangents {
        for _ in 0..MAX_POLISHINGS {
            let turn = here.slope / here.stiffness();
            if turn.abs() > MAX_TURN || turn.is_nan() {
                break;
            }
            let next = self.across(turned(here.normal, turn));
            if next.slope.abs() >= here.slope.abs() {
                break;
            }
            here = next;
        }
        here
    }

    fn higher(&self, here: &FacingTangents, mut turn: f64) -> Option<FacingTangents> {
        for _ in 0..MAX_HALVINGS {
            let next = self.across(turned(here.normal, turn));
            if next.gap > here.gap {
                return Some(next);
            }
            turn *= 0.5;
        }
        None
    }
}
