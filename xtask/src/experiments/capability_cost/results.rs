//! What each capability was found to cost.

use carom_tables::{Check, Figure};

use super::{
    callgrind::{self, Profile},
    capability::{Capability, CapabilityLevel, Variant},
    dependencies::Needs,
};

/// The most that a capability may cost where it is absent, and where it is idle (share of the
/// instructions).
const ABSENT: f64 = 0.02;
const IDLE: f64 = 0.05;

/// Results for one variant.
#[derive(Debug, Clone)]
pub struct VariantResult {
    /// The variant.
    pub variant: Variant,
    /// Instructions for each collision.
    pub instructions: Option<f64>,
    /// Processor time for each collision, median over the rounds (nanoseconds).
    pub nanoseconds: f64,
    /// Processor time for each collision relative to the plain gas in the same round, median over
    /// the rounds.
    pub time_ratio: f64,
    /// Memory for each body (bytes).
    pub bytes_per_body: f64,
}

/// All results.
#[derive(Debug)]
pub struct CostResults {
    /// The variants, the plain gas first.
    pub found: Vec<VariantResult>,
    /// Instructions of the plain gas by source.
    pub plain: Option<Profile>,
    /// Dependencies of each layer.
    pub needs: Vec<Needs>,
}

impl CostResults {
    /// Results for a variant.
    pub fn variant(&self, variant: Variant) -> Option<&VariantResult> {
        self.found.iter().find(|found| found.variant == variant)
    }

    /// Instructions for each collision relative to the plain gas, minus 1.
    pub fn excess(&self, variant: Variant) -> Option<f64> {
        Some(self.variant(variant)?.instructions? / self.found.first()?.instructions? - 1.0)
    }

    /// Share of the instructions of the plain gas that come from the capability's own sources.
    pub fn absent(&self, capability: Capability) -> Option<f64> {
        let plain = self.plain.as_ref()?;
        let own = callgrind::of_sources(plain, capability.sources());
        Some(own as f64 / callgrind::total(plain) as f64)
    }

    pub fn checks(&self) -> Vec<Check> {
        let mut checks = Vec::new();
        for capability in Capability::all() {
            if let Some(share) = self
                .absent(capability)
                .filter(|_| !capability.sources().is_empty())
            {
                checks.push(Check::at_most(
                    &format!("{} absent", capability.name()),
                    share,
                    ABSENT,
                ));
            }
            if let Some(excess) = self.excess(Variant::With(capability, CapabilityLevel::Idle)) {
                checks.push(Check::at_most(
                    &format!("{} idle", capability.name()),
                    excess,
                    IDLE,
                ));
            }
        }
        checks
    }

    pub fn figures(&self) -> Vec<Figure> {
        let of = |found: &VariantResult| {
            let variant = found.variant;
            let figure =
                |what: &str, value, unit| Figure::new(format!("{what}: {variant}"), value, unit);
            let instructions = found
                .instructions
                .map(|count| figure("instructions a collision", count, "1"));
            let every_run = self
                .variant(Variant::Measure("energy"))
                .and_then(|found| found.instructions);
            let price = match (variant, found.instructions, every_run) {
                (Variant::Measure(_), Some(count), Some(every_run)) => Some(figure(
                    "instructions a collision for it alone",
                    count - every_run,
                    "1",
                )),
                _ => None,
            };
            let rest = [
                figure("processor time of a collision", found.nanoseconds, "ns"),
                figure("time over that of the plain gas", found.time_ratio, "1"),
                figure("bytes a body", found.bytes_per_body, "byte"),
            ];
            instructions
                .into_iter()
                .chain(price)
                .chain(rest)
                .collect::<Vec<_>>()
        };
        self.found.iter().flat_map(of).collect()
    }
}
