//! placeholder
use glam::DVec2;
use crate::{Atom, Edge, Interior, interior};
pub(crate) use crate::covered_area::covered_area;
pub(crate) struct Union { circles: Vec<(DVec2, f64)>, bars: Vec<([u32;2], f64)>, rings: Vec<Vec<u32>> }
pub(crate) struct Properties { pub area: f64, pub centroid: DVec2, pub second_moment: f64 }
impl Union {
    pub fn of(atoms: &[Atom], edges: &[Edge], interior: Interior) -> Self {
        Self { circles: atoms.iter().map(|a| (a.offset(), a.radius())).collect(),
            bars: edges.iter().filter_map(|e| Some((e.ends()?, e.radius()))).collect(),
            rings: interior::solid_rings(atoms, edges, interior) }
    }
    pub fn properties(&self) -> Properties {
        let low = self.circles.iter().fold(DVec2::INFINITY, |l, c| l.min(c.0 - c.1));
        let high = self.circles.iter().fold(DVec2::NEG_INFINITY, |l, c| l.max(c.0 + c.1));
        let n = 200;
        let step = (high - low) / n as f64;
        let (mut area, mut first, mut second) = (0.0, DVec2::ZERO, 0.0);
        for i in 0..n { for j in 0..n {
            let p = low + step * DVec2::new(i as f64 + 0.5, j as f64 + 0.5);
            let inside = self.circles.iter().any(|c| c.0.distance(p) < c.1)
              || self.bars.iter().any(|&([a,b], r)| { let (a,b) = (self.circles[a as usize].0, self.circles[b as usize].0);
                 let t = ((p-a).dot(b-a)/(b-a).length_squared()).clamp(0.0,1.0); (a + t*(b-a)).distance(p) < r })
              || self.rings.iter().any(|ring| interior::encloses((0..ring.len()).map(|k| [self.circles[ring[k] as usize].0, self.circles[ring[(k+1)%ring.len()] as usize].0]), p));
            if inside { let d = step.x*step.y; area += d; first += d*p; second += d*p.length_squared(); }
        } }
        Properties { area, centroid: first/area, second_moment: second }
    }
}
