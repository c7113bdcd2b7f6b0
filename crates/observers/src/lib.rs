//! Observers measure a running simulation: one quantity per file, each an [`Observer`] that reads
//! the state and never changes it.
//!
//! Stable: its public items follow the policy of versions in the book (*Versions and releases*).
//!
//! ```
//! use carom_engine::{Observer, Scene, Simulation};
//! use carom_observers::{CollisionRate, EnergyLedger};
//!
//! let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
//! let mut simulation = Simulation::new(&scene)?;
//! let mut observers = (EnergyLedger::default(), CollisionRate::default());
//! observers.start(&simulation.view());
//! for sample in 1..=10 {
//!     simulation.observe_until(0.1 * f64::from(sample), &mut observers)?;
//!     observers.sample(&simulation.view());
//! }
//! let (energy, rate) = observers;
//! assert!(energy.drift() < 1e-13);
//! assert_eq!(rate.series().len(), 10);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | quantity | observer | receives |
//! | --- | --- | --- |
//! | directions of the impulses on a body, in its own frame | [`DirectionHistogram`] | contacts |
//! | components of the impulses on a body along one of its axes | [`ProjectionHistogram`] | contacts |
//! | mean force on a body and its mean velocity, in its own frame | [`RunningAverage`] | contacts, samples |
//! | impulses and torques on a body, its displacement and rotation, in its own frame | [`Drift`] | contacts, samples |
//! | energy and its expected value, momentum | [`EnergyLedger`] | samples |
//! | collisions per body and time | [`CollisionRate`] | samples |
//! | pressure from the virial of the contacts, momentum flux | [`Pressure`] | contacts, samples |
//! | pressure tensor | [`PressureTensor`] | contacts, samples |
//! | fields over the place: density, velocity, kT, stress, heat current | [`Fields`] | contacts, samples |
//! | translational and rotational temperature of a group | [`TemperatureByTag`] | samples |
//! | numbers of bodies by tag, and contacts between them | [`BodyNumbers`] | contacts, samples |
//! | place, velocity and energy of a piston | [`PistonSeries`] | samples |
//! | crossings of a segment: flux, first passages, a Poincaré section | [`Crossings`] | contacts, samples |
//! | path lengths between contacts | [`FreePaths`] | contacts |
//! | shear viscosity and heat conductivity: Helfand moments | [`HelfandMoment`] | contacts, samples |
//! | energy put in by resets and lost in contacts | [`ThermostatLedger`] | samples |
//! | velocities, and Boltzmann's H | [`VelocityDistribution`] | samples |
//! | friction coefficients from the squares of the impulses | [`Friction`] | contacts, samples |
//! | mean squared displacement, velocity autocorrelation | [`TimeCorrelation`] | samples |
//! | structural relaxation: F_s(k, t), α₂(t), Q(t), χ₄(t) | [`StructuralRelaxation`] | samples |
//! | displacements relative to the neighbours: cages | [`CageDisplacement`] | samples |
//! | distribution of displacements: van Hove G_s(r, t) | [`SelfVanHove`] | samples |
//! | distances to the other bodies after a lag: van Hove G_d(r, t) | [`DistinctVanHove`] | samples |
//! | orientations and angular velocities, correlated in time | [`OrientationCorrelation`] | samples |
//! | density waves: the structure factor S(k) | [`StructureFactor`] | samples |
//! | density waves by their direction: S(k_x, k_y) | [`StructureFactorMap`] | samples |
//! | density waves correlated in time: F(k, t) | [`IntermediateScattering`] | samples |
//! | currents correlated in time: C_L(k, t), C_T(k, t) | [`CurrentCorrelation`] | samples |
//! | bond orientation: ψₙ | [`HexaticOrder`] | samples |
//! | bond orientation of two bodies by their distance: g₆(r) | [`BondOrderCorrelation`] | samples |
//! | bond orientation of a body against the lag: G₆(t) | [`BondOrderRelaxation`] | samples |
//! | disclinations: bodies without six neighbours | [`Disclinations`] | samples |
//! | clusters of bodies nearer than a gap, or bonded; percolation | [`Clusters`] | samples |
//! | chains: bond lengths, end-to-end distance, tensor of gyration | [`ChainShapes`] | samples |
//! | chains: displacement, relaxation of the end-to-end vector and of a Rouse mode | [`ChainRelaxation`] | samples |
//! | areas of the Voronoi cells and their neighbours | [`VoronoiCells`] | samples |
//! | nematic, tetratic, k-atic order of orientations | [`OrientationalOrder`] | samples |
//! | displacements along and across the axis of a body, in its own frame | [`BodyFrameDiffusion`] | samples |
//! | distances: the pair distribution g(r) | [`PairDistribution`] | samples |
//! | density of a gas at contact along a body's boundary | [`ContactDensity`] | contacts, samples |
//! | growth of small deviations: the Lyapunov exponents | [`LyapunovSpectrum`] | contacts, samples |
//! | angles at which bodies meet fixed bodies and walls | [`Incidence`] | contacts |
//! | every impulse on a body | [`ImpulseLog`] | contacts |
//! | every contact between bodies of two tags | [`ContactLog`] | contacts |
//! | every flight of every body, up to a capacity | [`FlightLog`] | contacts |
//! | overlapping pairs | [`OverlapCheck`] | samples |
//! | user-defined: closures, by event and by tag | [`Subscriptions`] | contacts, samples |
//!
//! All except the last are plain data that serde stores to the bit: a run resumed from a checkpoint
//! continues its measurements.
//!
//! The statistical error follows from the scatter of blocks: [`Estimate`] of a mean, [`Isotropy`]
//! of a histogram of directions.
//!
//! An observer that receives samples only costs nothing between the samples; under shear those of
//! displacements receive contacts too, from which they have the displacement by the flow. Two
//! functions write a
//! view of the system as text: [`write_extended_xyz`] and [`picture`]. A tuple of observers is an
//! observer, as in the example.
//!
//! [`Observer`]: carom_engine::Observer

mod body_frame;
mod body_frame_diffusion;
mod body_numbers;
mod bond_order_correlation;
mod bond_order_relaxation;
mod bonded_clusters;
mod cage_displacement;
mod cell_list;
mod chain_relaxation;
mod chain_shapes;
mod chains;
mod clusters;
mod coarse_atoms;
mod collision_rate;
mod contact_density;
mod contact_log;
mod crossings;
mod currents;
mod delaunay;
mod direction_histogram;
mod disc_area;
mod disclinations;
mod disjoint_sets;
mod distinct_van_hove;
mod distribution;
mod drawn_bonds;
mod drawn_contours;
mod drift;
mod energy_ledger;
mod extended_xyz;
mod field_bins;
mod fields;
mod flight_log;
mod flow_displacement;
mod free_paths;
mod friction;
mod group;
mod helfand;
mod hexatic_order;
mod histogram;
mod impulse_log;
mod incidence;
mod intermediate_scattering;
mod isotropy;
mod kinds;
mod lags;
mod lyapunov;
mod maps;
mod moving_frame;
mod octaves;
mod open_interval;
mod orientational_correlation;
mod orientational_order;
mod overlap_check;
mod pair_distribution;
mod picture;
mod piston_series;
mod pressure;
mod pressure_tensor;
mod projection_histogram;
mod running_average;
mod scattering_scales;
mod size_bins;
mod structural_relaxation;
mod structure_factor;
mod structure_factor_map;
mod subscriptions;
mod tag_filter;
mod temperature;
#[cfg(test)]
mod test_scenes;
mod thermostat_ledger;
mod time_correlation;
mod van_hove;
mod velocity_distribution;
mod voronoi_cells;
mod wall_energy;
mod wall_pressure;
mod wave_vectors;
mod well_energy;

pub use body_frame_diffusion::{BodyFrameDiffusion, BodyFramePoint};
pub use body_numbers::{BodyNumbers, NumberPoint};
pub use bond_order_correlation::{BondOrderCorrelation, BondOrderPoint};
pub use bond_order_relaxation::{BondOrderLag, BondOrderRelaxation};
pub use bonded_clusters::Bonding;
pub use cage_displacement::{Cage, CageDisplacement, CageError, CagePoint};
pub use chain_relaxation::{ChainLag, ChainRelaxation};
pub use chain_shapes::{ChainPoint, ChainShapes};
pub use clusters::{ClusterPoint, Clusters};
pub use collision_rate::{CollisionRate, RatePoint};
pub use contact_density::{ContactDensity, ContactPoint};
pub use contact_log::{ContactLog, LoggedContact};
pub use crossings::{CrossingPoint, Crossings, SegmentCrossing, SegmentError};
pub use currents::{CurrentCorrelation, CurrentPoint};
pub use direction_histogram::DirectionHistogram;
pub use disclinations::{CountedBody, DefectPoint, Disclinations};
pub use distinct_van_hove::{DistinctCurve, DistinctVanHove, DistinctVanHoveError};
pub use distribution::{AdaptiveHistogram, Bins};
pub use drift::Drift;
pub use energy_ledger::{EnergyLedger, LedgerPoint};
pub use extended_xyz::write_extended_xyz;
pub use field_bins::FieldBins;
pub use fields::Fields;
pub use flight_log::{FlightLog, LoggedFlight};
pub use free_paths::FreePaths;
pub use friction::Friction;
pub use group::Group;
pub use helfand::{HelfandMoment, HelfandPoint};
pub use hexatic_order::{HexaticOrder, HexaticPoint, Neighbours};
pub use histogram::Histogram;
pub use impulse_log::{Impulse, ImpulseLog};
pub use incidence::Incidence;
pub use intermediate_scattering::{IntermediateScattering, ScatteringPoint};
pub use isotropy::Isotropy;
pub use lyapunov::{LyapunovError, LyapunovSpectrum};
pub use maps::{BoxMap, density_map, order_map};
pub use orientational_correlation::{OrientationCorrelation, OrientationPoint};
pub use orientational_order::{
    OrderLagPoint, OrderPoint, OrderRanges, OrientationalOrder, PairOrderPoint,
};
pub use overlap_check::OverlapCheck;
pub use pair_distribution::{CutoffError, PairDistribution, PairPoint};
pub use picture::picture;
pub use piston_series::{PistonPoint, PistonSeries};
pub use pressure::{Pressure, PressurePoint};
pub use pressure_tensor::{PressureTensor, TensorPoint};
pub use projection_histogram::{BodyAxis, ProjectionHistogram};
pub use running_average::{RunningAverage, RunningPoint};
pub use scattering_scales::{ScatteringError, ScatteringScales};
pub use structural_relaxation::{
    RelaxationPoint, RelaxationScales, ScalesError, StructuralRelaxation,
};
pub use structure_factor::{ShellsError, StructureFactor, StructurePoint};
pub use structure_factor_map::{StructureFactorMap, StructureMapError, StructureMapPoint};
pub use subscriptions::{EventKind, SubscriptionKey, Subscriptions};
pub use tag_filter::TagFilter;
pub use temperature::{TemperatureByTag, TemperaturePoint};
pub use thermostat_ledger::{HeatOfTag, ThermostatLedger, ThermostatPoint};
pub use time_correlation::{CorrelationPoint, TimeCorrelation};
pub use van_hove::{DisplacementBins, DisplacementBinsError, SelfVanHove, VanHoveCurve};
pub use velocity_distribution::{SpeedMoments, VelocityDistribution, VelocityPoint};
pub use voronoi_cells::{VoronoiCells, VoronoiPoint};
pub use wall_energy::{
    FromWalls, HeatFromWalls, WallEnergy, WallEnergyPoint, WallHeat, WallWork, WorkOfWalls,
};
pub use wall_pressure::{WallLayer, WallPressure, WallsAcross, WallsError};
pub use well_energy::{WellEnergy, WellPoint};

pub use carom_tables::Estimate;
// Parts that pictures and reports of runs share; no user of the library needs them.
#[doc(hidden)]
pub use coarse_atoms::{MAX_CIRCLES, drawn_circles};
#[doc(hidden)]
pub use drawn_bonds::drawn_bonds;
#[doc(hidden)]
pub use drawn_contours::{drawn_contours, packed_contours};
#[doc(hidden)]
pub use extended_xyz::bonded_atoms;
#[doc(hidden)]
pub use hexatic_order::local_orders;
#[doc(hidden)]
pub use kinds::{kinds_of_groups, names_of_kinds};
#[doc(hidden)]
pub use picture::{close_up, colour, coloured_kinds};
