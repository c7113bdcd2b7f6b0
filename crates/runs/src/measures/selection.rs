//! The bodies that a measure is restricted to.

use anyhow::{Context, Result, ensure};
use carom::{
    Group, View,
    engine::{BodyView, RunSpec, did_you_mean},
};

/// Longest lag of correlations in samples. It does not depend on the end of the run, so an extended
/// run measures the same as a long one.
const LONGEST_LAG: f64 = 1e6;

/// The run and the bodies of a measure.
#[derive(Debug, Clone, Copy)]
pub struct Selection<'a> {
    /// The name as in the scene, for error messages.
    name: &'a str,
    /// The bodies.
    pub group: Group,
    /// The system at the start of the measurement.
    pub view: &'a View<'a>,
    /// Duration and sampling of the run.
    pub run: &'a RunSpec,
}

impl<'a> Selection<'a> {
    /// The bodies with a tag; all bodies without one.
    ///
    /// # Errors
    /// No body carries the tag.
    pub fn new(name: &'a str, tag: Option<&str>, run: &'a RunSpec, view: &'a View<'a>) -> Result<Self> {
        let group = match tag {
            None => Group::All,
            Some(tag) => {
                let found = view.tag_names().find(tag);
                let found = found.filter(|&found| view.tagged(found).next().is_some());
                found.map(Group::from).with_context(|| {
                    let tags = view.bodies().flat_map(|body| body.body.tags().iter());
                    let nearest = did_you_mean(tag, tags.map(|&tag| view.tag_names().name(tag)));
                    format!("run.observe: '{name}': no body in the scene carries the tag {tag:?}{nearest}")
                })?
            }
        };
        Ok(Self { name, group, view, run })
    }

    /// The only body of the group.
    ///
    /// # Errors
    /// There are several.
    pub fn only_body(&self) -> Result<BodyView<'a>> {
        let mut members = self.view.bodies().filter(|body| self.group.contains(body.body));
        let (first, another) = (members.next(), members.next());
        let entry = format!("run.observe: '{}'", self.name);
        ensure!(another.is_none(), "{entry}: several bodies carry that tag, but only one can be observed");
        first.with_context(|| format!("{entry}: no body carries that tag"))
    }

    /// Longest lag of correlations (time).
    pub fn longest_lag(&self) -> f64 {
        (self.run.sample_interval * LONGEST_LAG).min(f64::MAX)
    }

    /// The moving bodies of the group.
    pub fn moving(&self) -> impl Iterator<Item = BodyView<'a>> {
        self.view.bodies().filter(|body| !body.body.is_fixed() && self.group.contains(body.body))
    }

    /// The largest bounding radius of a body of the group, without walls (length).
    pub fn largest_radius(&self) -> f64 {
        let members = self.view.bodies().filter(|body| self.group.contains(body.body));
        members
            .filter(|body| !body.body.is_wall())
            .map(|body| body.body.molecule().bounding_radius())
            .fold(0.0, f64::max)
    }
}
