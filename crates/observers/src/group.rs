//! The bodies to be measured: all, or those with a tag.

use carom_engine::{Body, BodyView, Tag, View};
use serde::{Deserialize, Serialize};

/// The bodies to be measured.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::Group;
///
/// let scene = Scene::from_toml(
///     "[[gas]]\ntags = [\"hot\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 9\n[[bumper]]\nradius = 0.1\nat = [0, 0]",
/// )?;
/// let simulation = Simulation::new(&scene)?;
/// let hot = Group::Tagged(simulation.find_tag("hot").expect("the scene names it"));
/// let count = |group: Group| simulation.view().bodies().filter(|view| group.contains(view.body)).count();
/// assert_eq!((count(hot), count(Group::All)), (9, 10));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Group {
    /// Every body.
    #[default]
    All,
    /// The bodies with the tag.
    Tagged(Tag),
}

impl Group {
    /// Whether the body belongs to the group now; tags can change at any sample.
    pub fn contains(self, body: &Body) -> bool {
        match self {
            Self::All => true,
            Self::Tagged(tag) => body.has_tag(tag),
        }
    }

    /// The discs and molecules of the group, fixed or free: all but walls.
    pub(crate) fn molecules<'a>(self, view: &View<'a>) -> impl Iterator<Item = BodyView<'a>> {
        view.bodies()
            .filter(move |body| !body.body.is_wall() && self.contains(body.body))
    }
}

impl From<Tag> for Group {
    fn from(tag: Tag) -> Self {
        Self::Tagged(tag)
    }
}
