//! Classes of bodies: those with equal sets of tags, for tables that have an entry for each pair.

use std::{
    collections::{BTreeMap, HashMap},
    sync::Arc,
};

use crate::world::{World, body::BodyKind, tags::Tags};

/// Gives each body the number of its class, and returns the tags of each class; further sets of
/// tags, which no body may have, get classes after those of the bodies.
pub(crate) fn sort_into_classes(world: &mut World, further: &[Tags]) -> Vec<Tags> {
    let mut classes: BTreeMap<Tags, u32> = BTreeMap::new();
    replace_kinds(world, |kind| {
        let next = classes.len() as u32;
        BodyKind {
            tag_class: *classes.entry(kind.tags.clone()).or_insert(next),
            ..kind.clone()
        }
    });
    for tags in further {
        let next = classes.len() as u32;
        classes.entry(tags.clone()).or_insert(next);
    }
    let mut tags: Vec<(Tags, u32)> = classes.into_iter().collect();
    tags.sort_by_key(|&(_, class)| class);
    tags.into_iter().map(|(tags, _)| tags).collect()
}

/// Replaces the descriptions of all bodies. Bodies that share a description still share it
/// afterwards.
pub(crate) fn replace_kinds(world: &mut World, mut replaced: impl FnMut(&BodyKind) -> BodyKind) {
    // Old kinds are kept alive so that their addresses stay unique.
    let mut done: HashMap<usize, [Arc<BodyKind>; 2]> = HashMap::new();
    let mut last: Option<[Arc<BodyKind>; 2]> = None;
    for body in &mut world.bodies {
        if let Some([before, after]) = &last
            && Arc::ptr_eq(&body.kind, before)
        {
            body.kind = Arc::clone(after);
            continue;
        }
        let both = done
            .entry(Arc::as_ptr(&body.kind).addr())
            .or_insert_with(|| [Arc::clone(&body.kind), Arc::new(replaced(&body.kind))]);
        body.kind = Arc::clone(&both[1]);
        last = Some(both.clone());
    }
}
