//! Observers: they receive each collision and each sample of a run, and cannot change it.

use crate::world::{body::Body, report::CollisionReport, view::View};

/// Observes a run. Each method has a default that does nothing.
///
/// [`Simulation::sample_every`](crate::Simulation::sample_every) calls all methods. The other
/// methods that run a simulation call [`Self::collision`] only; a program that uses them calls
/// [`Self::start`] before the run and [`Self::sample`] for each sample. Every program calls
/// [`Self::pause`] before an edit and [`Self::start`] after it.
///
/// Tuples, `Vec`, `Option`, `Box` and `&mut` of observers are observers; `Box<dyn Observer>` is
/// chosen at run time. `()` observes nothing, and a run with it builds no reports.
///
/// ```
/// use carom_engine::{CollisionReport, Observer};
///
/// /// Sums the magnitudes of all impulses.
/// #[derive(Default)]
/// struct TotalImpulse(f64);
///
/// impl Observer for TotalImpulse {
///     fn collision(&mut self, report: &CollisionReport<'_>) {
///         self.0 += report.impulse.length();
///     }
/// }
/// ```
pub trait Observer {
    /// Whether the observer wants reports of collisions at all; with `false` the run costs as much
    /// as without an observer. It is evaluated at the start of each epoch, and must not change
    /// between two samples. Composite observers must OR their members.
    #[inline]
    fn watches_any(&self) -> bool {
        true
    }

    /// Filter: returns whether a report of a collision of these two bodies is requested; `false`
    /// skips building the report. Composite observers must OR their members, so
    /// [`Self::collision`] may also receive collisions for which this returns `false`.
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        let _ = bodies;
        self.watches_any()
    }

    /// Called when the run begins, or continues after an edit.
    fn start(&mut self, view: &View<'_>) {
        let _ = view;
    }

    /// Called before an edit within a run, with the state to be edited; [`Self::start`] follows at
    /// the same time. Observers of intervals, such as a pressure, continue after the edit only if
    /// this was called.
    fn pause(&mut self, view: &View<'_>) {
        let _ = view;
    }

    /// Called after each collision of two bodies.
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let _ = report;
    }

    /// Called for each sample, with all bodies at one time.
    #[doc(alias = "standby")]
    fn sample(&mut self, view: &View<'_>) {
        let _ = view;
    }
}

impl Observer for () {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }
}

macro_rules! pointer_to_an_observer {
    ($pointer:ty) => {
        impl<O: Observer + ?Sized> Observer for $pointer {
            #[inline]
            fn watches_any(&self) -> bool {
                (**self).watches_any()
            }

            #[inline]
            fn watches(&self, bodies: [&Body; 2]) -> bool {
                (**self).watches(bodies)
            }

            fn start(&mut self, view: &View<'_>) {
                (**self).start(view);
            }

            fn pause(&mut self, view: &View<'_>) {
                (**self).pause(view);
            }

            fn collision(&mut self, report: &CollisionReport<'_>) {
                (**self).collision(report);
            }

            fn sample(&mut self, view: &View<'_>) {
                (**self).sample(view);
            }
        }
    };
}

pointer_to_an_observer!(&mut O);
pointer_to_an_observer!(Box<O>);

/// A list of observers is an observer. The members of `Vec<Box<dyn Observer>>` are chosen at run
/// time.
impl<O: Observer> Observer for Vec<O> {
    #[inline]
    fn watches_any(&self) -> bool {
        self.iter().any(Observer::watches_any)
    }

    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.iter().any(|observer| observer.watches(bodies))
    }

    fn start(&mut self, view: &View<'_>) {
        for observer in self {
            observer.start(view);
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        for observer in self {
            observer.pause(view);
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        for observer in self {
            observer.collision(report);
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        for observer in self {
            observer.sample(view);
        }
    }
}

impl<O: Observer> Observer for Option<O> {
    #[inline]
    fn watches_any(&self) -> bool {
        self.as_ref().is_some_and(Observer::watches_any)
    }

    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.as_ref()
            .is_some_and(|observer| observer.watches(bodies))
    }

    fn start(&mut self, view: &View<'_>) {
        if let Some(observer) = self {
            observer.start(view);
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        if let Some(observer) = self {
            observer.pause(view);
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if let Some(observer) = self {
            observer.collision(report);
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        if let Some(observer) = self {
            observer.sample(view);
        }
    }
}

macro_rules! tuple_of_observers {
    ($($member:ident),+) => {
        impl<$($member: Observer),+> Observer for ($($member,)+) {
            #[inline]
            #[expect(non_snake_case, reason = "type parameters double as names of the members")]
            fn watches_any(&self) -> bool {
                let ($($member,)+) = self;
                $($member.watches_any())||+
            }

            #[inline]
            #[expect(non_snake_case, reason = "type parameters double as names of the members")]
            fn watches(&self, bodies: [&Body; 2]) -> bool {
                let ($($member,)+) = self;
                $($member.watches(bodies))||+
            }

            #[expect(non_snake_case, reason = "type parameters double as names of the members")]
            fn start(&mut self, view: &View<'_>) {
                let ($($member,)+) = self;
                $($member.start(view);)+
            }

            #[expect(non_snake_case, reason = "type parameters double as names of the members")]
            fn pause(&mut self, view: &View<'_>) {
                let ($($member,)+) = self;
                $($member.pause(view);)+
            }

            #[expect(non_snake_case, reason = "type parameters double as names of the members")]
            fn collision(&mut self, report: &CollisionReport<'_>) {
                let ($($member,)+) = self;
                $($member.collision(report);)+
            }

            #[expect(non_snake_case, reason = "type parameters double as names of the members")]
            fn sample(&mut self, view: &View<'_>) {
                let ($($member,)+) = self;
                $($member.sample(view);)+
            }
        }
    };
}

tuple_of_observers!(A);
tuple_of_observers!(A, B);
tuple_of_observers!(A, B, C);
tuple_of_observers!(A, B, C, D);
tuple_of_observers!(A, B, C, D, E);
tuple_of_observers!(A, B, C, D, E, F);
tuple_of_observers!(A, B, C, D, E, F, G);
tuple_of_observers!(A, B, C, D, E, F, G, H);
