//! Classes of bodies: those with equal sets of tags, for tables that have an entry for each pair.

use std::{
    collections::{BTreeMap, HashMap},
    sync::Arc,
};

use crate::world::{World, body::BodyKind, tags::Tags};

/// Gives each body the number of its class, and returns the tags of each class.
///
/// Bodies that share a description still share it afterwards.
pub(crate) fn sort_into_classes(world: &mut World) -> Vec<Tags> {
    let mut classes: BTreeMap<Tags, u32> = BTreeMap::new();
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
            .or_insert_with(|| {
                let next = classes.len() as u32;
                let class = *classes.entry(body.kind.tags.clone()).or_insert(next);
                let after = BodyKind {
                    tag_class: class,
                    ..BodyKind::clone(&body.kind)
                };
                [Arc::clone(&body.kind), Arc::new(after)]
            });
        body.kind = Arc::clone(&both[1]);
        last = Some(both.clone());
    }
    let mut tags: Vec<(Tags, u32)> = classes.into_iter().collect();
    tags.sort_by_key(|&(_, class)| class);
    tags.into_iter().map(|(tags, _)| tags).collect()
}
