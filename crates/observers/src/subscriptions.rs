//! Closures that receive events of one kind, selected by tag at run time (Montanari 2017, section
//! 2.1.3).

use std::fmt;

use carom_engine::{Body, CollisionReport, Observer, View};
use slotmap::SlotMap;

use crate::TagFilter;

slotmap::new_key_type! {
    /// Handle of a subscription; never reused after the subscription ends.
    pub struct SubscriptionKey;
}

/// The kind of event that a subscription receives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// A contact of two moving bodies.
    Collision,
    /// A contact of a moving body with a fixed one.
    #[doc(alias = "bumper")]
    FixedCollision,
    /// A sample of the system.
    Sample,
}

/// Closures that observe a run; each can be added and removed during the run.
///
/// For observers fixed in advance a tuple is faster.
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

    /// Whether the subscription receives collisions of these two bodies.
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
    /// Calls `f` with all further contacts of moving bodies ([`EventKind::Collision`]) whose tags
    /// pass the filter.
    pub fn subscribe_collisions(
        &mut self,
        filter: TagFilter,
        f: impl FnMut(&CollisionReport<'_>) + 'static,
    ) -> SubscriptionKey {
        self.list
            .insert(Subscription::Collision(filter, Box::new(f)))
    }

    /// Calls `f` with all further contacts with fixed bodies ([`EventKind::FixedCollision`]) if the
    /// tags of the two bodies pass the filter.
    pub fn subscribe_fixed_collisions(
        &mut self,
        filter: TagFilter,
        f: impl FnMut(&CollisionReport<'_>) + 'static,
    ) -> SubscriptionKey {
        self.list
            .insert(Subscription::FixedCollision(filter, Box::new(f)))
    }

    /// Calls `f` with all further samples ([`EventKind::Sample`]); [`View::tagged`] selects the
    /// bodies of a tag.
    pub fn subscribe_samples(&mut self, f: impl FnMut(&View<'_>) + 'static) -> SubscriptionKey {
        self.list.insert(Subscription::Sample(Box::new(f)))
    }

    /// Ends a subscription; returns `false` if it had ended already.
    pub fn unsubscribe(&mut self, key: SubscriptionKey) -> bool {
        self.list.remove(key).is_some()
    }

    /// The kind of event that a subscription receives; `None` if it has ended.
    pub fn kind(&self, key: SubscriptionKey) -> Option<EventKind> {
        self.list.get(key).map(Subscription::kind)
    }

    /// The number of subscriptions.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are no subscriptions.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

impl Observer for Subscriptions {
    #[inline]
    fn watches_any(&self) -> bool {
        !self.list.is_empty()
    }

    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.list
            .values()
            .any(|subscription| subscription.wants(bodies))
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let bodies = report.sides.each_ref().map(|side| side.body);
        for subscription in self
            .list
            .values_mut()
            .filter(|subscription| subscription.wants(bodies))
        {
            if let Subscription::Collision(_, f) | Subscription::FixedCollision(_, f) = subscription
            {
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
        let kinds = self
            .list
            .iter()
            .map(|(key, subscription)| (key, subscription.kind()));
        f.debug_map().entries(kinds).finish()
    }
}
