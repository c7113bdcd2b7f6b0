//! Subscriptions against filters written by hand.

use std::{cell::RefCell, rc::Rc};

use carom::{
    BodyKey, CollisionReport, EpochTime, Scene, Simulation, Subscriptions, View,
    engine::{BumperSpec, Tag},
    observers::{EventKind, TagFilter},
};
use glam::DVec2;

use super::{ByHand, gas, observe, tee};

/// The record of a collision: its time and its bodies.
type Seen = (EpochTime, [BodyKey; 2]);

/// A filter by hand.
type Requested<'a> = Box<dyn Fn(&CollisionReport<'_>) -> bool + 'a>;

fn seen(report: &CollisionReport<'_>) -> Seen {
    (
        report.time,
        report.sides.each_ref().map(|side| side.body.key()),
    )
}

/// A list, and a closure that adds to it.
fn list() -> (
    Rc<RefCell<Vec<Seen>>>,
    impl FnMut(&CollisionReport<'_>) + 'static,
) {
    let list = Rc::new(RefCell::new(Vec::new()));
    let adding = Rc::clone(&list);
    (list, move |report: &CollisionReport<'_>| {
        adding.borrow_mut().push(seen(report));
    })
}

#[test]
#[expect(clippy::too_many_lines, reason = "one course with many looks")]
fn subscribers_receive_exactly_the_collisions_of_filters_by_hand() {
    let mut scene = Scene {
        molecule: vec![tee(DVec2::new(0.5, 0.5), 0.7)],
        ..Scene::default()
    };
    scene.molecule[0].tags = vec!["tee".into(), "hot".into()];
    scene.bumper.push(BumperSpec {
        tags: vec!["post".into()],
        radius: 0.03,
        at: [0.1, 0.1],
    });
    scene.bumper.push(BumperSpec {
        tags: vec![],
        radius: 0.03,
        at: [0.8, 0.8],
    });
    scene.gas.extend([gas("hot", 40), gas("cold", 60)]);
    let mut simulation = Simulation::new(&scene).unwrap();
    let tag = |name: &str| simulation.find_tag(name).unwrap();
    let (hot, cold, post) = (tag("hot"), tag("cold"), tag("post"));
    let has =
        |body: usize, tag: Tag| move |r: &CollisionReport<'_>| r.sides[body].body.has_tag(tag);
    let fixed = |r: &CollisionReport<'_>| r.sides[0].body.is_fixed() || r.sides[1].body.is_fixed();
    let hot_and_cold = |r: &CollisionReport<'_>| {
        (has(0, hot)(r) && has(1, cold)(r)) || (has(0, cold)(r) && has(1, hot)(r))
    };
    let moving: [(TagFilter, Requested<'_>); 5] = [
        (TagFilter::Any, Box::new(|r| !fixed(r))),
        (
            TagFilter::One(hot),
            Box::new(|r| !fixed(r) && (has(0, hot)(r) || has(1, hot)(r))),
        ),
        (
            TagFilter::One(cold),
            Box::new(|r| !fixed(r) && (has(0, cold)(r) || has(1, cold)(r))),
        ),
        (
            TagFilter::Pair(cold, hot),
            Box::new(|r| !fixed(r) && hot_and_cold(r)),
        ),
        (
            TagFilter::Pair(hot, hot),
            Box::new(|r| !fixed(r) && has(0, hot)(r) && has(1, hot)(r)),
        ),
    ];
    let mut subscriptions = Subscriptions::default();
    let mut lists = Vec::new();
    for (filter, requested) in moving {
        let (list, f) = list();
        let key = subscriptions.subscribe_collisions(filter, f);
        assert_eq!(subscriptions.kind(key), Some(EventKind::Collision));
        lists.push((key, list, requested));
    }
    let with_fixed: [(TagFilter, Requested<'_>); 2] = [
        (TagFilter::Any, Box::new(fixed)),
        (
            TagFilter::One(post),
            Box::new(|r| has(0, post)(r) || has(1, post)(r)),
        ),
    ];
    for (filter, requested) in with_fixed {
        let (list, f) = list();
        let key = subscriptions.subscribe_fixed_collisions(filter, f);
        assert_eq!(subscriptions.kind(key), Some(EventKind::FixedCollision));
        lists.push((key, list, requested));
    }
    let energies = Rc::new(RefCell::new(Vec::new()));
    let adding = Rc::clone(&energies);
    let samples = subscriptions.subscribe_samples(move |view: &View<'_>| {
        adding
            .borrow_mut()
            .push(view.tagged(hot).map(|body| body.energy()).sum::<f64>());
    });
    assert_eq!(
        (subscriptions.len(), subscriptions.kind(samples)),
        (8, Some(EventKind::Sample))
    );

    let all = lists
        .iter()
        .map(|(_, _, requested)| requested)
        .collect::<Vec<_>>();
    let by_hand = ByHand(Vec::new(), |r: &CollisionReport<'_>| {
        Some((
            seen(r),
            all.iter()
                .map(|requested| requested(r))
                .collect::<Vec<bool>>(),
        ))
    });
    let mut observers = (subscriptions, by_hand);
    observe(&mut simulation, &mut observers, 2.0, 4);
    let expected = |reports: &[(Seen, Vec<bool>)], index: usize| -> Vec<Seen> {
        reports
            .iter()
            .filter(|(_, requested)| requested[index])
            .map(|(seen, _)| *seen)
            .collect()
    };
    for (index, (_, list, _)) in lists.iter().enumerate() {
        assert!(
            list.borrow().len() > 10,
            "list {index} has {}",
            list.borrow().len()
        );
        assert_eq!(
            *list.borrow(),
            expected(&observers.1.0, index),
            "list {index}"
        );
    }
    assert_eq!(energies.borrow().len(), 4);
    assert!(
        energies
            .borrow()
            .iter()
            .all(|&energy| energy > 0.0 && energy < 100.0)
    );

    // One subscription ends; the others continue, and its key is no longer valid.
    let (ended, ended_list, _) = &lists[1];
    let before = ended_list.borrow().len();
    assert!(observers.0.unsubscribe(*ended) && observers.0.unsubscribe(samples));
    assert!(!observers.0.unsubscribe(*ended));
    assert_eq!((observers.0.len(), observers.0.kind(*ended)), (6, None));
    observe(&mut simulation, &mut observers, 3.0, 4);
    assert_eq!(
        (ended_list.borrow().len(), energies.borrow().len()),
        (before, 4)
    );
    assert_eq!(Rc::strong_count(ended_list), 1, "the closure is dropped");
    for index in [0, 2, 3, 4, 5, 6] {
        assert_eq!(
            *lists[index].1.borrow(),
            expected(&observers.1.0, index),
            "list {index}"
        );
    }
}
