//! The cases: generated and recorded encounters of all classes, with the oracle's reference.

use std::sync::OnceLock;

use anyhow::Result;
use carom_detection::encounters::{Class, Encounter};
use carom_tables::Totals;
use carom_testkit::oracle::{DoubleDouble, ExclusionReference, Oracle};
use rayon::prelude::*;

use super::{
    options::EncounterPlan,
    recorder::{Recording, recordings},
};

/// One encounter.
#[derive(Debug)]
pub struct EncounterCase {
    /// The pair.
    pub encounter: Encounter,
    oracle: Oracle,
    /// Computed on first use: it is slow, and a resumed run needs few.
    reference: OnceLock<ExclusionReference<DoubleDouble>>,
}

impl EncounterCase {
    /// Reference of the oracle for the first contact.
    pub fn reference(&self) -> &ExclusionReference<DoubleDouble> {
        self.reference
            .get_or_init(|| self.oracle.first_contact(&self.encounter))
    }
}

/// The cases of one class.
#[derive(Debug)]
pub struct CaseGroup {
    /// Name of the class.
    pub name: String,
    /// Description of the class.
    pub about: String,
    /// The cases.
    pub cases: Vec<EncounterCase>,
}

impl CaseGroup {
    fn new(name: String, about: String, encounters: Vec<Encounter>, oracle: Oracle) -> Self {
        let case = |encounter| EncounterCase {
            encounter,
            oracle,
            reference: OnceLock::new(),
        };
        Self {
            name,
            about,
            cases: encounters.into_iter().map(case).collect(),
        }
    }

    /// Computes the references of all cases on the threads of the current pool.
    pub fn solve(&self) {
        self.cases.par_iter().for_each(|case| {
            case.reference();
        });
    }

    /// Number of cases without a reference from the oracle.
    pub fn unresolved(&self) -> usize {
        self.cases
            .iter()
            .filter(|case| matches!(case.reference(), ExclusionReference::Unresolved))
            .count()
    }
}

/// All groups, and the totals of the runs in which pairs were recorded.
///
/// # Errors
/// A run in which pairs are recorded fails.
pub fn groups(seed: u64, plan: &EncounterPlan) -> Result<(Vec<CaseGroup>, Totals)> {
    let oracle = Oracle {
        most_intervals: plan.most_intervals,
    };
    let draw = |class: Class| {
        let encounters = (0..plan.cases)
            .into_par_iter()
            .map(|index| Encounter::draw(class, seed, index));
        CaseGroup::new(
            class.to_string(),
            about(class),
            encounters.collect(),
            oracle,
        )
    };
    let mut groups: Vec<CaseGroup> = Class::ALL.into_iter().map(draw).collect();
    let recordings = recordings(seed, plan.cases as usize)?;
    let totals = Totals::sum(
        &recordings
            .iter()
            .map(|recording| recording.totals)
            .collect::<Vec<_>>(),
    );
    for Recording {
        name,
        about,
        encounters,
        ..
    } in recordings
    {
        groups.push(CaseGroup::new(
            name.to_owned(),
            about.to_owned(),
            encounters,
            oracle,
        ));
    }
    Ok((groups, totals))
}

/// Short description of a class.
fn about(class: Class) -> String {
    match class {
        Class::DiscT1 => "two small discs, far apart".to_owned(),
        Class::Generic => "1 to 5 atoms each, thermal".to_owned(),
        Class::ZeroOmega => "neither rotates".to_owned(),
        Class::OneOmega => "one rotates".to_owned(),
        Class::LargeOmega => "spins × 1e2 to 1e4".to_owned(),
        Class::ExtremeRatio => "sizes to 1 : 1e6, to 1e6 turns".to_owned(),
        Class::Far => "to 1e6 sizes apart, 1e9 from the origin".to_owned(),
        Class::Annulus => "begins between the other's atoms".to_owned(),
        Class::AfterCollision => "begins in contact, any velocities".to_owned(),
        Class::Rebound => "begins just after a collision".to_owned(),
        Class::Overlap => "begins 0 to 27e-16 deep".to_owned(),
        Class::Fast => "1e4 to 1e8 turns in the window".to_owned(),
        Class::Grazing => "tangential, ±1e-9 to 1e-3 sizes deep".to_owned(),
        Class::Graze(exponent) => format!("tangential, ±1e-{exponent} sizes deep"),
        Class::Recontact(exponent) => format!("leaves a contact, back after 1e-{exponent}"),
        Class::MassRatio => "masses 1 : 1e6".to_owned(),
        Class::SizeRatio => "sizes 1 : 1000".to_owned(),
        Class::Slow => "temperature 1e-12".to_owned(),
        Class::Linear16 => "rods of 16".to_owned(),
        Class::MatchedSpins => "equal spins, constant gap 1e-9 to 1e-2".to_owned(),
        Class::Concentric => "one rotates inside the other, constant gap 1e-9 to 1e-2".to_owned(),
        Class::Rods => "rods of 2 to 256".to_owned(),
        Class::Blobs => "round, 2 to 256 atoms".to_owned(),
        Class::Wall => "comes at a wall or its end".to_owned(),
        Class::WallLargeOmega => "wall, spins × 1e2 to 1e4".to_owned(),
        Class::WallGraze(exponent) => format!("dips into a wall by ±1e-{exponent} sizes"),
        Class::WallRecontact(exponent) => format!("leaves a wall, back after 1e-{exponent}"),
        other => about_edges(other),
    }
}

/// Short description of a class of bodies with edges that turn.
fn about_edges(class: Class) -> String {
    let text = match class {
        Class::Squares => "squares, corners of 1e-9 to 0.1 sides",
        Class::Capsules => "capsules, stout to slender",
        Class::Needles => "capsules with r/L = 1e-6",
        Class::SharpTriangles => "triangles of height 1e-4 to 0.1",
        Class::Polygons => "polygons of 3 to 9 corners, most concave",
        Class::Ells => "L and L",
        Class::SixteenGons => "regular polygons of 16 sides, sizes to 1 : 3.5",
        Class::BondedDiscs => "discs connected by thinner edges",
        Class::DiscAndEdges => "a disc and a body with edges",
        Class::EllInNotch => "L begins in the notch of L",
        Class::RodInSlot => "rod begins in the slot of a fork",
        Class::InsideRing => "begins in a hollow ring of 6 to 24 sides",
        Class::TurningWall => "wall that turns",
        Class::EdgedLargeOmega => "edges, spins of 10 to 300 a passage",
        Class::EdgedFast => "edges, spins of 1e3 to 1e5 a passage",
        Class::ParallelFaces => "faces parallel to within 1e-12 to 1e-3, equal spins",
        Class::EdgedFar => "edges, to 1e6 sizes apart",
        Class::EdgeEnd => "corner within 1e-12 to 1e-2 of the end of an edge",
        Class::CornerGraze(exponent) => {
            return format!("corner passes by ±1e-{exponent} sizes");
        }
        other => return other.to_string(),
    };
    text.to_owned()
}
