//! The search for the first contact of two unions of discs in a window of time.

use carom_geometry::Outline;

use crate::{
    ErrorBound, Parts, Phase, SearchWindow, Touch,
    atom_block::BlockSearch,
    circle_descent::{DescentBody, descend},
    disc::disc_contact,
    flight::Flight,
    search::{PairOutcome, Search},
    trace::Recorder,
};

/// Searches bodies that do not turn: each atom pair is a pair of discs.
pub(crate) fn straight<R: Recorder>(
    a: Outline<'_>,
    b: Outline<'_>,
    flight: &Flight<'_>,
    search: &mut Search<R>,
) {
    let (motion, start) = (flight.motion, flight.at(0.0));
    for (i, atom_a) in a.atoms.iter().enumerate() {
        let arm_a = start.arm(0, atom_a.offset());
        for (j, atom_b) in b.atoms.iter().enumerate() {
            let arm_b = start.arm(1, atom_b.offset());
            let d = motion.separation + (arm_b - arm_a);
            let sigma = atom_a.radius() + atom_b.radius();
            let circles = [atom_a.into(), atom_b.into()];
            let error = ErrorBound::of_circles(motion, flight.speed, flight.spin, &circles).at(0.0);
            let time = disc_contact(d, motion.velocity, sigma, (error, motion.velocity_error));
            search.evaluations += 1;
            search
                .recorder
                .concerns(|| Parts::Pair(Touch::Atoms(i as u32, j as u32)));
            search.recorder.step(Phase::ClosedForm, 0.0, Some(time));
            if time <= search.limit() {
                search.record(PairOutcome::Contact(time), [i as u32, j as u32]);
            }
        }
    }
}

/// Searches bodies that turn: all atom pairs at once, or the trees of circles for many atoms.
pub(crate) fn turning<R: Recorder>(
    a: Outline<'_>,
    b: Outline<'_>,
    flight: &Flight<'_>,
    window: SearchWindow,
    search: &mut Search<R>,
) {
    let blocks = BlockSearch::new(flight, [a.bounding_radius, b.bounding_radius]);
    let bodies = [DescentBody::new(&a), DescentBody::new(&b)];
    match bodies.map(DescentBody::only_block) {
        [Some(a), Some(b)] => blocks.search(a, b, window.begin, search),
        _ => descend(&blocks, bodies, window.begin, search),
    }
}
