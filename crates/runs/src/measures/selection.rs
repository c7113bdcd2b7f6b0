//! The bodies and parameters of a measure.

use anyhow::{Context, Result, anyhow, ensure};
use carom::{
    Group, View,
    engine::{BodyView, MeasureParameter, RunSpec, Tag, did_you_mean},
    observers::coloured_kinds,
};

use super::{
    Request,
    kind::{Default, MAX_LAG},
    numbers,
    request::number,
};

/// Longest lag of correlations in samples. It does not depend on the end of the run, so an extended
/// run measures the same as a long one.
const MAX_LAGS: f64 = 1e6;

/// The tag with this name.
///
/// # Errors
/// No body carries it.
fn tag_of(view: &View<'_>, name: &str) -> Result<Tag> {
    let found = view.tag_names().find(name);
    let found = found.filter(|&found| view.tagged(found).next().is_some());
    found.with_context(|| {
        let tags = view.bodies().flat_map(|body| body.body.tags().iter());
        let nearest = did_you_mean(name, tags.map(|&tag| view.tag_names().name(tag)));
        format!("no body in the scene carries the tag {name:?}{nearest}")
    })
}

/// The tag with this name, if a reaction gives it and the measure counts bodies: there may be none
/// at first.
fn given_by_reactions(request: &Request, view: &View<'_>, name: &str) -> Option<Tag> {
    let mut reactions = view.reactions().iter();
    let is_given = reactions.any(|one| one.spec.given_tags().any(|tag| tag == name));
    let counts = request.kind.name == numbers::KIND.name;
    view.tag_names().find(name).filter(|_| is_given && counts)
}

/// The run, the bodies and the parameters of a measure.
#[derive(Debug, Clone, Copy)]
pub struct Selection<'a> {
    request: &'a Request,
    /// The tags of the bodies.
    tags: [Option<Tag>; 2],
    /// The bodies.
    pub group: Group,
    /// The system at the start of the measurement.
    pub view: &'a View<'a>,
    run: &'a RunSpec,
}

impl<'a> Selection<'a> {
    /// The bodies with a tag; all bodies without one.
    ///
    /// # Errors
    /// No body carries the tag.
    pub fn new(request: &'a Request, run: &'a RunSpec, view: &'a View<'a>) -> Result<Self> {
        let mut tags = [None; 2];
        for (tag, name) in tags.iter_mut().zip(&request.tags) {
            let found = match given_by_reactions(request, view, name) {
                Some(found) => Ok(found),
                None => tag_of(view, name),
            };
            *tag = Some(found.map_err(|error| anyhow!("{}: {error}", request.entry))?);
        }
        Ok(Self {
            request,
            tags,
            group: tags[0].map_or(Group::All, Group::from),
            view,
            run,
        })
    }

    /// The tags of the two bodies of a pair.
    pub fn tags(&self) -> [Option<Tag>; 2] {
        self.tags
    }

    /// The name of the measure.
    pub fn kind_name(&self) -> &'static str {
        self.request.kind.name
    }

    /// Whether a body of the group has an axis now: it is not round, or driven along an axis.
    pub fn has_axes(&self) -> bool {
        let has_axis = |body: BodyView<'_>| {
            !body.body.is_wall()
                && (!body.body.molecule().is_round() || self.view.axis(body.body.key()).is_some())
        };
        self.view
            .bodies()
            .filter(|body| self.group.contains(body.body))
            .any(has_axis)
    }

    /// Two groups: those of two tags, or the group twice.
    pub fn groups(&self) -> [Group; 2] {
        [self.group, self.tags[1].map_or(self.group, Group::from)]
    }

    /// The only body of the group.
    ///
    /// # Errors
    /// There are several.
    pub fn only_body(&self) -> Result<BodyView<'a>> {
        let mut members = self
            .view
            .bodies()
            .filter(|body| self.group.contains(body.body));
        let (first, another) = (members.next(), members.next());
        ensure!(
            another.is_none(),
            "several bodies carry that tag, but only one can be observed"
        );
        first.context("no body carries that tag")
    }

    /// A parameter that is a number, if the scene gives it.
    pub fn given(&self, name: &str) -> Option<f64> {
        number(self.request.given.get(name)?)
    }

    /// A parameter that is a word or a tag, if the scene gives it.
    pub fn given_word(&self, name: &str) -> Option<&'a str> {
        match self.request.given.get(name)? {
            MeasureParameter::Text(word) => Some(word),
            _ => None,
        }
    }

    /// A parameter that is a point, if the scene gives it (length).
    pub fn given_point(&self, name: &str) -> Option<[f64; 2]> {
        match self.request.given.get(name)? {
            MeasureParameter::Numbers(numbers) => numbers.as_slice().try_into().ok(),
            _ => None,
        }
    }

    /// The bodies of a parameter that is a tag, if the scene gives it.
    ///
    /// # Errors
    /// No body carries the tag.
    pub fn given_group(&self, name: &str) -> Result<Option<Group>> {
        let group = |tag| tag_of(self.view, tag).map(Group::from);
        let found = self.given_word(name).map(group).transpose();
        found.with_context(|| format!("'{name}'"))
    }

    /// A parameter that is a number of things: as given, or its default.
    ///
    /// # Panics
    /// The kind has no such parameter with a number as default.
    pub fn whole(&self, name: &str) -> usize {
        let of_kind = || {
            self.request
                .kind
                .all_parameters()
                .find(|parameter| parameter.name == name)
        };
        let default = || match of_kind().map(|parameter| parameter.default) {
            Some(Default::Number(number)) => number,
            _ => unreachable!("the kind has no parameter {name} with a default"),
        };
        self.given(name).unwrap_or_else(default) as usize
    }

    /// Time between two samples of the measure.
    pub fn interval(&self) -> f64 {
        self.run.sample_interval * self.request.every as f64
    }

    /// Longest lag of correlations (time).
    pub fn longest_lag(&self) -> f64 {
        self.given(MAX_LAG.name)
            .unwrap_or((self.interval() * MAX_LAGS).min(f64::MAX))
    }

    /// The moving bodies of the group.
    pub fn moving(&self) -> impl Iterator<Item = BodyView<'a>> {
        self.view
            .bodies()
            .filter(|body| body.body.is_free() && self.group.contains(body.body))
    }

    /// The kind of the first body with the tag of the measure in the numbering of pictures; 0 for
    /// all bodies.
    pub fn kind_of_body(&self) -> usize {
        if self.tags[0].is_none() {
            return 0;
        }
        let place = self
            .view
            .bodies()
            .position(|body| self.group.contains(body.body));
        place
            .and_then(|place| coloured_kinds(self.view).get(place).copied())
            .unwrap_or(0)
    }

    /// The largest bounding radius of a body of a group, without walls (length).
    pub fn largest_radius(&self, group: Group) -> f64 {
        let members = self.view.bodies().filter(|body| group.contains(body.body));
        members
            .filter(|body| !body.body.is_wall())
            .map(|body| body.body.molecule().bounding_radius())
            .fold(0.0, f64::max)
    }
}
