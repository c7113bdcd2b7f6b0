//! Colours of charts that colour-blind readers can distinguish (Okabe and Ito 2008, "Color
//! universal design"), in the reader's light or dark theme.

/// A colour of the theme.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// That of the text.
    Text,
    /// Weaker than the text.
    Quiet,
    /// For measured values.
    Blue,
    /// For a second measured quantity.
    Green,
    /// For a third one.
    Orange,
    /// For predictions.
    Vermillion,
    /// For a fourth measured quantity.
    Purple,
    /// For a sixth one.
    Sky,
    /// Red, green and blue of one of very many curves, the same in both themes.
    Other([u8; 3]),
}

/// Ends and middle of the colours of more curves than [`Ink::CURVES`], from the first to the last.
const SEQUENCE: [[f64; 3]; 3] = [
    [60.0, 10.0, 110.0],
    [30.0, 145.0, 140.0],
    [215.0, 170.0, 20.0],
];

impl Ink {
    /// The colours of curves, in order: those of the kinds of bodies in pictures.
    pub const CURVES: [Self; 6] = [
        Self::Blue,
        Self::Green,
        Self::Orange,
        Self::Purple,
        Self::Sky,
        Self::Text,
    ];

    /// The colour of one of `count` curves: one of [`Self::CURVES`], or of many curves one of a
    /// sequence.
    pub fn of_curve(index: usize, count: usize) -> Self {
        if count <= Self::CURVES.len() {
            return Self::CURVES[index % Self::CURVES.len()];
        }
        let place = 2.0 * index as f64 / (count - 1) as f64;
        let part = usize::from(place > 1.0);
        let share = place - part as f64;
        let mixed = |i: usize| SEQUENCE[part][i] * (1.0 - share) + SEQUENCE[part + 1][i] * share;
        Self::Other([0, 1, 2].map(|i| mixed(i).round() as u8))
    }

    /// The attributes of an element that is drawn in this colour in a style of [`STYLE`], such as
    /// `fill`.
    pub(crate) fn drawn(self, style: &str) -> String {
        let class = match self {
            Self::Text => "text",
            Self::Quiet => "quiet",
            Self::Blue => "blue",
            Self::Green => "green",
            Self::Orange => "orange",
            Self::Vermillion => "vermillion",
            Self::Purple => "purple",
            Self::Sky => "sky",
            Self::Other([red, green, blue]) => {
                return format!("color=\"#{red:02x}{green:02x}{blue:02x}\" class=\"{style}\"");
            }
        };
        format!("class=\"{class} {style}\"")
    }
}

/// The colours of both themes and the styles of lines and areas. Programs that do not know
/// `light-dark` take the light theme.
pub(crate) const STYLE: &str = "<style>:root{color-scheme:light dark}\
svg .ground{fill:#ffffff;fill:light-dark(#ffffff,#1c2026)}\
svg .text{color:#1d2126;color:light-dark(#1d2126,#e4e6e9)}\
svg .quiet{color:#5b636d;color:light-dark(#5b636d,#a2abb5)}\
svg .blue{color:#0072b2;color:light-dark(#0072b2,#56b4e9)}\
svg .green{color:#009e73;color:light-dark(#009e73,#4fd3a4)}\
svg .orange{color:#e69f00;color:light-dark(#e69f00,#f0b840)}\
svg .vermillion{color:#d55e00;color:light-dark(#d55e00,#ff9a63)}\
svg .purple{color:#cc79a7;color:light-dark(#cc79a7,#e39cc4)}\
svg .sky{color:#56b4e9;color:light-dark(#56b4e9,#9fd6f5)}\
svg .fill{fill:currentColor}svg .area{fill:currentColor;fill-opacity:.22}\
svg .thick,svg .thin,svg .dashed,svg .faint,svg .grid{fill:none;stroke:currentColor;stroke-width:1.2}\
svg .thick{stroke-width:2.4}svg .dashed{stroke-dasharray:6 4}svg .faint{stroke-opacity:.55}\
svg .grid{stroke-opacity:.18}</style>";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_curves_have_different_colours() {
        let inks: Vec<String> = (0..40)
            .map(|curve| Ink::of_curve(curve, 40).drawn("fill"))
            .collect();
        assert!(
            inks.iter()
                .enumerate()
                .all(|(index, ink)| !inks[..index].contains(ink))
        );
        assert_eq!(Ink::of_curve(0, 6), Ink::Blue);
    }
}
