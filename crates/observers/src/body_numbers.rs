//! Numbers of bodies by tag at each sample, and the contacts between them.
//!
//! Where two bodies of density n react at a share p of their contacts and both leave, dn/dt =
//! −p k n² with the rate constant k of contacts: 1/n grows in proportion to time as long as k is
//! constant. Between two samples of numbers N₁ and N₂ in an area A the integral of k is
//! 2 A C/(N₁ N₂), with the number C of contacts: exact where 1/n grows evenly.

use carom_engine::{Body, CollisionReport, Observer, Tag, View};
use serde::{Deserialize, Serialize};

use crate::Group;

/// The number of bodies of a group at each sample.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{BodyNumbers, Group};
///
/// let scene = Scene::from_toml(r#"
///     [[reaction]]
///     between = ["A"]
///     becomes = ["nothing", "nothing"]
///     [[gas]]
///     tags = ["A"]
///     radius = 0.01
///     mass = 1.0
///     energy = 1.0
///     count = 100
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let gas = simulation.find_tag("A").expect("the scene names it");
/// let mut numbers = BodyNumbers::new(Group::Tagged(gas), &simulation.view());
/// numbers.sample(&simulation.view());
/// simulation.observe_until(0.5, &mut numbers)?;
/// numbers.sample(&simulation.view());
/// let [first, last] = numbers.series() else { unreachable!() };
/// assert_eq!(first.number, 100.0);
/// assert_eq!(last.number, 100.0 - 2.0 * last.contacts);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct BodyNumbers {
    group: Group,
    area: f64,
    tags: Vec<(Tag, String)>,
    contacts: f64,
    series: Vec<NumberPoint>,
    /// The number of bodies with each tag, sample by sample.
    by_tag: Vec<f64>,
    sums: [[f64; 2]; 4],
}

/// The number of bodies of a group at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct NumberPoint {
    /// Time of the sample.
    pub time: f64,
    /// The number of bodies.
    pub number: f64,
    /// Contacts between two bodies of the group since the start of the observation.
    pub contacts: f64,
}

impl BodyNumbers {
    /// Observes a group: the bodies with its tag, or all that move. Of all bodies, those of each
    /// tag are counted too that a molecule carries now or that a reaction gives.
    pub fn new(group: Group, view: &View<'_>) -> Self {
        let mut tags: Vec<Tag> = Vec::new();
        if group == Group::All {
            let molecules = view.bodies().filter(|body| !body.body.is_wall());
            tags.extend(molecules.flat_map(|body| body.body.tags()));
            let in_force = view.reactions().iter().filter(|one| one.is_in_force);
            let given = in_force.flat_map(|one| one.spec.given_tags());
            tags.extend(given.filter_map(|name| view.tag_names().find(name)));
            tags.sort_unstable();
            tags.dedup();
        }
        let name = |tag: Tag| (tag, view.tag_names().name(tag).to_owned());
        let sides = view.bounds().sides();
        Self {
            group,
            area: sides.x * sides.y,
            tags: tags.into_iter().map(name).collect(),
            ..Self::default()
        }
    }

    /// The samples so far.
    pub fn series(&self) -> &[NumberPoint] {
        &self.series
    }

    /// The name of each tag that is counted by itself, and its number of bodies at each sample.
    pub fn by_tag(&self) -> impl Iterator<Item = (&str, Vec<f64>)> {
        let count = self.tags.len();
        let tags = self.tags.iter().enumerate();
        tags.map(move |(place, (_, name))| {
            let numbers = self.by_tag.iter().skip(place).step_by(count.max(1));
            (name.as_str(), numbers.copied().collect())
        })
    }

    /// The area of the box (length²).
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Memory that one more sample takes (bytes).
    pub fn bytes_per_sample(&self) -> usize {
        size_of::<NumberPoint>() + self.tags.len() * size_of::<f64>()
    }

    /// The integral over time of the rate constant of contacts between two points (length²), with
    /// at least one body at each.
    pub fn contact_integral(&self, [one, other]: [&NumberPoint; 2]) -> f64 {
        2.0 * self.area * (other.contacts - one.contacts) / (one.number * other.number)
    }

    /// [Σx, Σw] over the intervals between samples with bodies at both ends so far: of the change
    /// of 1/n by time; of the rate constant of contacts by time; of the change of 1/n by the latter
    /// integral; and of −ln n by ln t, from the first sample after time 0 on.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.sums.to_vec()
    }

    fn contains(&self, body: &Body) -> bool {
        match self.group {
            Group::All => body.is_free(),
            Group::Tagged(tag) => body.has_tag(tag),
        }
    }

    fn add(&mut self, earlier: NumberPoint, later: NumberPoint) {
        if earlier.number == 0.0 || later.number == 0.0 {
            return;
        }
        let time = later.time - earlier.time;
        let inverse = self.area * (1.0 / later.number - 1.0 / earlier.number);
        let of_contacts = self.contact_integral([&earlier, &later]);
        let logarithms = if earlier.time > 0.0 {
            [
                libm::log(earlier.number / later.number),
                libm::log(later.time / earlier.time),
            ]
        } else {
            [0.0; 2]
        };
        let terms = [
            [inverse, time],
            [of_contacts, time],
            [inverse, of_contacts],
            logarithms,
        ];
        for (sum, term) in self.sums.iter_mut().zip(terms) {
            sum[0] += term[0];
            sum[1] += term[1];
        }
    }
}

impl Observer for BodyNumbers {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.iter().all(|body| self.contains(body))
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if report.is_contact() && report.sides.iter().all(|side| self.contains(side.body)) {
            self.contacts += 1.0;
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        let mut number = 0.0;
        let begin = self.by_tag.len();
        self.by_tag.resize(begin + self.tags.len(), 0.0);
        for body in view.bodies() {
            if self.contains(body.body) {
                number += 1.0;
            }
            for (place, (tag, _)) in self.tags.iter().enumerate() {
                if body.body.has_tag(*tag) {
                    self.by_tag[begin + place] += 1.0;
                }
            }
        }
        let point = NumberPoint {
            time: view.time().to_f64(),
            number,
            contacts: self.contacts,
        };
        if let Some(&last) = self.series.last() {
            self.add(last, point);
        }
        self.series.push(point);
    }
}
