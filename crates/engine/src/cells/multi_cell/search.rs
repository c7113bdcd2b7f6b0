//! The earliest contact of a multi-cell body: candidates in the order of their lower bounds, each
//! searched up to the earliest event found so far.
//!
//! The broad phase has two steps. The first gives lower bounds for eight bodies at a time, from
//! their bounding circles and the molecule's rectangle ([`Detection::contact_time_lower_bounds`]).
//! The second gives a tighter bound for one disc, from the molecule's atoms, when its bound is the
//! lowest ([`Detection::contact_time_lower_bound`]). A disc in a covered cell tests the multi-cell
//! bodies of the cell one by one: by their bounding circles, then by their atoms.

use carom_detection::{DISC_LANES, Detection, QueryBody};
use carom_kinematics::HALF_ULP;
use glam::DVec2;

use super::{EarliestEvent, Listed, MultiCellBody, Surroundings};
use crate::{
    cells::{
        body_record::RecordKind,
        candidates::{Candidate, Candidates},
        dispatch::dispatched,
        frame::CellFrame,
        simd::Kernel,
        state::CellState,
    },
    world::World,
};

dispatched!(predict_multi_cell(body: u32, now: f64, except: Option<u32>));
dispatched!(search_listed_bodies(disc: u32, cell: u32, now: f64, except: Option<u32>));

impl<F: CellFrame> CellState<F> {
    /// Finds the earliest event of a multi-cell body: a contact, a re-check, or the exit from its
    /// shell.
    #[inline(always)]
    pub(in crate::cells) fn predict_multi_cell<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        body: u32,
        now: f64,
        except: Option<u32>,
    ) {
        let Some(index) = self.multi_cell.get(body) else {
            return;
        };
        let multi_cell_body = &self.multi_cell.list[index];
        let mut best = self.event_without_contacts(world, multi_cell_body, now);
        if multi_cell_body.is_disc_among_discs {
            let pairs = self.search_discs_around(
                kernel,
                world,
                detection,
                multi_cell_body,
                now,
                except,
                &mut best,
            );
            self.count_pairs(body, pairs);
            if self.multi_cell.are_large_discs() && detection.decides_discs_in_closed_form() {
                return self.store_event(body, &best);
            }
        }
        let mut around = std::mem::take(&mut self.multi_cell.around);
        around.clear();
        let multi_cell_body = &self.multi_cell.list[index];
        if !multi_cell_body.is_disc_among_discs {
            self.gather_discs(multi_cell_body, &mut around);
        }
        let in_closed_form =
            multi_cell_body.is_disc_among_discs && detection.decides_discs_in_closed_form();
        self.gather_neighbours(multi_cell_body, in_closed_form, &mut around);
        let outline = self.molecule(world, body).outline();
        let motion = multi_cell_body.motion;
        let query_body = QueryBody::new(outline, &motion, now);
        self.bound_candidates(
            kernel,
            world,
            detection,
            (index, now, except),
            &query_body,
            &mut around,
            &best,
        );
        let horizon = best.time - now;
        let tighter = |state: &Self, other: Listed| {
            let lanes = state.lanes::<1>(body, &[other], now);
            detection.contact_time_lower_bound(&query_body, &lanes, horizon)
        };
        self.search_candidates(
            world,
            detection,
            (body, now),
            &mut around.candidates,
            tighter,
            &mut best,
        );
        self.multi_cell.around = around;
        self.store_event(body, &best);
    }

    /// Moves the bodies around a multi-cell body, given by its place in the list, to the
    /// candidates, with lower bounds on the times of their contacts; without those that it cannot
    /// touch before its best event. `except` is a partner to skip.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "the kernel, of size 0, is the eighth"
    )]
    fn bound_candidates<D: Detection, K: Kernel>(
        &self,
        kernel: K,
        world: &World,
        detection: &D,
        (index, now, except): (usize, f64, Option<u32>),
        query_body: &QueryBody<'_>,
        around: &mut Surroundings,
        best: &EarliestEvent,
    ) {
        let multi_cell_body = &self.multi_cell.list[index];
        let body = multi_cell_body.body;
        let horizon = best.time - now;
        let query = self.multi_cell_query(body, now);
        let Surroundings {
            slots,
            seen,
            candidates,
        } = around;
        if multi_cell_body.is_piston() {
            let around = (&mut *slots, &mut *seen);
            self.bound_by_speeds(multi_cell_body, (now, except), around, candidates, best);
        }
        slots.resize(slots.len().next_multiple_of(DISC_LANES), self.dummy());
        for eight in slots.as_chunks::<DISC_LANES>().0 {
            let bounds = detection.contact_time_lower_bounds(
                query_body,
                &kernel.lanes(&query, eight, false),
                horizon,
            );
            candidates.sift(
                bounds,
                |bound| best.is_after(now, bound),
                |lane| {
                    (Some(eight[lane]) != except).then_some(Listed {
                        index: eight[lane],
                        image: [0; 2],
                    })
                },
            );
        }
        let driven = self.driven_neighbours(multi_cell_body, except);
        driven.for_each(|item| candidates.push(Candidate::unbounded(item)));
        for some in seen.chunks(DISC_LANES) {
            let bounds = detection.contact_time_lower_bounds(
                query_body,
                &self.lanes::<DISC_LANES>(body, some, now),
                horizon,
            );
            candidates.sift(
                bounds,
                |bound| best.is_after(now, bound),
                |lane| {
                    some.get(lane)
                        .copied()
                        .filter(|other| Some(other.index) != except)
                },
            );
        }
        if world.pairs.is_active() {
            candidates.retain(|other| self.pair_factor(world, [body, other.index]) > 0.0);
        }
    }

    /// Searches the candidates for the earliest contact of a multi-cell body. `tighter` is a bound
    /// on the time of a contact with a disc that takes longer to compute than those so far.
    #[inline(always)]
    fn search_candidates<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        (body, now): (u32, f64),
        candidates: &mut Candidates<Listed>,
        tighter: impl Fn(&Self, Listed) -> f64,
        best: &mut EarliestEvent,
    ) {
        // Lowest bound first: most candidates then need no search.
        while let Some(candidate) = candidates.take_least(|listed| listed.index) {
            let Candidate {
                bound,
                item: other,
                is_tight,
            } = candidate;
            if !best.is_after(now, bound) || now + bound >= self.limit {
                break;
            }
            if !is_tight && self.molecule(world, other.index).is_disc() {
                let bound_of_disc = tighter(self, other);
                if bound_of_disc > bound {
                    candidates.push(Candidate {
                        bound: bound_of_disc,
                        is_tight: true,
                        ..candidate
                    });
                    continue;
                }
            }
            self.search(world, detection, body, &candidate, now, best);
        }
    }

    /// The event of a body without contacts: it leaves its shell, or a piston reaches a stop.
    #[inline(always)]
    fn event_without_contacts(
        &self,
        world: &World,
        multi_cell_body: &MultiCellBody,
        now: f64,
    ) -> EarliestEvent {
        if multi_cell_body.is_piston() {
            return self.first_event_of_piston(world, multi_cell_body, now);
        }
        EarliestEvent::before(leaves_shell(multi_cell_body, now), RecordKind::Shell)
    }

    /// The event of a piston without contacts: it reaches a stop, or leaves its strip.
    #[cold]
    fn first_event_of_piston(
        &self,
        world: &World,
        piston: &MultiCellBody,
        now: f64,
    ) -> EarliestEvent {
        let speed = piston.max_speed(self.limit);
        let way = (piston.motion_at(now).position - piston.centre).length();
        let left = (piston.shell * (1.0 - 1e-9) - way).max(0.0);
        let leaves = if speed == 0.0 {
            f64::INFINITY
        } else {
            now + left / speed
        };
        let stop = world.stop_time(piston.body, &piston.motion, now);
        if stop <= leaves {
            EarliestEvent::before(stop, RecordKind::Stop)
        } else {
            EarliestEvent::before(leaves, RecordKind::Shell)
        }
    }

    /// Moves the bodies around a piston to the candidates, with the time in which they come
    /// together along its normal: at their present speeds, or at their top speeds if a force pushes
    /// it; without those that it cannot touch before its best event. `except` is a partner to skip.
    #[inline(never)]
    fn bound_by_speeds(
        &self,
        piston: &MultiCellBody,
        (now, except): (f64, Option<u32>),
        (slots, seen): (&mut Vec<u32>, &mut Vec<Listed>),
        candidates: &mut Candidates<Listed>,
        best: &EarliestEvent,
    ) {
        let Some(wall) = &piston.wall else { return };
        let [first, second] = wall.ends();
        let normal = (second - first).normalize_or_zero().perp();
        let here = piston.motion_at(now).position;
        let driven = piston.drive.map(|_| piston.max_speed(self.limit));
        let unshifted = slots.drain(..).map(|index| Listed {
            index,
            image: [0; 2],
        });
        for other in unshifted.chain(seen.drain(..)) {
            if other.index == self.dummy() || Some(other.index) == except {
                continue;
            }
            let record = &self.records[other.index as usize];
            let shift = DVec2::new(
                f64::from(other.image[0]) * self.sides[0],
                f64::from(other.image[1]) * self.sides[1],
            );
            let place = record.origin() + record.velocity() * now + shift;
            let way = (place - here).dot(normal);
            let distance = way.abs() - record.radius() - wall.radius();
            let left = (distance * (1.0 - 1e-9) - self.separation_error).max(0.0);
            let speed = if let Some(top_speed) = driven {
                top_speed + record.velocity().length()
            } else {
                let apart = (record.velocity() - piston.motion.velocity).dot(normal);
                let speeds = record.velocity().length() + piston.motion.velocity.length();
                // At least the rounding of the speed of approach.
                (-apart * way.signum()).max(0.0) + 16.0 * HALF_ULP * speeds
            };
            // A body that turns in place may reach a piston at rest.
            let bound = if left > 0.0 { left / speed } else { 0.0 };
            if best.is_after(now, bound) {
                candidates.push(Candidate {
                    bound,
                    item: other,
                    is_tight: true,
                });
            }
        }
    }

    /// The neighbours of a body for which no bound of the broad phase holds, because they are
    /// driven.
    fn driven_neighbours(
        &self,
        multi_cell_body: &MultiCellBody,
        except: Option<u32>,
    ) -> impl Iterator<Item = Listed> {
        let neighbours = multi_cell_body.neighbours.iter();
        neighbours.filter_map(move |neighbour| {
            let other = &self.multi_cell.list[neighbour.index as usize];
            let is_one = other.drive.is_some() && Some(other.body) != except;
            is_one.then_some(Listed {
                index: other.body,
                image: neighbour.image,
            })
        })
    }

    /// Collects the neighbours of a multi-cell body that are not driven; discs only if contacts of
    /// two discs are not in closed form.
    #[inline(always)]
    fn gather_neighbours(
        &self,
        multi_cell_body: &MultiCellBody,
        in_closed_form: bool,
        around: &mut Surroundings,
    ) {
        for neighbour in &multi_cell_body.neighbours {
            let other = &self.multi_cell.list[neighbour.index as usize];
            if other.drive.is_none() && !(in_closed_form && other.is_disc_among_discs) {
                around.seen.push(Listed {
                    index: other.body,
                    image: neighbour.image,
                });
            }
        }
    }

    /// Collects the discs around a multi-cell body from the neighbour lists of its tiles.
    fn gather_discs(&self, multi_cell_body: &MultiCellBody, around: &mut Surroundings) {
        if multi_cell_body.is_piston() {
            for cell in &multi_cell_body.cells {
                let inside = self.bodies_in(cell.index);
                if cell.image == [0; 2] {
                    around.slots.extend(inside);
                } else {
                    around.seen.extend(inside.map(|index| Listed {
                        index,
                        image: cell.image,
                    }));
                }
            }
            return;
        }
        for tile in &multi_cell_body.tiles {
            let list = self.neighbour_lists.list_of(tile.index);
            if tile.image == [0; 2] && !list.at_border {
                list.append_to(&mut around.slots);
            } else {
                around.seen.extend(self.seen_from(*tile));
            }
        }
    }

    /// Finds contacts of a disc with the multi-cell bodies listed in its cell, all of them large
    /// discs, before its present event. Returns the time of its earliest event.
    #[inline(never)]
    pub(in crate::cells) fn search_large_discs(&mut self, disc: u32, cell: u32, now: f64) -> f64 {
        let mut best = self.stored_event(disc);
        for place in 0..self.multi_cell.covered.count(cell) {
            let Listed { index, image } = self.multi_cell.covered.get(cell, place);
            // `image` is that of the disc as seen from the large disc; the other way it has the
            // opposite sign.
            self.test_large_disc(
                disc,
                Listed {
                    index,
                    image: image.map(|boxes| -boxes),
                },
                1.0,
                now,
                &mut best,
            );
        }
        if best.kind == RecordKind::MultiCell {
            self.store_event(disc, &best);
        }
        best.time
    }

    /// Finds contacts of a disc with the multi-cell bodies listed in its cell, before its present
    /// event, and stores the earliest.
    #[cold]
    #[inline(never)]
    pub(in crate::cells) fn search_covered_cell<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        disc: u32,
        cell: u32,
        now: f64,
        except: Option<u32>,
    ) {
        search_listed_bodies(self, world, detection, disc, cell, now, except);
    }

    /// Implementation of [`Self::search_covered_cell`] for one instruction set.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "the kernel, of size 0, is the eighth"
    )]
    pub(in crate::cells) fn search_listed_bodies<D: Detection, K: Kernel>(
        &mut self,
        _: K,
        world: &World,
        detection: &D,
        disc: u32,
        cell: u32,
        now: f64,
        except: Option<u32>,
    ) {
        let mut best = self.stored_event(disc);
        let by_pair = world.pairs.is_active();
        // One horizon for all bodies: the bounds must not depend on the order of the tests.
        let horizon = best.time - now;
        for place in 0..self.multi_cell.covered.count(cell) {
            let listed = self.multi_cell.covered.get(cell, place);
            let other = listed.index;
            if Some(other) == except {
                continue;
            }
            let factor = if by_pair {
                self.pair_factor(world, [disc, other])
            } else {
                1.0
            };
            if factor == 0.0 {
                continue;
            }
            // `listed.image` is that of the disc as seen from the multi-cell body; the other way it
            // has the opposite sign.
            let image = listed.image.map(|boxes| -boxes);
            let multi_cell_body =
                &self.multi_cell.list[self.multi_cell.index_of[other as usize].index()];
            if multi_cell_body.drive.is_some() {
                // No bound of the broad phase holds for it.
                let candidate = Candidate::unbounded(Listed {
                    index: other,
                    image,
                });
                self.search(world, detection, disc, &candidate, now, &mut best);
            } else if multi_cell_body.is_disc_among_discs
                && detection.decides_discs_in_closed_form()
            {
                self.test_large_disc(
                    disc,
                    Listed {
                        index: other,
                        image,
                    },
                    factor,
                    now,
                    &mut best,
                );
            } else {
                let seen = [Listed {
                    index: disc,
                    image: listed.image,
                }];
                let lanes = self.lanes::<1>(other, &seen, now);
                // Most are excluded by the bounding circle alone, which does not need the
                // molecule's rotation.
                let [entry] = lanes.entry_times();
                if !best.is_after(now, entry) {
                    continue;
                }
                let outline = self.molecule(world, other).outline();
                let query_body = QueryBody::new(outline, &multi_cell_body.motion, now);
                let is_disc = self.molecule(world, disc).is_disc();
                let tighter = if is_disc {
                    detection.contact_time_lower_bound(&query_body, &lanes, horizon)
                } else {
                    detection.contact_time_lower_bounds(&query_body, &lanes, horizon)[0]
                };
                let bound = if tighter > entry { tighter } else { entry };
                if best.is_after(now, bound) {
                    let candidate = Candidate {
                        bound,
                        item: Listed {
                            index: other,
                            image,
                        },
                        is_tight: true,
                    };
                    self.search(world, detection, disc, &candidate, now, &mut best);
                }
            }
        }
        if matches!(best.kind, RecordKind::MultiCell | RecordKind::Recheck) {
            self.store_event(disc, &best);
        }
    }
}

/// Time at which a body's centre leaves its shell (offset in the epoch): slightly early, never
/// late.
fn leaves_shell(multi_cell_body: &MultiCellBody, now: f64) -> f64 {
    let d = multi_cell_body.motion.position_at(now) - multi_cell_body.centre;
    let v = multi_cell_body.motion.velocity;
    let v_squared = v.length_squared();
    if v_squared == 0.0 {
        return f64::INFINITY;
    }
    let shell = multi_cell_body.shell * (1.0 - 1e-9);
    let b = d.dot(v);
    let inside = (shell * shell - d.length_squared()).max(0.0);
    let root = (b * b + v_squared * inside).sqrt();
    // The later root of |d + v t| = h, in the form without cancellation.
    let stay = if b > 0.0 {
        inside / (b + root)
    } else {
        (root - b) / v_squared
    };
    now + stay
}
