//! All numbers on which a search depends: what each is for and what breaks if it changes.
//!
//! All but one ([`LEAST_JERK`]) are relative or counts, so that velocities times a power of two give the same bits.

use carom_kinematics::HALF_ULP;

/// Relative shortening of each certified step and window edge, against the rounding of the step
/// itself (a dozen operations). Smaller: the proof has a hole of an ulp. Larger: slower, no less exact.
pub const STEP_MARGIN: f64 = 16.0 * HALF_ULP;

/// Most steps that [`Exact`](crate::Exact) takes for one atom pair before it answers "certified free
/// until". Ordinary pairs take 5 to 30, grazes up to 80. Smaller: more re-checks. Larger: a pair that
/// flies along at a constant gap of rounding size keeps one query busy for longer.
pub const MOST_STEPS: u32 = 4096;

/// How many steps of an atom pair are not lengthened by looking farther ahead for better bounds on its curvature.
/// Smaller: ordinary pairs cost more. Larger: so do grazes and pairs with matched spins.
pub const SHORT_STEPS: u32 = 6;

/// After the first step of all atom pairs together, at most this many more are taken so: one for each atom of the
/// smaller body but the first. Fewer: more pairs are followed one by one. More: steps of pairs that are of no interest any
/// more.
pub const SHARED_STEPS: usize = 2;

/// Most doublings of one certified step while better bounds on the curvature still lengthen it. Smaller than
/// about 15: pairs that fly along with matched spins take many steps.
pub const MOST_DOUBLINGS: u32 = 20;

/// Two circles of the tree are split where their gap is below this share of the sum of their radii. Smaller: more
/// steps before a split. Larger: more splits that a further step would have made needless.
pub const NEARNESS: f64 = 0.2;

/// A body turns fast for [`Exact`](crate::Exact) if it turns by this angle (radians) while an atom of the other one
/// moves by its own arm; then the atom's orbit is looked at, too. Smaller: work in vain for ordinary pairs. Larger:
/// more steps for fast rotors.
pub const FAST_ROTOR: f64 = 2.0;

/// Bounds on third derivatives below this are not used: products of three velocities that are all but 0 have lost their
/// digits. Smaller than about 10⁻³⁰⁷: the slowest rotors are followed too far at once. Larger: slow bodies are followed in
/// shorter steps.
pub const LEAST_JERK: f64 = 1e-300;

/// Squares below this have lost digits to underflow; |x| + |y| takes the place of the root of x² + y² there.
pub const LEAST_SQUARE: f64 = 1e-280;

/// How many times the rounding bound E the sum of two radii must be for the bound on the third derivative of the gap. It
/// supposes |d| ≥ (1 − 1/64) s up to the first contact, where |d| ≥ s − 2 E is known. Smaller than 128: a hole in the
/// proof. Larger: more steps for tiny atoms.
pub const LEAST_ATOM_ERRORS: f64 = 128.0;

/// A pair that touches is in contact when it has become deeper than this share of its rounding bound, however slowly it
/// closes, and counts as deep from there on. Larger: bodies that rest on each other overlap by more. Smaller: contacts
/// of bodies that slide on each other come at random times.
pub const RESTING_DEPTH: f64 = 0.125;

/// A pair that may be back within this share of the time in which it moves by its own size is followed by its gap
/// relative to the contact that it leaves. Smaller than 10⁻⁷: rattling pairs lose digits of the interval. Larger:
/// work in vain.
pub const SOON: f64 = 1e-3;

/// Most steps from one contact to the next of a pair that is followed so; afterwards the ordinary search goes on.
pub const MOST_RECONTACT_STEPS: u32 = 64;

/// Relative tolerance of the golden-section search and of the secant: five machine epsilon
/// (Montanari 2017, appendix A), taken relative to the time sought. Smaller than about 2: neither
/// search can end before its rounds are used up.
pub const THESIS_TOLERANCE: f64 = 5.0 * f64::EPSILON;

/// Share of the shortest quarter period that a segment of [`GoldenSecant`](crate::GoldenSecant) lasts: the
/// 1/2 of equation 2.4, Montanari (2017). Smaller: more segments, fewer dips that share one.
pub const CROP_FACTOR: f64 = 0.5;

/// Most rounds of one golden section (75 for five epsilon) or one secant (10; 210 if it has to bisect).
/// Smaller: searches end unresolved.
pub const MOST_ROUNDS: u32 = 250;

/// Most segments into which one window is cropped: 512 turns of the faster body. Smaller: fast rotors end
/// unresolved. Larger: one query can take seconds, since each atom pair costs some 80 evaluations a segment.
pub const MOST_SEGMENTS: u32 = 4096;

/// By how much of its length the window of [`GoldenSecant`](crate::GoldenSecant) begins earlier. Zero: two
/// discs, whose bounding circles are the atoms, touch where the window begins, and are lost to rounding.
pub const WINDOW_MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// Step of [`FixedStep`](crate::FixedStep) in natural times of the pair. Larger: grazes and thin atoms are
/// missed.
pub const FIXED_STEP: f64 = 1e-3;

/// Most steps of [`FixedStep`](crate::FixedStep) in one window: a thousand natural times. Smaller: slow pairs
/// that spin end unresolved.
pub const MOST_FIXED_STEPS: u32 = 1 << 20;

/// Most bisections inside one fixed step: enough to come down to neighbouring floats from any step that is
/// not astronomically later than its length.
pub const MOST_BISECTIONS: u32 = 128;
