//! Which wells are refused: those that do not fit the box, or hold too many pairs.

use std::collections::BTreeMap;

use crate::{
    scene::error::SceneError,
    start::bonds::{MAX_SHARE, MIN_ROOM},
    world::World,
};

/// Most pairs within the ranges of their wells, at random places: about 5 GB.
const MAX_PAIRS: f64 = 3e7;

/// Refuses a shear of discs with wells, ranges for which images are ambiguous, and steps that
/// are too narrow; `name` names a body.
///
/// # Errors
/// [`SceneError::Entry`].
pub(crate) fn refuse_wells(
    world: &World,
    name: impl Fn(usize) -> String,
) -> Result<(), SceneError> {
    if !world.has_wells() {
        return Ok(());
    }
    if world.is_sheared() {
        return Err(SceneError::of_entry("well", "does not go with a shear yet"));
    }
    let sides = world.bounds.sides();
    let (widest, least) = (
        MAX_SHARE * sides.min_element(),
        MIN_ROOM * sides.max_element(),
    );
    let groups = groups_of_discs(world);
    let mut pairs = 0.0;
    for (n, one) in groups.iter().enumerate() {
        for other in &groups[..=n] {
            if let Some((pair, [inner, outer])) =
                extreme_shell(world, [&one.extremes, &other.extremes], widest, least)
            {
                let [a, b] = pair.map(name);
                let problem = if outer > widest {
                    format!(
                        "reaches {outer:?} (length) between {a} and {b}, so that two images are equally near: it \
                         must be at most {widest:?}, just below half the shorter side"
                    )
                } else {
                    format!(
                        "has a step from {inner:?} to {outer:?} (length) between {a} and {b}: it must be at least \
                         1e-10 of the longer side wide, {least:?} (length)"
                    )
                };
                return Err(SceneError::of_entry("well", problem));
            }
            pairs += expected_pairs(world, one, other);
        }
    }
    if pairs > MAX_PAIRS {
        let problem = format!(
            "would hold about {pairs:.1e} pairs at random places, at most {MAX_PAIRS:.0e} are allowed: make the \
             ranges shorter"
        );
        return Err(SceneError::of_entry("well", problem));
    }
    Ok(())
}

/// The discs of each class of tags that move, and those that are fixed.
fn groups_of_discs(world: &World) -> Vec<DiscGroup> {
    let mut groups: BTreeMap<(u32, bool), Vec<usize>> = BTreeMap::new();
    for (index, body) in world.bodies.iter().enumerate() {
        let group = (body.kind.tag_class, body.is_fixed());
        groups.entry(group).or_default().push(index);
    }
    let radius = |index: &usize| world.bodies[*index].molecule().bounding_radius();
    let group = |mut all: Vec<usize>| {
        all.sort_by(|a, b| radius(a).total_cmp(&radius(b)));
        let count = all.len();
        if count > 4 {
            all = vec![all[0], all[1], all[count - 2], all[count - 1]];
        }
        DiscGroup {
            count: count as f64,
            extremes: all,
        }
    };
    groups.into_values().map(group).collect()
}

/// A pair of these discs with a shell that ends beyond `widest` or is narrower than `least`
/// (length), and its borders.
fn extreme_shell(
    world: &World,
    [some, others]: [&[usize]; 2],
    widest: f64,
    least: f64,
) -> Option<([usize; 2], [f64; 2])> {
    for (&a, &b) in some.iter().flat_map(|a| others.iter().map(move |b| (a, b))) {
        if a == b {
            continue;
        }
        let pair = [a.min(b), a.max(b)];
        for shell in world.shells_of(pair.map(|body| body as u32)) {
            let [inner, outer] = shell.borders;
            if outer > widest || outer - inner < least {
                return Some((pair, [inner, outer]));
            }
        }
    }
    None
}

/// The number of pairs of two groups within the ranges of their wells at random places.
fn expected_pairs(world: &World, one: &DiscGroup, other: &DiscGroup) -> f64 {
    let (Some(&a), Some(&b)) = (one.extremes.last(), other.extremes.last()) else {
        return 0.0;
    };
    let widest = world.shells_of([a as u32, b as u32]).last();
    let Some([_, range]) = widest.map(|shell| shell.borders) else {
        return 0.0;
    };
    let share = std::f64::consts::PI * range * range / world.bounds.area();
    let both = if a == b { 0.5 } else { 1.0 };
    both * one.count * other.count * share.min(1.0)
}

/// Discs of one class of tags, which all move or are all fixed.
struct DiscGroup {
    count: f64,
    /// The two smallest and the two largest, in ascending order, by their indices.
    extremes: Vec<usize>,
}
