//! Vectors in the plane as plain pairs of numbers.

/// Two numbers: a position, a velocity, or a cosine and sine.
pub type BodyPair = [f64; 2];

/// Unit roundoff: half the distance from 1 to the next float.
pub const U: f64 = 0.5 * f64::EPSILON;

/// Scalar product.
pub fn dot(a: BodyPair, b: BodyPair) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// a_x b_y − a_y b_x.
pub fn cross(a: BodyPair, b: BodyPair) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// a + f b.
pub fn along(a: BodyPair, factor: f64, b: BodyPair) -> BodyPair {
    [a[0] + factor * b[0], a[1] + factor * b[1]]
}

/// Magnitude of a vector.
pub fn length(a: BodyPair) -> f64 {
    a[0].hypot(a[1])
}

/// Vector rotated by the angle with the given cosine and sine.
pub fn rotated([x, y]: BodyPair, [cos, sin]: BodyPair) -> BodyPair {
    [x * cos - y * sin, x * sin + y * cos]
}
