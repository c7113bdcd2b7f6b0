//! The numerical parameters of all searches, each with its purpose and the effect of changing it.
//!
//! All except `MIN_JERK` and `MIN_SQUARE` are relative or counts, so that velocities times a
//! power of two give the same bits.

use carom_kinematics::HALF_ULP;

/// Relative shortening of each certified step and window edge, to cover the rounding of the step
/// itself (about twelve operations). Smaller: the proof fails by a unit in the last place. Larger:
/// slower, no less exact.
pub(crate) const STEP_MARGIN: f64 = 16.0 * HALF_ULP;

/// Step limit of [`Exact`](crate::Exact) for one atom pair; a search that reaches it ends as
/// "certified free until". Ordinary pairs take 5 to 30 steps, grazes up to 80. Smaller: more
/// re-checks. Larger: a pair that moves at a constant gap of rounding size makes one query slower.
pub const MAX_STEPS: u32 = 4096;

/// The number of first steps of an atom pair that do not look farther ahead for better bounds on
/// the curvature. Smaller: ordinary pairs cost more. Larger: grazes and pairs with matched angular
/// velocities cost more.
pub(crate) const SHORT_STEPS: u32 = 6;

/// The most further steps of all atom pairs together, after the first: one for each atom of the
/// smaller body but the first, up to this number. Fewer: more pairs are searched one by one. More:
/// unneeded steps of pairs that are already excluded.
pub(crate) const SHARED_STEPS: usize = 2;

/// Most doublings of one certified step while better bounds on the curvature still lengthen it.
/// Smaller than about 15: pairs with matched angular velocities take many steps.
pub(crate) const MAX_DOUBLINGS: u32 = 20;

/// Two circles of the tree are split where their gap is below this share of the sum of their radii.
/// Smaller: more steps before a split. Larger: splits that one further step would have avoided.
pub(crate) const NEARNESS: f64 = 0.2;

/// A body turns fast for [`Exact`](crate::Exact) if it turns by more than this angle (radians)
/// while an atom of the other body moves by its own arm. The orbit of its atom is then tested, too.
/// Smaller: unneeded work for ordinary pairs. Larger: more steps for fast rotors.
pub(crate) const FAST_ROTOR: f64 = 2.0;

/// Bounds on third derivatives below this are not used: products of three velocities close to the
/// smallest float have lost digits. Smaller than about 10⁻³⁰⁷: steps of the slowest rotors are too
/// long. Larger: steps of slow bodies are shorter.
pub(crate) const MIN_JERK: f64 = 1e-300;

/// Squares below this have lost digits to underflow; the length is then bounded by |x| + |y|
/// instead of √(x² + y²).
pub(crate) const MIN_SQUARE: f64 = 1e-280;

/// How many times the rounding bound E the sum of two radii must be for the bound on the third
/// derivative of the gap to be used. That bound assumes |d| ≥ (1 − 1/64) s up to the first contact,
/// while |d| ≥ s − 2 E is proved. Smaller than 128: the proof fails. Larger: more steps for tiny
/// atoms.
pub(crate) const MIN_ATOM_ERRORS: f64 = 128.0;

/// A touching pair that is deeper than this share of its rounding bound is deep. It is in contact
/// however slowly it closes. Larger: bodies that rest on each other overlap by more. Smaller:
/// contacts of bodies that slide on each other occur at random times.
pub(crate) const RESTING_DEPTH: f64 = 0.125;

/// A pair that may return within this share of the time in which it moves by its own size is
/// searched by its gap relative to the contact that it leaves. Smaller than 10⁻⁷: rattling pairs
/// lose digits of the interval. Larger: unneeded work.
pub(crate) const SOON: f64 = 1e-3;

/// Step limit of that search; past it the ordinary search continues.
pub(crate) const MAX_RECONTACT_STEPS: u32 = 64;

/// Relative tolerance of the golden-section search and of the secant method: five machine epsilon
/// (Montanari 2017, appendix A), relative to the time of the result. Smaller than about 2 epsilon:
/// neither search can end before its limit of rounds.
pub const THESIS_TOLERANCE: f64 = 5.0 * f64::EPSILON;

/// Length of a segment of [`GoldenSecant`](crate::GoldenSecant) as a share of the shortest quarter
/// period: the 1/2 of equation 2.4, Montanari (2017). Smaller: more segments, and fewer dips that
/// share one.
pub const CROP_FACTOR: f64 = 0.5;

/// Most separating lines that one search tries before it looks at pairs of parts. Smaller: bodies
/// that pass closely cost more. Larger: no effect on most pairs.
pub(crate) const MAX_LINES: u32 = 64;

/// Parts within this share of the sum of the bounding radii of a contact that a line has found are
/// searched as well, since their smaller rounding may decide. Smaller than the root of the rounding
/// of a gap times the radius of a corner: contacts of edge and end are confused. Larger: such
/// contacts cost more.
pub(crate) const NEAR_OTHERS: f64 = 1e-6;

/// Two bodies of at most this number of pairs of atoms are searched as a whole where no line
/// separates them: two capsules, or a disc and a polygon of four corners. Smaller: capsules cost
/// more. Larger: polygons do.
pub(crate) const FEW_PAIRS: usize = 4;

/// A corner that is nearer to a separating line than this share of the sum of the bounding radii is
/// searched by itself. Smaller: more lines for slow approaches. Larger: searches of corners that
/// another line would have kept apart.
pub(crate) const NEAR_LINE: f64 = 1e-3;

/// Limit of rounds of one golden section (75 for five epsilon) or one secant (10; 210 with
/// bisections only). Smaller: searches end unresolved.
pub const MAX_ROUNDS: u32 = 250;

/// Limit of segments in one window: 512 turns of the faster body. Smaller: fast rotors end
/// unresolved. Larger: one query can take seconds, since each atom pair costs about 80 evaluations
/// per segment.
pub const MAX_SEGMENTS: u32 = 4096;

/// The share of its length by which the window of [`GoldenSecant`](crate::GoldenSecant) begins
/// earlier. Zero: two discs, whose bounding circles are the atoms, touch where the window begins,
/// and rounding loses the contact.
pub(crate) const WINDOW_MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// Step of [`FixedStep`](crate::FixedStep) in natural times of the pair. Larger: grazes and
/// contacts of thin atoms are missed.
pub const FIXED_STEP: f64 = 1e-3;

/// Step limit of [`FixedStep`](crate::FixedStep) in one window: a thousand natural times. Smaller:
/// slow pairs that turn end unresolved.
pub const MAX_FIXED_STEPS: u32 = 1 << 20;

/// Limit of bisections inside one fixed step: enough to reach neighbouring floats, unless the step
/// begins at a time many orders of magnitude later than its length.
pub(crate) const MAX_BISECTIONS: u32 = 128;
