//! The page of a run: one self-contained HTML file with a light and a dark colour scheme.

use std::fmt::Write as _;

use carom_tables::{Check, Figure, OneRun, Totals};

/// A page under construction, from top to bottom.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    body: String,
}

/// Layout of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Each over the full width.
    Full,
    /// Side by side if the width allows.
    Beside,
}

impl Page {
    /// A page with its title and an introductory sentence.
    pub fn new(title: &str, lead: &str) -> Self {
        let body = format!("<h1>{}</h1>\n<p class=\"lead\">{}</p>\n", escape(title), escape(lead));
        Self { title: title.to_owned(), body }
    }

    /// Adds a highlighted note, such as a caveat.
    pub fn note(&mut self, text: &str) {
        self.element("p class=\"note\"", text);
    }

    /// Adds a heading.
    pub fn heading(&mut self, text: &str) {
        self.element("h2", text);
    }

    /// Adds a subheading.
    pub fn subheading(&mut self, text: &str) {
        self.element("h3", text);
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.element("p", text);
    }

    /// Adds terminal commands or output.
    pub fn code(&mut self, text: &str) {
        self.element("pre", text);
    }

    /// Adds links to files, by their path relative to the page.
    pub fn links<'a>(&mut self, paths: impl IntoIterator<Item = &'a str>) {
        let links: Vec<String> =
            paths.into_iter().map(|path| format!("<a href=\"{0}\">{0}</a>", escape(path))).collect();
        let _ = writeln!(self.body, "<p>{}</p>", links.join(" · "));
    }

    /// Adds SVG pictures, each with a caption.
    pub fn pictures(&mut self, layout: Layout, pictures: &[(&str, &str)]) {
        let class = if layout == Layout::Full { "pictures full" } else { "pictures" };
        let _ = writeln!(self.body, "<div class=\"{class}\">");
        for (svg, caption) in pictures {
            let svg = &svg[svg.find("<svg").unwrap_or(0)..];
            let caption = escape(caption);
            let _ = writeln!(self.body, "<figure>\n{svg}\n<figcaption>{caption}</figcaption>\n</figure>");
        }
        self.body.push_str("</div>\n");
    }

    /// Adds an animation from the data that `carom-runs` records.
    pub fn animation(&mut self, animation: &str, caption: &str) {
        // In a JSON string this has the same meaning and cannot close an element of the page.
        let animation = animation.replace('<', "\\u003c");
        let _ = writeln!(
            self.body,
            "<figure class=\"animation\">\n<div class=\"views\"></div>\n<div class=\"controls\"></div>\n\
             <figcaption>{}</figcaption>\n<script type=\"application/json\">{animation}</script>\n</figure>\n\
             <script>\n{}</script>",
            escape(caption),
            include_str!("animation.js")
        );
    }

    /// Adds a table of two columns.
    pub fn facts(&mut self, facts: &[(&str, String)]) {
        self.body.push_str("<div class=\"wide\"><table class=\"facts\">\n");
        for (name, value) in facts {
            let (name, value) = (escape(name), escape(value));
            let _ = writeln!(self.body, "<tr><th>{name}</th><td>{value}</td></tr>");
        }
        self.body.push_str("</table></div>\n");
    }

    /// Adds a table of any number of columns: the first is text; the others are numbers, or text
    /// where longer than a number.
    pub fn table(&mut self, header: &[&str], rows: &[Vec<String>]) {
        self.body.push_str("<div class=\"wide\"><table>\n<tr>");
        for name in header {
            let _ = write!(self.body, "<th>{}</th>", escape(name));
        }
        for row in rows {
            self.body.push_str("</tr>\n<tr>");
            for (column, cell) in row.iter().enumerate() {
                let is_text = column == 0 || cell.chars().count() > LONGEST_NUMBER;
                let class = if is_text { "" } else { " class=\"number\"" };
                let _ = write!(self.body, "<td{class}>{}</td>", escape(cell));
            }
        }
        self.body.push_str("</tr>\n</table></div>\n");
    }

    /// Adds a table of figures with errors, predictions and sources.
    pub fn figures(&mut self, figures: &[Figure]) {
        self.body.push_str(
            "<div class=\"wide\"><table>\n<tr><th>figure</th><th>measured</th><th>unit</th>\
             <th>predicted</th><th>source of the prediction</th></tr>\n",
        );
        for figure in figures {
            let measured = with_error(figure.value, figure.standard_error);
            let predicted =
                figure.prediction.map_or_else(|| "–".to_owned(), |value| predicted(value, figure));
            let _ = writeln!(
                self.body,
                "<tr><td>{}</td><td class=\"number\">{measured}</td><td class=\"unit\">{}</td><td class=\"number\">{predicted}</td>\
                 <td class=\"source\">{}</td></tr>",
                escape(&figure.name),
                escape(&figure.unit),
                escape(figure.source.as_deref().unwrap_or("")),
            );
        }
        self.body.push_str("</table></div>\n");
    }

    /// Adds the totals of a run.
    pub fn totals(&mut self, totals: &Totals) {
        let number = |value: f64| with_error(value, None);
        self.facts(&[
            ("simulated time", number(totals.simulated_time)),
            ("collisions", totals.collisions.to_string()),
            ("collisions per processor second", format!("{:.0}", totals.collisions_per_second)),
            ("energy drift, relative", number(totals.energy_drift)),
            ("overlapping pairs", totals.overlapping_pairs.to_string()),
            ("deepest overlap, in diameters", number(totals.max_overlap)),
        ]);
    }

    /// Adds a table of the runs of a campaign.
    pub fn runs(&mut self, runs: &[OneRun]) {
        let row = |run: &OneRun| {
            let rate = run.collisions as f64 / run.cpu_seconds / 1e6;
            let (seconds, rate) =
                (format!("{:.1} s", run.cpu_seconds), format!("{rate:.2} million per processor second"));
            vec![run.name.clone(), run.collisions.to_string(), seconds, rate]
        };
        let header = ["run", "collisions", "processor time", "rate"];
        self.table(&header, &runs.iter().map(row).collect::<Vec<_>>());
    }

    /// Adds a table of checks.
    pub fn checks(&mut self, checks: &[Check]) {
        self.body.push_str(
            "<div class=\"wide\"><table>\n<tr><th>check</th><th>found</th><th>at most</th><th></th></tr>\n",
        );
        for check in checks {
            let (class, word) = if check.passed { ("good", "passed") } else { ("bad", "failed") };
            let _ = writeln!(
                self.body,
                "<tr><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"{class}\">{word}</td></tr>",
                escape(&check.name),
                with_error(check.found, None),
                with_error(check.allowed, None),
            );
        }
        self.body.push_str("</table></div>\n");
    }

    /// Returns the complete file.
    pub fn html(&self) -> String {
        include_str!("page.html")
            .replace("{{title}}", &escape(&self.title))
            .replace("{{version}}", env!("CARGO_PKG_VERSION"))
            .replace("{{body}}", &self.body)
    }

    fn element(&mut self, tag: &str, text: &str) {
        let name = tag.split(' ').next().unwrap_or(tag);
        let _ = writeln!(self.body, "<{tag}>{}</{name}>", escape(text));
    }
}

/// A cell with more characters than this is text and may break into lines. Less: numbers with their
/// errors break. More: text makes the table wider than the page.
const LONGEST_NUMBER: usize = 24;

/// Formats a prediction with one digit more than the measured value.
fn predicted(value: f64, figure: &Figure) -> String {
    match figure.standard_error {
        Some(error) if value != 0.0 && error > 0.0 && error.is_finite() => {
            format!("{value:.0$}", (2.0 - error.log10().floor()).clamp(0.0, 12.0) as usize)
        }
        _ => with_error(value, None),
    }
}

/// Formats a value to the digits that its standard error justifies, or to six.
pub fn with_error(value: f64, standard_error: Option<f64>) -> String {
    match standard_error {
        // A smaller error is that of rounding.
        Some(error) if error > 1e-12 * value.abs() && error.is_finite() => {
            let decimals = (1.0 - error.log10().floor()).clamp(0.0, 12.0) as usize;
            format!("{value:.decimals$} ± {error:.decimals$}")
        }
        _ if value == 0.0 => "0".to_owned(),
        _ if value.fract() == 0.0 && value.abs() < 1e15 => format!("{value:.0}"),
        _ if value.abs() >= 1e6 || value.abs() < 1e-4 => format!("{value:.3e}"),
        _ => {
            let decimals = (5.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize;
            let text = format!("{value:.decimals$}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    }
}

/// Escapes text for HTML.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            other => escaped.push(other),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        let evil = "<script>alert('1')</script> & \"x\"";
        let mut page = Page::new(evil, evil);
        page.paragraph(evil);
        page.code(evil);
        page.facts(&[("a", evil.to_owned())]);
        page.figures(&[Figure::new(evil, 1.0, evil).predicted(1.0, evil)]);
        page.checks(&[Check::at_most(evil, 0.0, 0.0)]);
        page.pictures(Layout::Beside, &[("<svg></svg>", evil)]);
        page.table(&[evil], &[vec![evil.to_owned()]]);
        page.links([evil]);
        page.animation(&serde_json::to_string(evil).unwrap(), evil);
        let html = page.html();
        // One script of the page itself; for the animation, its data and its player.
        assert_eq!(html.matches("<script").count(), 3, "{html}");
        assert_eq!(html.matches("</script").count(), 3, "{html}");
        assert!(!html.contains("{{"), "a placeholder remains");
        assert!(html.contains("&lt;script&gt;"));
    }

    #[test]
    fn text_in_a_table_may_break_into_lines_but_numbers_may_not() {
        let mut page = Page::new("", "");
        let row = ["name", "350.62 ± 0.12", "no end in the processor time allowed"].map(str::to_owned);
        page.table(&["a", "b", "c"], &[row.to_vec()]);
        assert!(page.body.contains("<td>name</td><td class=\"number\">350.62 ± 0.12</td><td>no end"));
    }

    #[test]
    fn digits_follow_the_error() {
        assert_eq!(with_error(350.6183, Some(0.123)), "350.62 ± 0.12");
        assert_eq!(with_error(0.029_12, Some(0.0017)), "0.0291 ± 0.0017");
        assert_eq!(with_error(1234.5, Some(30.0)), "1234 ± 30");
        assert_eq!(with_error(0.25, None), "0.25");
        assert_eq!(with_error(3e-16, None), "3.000e-16");
        assert_eq!(with_error(12_345_678.0, None), "12345678");
        assert_eq!(with_error(f64::NAN, None), "NaN");
    }
}
