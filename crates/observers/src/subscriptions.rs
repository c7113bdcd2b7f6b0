//! Subscriptions: closures that are told of events of one kind, chosen by tag at run time (Montanari 2017, section
//! 2.1.3).

use std::fmt;

use carom_engine::{Body, CollisionReport, Observer, View};
use slotmap::SlotMap;

use crate::TagFilter;

slotmap::new_key_type! {
    /// Handle of a subscription; never used again once that has ended.
    pub struct SubscriptionKey;
}

/// What kind of event a subscription is told of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// A contact of two bodies that move.
    Collision,
    /// A contact of a body that moves with a fixed one.
    #[doc(alias = "bumper")]
    FixedCollision,
    /// The system stands by.
    Sample,
}

/// Closures that watch a run; each can come and go while it lasts.
///
/// For what is known beforehand a tuple of observers is faster.
///
/// ```
/// use std::{cell::Cell, rc::Rc};
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::{Subscriptions, TagFilter};
///
/// let scene = Scene::from_toml(r#"
///     [[gas]]
///     tags = ["hot"]
///     radius = 0.02
///     mass = 1.0
///     energy = 4.0
///     count = 50
///     [[gas]]
///     tags = ["cold"]
///     radius = 0.02
///     mass = 1.0
///     energy = 1.0
///     count = 50
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let tag = |name| simulation.find_tag(name).expect("the scene names it");
/// let mixed = TagFilter::Pair(tag("hot"), tag("cold"));
///
/// let count = Rc::new(Cell::new(0));
/// let seen = Rc::clone(&count);
/// let mut subscriptions = Subscriptions::default();
/// let key = subscriptions.subscribe_collisions(mixed, move |_| seen.set(seen.get() + 1));
/// simulation.observe_until(1.0, &mut subscriptions)?;
/// assert!(count.get() > 0);
/// assert!(subscriptions.unsubscribe(key));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct Subscriptions {
    list: SlotMap<SubscriptionKey, Subscription>,
}

type OnCollision = Box<dyn FnMut(&CollisionReport<'_>)>;
type OnSample = Box<dyn FnMut(&View<'_>)>;

enum Subscription {
    Collision(TagFilter, OnCollision),
    FixedCollision(TagFilter, OnCollision),
    Sample(OnSample),
}

impl Subscription {
    fn kind(&self) -> EventKind {
        match self {
            Self::Collision(..) => EventKind::Collision,
            Self::FixedCollision(..) => EventKind::FixedCollision,
            Self::Sample(_) => EventKind::Sample,
        }
    }

    /// Whether it is told of collisions of these two.
    fn wants(&self, bodies: [&Body; 2]) -> bool {
        let with_fixed = bodies.iter().any(|body| body.is_fixed());
        match self {
            Self::Collision(filter, _) => !with_fixed && filter.matches(bodies),
            Self::FixedCollision(filter, _) => with_fixed && filter.matches(bodies),
            Self::Sample(_) => false,
        }
    }
}

impl Subscriptions {
    /// From now on `f` is told of the contacts of bodies that move ([`EventKind::Collision`]), if their tags pass
    /// the filter.
    pub fn subscribe_collisions(
        &mut self,
        filter: TagFilter,
        f: impl FnMut(&CollisionReport<'_>) + 'static,
    ) -> SubscriptionKey {
        self.list.insert(Subscription::Collision(filter, Box::new(f)))
    }

    /// From now on `f` is told of the contacts with fixed bodies ([`EventKind::FixedCollision`]), if the tags of
    /// the two pass the filter.
    pub fn subscribe_fixed_collisions(
        &mut self,
        filter: TagFilter,
        f: impl FnMut(&CollisionReport<'_>) + 'static,
    ) -> SubscriptionKey {
        self.list.insert(Subscription::FixedCollision(filter, Box::new(f)))
    }

    /// From now on `f` is told of the samples ([`EventKind::Sample`]); [`View::tagged`] gives it the bodies of a
    /// tag.
    pub fn subscribe_samples(&mut self, f: impl FnMut(&View<'_>) + 'static) -> SubscriptionKey {
        self.list.insert(Subscription::Sample(Box::new(f)))
    }

    /// Ends a subscription; `false` if it had ended already.
    pub fn unsubscribe(&mut self, key: SubscriptionKey) -> bool {
        self.list.remove(key).is_some()
    }

    /// What a subscription is told of; `None` if it has ended.
    pub fn kind(&self, key: SubscriptionKey) -> Option<EventKind> {
        self.list.get(key).map(Subscription::kind)
    }

    /// How many subscriptions there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

impl Observer for Subscriptions {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.list.values().any(|subscription| subscription.wants(bodies))
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let bodies = report.sides.each_ref().map(|side| side.body);
        for subscription in self.list.values_mut().filter(|subscription| subscription.wants(bodies)) {
            if let Subscription::Collision(_, f) | Subscription::FixedCollision(_, f) = subscription {
                f(report);
            }
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        for subscription in self.list.values_mut() {
            if let Subscription::Sample(f) = subscription {
                f(view);
            }
        }
    }
}

impl fmt::Debug for Subscriptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kinds = self.list.iter().map(|(key, subscription)| (key, subscription.kind()));
        f.debug_map().entries(kinds).finish()
    }
}
