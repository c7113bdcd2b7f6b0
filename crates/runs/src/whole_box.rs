//! Maps of the whole box of a system so large that its picture shows a part: where it is dense, and
//! where it is ordered.

use carom::{
    View,
    observers::{density_map, order_map},
};
use carom_report::map::{ColourBar, Map, WIDE};
use carom_tables::with_error;

use crate::visible_region::VisibleRegion;

/// Files of the maps, with what they show.
pub const MAPS: [(&str, &str); 2] = [
    ("density.svg", "The whole box: area fraction at the end."),
    (
        "order.svg",
        "The whole box: the direction of sixfold order at the end, from the mean of ψ₆; grey where its magnitude is \
         below 0.4.",
    ),
];

/// Most cells along a side of a map. More: larger files.
const MAX_CELLS: usize = 180;

/// Systems of more bodies have no map of the order, which takes a microsecond a body.
const MAX_ORDERED: usize = 2_000_000;

/// Where the magnitude of the mean of ψ₆ is less, there is no direction. A crystal has 0.7 to 1; of
/// sixteen bodies in a gas the mean is 0.1.
const MIN_ORDER: f64 = 0.4;
const NO_ORDER: [u8; 3] = [178, 178, 178];

/// The maps with the names of their files; none of a system that is shown whole.
pub fn maps_of(view: &View<'_>) -> Vec<(&'static str, String)> {
    if VisibleRegion::is_all(view) {
        return Vec::new();
    }
    let mut maps = vec![(MAPS[0].0, density(view))];
    maps.extend((view.len() <= MAX_ORDERED).then(|| (MAPS[1].0, order(view))));
    maps
}

fn density(view: &View<'_>) -> String {
    let map = density_map(view, MAX_CELLS);
    let most = map.values.iter().copied().fold(0.0, f64::max);
    let share = |value: f64| if most > 0.0 { value / most } else { 0.0 };
    let bar = ColourBar::sequence(labels(|place| format!("{:.3}", place * most)));
    let colours = map
        .values
        .iter()
        .map(|&value| bar.colour(share(value)))
        .collect();
    let title = format!(
        "area fraction at t = {}",
        with_error(view.time().to_f64(), None)
    );
    Map {
        title,
        sides: view.bounds().sides().to_array(),
        longer: WIDE,
        counts: map.counts,
        colours,
        bar,
    }
    .svg()
}

fn order(view: &View<'_>) -> String {
    let map = order_map(view, MAX_CELLS);
    let bar = ColourBar::circle(labels(|place| format!("{}°", 60.0 * place)));
    let colour = |order: &glam::DVec2| {
        // Six times the direction.
        let share = order.to_angle().rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU;
        if order.length() < MIN_ORDER {
            NO_ORDER
        } else {
            bar.colour(share)
        }
    };
    let colours = map.values.iter().map(colour).collect();
    let time = with_error(view.time().to_f64(), None);
    let title = format!("direction of sixfold order at t = {time}; grey: none");
    Map {
        title,
        sides: view.bounds().sides().to_array(),
        longer: WIDE,
        counts: map.counts,
        colours,
        bar,
    }
    .svg()
}

/// Labels of a colour bar at its quarters.
fn labels(words: impl Fn(f64) -> String) -> Vec<(f64, String)> {
    [0.0, 0.25, 0.5, 0.75, 1.0]
        .map(|place| (place, words(place)))
        .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;
    use carom_methods::AnySimulation;

    #[test]
    fn only_a_system_that_is_not_shown_whole_has_maps() {
        let maps = |count: usize| {
            let scene =
                format!("[[gas]]\nradius = 0.001\nmass = 1.0\nenergy = 1.0\ncount = {count}");
            let simulation = AnySimulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
            maps_of(&simulation.view())
        };
        assert!(maps(9000).is_empty());
        let found = maps(20_000);
        assert_eq!(
            found.iter().map(|(file, _)| *file).collect::<Vec<_>>(),
            MAPS.map(|(file, _)| file)
        );
        for (file, svg) in found {
            assert!(
                svg.starts_with("<svg") && svg.len() < 100_000 && !svg.contains("NaN"),
                "{file}"
            );
        }
    }
}
