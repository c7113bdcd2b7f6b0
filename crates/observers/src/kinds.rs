//! Kinds of bodies, to distinguish them in a picture or a table.

use std::collections::{BTreeMap, BTreeSet};

use carom_engine::{Body, BodyView, Tag, View};
use carom_geometry::{Edge, Ellipse, Interior, Molecule};

/// The common properties of a kind: fixed or not, tags, make-up; size and mass.
type Likeness<'a> = (bool, &'a [Tag], MakeUp, [u64; 2]);

/// What a molecule is made of: the number of its atoms; of each edge the atoms at its ends, and its
/// radius over the smaller of theirs in millionths; and whether the interior of its closed lines of
/// edges is hollow; and the half axes and directions of its ellipses.
type MakeUp = (usize, Vec<([u32; 2], u32)>, bool, Vec<[u64; 4]>);

/// The kind of each body of a view, in its order, numbered 0, 1, … in order of appearance.
///
/// Bodies of one kind have the same tags, number of atoms, edges, size and mass, and all or none of
/// them are fixed.
fn kinds(view: &View<'_>) -> Vec<usize> {
    numbered(view, likeness)
}

/// The kind of each body of a view, numbered in order of appearance; where these are more than
/// `most`, as in a gas of many sizes, bodies that differ only in size or mass are of one kind.
pub fn few_kinds(view: &View<'_>, most: usize) -> Vec<usize> {
    let all = kinds(view);
    if all.iter().all(|&kind| kind < most) {
        return all;
    }
    numbered(view, |body| {
        let (is_fixed, tags, parts, _) = likeness(body);
        (is_fixed, tags, parts, [0; 2])
    })
}

/// Most sizes and masses in one group of bodies that are kinds of their own: as many as pictures
/// have colours. More are those of a distribution.
const MAX_SIZES: usize = 7;

/// The kind of each body of a view, numbered in order of appearance; where bodies that are alike
/// but for size and mass have more than seven sizes, as a gas that draws them, all of them are of
/// one kind.
pub fn kinds_of_groups(view: &View<'_>) -> Vec<usize> {
    let mut sizes: BTreeMap<Likeness<'_>, BTreeSet<[u64; 2]>> = BTreeMap::new();
    let group = |(is_fixed, tags, parts, _)| (is_fixed, tags, parts, [0; 2]);
    for body in view.bodies() {
        let all = likeness(body.body);
        let size = all.3;
        let of_group = sizes.entry(group(all)).or_default();
        if of_group.len() <= MAX_SIZES {
            of_group.insert(size);
        }
    }
    numbered(view, |body| {
        let all = likeness(body);
        let group = group(all.clone());
        let is_drawn = sizes
            .get(&group)
            .is_some_and(|sizes| sizes.len() > MAX_SIZES);
        if is_drawn { group } else { all }
    })
}

/// A name for each kind of a numbering in order of appearance: its tags, or what it is. Kinds of
/// the same tags have numbers. A name has no spaces and no quotes.
pub fn names_of_kinds(view: &View<'_>, kinds: &[usize]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let mut known = BTreeSet::new();
    for (BodyView { body, .. }, &kind) in view.bodies().zip(kinds) {
        if kind < names.len() {
            continue;
        }
        let tags: Vec<&str> = body
            .tags()
            .iter()
            .map(|&tag| view.tag_names().name(tag))
            .collect();
        let name = match tags.as_slice() {
            [] if body.is_wall() => "wall".to_owned(),
            [] if body.is_fixed() => "fixed".to_owned(),
            [] => "molecule".to_owned(),
            tags => tags.join("+").replace(
                |c: char| c.is_whitespace() || c.is_control() || c == '"',
                "_",
            ),
        };
        // One of so many names is new.
        let numbered = (2..=known.len() + 2).map(|number| format!("{name}-{number}"));
        let new = std::iter::once(name.clone())
            .chain(numbered)
            .find(|name| !known.contains(name));
        let new = new.unwrap_or(name);
        known.insert(new.clone());
        names.push(new);
    }
    names
}

/// Numbers bodies by their likeness, in order of appearance.
fn numbered<'a>(view: &View<'a>, likeness: impl Fn(&'a Body) -> Likeness<'a>) -> Vec<usize> {
    let mut known: BTreeMap<Likeness<'a>, usize> = BTreeMap::new();
    view.bodies()
        .map(|view| {
            let next = known.len();
            *known.entry(likeness(view.body)).or_insert(next)
        })
        .collect()
}

fn likeness(body: &Body) -> Likeness<'_> {
    let molecule = body.molecule();
    let size = [molecule.bounding_radius(), molecule.mass()].map(f64::to_bits);
    (body.is_fixed(), body.tags(), make_up(molecule), size)
}

fn make_up(molecule: &Molecule) -> MakeUp {
    let atoms = molecule.atoms();
    let edge = |edge: &Edge| {
        let ends = edge.ends()?;
        let thinner = ends.map(|end| atoms[end as usize].radius());
        let share = edge.radius() / thinner[0].min(thinner[1]);
        Some((ends, (1e6 * share).round() as u32))
    };
    let edges = if molecule.is_wall() {
        Vec::new()
    } else {
        molecule.edges().iter().filter_map(edge).collect()
    };
    let is_hollow = molecule.interior() == Interior::Hollow;
    let ellipse = |ellipse: &Ellipse| {
        let ([a, b], along) = (ellipse.axes(), ellipse.along());
        [a, b, along.x, along.y].map(f64::to_bits)
    };
    let ellipses = molecule.ellipses().iter().map(ellipse).collect();
    (atoms.len(), edges, is_hollow, ellipses)
}

#[cfg(test)]
mod tests {
    use carom_engine::{Scene, Simulation};

    use super::*;

    #[test]
    fn a_gas_that_draws_its_sizes_is_one_kind_beside_others_of_few_sizes() {
        let scene = Scene::from_toml(
            "[[gas]]\ntags = [\"drawn\"]\nradius = { uniform = [0.01, 0.02] }\nmass = 1.0\nenergy = 1.0\ncount = 20\n\
             [[gas]]\ntags = [\"two\"]\nradius = { values = [0.01, 0.02] }\nmass = 1.0\nenergy = 1.0\ncount = 30\n\
             [[gas]]\ntags = [\"equal\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 5\n",
        )
        .unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let found = kinds_of_groups(&simulation.view());
        assert_eq!((&found[..20], &found[50..]), (&[0; 20][..], &[3; 5][..]));
        let two: BTreeSet<usize> = found[20..50].iter().copied().collect();
        assert_eq!(two.into_iter().collect::<Vec<_>>(), [1, 2]);
        assert_eq!(
            names_of_kinds(&simulation.view(), &found),
            ["drawn", "two", "two-2", "equal"]
        );
    }

    #[test]
    fn a_gas_of_many_sizes_is_one_kind_where_kinds_are_few() {
        let scene = Scene::from_toml(
            "[[molecule]]\nshape = \"tee\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.5, 0.5]\n\
             [[gas]]\ntags = [\"gas\"]\nradius = { uniform = [0.01, 0.02] }\nmass = 1.0\nenergy = 1.0\ncount = 20\n",
        )
        .unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let view = simulation.view();
        assert_eq!(kinds(&view).into_iter().max(), Some(20));
        assert_eq!(few_kinds(&view, 7)[1..], [1; 20]);
        assert_eq!(few_kinds(&view, 21), kinds(&view));
    }
}
