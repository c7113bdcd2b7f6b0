//! What surrounds the molecule: one gas of equal discs, for which kinetic theory predicts the
//! kicks, or any mixture of gases and molecules, for which it has no prediction here.

use anyhow::{Context, Result, ensure};
use carom::{
    Molecule, Scene,
    engine::{Distribution, GasSpec, MoleculeSpec},
};

/// Least radius of a probe in mean radii, for sizes whose distribution reaches down to 0.
const LEAST_PROBE: f64 = 1e-3;

/// The bodies that move and touch the molecule.
#[derive(Debug, Clone, PartialEq)]
pub struct Surroundings {
    /// A kind for each gas, then for each other molecule that moves; at least one.
    pub kinds: Vec<Kind>,
    /// Whether they are one gas of equal discs.
    pub is_one_gas: bool,
}

/// Molecules of one gas, or one other molecule.
#[derive(Debug, Clone, PartialEq)]
pub struct Kind {
    /// Radius of the smallest atom of the smallest molecule (length).
    pub smallest: f64,
    /// Radius of the disc of the area of a mean molecule (length).
    pub radius: f64,
    /// Mass of a mean molecule.
    pub mass: f64,
    /// Number of molecules; of drawn sizes, expected.
    pub number: f64,
    /// Description, such as "discs of radius 0.01, mass 1".
    pub words: String,
}

impl Surroundings {
    /// The surroundings of the molecule `body` of a scene.
    ///
    /// # Errors
    /// Nothing else moves, or a molecule is invalid; the message names the entry.
    pub fn of(scene: &Scene, body: usize) -> Result<Self> {
        let [width, height] = scene.bounds.sides;
        let gases = scene.gas.iter().enumerate();
        let gases = gases.map(|(index, gas)| Kind::of_gas(gas, &format!("gas[{index}]"), width * height));
        let moves = |(index, entry): &(usize, &MoleculeSpec)| *index != body && !entry.fixed;
        let others = scene.molecule.iter().enumerate().filter(moves);
        let others = others
            .map(|(index, entry)| Ok(Kind::of_molecule(&entry.molecule(&format!("molecule[{index}]"))?)));
        let kinds: Vec<Kind> = gases.chain(others).collect::<Result<_>>()?;
        ensure!(
            kinds.iter().any(|kind| kind.number > 0.0),
            "gas: nothing moves around the molecule; give the scene a [[gas]]"
        );
        let is_one_gas = matches!((scene.gas.as_slice(), kinds.len()), ([gas], 1) if is_of_equal_discs(gas));
        Ok(Self { kinds, is_one_gas })
    }

    /// Radius of the smallest disc that can touch the molecule: that of the gas, or of the smallest
    /// atom of all (length).
    pub fn probe(&self) -> f64 {
        self.kinds.iter().map(|kind| kind.smallest).fold(f64::INFINITY, f64::min)
    }

    /// Largest mean mass of a kind.
    pub fn largest_mass(&self) -> f64 {
        self.kinds.iter().map(|kind| kind.mass).fold(0.0, f64::max)
    }

    /// Description of all kinds.
    pub fn words(&self) -> String {
        self.kinds.iter().map(|kind| kind.words.as_str()).collect::<Vec<_>>().join("; ")
    }
}

fn is_of_equal_discs(gas: &GasSpec) -> bool {
    let is_disc = gas.atoms.is_empty() && gas.shape.as_deref().is_none_or(|shape| shape == "disc");
    is_disc
        && gas.radius_distribution.is_none()
        && gas.mass_distribution.is_none()
        && gas.scale.is_none()
        && gas.density.is_none()
}

impl Kind {
    fn of_gas(gas: &GasSpec, entry: &str, area: f64) -> Result<Self> {
        let mean = |distribution: &Option<Distribution>| distribution.as_ref().map(Distribution::mean);
        let has_list = !gas.atoms.is_empty();
        let spec = MoleculeSpec {
            shape: (!has_list).then(|| gas.shape.clone().unwrap_or_else(|| "disc".to_owned())),
            atoms: gas.atoms.clone(),
            atom_radius: gas.radius.or(gas.atom_radius).or(mean(&gas.radius_distribution)),
            // With a density the mass follows from the area.
            atom_mass: gas
                .mass
                .or(gas.atom_mass)
                .or(mean(&gas.mass_distribution))
                .or((!has_list && gas.density.is_some()).then_some(1.0)),
            ..MoleculeSpec::default()
        };
        let scale = mean(&gas.scale).unwrap_or(1.0);
        let molecule = spec.molecule(entry)?;
        let molecule = molecule.scaled(scale).with_context(|| entry.to_owned())?;
        let kind = Self::of_molecule(&molecule);
        let least = |distribution: &Option<Distribution>| {
            distribution.as_ref().map_or(1.0, |sizes| (sizes.lower_bound() / sizes.mean()).max(LEAST_PROBE))
        };
        let number = match (gas.count, gas.area_fraction) {
            (Some(count), _) => count as f64,
            (None, fraction) => (fraction.unwrap_or(0.0) * area / molecule.area()).round(),
        };
        let mass = gas.density.map_or(kind.mass, |density| density * molecule.area());
        let smallest = kind.smallest * least(&gas.radius_distribution) * least(&gas.scale);
        Ok(Self { smallest, mass, number, words: words(gas, &molecule, mass, number), ..kind })
    }

    fn of_molecule(molecule: &Molecule) -> Self {
        let atoms = molecule.atoms();
        Self {
            smallest: atoms.iter().map(carom::geometry::Atom::radius).fold(f64::INFINITY, f64::min),
            radius: (molecule.area() / std::f64::consts::PI).sqrt(),
            mass: molecule.mass(),
            number: 1.0,
            words: format!("a molecule of {} discs, mass {}", atoms.len(), short(molecule.mass())),
        }
    }
}

/// Description of a gas by its mean molecule.
fn words(gas: &GasSpec, molecule: &Molecule, mass: f64, number: f64) -> String {
    let is_drawn = gas.radius_distribution.is_some() || gas.scale.is_some();
    let about = if is_drawn && gas.count.is_none() { "about " } else { "" };
    let mean = if is_drawn || gas.mass_distribution.is_some() { "mean " } else { "" };
    let shape = match (gas.shape.as_deref(), molecule.is_disc()) {
        (_, true) => "discs".to_owned(),
        (Some(shape), _) => format!("molecules ({shape})"),
        (None, _) => format!("molecules of {} discs", molecule.atoms().len()),
    };
    let radius = short(molecule.atoms().iter().map(carom::geometry::Atom::radius).fold(0.0, f64::max));
    let of_atoms = if molecule.is_disc() { "" } else { "atoms of " };
    format!("{about}{number:.0} {shape}, {of_atoms}{mean}radius {radius}, {mean}mass {}", short(mass))
}

fn short(value: f64) -> String {
    carom_report::page::with_error(value, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Surroundings {
        let probe = "[[molecule]]\ntags = [\"probe\"]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\n\
                     at = [0.5, 0.5]\n";
        Surroundings::of(&Scene::from_toml(&format!("{probe}{text}")).unwrap(), 0).unwrap()
    }

    #[test]
    fn one_gas_of_equal_discs_is_told_from_mixtures() {
        let gas = "[[gas]]\nradius = 0.03\nmass = 2.0\nenergy = 1.0\ncount = 40\n";
        let one = of(gas);
        assert!(one.is_one_gas && one.probe() == 0.03 && one.largest_mass() == 2.0);
        let two =
            of(&format!("{gas}[[gas]]\nradius = 0.01\nmass = 0.5\nenergy = 1.0\narea_fraction = 0.1\n"));
        assert!(!two.is_one_gas && two.probe() == 0.01 && two.largest_mass() == 2.0);
        assert_eq!(two.kinds[1].number, (0.1 / (std::f64::consts::PI * 1e-4)).round());
        let with_rod = of(&format!(
            "{gas}[[molecule]]\nshape = \"rod:3\"\natom_radius = 0.004\natom_mass = 1.0\nat = [0.1, 0.1]\n"
        ));
        assert!(!with_rod.is_one_gas && with_rod.probe() == 0.004);
    }

    #[test]
    fn drawn_sizes_have_their_lower_bound_and_mean() {
        let gas = "[[gas]]\nradius = { uniform = [0.01, 0.03] }\nscale = { values = [0.5, 1.5] }\ndensity = 100.0\n\
                   energy = 1.0\ncount = 40\n";
        let drawn = of(gas);
        assert!(!drawn.is_one_gas && (drawn.probe() - 0.005).abs() < 1e-15);
        let mass = 100.0 * std::f64::consts::PI * 4e-4;
        assert!((drawn.largest_mass() / mass - 1.0).abs() < 1e-12);
        assert_eq!(drawn.words(), "40 discs, mean radius 0.02, mean mass 0.125664");
    }

    #[test]
    fn a_molecule_alone_is_refused() {
        let scene = Scene::from_toml(
            "[[molecule]]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\n",
        );
        let error = Surroundings::of(&scene.unwrap(), 0).unwrap_err().to_string();
        assert!(error.contains("nothing moves around"), "{error}");
    }
}
