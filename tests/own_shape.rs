//! A user-defined shape is data: any list of atoms, in code or in a scene file. Only a named family
//! of shapes needs code.

use carom::{Atom, Molecule, Scene, Shape, Simulation};
use glam::DVec2;

/// A hook of five unequal discs.
const HOOK: [([f64; 2], f64, f64); 5] = [
    ([0.0, 0.0], 0.03, 3.0),
    ([0.05, 0.0], 0.02, 1.0),
    ([0.09, 0.01], 0.02, 1.0),
    ([0.1, 0.045], 0.015, 0.5),
    ([0.08, 0.07], 0.01, 0.25),
];

fn atoms() -> Vec<Atom> {
    let atom = |(at, radius, mass): ([f64; 2], f64, f64)| Atom::new(DVec2::from(at), radius, mass);
    HOOK.into_iter()
        .map(|atom_of| atom(atom_of).unwrap())
        .collect()
}

#[test]
fn a_list_of_atoms_is_a_molecule_with_the_mass_and_moment_of_its_discs() {
    let hook = Molecule::new(atoms()).unwrap();
    let mass: f64 = HOOK.iter().map(|&(_, _, mass)| mass).sum();
    let centre: DVec2 = HOOK
        .iter()
        .map(|&(at, _, mass)| mass * DVec2::from(at))
        .sum::<DVec2>()
        / mass;
    // Each disc turns about its own centre (m r²/2), which is displaced from the common centre
    // (Steiner).
    let moment: f64 = HOOK
        .iter()
        .map(|&(at, radius, mass)| {
            mass * (0.5 * radius * radius + (DVec2::from(at) - centre).length_squared())
        })
        .sum();
    assert!((hook.mass() - mass).abs() < 1e-15 * mass);
    assert!((hook.moment_of_inertia() - moment).abs() < 1e-14 * moment);
}

#[test]
fn a_scene_of_molecules_from_a_list_of_atoms_conserves_energy_and_momentum() {
    let atom = |(at, radius, mass)| format!("{{ at = {at:?}, radius = {radius}, mass = {mass} }}");
    let atoms = HOOK.map(atom).join(",\n");
    let scene = Scene::from_toml(&format!(
        "[box]\nseed = 3\n[[gas]]\ncount = 12\nenergy = 1.0\natoms = [\n{atoms}]\n"
    ))
    .unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    let before = (simulation.view().energy(), simulation.view().momentum());
    simulation.run_until(10.0).unwrap();
    let view = simulation.view();
    assert!(view.counters().collisions > 100, "{:?}", view.counters());
    assert_eq!(view.overlaps().pairs, 0);
    assert!((view.energy() - before.0).abs() < 1e-13 * before.0);
    assert!((view.momentum() - before.1).length() < 1e-12);
    let by_code = Molecule::new(self::atoms()).unwrap();
    assert!(view.bodies().all(|body| *body.body.molecule() == by_code));
}

#[test]
fn a_named_shape_gives_the_atoms_that_a_list_would() {
    let named: Shape = "rod:3".parse().unwrap();
    let listed: Vec<Atom> = [-2.0, 0.0, 2.0]
        .map(|x| Atom::new(DVec2::new(0.01 * x, 0.0), 0.01, 1.0).unwrap())
        .into();
    let [named, listed] =
        [named.atoms(0.01, 1.0).unwrap(), listed].map(|atoms| Molecule::new(atoms).unwrap());
    assert_eq!(named.bounding_radius(), listed.bounding_radius());
    assert_eq!(named.moment_of_inertia(), listed.moment_of_inertia());
}
