//! Filter for contacts of the molecule with the gas: contacts with the fixed bumper are excluded.

use carom::{CollisionReport, Observer, View, engine::Body};
use serde::{Deserialize, Serialize};

/// Forwards collisions between moving bodies only.
///
/// The bumper is smaller than a gas disc and reaches corners of the molecule that the gas cannot
/// reach; predictions apply to the gas.
#[derive(Debug, Serialize, Deserialize)]
pub struct FromGas<O>(pub O);

impl<O: Observer> Observer for FromGas<O> {
    #[inline]
    fn watches_any(&self) -> bool {
        self.0.watches_any()
    }

    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.0.watches(bodies) && bodies.iter().all(|body| !body.is_fixed())
    }

    fn start(&mut self, view: &View<'_>) {
        self.0.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.0.pause(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if report.sides.iter().all(|side| !side.body.is_fixed()) {
            self.0.collision(report);
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        self.0.sample(view);
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

    #[test]
    fn contacts_with_fixed_bodies_are_excluded() {
        let scene = Scene::from_toml(
            "[[bumper]]\nradius = 0.2\nat = [0.5, 0.5]\n\
             [[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 30\n",
        )
        .unwrap();
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let (mut kicks, mut all) = (FromGas(Count::default()), Count::default());
        simulation.observe_until(2.0, &mut (&mut kicks, &mut all)).unwrap();
        let fixed = simulation.view().counters().fixed_collisions;
        assert!(fixed > 0);
        assert_eq!(kicks.0.0, all.0 - fixed);
        // It requests reports only if the inner observer does.
        let view = simulation.view();
        let bodies: Vec<_> = view.bodies().map(|body| body.body).collect();
        let disc = |fixed: bool| bodies.iter().filter(move |body| body.is_fixed() == fixed);
        let (mut moving, bumper) = (disc(false), disc(true).next().unwrap());
        let [one, other] = [moving.next().unwrap(), moving.next().unwrap()];
        assert!(FromGas(&mut all).watches([one, other]) && !FromGas(()).watches([one, other]));
        assert!(!FromGas(&mut all).watches([one, bumper]));
    }
}
