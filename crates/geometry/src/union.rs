//! A plane body composed of discs, straight bars between their centres, and filled polygons.

use glam::DVec2;

use crate::interior::encloses;

/// A straight bar: all points between the centres of two discs, within `radius` of the line through
/// them.
///
/// The rectangle ends at the two centres. The discs there have at least its radius, so its two
/// short ends lie inside them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bar {
    /// Indices of the two circles.
    pub ends: [u32; 2],
    /// Half the width (length), at most the radius of either circle.
    pub radius: f64,
}

/// The union of discs, bars and the interiors of closed rings of bars.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Union {
    /// Centres and radii (length).
    pub circles: Vec<(DVec2, f64)>,
    pub bars: Vec<Bar>,
    /// Each ring lists the circles at the corners of a simple polygon that is filled. A bar joins
    /// each circle with the next one, and the last one with the first.
    pub rings: Vec<Vec<u32>>,
}

impl Union {
    /// The union of discs alone, given as centres and radii (length).
    pub fn of_discs(circles: Vec<(DVec2, f64)>) -> Self {
        Self {
            circles,
            ..Self::default()
        }
    }

    /// All points within `distance` (length) of this union: every radius grows by it.
    pub fn inflated(&self, distance: f64) -> Self {
        let circle = |&(centre, radius): &(DVec2, f64)| (centre, radius + distance);
        let bar = |bar: &Bar| Bar {
            radius: bar.radius + distance,
            ..*bar
        };
        Self {
            circles: self.circles.iter().map(circle).collect(),
            bars: self.bars.iter().map(bar).collect(),
            rings: self.rings.clone(),
        }
    }

    /// Whether a filled polygon contains this point.
    pub fn fills(&self, point: DVec2) -> bool {
        self.rings
            .iter()
            .any(|ring| self.is_in_polygon(ring, point))
    }

    fn is_in_polygon(&self, ring: &[u32], point: DVec2) -> bool {
        let corner = |index: usize| self.circles[ring[index % ring.len()] as usize].0;
        encloses(
            (0..ring.len()).map(|index| [corner(index), corner(index + 1)]),
            point,
        )
    }
}

#[cfg(test)]
pub(crate) mod samples;

#[cfg(test)]
mod tests {
    use super::{samples::ell, *};

    #[test]
    fn a_ring_fills_its_polygon_and_not_its_notch() {
        let ell = ell(0.1);
        for (x, y, is_inside) in [
            (0.5, 1.5, true),
            (1.5, 0.5, true),
            (0.5, 1.0, true),
            (1.5, 1.5, false),
            (-0.5, 0.5, false),
            (0.5, 2.5, false),
        ] {
            assert_eq!(ell.fills(DVec2::new(x, y)), is_inside, "{x} {y}");
        }
    }
}
