//! Filter for contacts of a body with the gas: contacts with fixed bodies are excluded.

use carom::{BodyKey, CollisionReport, Observer, View, engine::Body};
use serde::{Deserialize, Serialize};

/// Forwards the collisions of one body with bodies that move.
///
/// A fixed disc may be smaller than the discs of the gas and reach corners of the body that the gas
/// cannot reach; predictions apply to the gas.
#[derive(Debug, Serialize, Deserialize)]
pub struct FromGas<O> {
    body: BodyKey,
    /// The observer of the collisions.
    pub observer: O,
}

impl<O> FromGas<O> {
    /// Gives `observer` the collisions of this body with bodies that move.
    pub fn new(body: BodyKey, observer: O) -> Self {
        Self { body, observer }
    }

    fn is_from_gas(&self, bodies: [&Body; 2]) -> bool {
        bodies.iter().any(|body| body.key() == self.body)
            && bodies
                .iter()
                .all(|body| body.key() == self.body || body.is_free())
    }
}

impl<O: Observer> Observer for FromGas<O> {
    #[inline]
    fn watches_any(&self) -> bool {
        self.observer.watches_any()
    }

    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.observer.watches(bodies) && self.is_from_gas(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.observer.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.observer.pause(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if self.is_from_gas(report.sides.each_ref().map(|side| side.body)) {
            self.observer.collision(report);
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        self.observer.sample(view);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;
    use carom_methods::AnySimulation;

    #[derive(Default)]
    struct Count(u64);

    impl Observer for Count {
        fn collision(&mut self, _: &CollisionReport<'_>) {
            self.0 += 1;
        }
    }

    /// A disc, a fixed disc and a gas: the collisions of the disc with the fixed one are left out,
    /// and those of the fixed one with the gas are not.
    #[test]
    fn contacts_with_other_fixed_bodies_are_excluded() {
        let scene = Scene::from_toml(
            "[[molecule]]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\nat = [0.1, 0.1]\n\
             [[bumper]]\nradius = 0.3\nat = [0.5, 0.5]\n\
             [[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 30\n",
        )
        .unwrap();
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let bodies: Vec<Body> = simulation
            .view()
            .bodies()
            .map(|body| body.body.clone())
            .collect();
        let of = |is_wanted: fn(&Body) -> bool| bodies.iter().find(|body| is_wanted(body)).unwrap();
        let disc = of(|body| body.molecule().bounding_radius() == 0.1);
        let bumper = of(Body::is_fixed);
        let gas = of(|body| body.molecule().bounding_radius() == 0.02);
        let mut on_disc = FromGas::new(disc.key(), Count::default());
        let mut on_bumper = FromGas::new(bumper.key(), Count::default());
        let mut all = Count::default();
        simulation
            .observe_until(2.0, &mut (&mut on_disc, &mut on_bumper, &mut all))
            .unwrap();
        // A contact of the two is one of the bumper's alone.
        assert_eq!(
            on_bumper.observer.0,
            simulation.view().counters().fixed_collisions
        );
        assert!(on_disc.observer.0 > 0 && on_disc.observer.0 + on_bumper.observer.0 < all.0);
        // It requests reports only if the inner observer does.
        assert!(on_disc.watches([disc, gas]) && !FromGas::new(disc.key(), ()).watches([disc, gas]));
        assert!(!on_disc.watches([disc, bumper]) && on_bumper.watches([disc, bumper]));
        assert!(!on_disc.watches([gas, gas]));
    }
}
