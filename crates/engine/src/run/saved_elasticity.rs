//! The rules of elasticity in a checkpoint: those of a scene, in a form that any encoding can hold.
//!
//! A scene leaves out keys that have their defaults, and a restitution is a number or a table: a
//! format that describes its own structure is needed to read either.

use serde::{Deserialize, Serialize};

use crate::scene::elasticity_spec::{ElasticityRule, ElasticitySpec, Restitution};

/// The rules of elasticity of a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct SavedElasticity {
    pub default: f64,
    pub tangential: f64,
    pub friction: Option<f64>,
    pub contact_time: f64,
    pub pair: Vec<SavedRule>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct SavedRule {
    between: Vec<String>,
    coefficient: SavedRestitution,
    tangential: f64,
    friction: Option<f64>,
    kick: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
enum SavedRestitution {
    Number(f64),
    Power { power: f64, at: f64 },
    Table { speeds: Vec<f64>, values: Vec<f64> },
}

impl From<ElasticitySpec> for SavedElasticity {
    fn from(spec: ElasticitySpec) -> Self {
        let ElasticitySpec {
            default,
            tangential,
            friction,
            contact_time,
            pair,
        } = spec;
        Self {
            default,
            tangential,
            friction,
            contact_time,
            pair: pair.into_iter().map(SavedRule::from).collect(),
        }
    }
}

impl From<SavedElasticity> for ElasticitySpec {
    fn from(saved: SavedElasticity) -> Self {
        let SavedElasticity {
            default,
            tangential,
            friction,
            contact_time,
            pair,
        } = saved;
        Self {
            default,
            tangential,
            friction,
            contact_time,
            pair: pair.into_iter().map(ElasticityRule::from).collect(),
        }
    }
}

impl From<ElasticityRule> for SavedRule {
    fn from(rule: ElasticityRule) -> Self {
        let ElasticityRule {
            between,
            coefficient,
            tangential,
            friction,
            kick,
        } = rule;
        let coefficient = match coefficient {
            Restitution::Number(number) => SavedRestitution::Number(number),
            Restitution::Power { power, at } => SavedRestitution::Power { power, at },
            Restitution::Table { speeds, values } => SavedRestitution::Table { speeds, values },
        };
        Self {
            between,
            coefficient,
            tangential,
            friction,
            kick,
        }
    }
}

impl From<SavedRule> for ElasticityRule {
    fn from(saved: SavedRule) -> Self {
        let SavedRule {
            between,
            coefficient,
            tangential,
            friction,
            kick,
        } = saved;
        let coefficient = match coefficient {
            SavedRestitution::Number(number) => Restitution::Number(number),
            SavedRestitution::Power { power, at } => Restitution::Power { power, at },
            SavedRestitution::Table { speeds, values } => Restitution::Table { speeds, values },
        };
        Self {
            between,
            coefficient,
            tangential,
            friction,
            kick,
        }
    }
}
