//! A user-defined observer: on the stack, in a box, in a list, and as part of a tuple, it observes
//! the same run.

use std::{cell::Cell, rc::Rc};

use crate::support::{bits, reference_scene, scene, simulate};
use carom_engine::{
    Body, CellScheduler, CollisionReport, Instructions, Observer, RunError, Tag, View,
};

/// The data that an observer has received.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Seen {
    starts: u32,
    collisions: u64,
    /// Sum of the magnitudes of all impulses.
    impulse: f64,
    samples: u32,
    /// Time of the last sample.
    last: f64,
}

/// Counts its calls; its counts can be read while another value owns it.
#[derive(Clone, Default)]
struct Count(Rc<Cell<Seen>>);

impl Count {
    fn add(&self, change: impl FnOnce(&mut Seen)) {
        let mut seen = self.0.get();
        change(&mut seen);
        self.0.set(seen);
    }
}

impl Observer for Count {
    fn start(&mut self, _: &View<'_>) {
        self.add(|seen| seen.starts += 1);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.add(|seen| {
            seen.collisions += 1;
            seen.impulse += report.impulse.length();
        });
    }

    fn sample(&mut self, view: &View<'_>) {
        self.add(|seen| {
            seen.samples += 1;
            seen.last = view.time().to_f64();
        });
    }
}

/// Counts the collisions of the bodies with a tag.
struct OfTag(Tag, Count);

impl Observer for OfTag {
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.iter().any(|body| body.has_tag(self.0))
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if self.watches([report.sides[0].body, report.sides[1].body]) {
            self.1.collision(report);
        }
    }
}

/// Runs the scene with all kinds of bodies with samples; returns its last state.
fn run(observer: &mut dyn Observer) -> Vec<[u64; 6]> {
    let mut simulation = simulate::<CellScheduler>(&reference_scene(5), &Instructions::default());
    simulation.sample_every(0.25, 2.1, observer).unwrap();
    assert_eq!(simulation.time().to_f64(), 2.1);
    bits(&simulation.view())
}

#[test]
fn an_observer_sees_the_same_run_in_each_container() {
    let expected = Count::default();
    let unwatched = run(&mut ());
    assert_eq!(
        run(&mut expected.clone()),
        unwatched,
        "observers change no bit"
    );
    let seen = expected.0.get();
    assert!(seen.collisions > 500 && seen.impulse > 0.0, "{seen:?}");
    assert_eq!((seen.starts, seen.samples, seen.last), (1, 8, 2.0));

    let boxed = Count::default();
    let mut dynamic: Box<dyn Observer> = Box::new(boxed.clone());
    assert_eq!(run(&mut dynamic), unwatched);
    assert_eq!(run(dynamic.as_mut()), unwatched);
    assert_eq!(boxed.0.get().collisions, 2 * seen.collisions);

    let listed = [Count::default(), Count::default()];
    let mut list: Vec<Box<dyn Observer>> = listed
        .iter()
        .map(|count| Box::new(count.clone()) as Box<dyn Observer>)
        .collect();
    run(&mut list);
    let paired = Count::default();
    run(&mut (paired.clone(), Vec::<Count>::new(), None::<Count>));
    for count in listed.iter().chain([&paired]) {
        assert_eq!(count.0.get(), seen);
    }
}

#[test]
fn reports_are_made_only_for_bodies_that_are_watched() {
    let mut scene = reference_scene(5);
    scene.molecule[0].tags = vec!["tee".to_owned()];
    let mut simulation = simulate::<CellScheduler>(&scene, &Instructions::default());
    let tag = simulation.view().tag_names().find("tee").unwrap();
    let (of_tee, all) = (Count::default(), Count::default());
    let observer: &mut dyn Observer = &mut OfTag(tag, of_tee.clone());
    simulation.sample_every(1.0, 3.0, observer).unwrap();
    let mut again = simulate::<CellScheduler>(&scene, &Instructions::default());
    let both: &mut dyn Observer = &mut (OfTag(tag, Count::default()), all.clone());
    again.sample_every(1.0, 3.0, both).unwrap();
    let (of_tee, all) = (of_tee.0.get().collisions, all.0.get().collisions);
    assert!(of_tee > 10 && of_tee < all / 4, "{of_tee} of {all}");
    assert_eq!(all, again.view().counters().collisions);
}

#[test]
fn an_interval_that_is_not_positive_and_finite_is_refused() {
    let mut simulation = simulate::<CellScheduler>(&reference_scene(5), &Instructions::default());
    for interval in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300] {
        let refused = simulation.sample_every(interval, 1.0, &mut ());
        assert!(
            matches!(refused, Err(RunError::Interval(_))),
            "{interval}: {refused:?}"
        );
    }
    assert!(matches!(
        simulation.sample_every(0.1, f64::NAN, &mut ()),
        Err(RunError::Time(_))
    ));
    // An interval longer than the run: no sample is taken, but the run takes place.
    let count = Count::default();
    simulation
        .sample_every(10.0, 0.5, &mut count.clone())
        .unwrap();
    assert_eq!(
        (count.0.get().samples, simulation.time().to_f64()),
        (0, 0.5)
    );
}

/// Records the time of each sample, as a float.
#[derive(Default)]
struct Times(Vec<f64>);

impl Observer for Times {
    fn sample(&mut self, view: &View<'_>) {
        self.0.push(view.time().to_f64());
    }
}

/// Times of the samples of an empty box, starting at `start` (time).
fn times(start: f64, interval: f64, until: f64) -> Vec<f64> {
    let mut simulation = simulate::<CellScheduler>(&scene(Vec::new()), &Instructions::default());
    simulation.run_until(start).unwrap();
    let mut times = Times::default();
    simulation
        .sample_every(interval, until, &mut times)
        .unwrap();
    assert_eq!(simulation.time().to_f64(), until);
    times.0
}

#[test]
fn rounding_loses_no_sample_at_the_end() {
    // 3 × 0.1, 6 × 0.1 and 7 × 0.1 are later than 0.3, 0.6 and 0.7 by a rounding.
    for (until, samples) in [(0.3, 3), (0.6, 6), (0.7, 7), (0.99, 9), (100.0, 1000)] {
        let times = times(0.0, 0.1, until);
        assert_eq!(times.len(), samples, "{until}");
        assert!(times.iter().all(|&time| time <= until), "{times:?}");
        assert!(
            times.is_sorted_by(|one, next| (next - one - 0.1).abs() < 1e-13),
            "{times:?}"
        );
    }
    // The end of the run of an old system is rounded by more than four roundings of the duration.
    for start in [1e6, 1e6 + 0.1, 3e9 + 0.7] {
        let times = times(start, 0.1, start + 0.3);
        assert_eq!((times.len(), times[2]), (3, start + 0.3), "{start}");
    }
}

#[test]
fn an_interval_shorter_than_the_rounding_of_time_takes_no_spurious_sample() {
    for interval in [1e-300, 1e-17, 1.0] {
        assert!(times(1.0, interval, 1.0).is_empty(), "{interval}");
    }
    // Ten intervals fit between 1 and the next float, and are not taken twice.
    let next = 1.0 + f64::EPSILON;
    assert_eq!(times(1.0, 0.1 * f64::EPSILON, next).len(), 10);
}
