//! The page that a run leaves behind: one HTML file with everything in it, readable by day and by night.

use std::fmt::Write as _;

use carom_tables::{Check, Figure, OneRun, Totals};

/// A page that is being written, from top to bottom.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    body: String,
}

/// How pictures stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Each over the whole width.
    Full,
    /// Side by side where there is room.
    Beside,
}

impl Page {
    /// A page with its heading and what it is about.
    pub fn new(title: &str, lead: &str) -> Self {
        let body = format!("<h1>{}</h1>\n<p class=\"lead\">{}</p>\n", escape(title), escape(lead));
        Self { title: title.to_owned(), body }
    }

    /// A part of a page, without heading of its own.
    pub fn section() -> Self {
        Self { title: String::new(), body: String::new() }
    }

    /// Puts a part at the end.
    pub fn append(&mut self, section: &Self) {
        self.body.push_str(&section.body);
    }

    /// What a reader must know first.
    pub fn note(&mut self, text: &str) {
        self.element("p class=\"note\"", text);
    }

    /// A heading.
    pub fn heading(&mut self, text: &str) {
        self.element("h2", text);
    }

    /// A lesser heading.
    pub fn subheading(&mut self, text: &str) {
        self.element("h3", text);
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.element("p", text);
    }

    /// Something to type or to read in a terminal.
    pub fn code(&mut self, text: &str) {
        self.element("pre", text);
    }

    /// Links to files, by their path from the page.
    pub fn links<'a>(&mut self, paths: impl IntoIterator<Item = &'a str>) {
        let links: Vec<String> =
            paths.into_iter().map(|path| format!("<a href=\"{0}\">{0}</a>", escape(path))).collect();
        let _ = writeln!(self.body, "<p>{}</p>", links.join(" · "));
    }

    /// Pictures, as SVG with a caption each.
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

    /// A moving view, of what [`animation`](carom_runs::animation) has recorded.
    pub fn animation(&mut self, animation: &str, caption: &str) {
        // In a string of JSON this means the same, and can end no element of the page.
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

    /// A table of two columns.
    pub fn facts(&mut self, facts: &[(&str, String)]) {
        self.body.push_str("<div class=\"wide\"><table class=\"facts\">\n");
        for (name, value) in facts {
            let (name, value) = (escape(name), escape(value));
            let _ = writeln!(self.body, "<tr><th>{name}</th><td>{value}</td></tr>");
        }
        self.body.push_str("</table></div>\n");
    }

    /// A table of any columns; the first is text, the others are numbers, or text where they are too long for one.
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

    /// Figures with their errors, predictions and sources.
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

    /// What a run took.
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

    /// The runs of a campaign, one by one.
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

    /// Checks, passed or not.
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

    /// The whole file.
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

/// A cell of a table with more characters than this is no number, and may be broken into lines. Less: numbers with their
/// errors are broken. More: words in a table make it wider than the page.
const LONGEST_NUMBER: usize = 24;

/// A prediction to one digit more than the measured value.
fn predicted(value: f64, figure: &Figure) -> String {
    match figure.standard_error {
        Some(error) if value != 0.0 && error > 0.0 && error.is_finite() => {
            format!("{value:.0$}", (2.0 - error.log10().floor()).clamp(0.0, 12.0) as usize)
        }
        _ => with_error(value, None),
    }
}

/// A value to as many digits as its standard error bears, or to six.
pub fn with_error(value: f64, standard_error: Option<f64>) -> String {
    match standard_error {
        Some(error) if error > 0.0 && error.is_finite() => {
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

/// Text as HTML that says just that.
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
        // That of the page itself; of the animation, its data and what plays them.
        assert_eq!(html.matches("<script").count(), 3, "{html}");
        assert_eq!(html.matches("</script").count(), 3, "{html}");
        assert!(!html.contains("{{"), "a placeholder is left");
        assert!(html.contains("&lt;script&gt;"));
    }

    #[test]
    fn words_in_a_table_may_be_broken_into_lines_and_numbers_not() {
        let mut page = Page::section();
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
