//! A simulation for Python: every call holds its lock, and a call from another thread meanwhile is
//! refused.

use std::{
    ops::ControlFlow,
    path::PathBuf,
    sync::{
        Mutex, MutexGuard, TryLockError,
        atomic::{AtomicBool, Ordering},
    },
};

use carom::{
    EpochTime,
    engine::{Growth, MeasureParameter, MeasureSpec},
    observers::TagFilter,
};
use carom_methods::{AnySimulation, Method};
use carom_report::page::Page;
use carom_runs::{
    animation,
    measures::{SingleMeasure, Tracked},
    memory::{self, Demand},
    picture_of, resumable,
};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::{
    exceptions::PyValueError,
    prelude::*,
    types::{PyBytes, PyDict, PyTuple},
};

use crate::{
    arrays,
    collisions::{MAX_ROWS, Rows},
    edits::{self, Change},
    errors, records,
    run_loop::{Ended, State},
    scene,
};

/// A simulation with its measures.
#[pyclass(frozen, module = "carom._carom")]
pub struct Core {
    state: Mutex<State>,
    /// Whether a run is in progress, also while it calls Python.
    is_running: AtomicBool,
}

/// The value of a parameter of a measure.
#[derive(FromPyObject)]
enum Parameter {
    Number(f64),
    Text(String),
    Numbers(Vec<f64>),
}

impl From<Parameter> for MeasureParameter {
    fn from(value: Parameter) -> Self {
        match value {
            Parameter::Number(number) => Self::Number(number),
            Parameter::Text(text) => Self::Text(text),
            Parameter::Numbers(numbers) => Self::Numbers(numbers),
        }
    }
}

/// Energy, momentum, temperature, collisions, and energy lost, put in and given as heat.
type Totals = (f64, [f64; 2], Option<f64>, u64, [f64; 9]);

/// Marks a run in progress until it is dropped.
struct Running<'a>(&'a AtomicBool);

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

impl Core {
    fn from_state(state: State) -> Self {
        Self {
            state: Mutex::new(state),
            is_running: AtomicBool::new(false),
        }
    }

    fn lock(&self) -> PyResult<MutexGuard<'_, State>> {
        match self.state.try_lock() {
            Ok(state) => Ok(state),
            Err(TryLockError::WouldBlock) => Err(errors::busy()),
            Err(TryLockError::Poisoned(_)) => Err(errors::RunError::new_err(
                "an internal error has damaged the simulation: create it anew",
            )),
        }
    }

    fn begin_run(&self) -> PyResult<Running<'_>> {
        if self.is_running.swap(true, Ordering::AcqRel) {
            return Err(errors::busy());
        }
        Ok(Running(&self.is_running))
    }

    /// The end of a run: refused if it is past, too late, or not finite.
    fn end_of_run(&self, until: f64) -> PyResult<EpochTime> {
        self.lock()?
            .simulation
            .end_of_run(until)
            .map_err(errors::run)
    }

    /// Makes an edit, and informs the measures.
    fn edit<T: Send>(
        &self,
        py: Python<'_>,
        edit: impl FnOnce(&mut State) -> Result<T, carom::EditError> + Send,
    ) -> PyResult<T> {
        let mut guard = self.lock()?;
        let state: &mut State = &mut guard;
        py.detach(|| {
            state.pause();
            let made = edit(state)?;
            state.edited();
            Ok(made)
        })
        .map_err(|error: carom::EditError| errors::edit(error))
    }

    fn change(&self, py: Python<'_>, ids: &[u64], change: Change<'_>) -> PyResult<()> {
        self.edit(py, |state| {
            edits::change(&mut state.simulation, ids, change)
        })
    }
}

/// Largest side of a picture (pixels).
const MAX_PICTURE: u32 = 16_384;

fn filter(state: &State, between: &[String]) -> PyResult<TagFilter> {
    let view = state.simulation.view();
    let tag = |name: &String| {
        let unknown =
            || errors::EditError::new_err(format!("no body or rule has ever had the tag {name:?}"));
        view.tag_names().find(name).ok_or_else(unknown)
    };
    match between {
        [] => Ok(TagFilter::Any),
        [one] => Ok(TagFilter::One(tag(one)?)),
        [one, other] => Ok(TagFilter::Pair(tag(one)?, tag(other)?)),
        _ => Err(PyValueError::new_err(
            "collisions are between at most two tags",
        )),
    }
}

#[pymethods]
impl Core {
    #[new]
    fn new(py: Python<'_>, text: &str, snapshot: Option<String>) -> PyResult<Self> {
        let scene = scene::parsed(text, snapshot)?;
        Demand::new(&scene)
            .and_then(|demand| demand.refuse_unless_fits(memory::available()))
            .map_err(errors::scene)?;
        let method = Method::try_from(&scene.method)
            .map_err(carom::SceneError::from)
            .map_err(errors::scene)?;
        let mut interrupted = None;
        // Growth to a dense start may take long.
        let mut look = |_: &Growth| match Python::attach(|py| py.check_signals()) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                interrupted = Some(error);
                ControlFlow::Break(())
            }
        };
        let built = py.detach(|| AnySimulation::with_progress(&scene, &method, &mut look));
        match interrupted {
            Some(error) => Err(error),
            None => Ok(Self::from_state(State::new(
                built.map_err(errors::scene)?,
                scene,
            ))),
        }
    }

    /// Sets the number of threads of a run of this system.
    fn set_threads(&self, threads: usize) -> PyResult<()> {
        let mut state = self.lock()?;
        let method = Method::try_from(&state.scene.method)
            .map_err(carom::SceneError::from)
            .map_err(errors::scene)?;
        state.simulation.set_tiling(&method.tiling(threads));
        Ok(())
    }

    /// The simulation at the end, or the last checkpoint, of a file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let path = if path.is_dir() {
            path.join(resumable::CHECKPOINT)
        } else {
            path
        };
        let read = || -> anyhow::Result<State> {
            let (last, data) = resumable::read_state::<Vec<Tracked>>(&path)?;
            let Some(text) = last.what.strip_prefix("run\n") else {
                anyhow::bail!("it is a run of an experiment, not of a scene");
            };
            let mut scene = carom::Scene::from_toml(text)?;
            scene.run = carom::engine::RunSpec {
                until: 1.0,
                ..scene.run
            };
            scene.stage.clear();
            let simulation = AnySimulation::resume(&last.state, &Method::try_from(&scene.method)?)?;
            let mut state = State::new(simulation, scene);
            state.watching.measures = data.unwrap_or_default();
            Ok(state)
        };
        let state = py.detach(read);
        state.map(Self::from_state).map_err(|error| {
            errors::checkpoint(error.context(format!("cannot load {}", path.display())))
        })
    }

    fn copy(&self) -> PyResult<Self> {
        let state = self.lock()?;
        Ok(Self::from_state(State::new(
            state.simulation.clone(),
            state.scene.clone(),
        )))
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let mut guard = self.lock()?;
        let state: &mut State = &mut guard;
        let write = move || {
            let now = state.simulation.end_epoch_here();
            resumable::write_state(&path, &state.scene, now, &state.watching.measures)
        };
        py.detach(write).map_err(errors::checkpoint)
    }

    fn scene(&self) -> PyResult<String> {
        Ok(self.lock()?.scene.to_toml())
    }

    fn time(&self) -> PyResult<f64> {
        Ok(self.lock()?.simulation.time().to_f64())
    }

    fn len(&self) -> PyResult<usize> {
        Ok(self.lock()?.simulation.view().len())
    }

    fn sides(&self) -> PyResult<[f64; 2]> {
        Ok(self.lock()?.simulation.view().bounds().sides().to_array())
    }

    fn tilt(&self) -> PyResult<f64> {
        Ok(self.lock()?.simulation.view().bounds().tilt())
    }

    fn totals(&self) -> PyResult<Totals> {
        let state = self.lock()?;
        let view = state.simulation.view();
        let ledger = view.ledger();
        let booked = [
            ledger.initial,
            ledger.lost,
            ledger.put_in,
            ledger.heat,
            ledger.work,
            ledger.fallen,
            ledger.sheared,
            ledger.wells,
            ledger.dragged,
        ];
        Ok((
            view.energy(),
            view.momentum().to_array(),
            view.temperature(),
            view.counters().collisions,
            booked,
        ))
    }

    /// Each reaction in a line, whether it is in force, and what it has done.
    fn reactions(&self) -> PyResult<Vec<(String, bool, u64, u64, u64, f64)>> {
        let state = self.lock()?;
        let records = state.simulation.view().reactions().iter();
        let row = |one: &carom::engine::ReactionRecord| {
            let counts = one.counts;
            (
                one.spec.equation(),
                one.is_in_force,
                counts.contacts,
                counts.reactions,
                counts.blocked,
                counts.energy,
            )
        };
        Ok(records.map(row).collect())
    }

    /// Number of overlapping pairs.
    fn overlaps(&self) -> PyResult<usize> {
        Ok(self.lock()?.simulation.view().overlaps().pairs)
    }

    fn array<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        arrays::named(py, &self.lock()?.simulation.view(), name)
    }

    fn atoms<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        arrays::atoms(py, &self.lock()?.simulation.view())
    }

    fn tags(&self, py: Python<'_>) -> PyResult<Vec<Py<PyTuple>>> {
        arrays::tags(py, &self.lock()?.simulation.view())
    }

    fn ids_of<'py>(&self, py: Python<'py>, tag: &str) -> PyResult<Bound<'py, PyArray1<u64>>> {
        Ok(PyArray1::from_vec(
            py,
            edits::ids_of(&self.lock()?.simulation, tag)?,
        ))
    }

    fn picture(&self, size: u32) -> PyResult<String> {
        if !(1..=MAX_PICTURE).contains(&size) {
            let words =
                format!("a picture has a side from 1 to {MAX_PICTURE} pixels, but not {size}");
            return Err(PyValueError::new_err(words));
        }
        Ok(picture_of(&self.lock()?.simulation.view(), size))
    }

    /// A page with the motion from now on.
    fn page(&self, py: Python<'_>, title: &str, caption: &str) -> PyResult<String> {
        let guard = self.lock()?;
        // A copy runs ahead, so that the lock is free meanwhile.
        let ahead = guard.simulation.clone();
        drop(guard);
        let json = py
            .detach(move || animation::json(&ahead))
            .map_err(errors::run)?;
        let mut page = Page::new(title, "");
        page.animation(&json, caption);
        Ok(page.html())
    }

    /// Runs to `until`. `progress` receives time and collisions; `callbacks` are called with the
    /// bytes of one report each.
    fn run(
        &self,
        py: Python<'_>,
        until: f64,
        progress: Option<Bound<'_, PyAny>>,
        callbacks: Vec<(Vec<String>, Bound<'_, PyAny>)>,
    ) -> PyResult<()> {
        let running = self.begin_run()?;
        let until = self.end_of_run(until)?;
        if !callbacks.is_empty() {
            return self.run_with_callbacks(py, until, progress, &callbacks);
        }
        let mut guard = self.lock()?;
        let state: &mut State = &mut guard;
        loop {
            let ended = py.detach(|| state.run_piece(until)).map_err(errors::run)?;
            py.check_signals()?;
            if let Some(progress) = &progress {
                let view = state.simulation.view();
                progress.call1((view.time().to_f64(), view.counters().collisions))?;
            }
            if ended == Ended::AtEnd {
                drop(running);
                return Ok(());
            }
        }
    }

    /// Runs through the next collision, if it happens no later than `until`, and returns its
    /// report.
    fn step<'py>(&self, py: Python<'py>, until: f64) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let _running = self.begin_run()?;
        let until = self.end_of_run(until)?;
        let mut guard = self.lock()?;
        let state: &mut State = &mut guard;
        state.watching.rows = Rows {
            filters: vec![TagFilter::Any],
            ..Rows::default()
        };
        let ended = loop {
            let ended = py.detach(|| state.step_piece(until));
            let checked = ended
                .map_err(errors::run)
                .and_then(|ended| py.check_signals().map(|()| ended));
            match checked {
                Ok(Ended::Early) => {}
                other => break other,
            }
        };
        let rows = std::mem::take(&mut state.watching.rows);
        Ok((ended? == Ended::AtCollision).then(|| PyBytes::new(py, &rows.bytes)))
    }

    /// Runs to `until` and returns all collisions between the tags as bytes.
    fn collisions<'py>(
        &self,
        py: Python<'py>,
        until: f64,
        between: Vec<String>,
    ) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let _running = self.begin_run()?;
        let until = self.end_of_run(until)?;
        let mut guard = self.lock()?;
        let state: &mut State = &mut guard;
        let filters = vec![filter(state, &between)?];
        state.watching.rows = Rows {
            filters,
            ..Rows::default()
        };
        let ended = loop {
            match py.detach(|| state.run_piece(until)).map_err(errors::run) {
                Ok(Ended::AtEnd) => break Ok(()),
                Err(error) => break Err(error),
                Ok(_) => {}
            }
            if let Err(error) = py.check_signals() {
                break Err(error);
            }
            if state.watching.rows.len() > MAX_ROWS {
                let words =
                    format!("more than {MAX_ROWS} collisions at once: choose an earlier `until`");
                break Err(errors::RunError::new_err(words));
            }
        };
        let rows = std::mem::take(&mut state.watching.rows);
        ended?;
        Ok(PyArray1::from_vec(py, rows.bytes))
    }

    /// Starts a measure and returns its number.
    fn measure(
        &self,
        kind: &str,
        of: Option<String>,
        name: Option<String>,
        every: f64,
        parameters: Vec<(String, Parameter)>,
    ) -> PyResult<usize> {
        let mut guard = self.lock()?;
        let State {
            simulation,
            scene,
            watching,
            ..
        } = &mut *guard;
        let parameters = parameters
            .into_iter()
            .map(|(key, value)| (key, value.into()))
            .collect();
        let spec = MeasureSpec {
            kind: kind.to_owned(),
            of,
            name,
            parameters,
        };
        let view = simulation.view();
        let measure = SingleMeasure::new(&spec, every, scene, &view).map_err(errors::measure)?;
        watching.measures.push(Tracked::new(measure, &view));
        Ok(watching.measures.len() - 1)
    }

    /// The record of a measure.
    fn results<'py>(&self, py: Python<'py>, measure: usize) -> PyResult<Bound<'py, PyBytes>> {
        let guard = self.lock()?;
        let Some(tracked) = guard.watching.measures.get(measure) else {
            return Err(errors::MeasureError::new_err(format!(
                "there is no measure {measure}"
            )));
        };
        let disturbed = tracked
            .is_disturbed
            .then_some("the system is edited after the start of the measurement");
        let record = tracked
            .measure
            .record(&guard.scene, &guard.simulation.view(), disturbed);
        records::encoded(py, &record)
    }

    /// Ends a measure: it keeps its results.
    fn end_measure(&self, measure: usize) -> PyResult<()> {
        if let Some(tracked) = self.lock()?.watching.measures.get_mut(measure) {
            tracked.is_active = false;
        }
        Ok(())
    }

    fn measures(&self) -> PyResult<usize> {
        Ok(self.lock()?.watching.measures.len())
    }

    fn add<'py>(
        &self,
        py: Python<'py>,
        text: &str,
        motions: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<u64>>> {
        let motions = motions.as_slice()?;
        let ids = self.edit(py, |state| edits::add(&mut state.simulation, text, motions))?;
        Ok(PyArray1::from_vec(py, ids))
    }

    fn add_wall(&self, py: Python<'_>, text: &str) -> PyResult<u64> {
        self.edit(py, |state| edits::add_wall(&mut state.simulation, text))
    }

    fn remove(&self, py: Python<'_>, ids: PyReadonlyArray1<'_, u64>) -> PyResult<()> {
        self.change(py, ids.as_slice()?, Change::Remove)
    }

    fn lock_rotation(&self, py: Python<'_>, ids: PyReadonlyArray1<'_, u64>) -> PyResult<()> {
        self.change(py, ids.as_slice()?, Change::Lock)
    }

    fn unlock_rotation(&self, py: Python<'_>, ids: PyReadonlyArray1<'_, u64>) -> PyResult<()> {
        self.change(py, ids.as_slice()?, Change::Unlock)
    }

    fn bond(&self, py: Python<'_>, text: &str) -> PyResult<()> {
        self.edit(py, |state| {
            let bonds = edits::bonds(text)?;
            state
                .simulation
                .edit(|batch| bonds.iter().try_for_each(|bond| batch.bond(bond)))
        })
    }

    fn unbond(&self, py: Python<'_>, ids: PyReadonlyArray1<'_, u64>) -> PyResult<()> {
        let keys: Vec<_> = ids
            .as_slice()?
            .iter()
            .map(|&id| carom::BodyKey::of_id(id))
            .collect();
        self.edit(py, |state| {
            state.simulation.edit(|batch| batch.unbond(&keys))
        })
    }

    /// The two bodies of each bond by their numbers, and the distance of its points (length).
    fn bonds(&self) -> PyResult<Vec<([u64; 2], f64)>> {
        let state = self.lock()?;
        let view = state.simulation.view();
        let bonds = view.bonds();
        Ok(bonds
            .map(|bond| (bond.bodies.map(carom::BodyKey::id), bond.length))
            .collect())
    }

    fn set_wells(&self, py: Python<'_>, text: &str) -> PyResult<()> {
        self.edit(py, |state| {
            let wells = edits::wells(text)?;
            state.simulation.edit(|batch| batch.set_wells(&wells))
        })
    }

    /// The two discs of each pair within the range of its well by their numbers, the step, and the
    /// energy.
    fn pairs_in_wells(&self) -> PyResult<Vec<([u64; 2], usize, f64)>> {
        let state = self.lock()?;
        let pairs = state.simulation.view().pairs_in_wells();
        Ok(pairs
            .map(|pair| (pair.bodies.map(carom::BodyKey::id), pair.step, pair.energy))
            .collect())
    }

    fn tag(&self, py: Python<'_>, ids: PyReadonlyArray1<'_, u64>, name: &str) -> PyResult<()> {
        self.change(py, ids.as_slice()?, Change::Tag(name))
    }

    fn untag(&self, py: Python<'_>, ids: PyReadonlyArray1<'_, u64>, name: &str) -> PyResult<()> {
        self.change(py, ids.as_slice()?, Change::Untag(name))
    }

    fn set_energy(
        &self,
        py: Python<'_>,
        ids: PyReadonlyArray1<'_, u64>,
        energies: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let (ids, energies) = (ids.as_slice()?, energies.as_slice()?);
        self.edit(py, |state| {
            edits::set_energies(&mut state.simulation, ids, energies)
        })
    }

    fn set_velocity(
        &self,
        py: Python<'_>,
        ids: PyReadonlyArray1<'_, u64>,
        velocities: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let (ids, velocities) = (ids.as_slice()?, velocities.as_slice()?);
        self.edit(py, |state| {
            edits::set_velocities(&mut state.simulation, ids, velocities)
        })
    }

    fn set_angular_velocity(
        &self,
        py: Python<'_>,
        ids: PyReadonlyArray1<'_, u64>,
        angular_velocities: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let (ids, spins) = (ids.as_slice()?, angular_velocities.as_slice()?);
        self.edit(py, |state| {
            edits::set_angular_velocities(&mut state.simulation, ids, spins)
        })
    }

    fn set_elasticity(&self, py: Python<'_>, text: &str) -> PyResult<()> {
        self.edit(py, |state| {
            let spec = edits::elasticity(text)?;
            state.simulation.set_elasticity(&spec)?;
            state.scene.elasticity = spec;
            Ok(())
        })
    }

    fn set_reactions(&self, py: Python<'_>, text: &str) -> PyResult<()> {
        self.edit(py, |state| {
            let rules = edits::reactions(text)?;
            state.simulation.edit(|batch| batch.set_reactions(&rules))?;
            state.scene.reaction = rules;
            Ok(())
        })
    }

    fn set_transparent(&self, py: Python<'_>, text: &str) -> PyResult<()> {
        self.edit(py, |state| {
            let rules = edits::transparent(text)?;
            state
                .simulation
                .edit(|batch| batch.set_transparent(&rules))?;
            state.scene.transparent = rules;
            Ok(())
        })
    }

    fn thermostat(&self, py: Python<'_>, text: &str) -> PyResult<()> {
        self.edit(py, |state| {
            edits::act(&mut state.simulation, &state.scene, text)
        })
    }

    fn set_drag(&self, py: Python<'_>, drag: f64) -> PyResult<()> {
        self.edit(py, |state| {
            state.simulation.set_drag(drag)?;
            state.scene.bounds.drag = drag;
            Ok(())
        })
    }

    fn move_walls(
        &self,
        py: Python<'_>,
        ids: PyReadonlyArray1<'_, u64>,
        text: &str,
    ) -> PyResult<()> {
        let ids = ids.as_slice()?;
        self.edit(py, |state| {
            edits::move_walls(&mut state.simulation, ids, text)
        })
    }

    fn push_pistons(
        &self,
        py: Python<'_>,
        ids: PyReadonlyArray1<'_, u64>,
        force: f64,
    ) -> PyResult<()> {
        let ids = ids.as_slice()?;
        self.edit(py, |state| {
            edits::push_pistons(&mut state.simulation, ids, force)
        })
    }

    fn set_gravity(&self, py: Python<'_>, gravity: [f64; 2]) -> PyResult<()> {
        self.edit(py, |state| {
            state.simulation.set_gravity(gravity)?;
            state.scene.gravity.acceleration = gravity;
            Ok(())
        })
    }

    fn set_shear_rate(&self, py: Python<'_>, rate: f64) -> PyResult<()> {
        self.edit(py, |state| {
            state.simulation.set_shear_rate(rate)?;
            state.scene.bounds.shear_rate = rate;
            Ok(())
        })
    }

    fn reverse(&self, py: Python<'_>) -> PyResult<()> {
        self.edit(py, |state| {
            state.simulation.reverse();
            Ok(())
        })
    }
}

impl Core {
    /// Calls Python after each collision that a filter admits; the lock is free meanwhile, so that
    /// the callback can read and edit the simulation.
    fn run_with_callbacks(
        &self,
        py: Python<'_>,
        until: EpochTime,
        progress: Option<Bound<'_, PyAny>>,
        callbacks: &[(Vec<String>, Bound<'_, PyAny>)],
    ) -> PyResult<()> {
        loop {
            let mut guard = self.lock()?;
            let state: &mut State = &mut guard;
            let filters: PyResult<Vec<TagFilter>> = callbacks
                .iter()
                .map(|(between, _)| filter(state, between))
                .collect();
            state.watching.rows = Rows {
                filters: filters?,
                bytes: Vec::new(),
                admitted: Some(Vec::new()),
            };
            let ended = py.detach(|| state.step_piece(until));
            let rows = std::mem::take(&mut state.watching.rows);
            let view = state.simulation.view();
            let now = (view.time().to_f64(), view.counters().collisions);
            drop(guard);
            let ended = ended.map_err(errors::run)?;
            py.check_signals()?;
            if ended != Ended::AtCollision
                && let Some(progress) = &progress
            {
                progress.call1(now)?;
            }
            for index in rows.admitted.into_iter().flatten().flatten() {
                callbacks[index].1.call1((PyBytes::new(py, &rows.bytes),))?;
            }
            if ended == Ended::AtEnd {
                return Ok(());
            }
        }
    }
}
