//! The animation on the page of a sweep: the first replica of its first point, from its start.

use std::ops::ControlFlow;

use carom_methods::{AnySimulation, Method};
use carom_report::page::Page;
use carom_runs::animation;

use crate::point::StudyPoint;

/// Larger scenes have no animation: their bodies would be placed once more for it alone.
const MAX_BODIES: usize = 10_000;

/// Adds the animation of a point to a page. A scene whose gases have to be grown, or with a very
/// large number of bodies, has none.
pub fn show(page: &mut Page, point: &StudyPoint) {
    let scene = point.replica(1);
    let is_small = scene
        .expected_bodies()
        .is_ok_and(|bodies| bodies <= MAX_BODIES);
    let Ok(method) = Method::try_from(&scene.method) else {
        return;
    };
    if !is_small {
        return;
    }
    // An error has ended the replica, too, and is on the page.
    let mut refuse = |_: &carom::engine::Growth| ControlFlow::Break(());
    let Ok(simulation) = AnySimulation::with_progress(&scene, &method, &mut refuse) else {
        return;
    };
    let Ok(animation) = animation::json(&simulation) else {
        return;
    };
    let caption = format!(
        "The first replica of {} from its start: its flights between contacts.",
        point.label
    );
    page.animation(&animation, &caption);
}
