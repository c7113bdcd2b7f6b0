//! Runs a case epoch by epoch with one scheduler, together with a copy restored from an encoded
//! checkpoint.

use carom::engine::{Checkpoint, RunError, Violation};
use carom_kinematics::EpochTime;
use carom_methods::{AnySimulation, Order};
use carom_runs::checkpoint_file::{decode, encode};

use super::{
    SceneParts,
    case::{CaseEdit, SceneCase},
    laws::SceneRules,
    watcher::{Logged, Watcher},
};
use crate::fuzz::{random::FuzzDraw, subject::Report};

/// Largest number of epochs; a longer case ends early.
const MAX_EPOCHS: u64 = 40_000;

/// Largest number of contacts, tested after each epoch.
const MAX_CONTACTS: u64 = 6_000;

/// Horizon of the brute-force search in `check_invariants`, as a share of the run.
const AHEAD: f64 = 0.1;

/// Results of a run.
pub struct SceneOutcome {
    /// Findings.
    pub report: Report,
    /// All contacts.
    pub log: Vec<Logged>,
    /// True if the case ran to its end.
    pub whole: bool,
}

/// The simulations of a case.
pub struct Seams<'a> {
    /// Detector and response.
    pub parts: &'a dyn SceneParts,
    /// The scheduler.
    pub order: Order,
    /// The scheduler of the resumed run: another implementation that must give the same bits.
    pub resumed: Order,
}

/// Runs the case; `None` if the scene is refused.
pub fn run(case: &SceneCase, seams: &Seams<'_>) -> Option<SceneOutcome> {
    let mut simulation = seams.parts.start(&case.scene, seams.order).ok()?;
    let mut rules = SceneRules::new(&case.scene);
    let mut watcher = Watcher::new(&simulation.view(), &rules, case);
    let mut draw = FuzzDraw::new(case.seed);
    let mut twin: Option<AnySimulation> = None;
    let mut whole = true;
    let mut until = EpochTime::ZERO;
    for stretch in &case.stretch {
        until = until.new_epoch(stretch.duration);
        let ended = run_stretch(
            &mut simulation,
            &mut twin,
            until,
            &mut watcher,
            &mut draw,
            seams,
        );
        if watcher.is_done() {
            return Some(outcome(watcher, false));
        }
        let error = match &ended {
            Ended::With(error) => Some(error),
            Ended::Reached | Ended::CutShort => None,
        };
        if let Ended::CutShort = ended {
            watcher.report.count("cut short", 1);
        } else {
            compare_twin(&simulation, &mut twin, until, error, &mut watcher);
        }
        watcher.compare(&simulation.view());
        whole = matches!(ended, Ended::Reached);
        check_census(&simulation, stretch.duration, whole, &mut watcher);
        if let Some(error) = error {
            named_end(error, &rules, &mut watcher.report);
        }
        if let Some(RunError::WallsMeet { time, wall, other }) = error {
            watcher.report.count("walls met", 1);
            watcher.check_meeting([wall.key, other.key], *time);
        }
        if watcher.is_done() || !whole {
            break;
        }
        for edit in &stretch.edits {
            let made = apply(edit, &mut simulation, &mut twin, &mut rules, &mut watcher);
            watcher.edited(&simulation.view(), &rules, made.then_some(edit));
        }
    }
    let counters = *simulation.view().counters();
    watcher.report.count("contacts", counters.collisions);
    Some(outcome(watcher, whole))
}

fn outcome(mut watcher: Watcher, whole: bool) -> SceneOutcome {
    SceneOutcome {
        report: std::mem::take(&mut watcher.report),
        log: std::mem::take(&mut watcher.log),
        whole,
    }
}

enum Ended {
    Reached,
    CutShort,
    With(RunError),
}

/// Runs epoch by epoch; at the end of one epoch a copy is resumed from an encoded checkpoint.
fn run_stretch(
    simulation: &mut AnySimulation,
    twin: &mut Option<AnySimulation>,
    until: EpochTime,
    watcher: &mut Watcher,
    draw: &mut FuzzDraw,
    seams: &Seams<'_>,
) -> Ended {
    loop {
        if twin.is_none() && draw.happens(0.2) {
            *twin = resumed(simulation, seams, &mut watcher.report);
        }
        match simulation.observe_epoch(until, watcher) {
            Ok(true) => return Ended::Reached,
            Ok(false) => {}
            Err(error) => return Ended::With(error),
        }
        watcher.epochs += 1;
        if watcher.is_done()
            || watcher.epochs > MAX_EPOCHS
            || simulation.view().counters().collisions > MAX_CONTACTS
        {
            return Ended::CutShort;
        }
    }
}

/// A simulation restored from an encoded checkpoint, if there is one.
fn resumed(
    simulation: &AnySimulation,
    seams: &Seams<'_>,
    report: &mut Report,
) -> Option<AnySimulation> {
    let checkpoint = simulation.checkpoint()?;
    let bytes = encode(&checkpoint).and_then(|bytes| decode::<Checkpoint>(&bytes));
    let resumed = bytes
        .map_err(|error| error.to_string())
        .and_then(|checkpoint| {
            seams
                .parts
                .resume(&checkpoint, seams.resumed)
                .map_err(|error| error.to_string())
        });
    match resumed {
        Ok(resumed) => {
            report.count("resumed", 1);
            Some(resumed)
        }
        Err(error) => {
            report.fail(
                "resume",
                format!("a newly written checkpoint is refused: {error}"),
            );
            None
        }
    }
}

/// Runs the copy to the same time without observers in one call, and compares every bit.
fn compare_twin(
    simulation: &AnySimulation,
    twin: &mut Option<AnySimulation>,
    until: EpochTime,
    error: Option<&RunError>,
    watcher: &mut Watcher,
) {
    let Some(twin) = twin else { return };
    let ended = twin.observe_until_epoch_time(until, &mut ());
    if ended.as_ref().err().map(ToString::to_string) != error.map(ToString::to_string) {
        watcher.report.fail(
            "resume",
            format!("resumed: {ended:?}; uninterrupted: {error:?}"),
        );
    }
    let bits = |simulation: &AnySimulation| {
        let view = simulation.view();
        let motions: Vec<[u64; 8]> = view
            .bodies()
            .map(|body| {
                let motion = body.motion;
                [
                    motion.position.x.to_bits(),
                    motion.position.y.to_bits(),
                    motion.velocity.x.to_bits(),
                    motion.velocity.y.to_bits(),
                    motion.orientation.turns().to_bits(),
                    motion.angular_velocity.to_bits(),
                    body.winding[0] as u64,
                    body.winding[1] as u64,
                ]
            })
            .collect();
        let ledger = view.ledger();
        let ledger = [
            ledger.initial,
            ledger.lost,
            ledger.spared,
            ledger.put_in,
            ledger.heat,
            ledger.work,
            ledger.dragged,
            ledger.fallen,
        ]
        .map(f64::to_bits);
        let counters = view.counters();
        let contacts = [
            counters.collisions,
            counters.fixed_collisions,
            counters.guarded_collisions,
        ];
        (motions, ledger, contacts, view.time().to_f64().to_bits())
    };
    if bits(simulation) != bits(twin) {
        watcher
            .report
            .fail("resume", "a resumed run differs from the uninterrupted one");
    }
}

/// Checks with the engine's own invariants that no pair overlaps, no contact was missed, and the
/// ledger is right.
fn check_census(simulation: &AnySimulation, duration: f64, whole: bool, watcher: &mut Watcher) {
    let overlaps = simulation.view().overlaps();
    if overlaps.pairs > 0 {
        watcher.report.fail("census", format!("{overlaps:?}"));
    }
    if !whole {
        return;
    }
    match simulation.check_invariants(AHEAD * duration) {
        Ok(()) => {}
        // Decided by the independent kinematics: the two differ by rounding for slowly approaching
        // bodies.
        Err(Violation::Missed { time, next, .. }) => {
            watcher.report.count("reported as missed", 1);
            watcher.look_ahead(simulation.time(), time, next);
        }
        // Decided by the watcher, which holds the largest energy so far.
        Err(Violation::Energy { .. }) => watcher.report.count("reported as energy", 1),
        Err(violation) => watcher.report.fail("invariants", violation.to_string()),
    }
}

/// Checks that the scene allows the error that ended a run.
fn named_end(error: &RunError, rules: &SceneRules, report: &mut Report) {
    let elasticity = &rules.elasticity;
    let superelastic = elasticity.adds_energy();
    let moves_walls = rules.moves_walls;
    let allowed = match error {
        RunError::Stalled { .. } => elasticity.contact_time == 0.0 || moves_walls,
        RunError::BlowUp { .. } | RunError::TimeStandsStill { .. } => superelastic || moves_walls,
        RunError::WallsMeet { .. } | RunError::Squeezed { .. } => moves_walls,
        RunError::TimeScalesTooFarApart { .. } => true,
        _ => false,
    };
    report.count("ended by name", 1);
    if !allowed {
        report.fail("ended by name", error.to_string());
    }
}

/// Makes an edit in both simulations; returns false if it is refused.
fn apply(
    edit: &CaseEdit,
    simulation: &mut AnySimulation,
    twin: &mut Option<AnySimulation>,
    rules: &mut SceneRules,
    watcher: &mut Watcher,
) -> bool {
    let made = edit.apply(simulation);
    watcher.report.count("edits", 1);
    if made.is_err() {
        watcher.report.count("refused edits", 1);
    }
    if let Some(twin) = twin {
        let also = edit.apply(twin);
        if made.as_ref().err().map(ToString::to_string)
            != also.as_ref().err().map(ToString::to_string)
        {
            watcher.report.fail(
                "resume",
                format!("{edit:?}: {made:?}, but in the resumed run {also:?}"),
            );
        }
    }
    if made.is_ok() {
        match edit {
            CaseEdit::Elasticity(spec) => rules.elasticity.clone_from(spec),
            CaseEdit::Transparent(pairs) => rules.transparent.clone_from(pairs),
            CaseEdit::Wells(wells) => rules.well.clone_from(wells),
            CaseEdit::Drag(drag) => rules.drag = *drag,
            CaseEdit::Gravity(gravity) => rules.gravity = *gravity,
            CaseEdit::MoveWall(..) => rules.moves_walls = true,
            CaseEdit::AddWall(spec) => rules.moves_walls |= spec.motion.is_some(),
            _ => {}
        }
    }
    made.is_ok()
}
