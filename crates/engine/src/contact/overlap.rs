//! The overlap check: all near pairs of a view, computed independently of the scheduler's lists.

use glam::DVec2;

use crate::world::{
    body::Body,
    near_pairs::each_near_pair,
    pair_table::{PairTable, gap_with_factor},
    rounding_bound::rounding_bound,
    tethers::BondView,
    view::{BodyView, View},
    wall::StandingWall,
};

/// The overlapping pairs at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct OverlapCensus {
    /// Number of pairs that overlap, and of bonds that are beyond their bounds, by more than the
    /// rounding bound.
    pub pairs: usize,
    /// The deepest overlap of any pair, in units of the smaller diameter of the two bodies: that
    /// of the smallest atom, or 4 A/P for a body of area A and perimeter P that has edges; 0 if no
    /// bodies overlap. It may be due to rounding.
    pub deepest: f64,
    /// The deepest overlap of any pair, or the largest excess of a bond (length).
    pub deepest_length: f64,
}

impl View<'_> {
    /// Pairs of bodies that overlap by more than rounding.
    pub fn overlaps(&self) -> OverlapCensus {
        census(self)
    }
}

/// Counts the overlapping pairs of a view.
fn census(view: &View<'_>) -> OverlapCensus {
    let sides = view.bounds().sides();
    let mut bodies: Vec<BodyView<'_>> = view.bodies().collect();
    let pairs = &view.world.pairs;
    let mut census = OverlapCensus::default();
    each_near_pair(view.world, view.offset, &mut bodies, |_, [a, b], shift| {
        look(a, b, pairs, shift, sides, &mut census);
    });
    for wall in bodies.iter().filter(|body| body.body.is_wall()) {
        let may_touch = |body: &Body| body.is_free() || (wall.body.is_piston() && !body.is_wall());
        for body in bodies.iter().filter(|body| may_touch(body.body)) {
            look_at_images(body, wall, pairs, sides, &mut census);
        }
    }
    for BondView { bond, length, .. } in view.bonds() {
        let excess = bond.excess(length);
        census.deepest_length = census.deepest_length.max(excess);
        if excess > rounding_bound(sides, bond.tether.reach()) {
            census.pairs += 1;
        }
    }
    census
}

/// Checks a body against each image of a wall that comes near its bounding circle.
fn look_at_images(
    body: &BodyView<'_>,
    wall: &BodyView<'_>,
    pairs: &PairTable,
    sides: DVec2,
    census: &mut OverlapCensus,
) {
    let Some(standing) = StandingWall::new(wall.body, &wall.motion) else {
        return;
    };
    let reach = body.body.reach() + wall.body.reach();
    let [first, last] = standing
        .extent()
        .map(|corner| body.motion.position - corner);
    let (low, high) = (
        ((last - reach) / sides).ceil(),
        ((first + reach) / sides).floor(),
    );
    for row in low.y as i64..=high.y as i64 {
        for column in low.x as i64..=high.x as i64 {
            look(
                body,
                wall,
                pairs,
                DVec2::new(column as f64, row as f64) * sides,
                sides,
                census,
            );
        }
    }
}

fn look(
    a: &BodyView<'_>,
    b: &BodyView<'_>,
    pairs: &PairTable,
    shift: DVec2,
    sides: DVec2,
    census: &mut OverlapCensus,
) {
    if a.body.is_fixed() && b.body.is_fixed() {
        return;
    }
    let factor = pairs.factor(a.body, b.body);
    let separation = (b.motion.position - a.motion.position) + shift;
    let bounding =
        factor * (a.body.molecule().bounding_radius() + b.body.molecule().bounding_radius());
    if factor == 0.0 || separation.length_squared() > bounding * bounding {
        return;
    }
    let reach = a.body.reach() + b.body.reach();
    let rotation = |body: &BodyView<'_>| body.motion.orientation.cos_sin();
    let gap = gap_with_factor(
        factor,
        [a.body.molecule(), b.body.molecule()],
        [rotation(a), rotation(b)],
        separation,
    );
    if gap >= 0.0 {
        return;
    }
    census.deepest_length = census.deepest_length.max(-gap);
    let diameter = [a, b].map(|body| diameter(body.body));
    census.deepest = census.deepest.max(-gap / diameter[0].min(diameter[1]));
    if -gap > rounding_bound(sides, reach) {
        census.pairs += 1;
    }
}

/// The length to which an overlap is compared: the diameter of the smallest atom, or the width of
/// an ellipse; for a body with edges, whose corners may be sharp, the hydraulic diameter 4 A/P;
/// infinite for a wall, which has no diameter of its own.
fn diameter(body: &Body) -> f64 {
    let molecule = body.molecule();
    if body.is_wall() {
        return f64::INFINITY;
    }
    if !molecule.edges().is_empty() {
        return 2.0 * molecule.mean_half_width();
    }
    2.0 * body.smallest_atom()
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use crate::{run::simulation::Simulation, scene::Scene};

    /// The wall lies from 0.05 to 0.45, beyond the border of the box as seen from its pivot.
    #[test]
    fn an_overlap_with_a_wall_far_from_its_pivot_is_found() {
        let scene = Scene::from_toml(
            "[[wall]]\nfrom = [0.05, 0.5]\nto = [0.45, 0.5]\nmotion = { turn = 1.0, about = [0.95, 0.5] }\n\
             [[molecule]]\natoms = [{ at = [0, 0], radius = 0.02, mass = 1.0 }]\nat = [0.4, 0.9]",
        )
        .unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        assert_eq!(simulation.view().overlaps().pairs, 0);
        let disc = (simulation.world.bodies.iter())
            .position(|body| !body.is_fixed())
            .unwrap();
        simulation.world.motions[disc].position = DVec2::new(0.4, 0.51);
        let overlaps = simulation.view().overlaps();
        assert_eq!(overlaps.pairs, 1);
        assert!(
            (overlaps.deepest_length - 0.01).abs() < 1e-12,
            "{overlaps:?}"
        );
    }

    #[test]
    fn a_body_within_a_solid_square_overlaps_it() {
        for (shape, half_width) in [
            ("shape = \"ellipse:2\"\nsize = 0.04\nmass = 1.0", 0.01),
            (
                "shape = \"disc\"\natom_radius = 0.01\natom_mass = 1.0",
                0.01,
            ),
        ] {
            let square = "shape = \"square\"\nsize = 0.4\nmass = 1.0\nat = [0.5, 0.5]";
            let body = format!("{shape}\nat = [0.1, 0.1]");
            let body = body.as_str();
            for entries in [[square, body], [body, square]] {
                let text = entries.map(|entry| format!("[[molecule]]\n{entry}\n"));
                let scene = Scene::from_toml(&text.concat()).unwrap();
                let mut simulation = Simulation::new(&scene).unwrap();
                assert_eq!(simulation.view().overlaps().pairs, 0);
                let inner = (simulation.world.bodies.iter())
                    .position(|body| body.molecule().edges().is_empty())
                    .unwrap();
                simulation.world.motions[inner].position = DVec2::new(0.5, 0.52);
                let overlaps = simulation.view().overlaps();
                assert_eq!(overlaps.pairs, 1, "{text:?}");
                // The corners have a radius of 10⁻⁶ sizes.
                let depth = 0.18 + 4e-7 + half_width;
                assert!(
                    (overlaps.deepest_length - depth).abs() < 1e-12,
                    "{overlaps:?}"
                );
            }
        }
    }
}
