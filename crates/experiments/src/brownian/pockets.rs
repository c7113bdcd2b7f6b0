//! Pockets of a molecule, such as the hole of a ring: bodies of the gas that were placed there
//! could never leave, and would hit the molecule from within.

use anyhow::Result;
use carom::{BodyKey, Molecule, View, geometry::ExcludedRegion};
use carom_methods::AnySimulation;
use glam::DVec2;

use super::setting::Setting;

/// Removes the bodies of the gas in pockets of the molecule.
///
/// # Errors
/// The radius of a disc is out of range.
pub fn empty(simulation: &mut AnySimulation, setting: &Setting) -> Result<()> {
    let trapped = trapped(&simulation.view(), setting)?;
    if !trapped.is_empty() {
        simulation.edit(|batch| trapped.iter().try_for_each(|&key| batch.remove(key)))?;
    }
    Ok(())
}

/// Bodies with an atom in a pocket, which differs by the radius of the atom.
fn trapped(view: &View<'_>, setting: &Setting) -> Result<Vec<BodyKey>> {
    let Some(molecule) = view.bodies().nth(setting.body) else { return Ok(Vec::new()) };
    let mut regions = Regions { molecule: molecule.body.molecule(), last: None };
    let sides = view.bounds().sides();
    // Turns the frame of the box into that of the molecule.
    let turn = molecule.motion.orientation.cos_sin() * DVec2::new(1.0, -1.0);
    let reach = molecule.body.reach();
    let mut trapped = Vec::new();
    for other in view.bodies() {
        // A scene has its gases after its single bodies, which stay where its author put them.
        if other.body.is_fixed() || (other.body.id() as usize) < setting.scene.molecule.len() {
            continue;
        }
        let rotation = other.motion.orientation.cos_sin();
        for atom in other.body.molecule().atoms() {
            let place = other.motion.position + rotation.rotate(atom.offset());
            let apart = place - molecule.motion.position;
            let nearest = apart - sides * (apart / sides).round();
            if nearest.length() < reach && regions.has_in_pocket(atom.radius(), turn.rotate(nearest))? {
                trapped.push(other.body.key());
                break;
            }
        }
    }
    Ok(trapped)
}

/// The regions that discs cannot enter; that of the last radius is kept.
struct Regions<'a> {
    molecule: &'a Molecule,
    last: Option<(f64, ExcludedRegion)>,
}

impl Regions<'_> {
    /// Whether the centre of a disc that does not overlap the molecule, in its frame, lies in a
    /// pocket.
    fn has_in_pocket(&mut self, radius: f64, centre: DVec2) -> Result<bool> {
        let region = match self.last.take() {
            Some((known, region)) if known == radius => region,
            _ => ExcludedRegion::of(self.molecule, radius)?,
        };
        let is_in = !region.hidden_arcs().is_empty() && region.contains(centre);
        self.last = Some((radius, region));
        Ok(is_in)
    }
}

#[cfg(test)]
mod tests {
    use super::{super::setting::Gas, *};
    use carom::engine::{BodyView, Distribution, GasSpec, MoleculeSpec};

    /// Discs of drawn sizes, and dumbbells: of each, those inside are removed.
    #[test]
    fn a_mixture_in_the_hole_of_a_ring_is_removed() {
        let ring = MoleculeSpec {
            shape: Some("ring:20".to_owned()),
            atom_radius: Some(0.02),
            atom_mass: Some(1.0),
            ..MoleculeSpec::default()
        };
        let mut scene = Gas { radius: 0.01, area_fraction: 0.2, side: 1.0 }.around(ring);
        let first = &mut scene.gas[0];
        (first.radius, first.radius_distribution) = (None, Some(Distribution::Uniform([0.008, 0.012])));
        scene.gas.push(GasSpec {
            shape: Some("dumbbell".to_owned()),
            atom_radius: Some(0.006),
            atom_mass: Some(1.0),
            energy: 1.0,
            area_fraction: Some(0.1),
            ..GasSpec::default()
        });
        let words = "ring".to_owned();
        let setting = Setting { name: words.clone(), title: words.clone(), words, scene, body: 0 };
        let mut simulation = AnySimulation::new(&setting.scene).unwrap();
        let within = |simulation: &AnySimulation, atoms: usize| {
            let view = simulation.view();
            let middle = view.bodies().next().unwrap().motion.position;
            let is_in = |body: &BodyView<'_>| {
                body.body.molecule().atoms().len() == atoms && body.motion.position.distance(middle) < 0.12
            };
            view.bodies().filter(is_in).count()
        };
        assert!(within(&simulation, 1) > 3 && within(&simulation, 2) > 1);
        empty(&mut simulation, &setting).unwrap();
        simulation.run_until(0.2).unwrap();
        assert_eq!((within(&simulation, 1), within(&simulation, 2)), (0, 0));
    }

    /// A ring whose hole holds gas discs, turned so that it is not symmetric in the box; after they
    /// are removed the others are as before.
    #[test]
    fn discs_in_the_hole_of_a_ring_are_removed() {
        let ring = MoleculeSpec {
            shape: Some("ring:20".to_owned()),
            atom_radius: Some(0.02),
            atom_mass: Some(1.0),
            orientation: Some(0.1),
            ..MoleculeSpec::default()
        };
        let scene = Gas { radius: 0.01, area_fraction: 0.3, side: 1.0 }.around(ring);
        let words = "ring".to_owned();
        let setting = Setting { name: words.clone(), title: words.clone(), words, scene, body: 0 };
        let mut simulation = AnySimulation::new(&setting.scene).unwrap();
        let within = |simulation: &AnySimulation| {
            let view = simulation.view();
            let middle = view.bodies().next().unwrap().motion.position;
            let near = |body: &BodyView<'_>| body.motion.position.distance(middle) < 0.12;
            // Without the ring itself.
            view.bodies().filter(near).count() - 1
        };
        let (before, inside) = (simulation.view().len(), within(&simulation));
        assert!(inside > 5, "{inside}");
        empty(&mut simulation, &setting).unwrap();
        assert_eq!((simulation.view().len(), within(&simulation)), (before - inside, 0));
        simulation.run_until(0.2).unwrap();
        assert_eq!(within(&simulation), 0);
    }
}
