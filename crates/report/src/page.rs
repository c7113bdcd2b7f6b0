//! The page of a run: one self-contained HTML file with a light and a dark colour scheme, which
//! leads with its answer.
//!
//! A page consists of [parts](PagePart), which it shows in one order whatever the order of
//! writing: the verdict with what carries it, the moving picture, results, data, the command, and
//! checks.

mod gallery;
mod inert_svg;
mod parts;

use std::fmt::Write as _;

use base64::{Engine as _, prelude::BASE64_STANDARD};
use carom_tables::{
    Check, Figure, OneRun, Totals, grouped, in_parentheses, named, predicted as predicted_value,
    two_digits, with_error,
};
use sha2::{Digest as _, Sha256};

pub use gallery::GalleryCard;
pub use parts::PagePart;
use parts::PageParts;

/// A page under construction.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    /// Links above the title.
    navigation: String,
    lead: String,
    verdict: String,
    /// Above the verdict.
    errors: String,
    /// Below the verdict.
    notes: String,
    /// All checks so far.
    checks: Vec<Check>,
    parts: PageParts,
    /// Where text, tables and pictures go.
    part: PagePart,
}

/// Layout of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Each over the full width.
    Full,
    /// Side by side if the width allows.
    Beside,
}

/// A chart with the file of its data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DataChart {
    /// The chart.
    pub svg: String,
    /// What the reader must know; may be empty.
    pub caption: String,
    /// Path of the data relative to the page; may be empty.
    pub file: String,
}

impl Page {
    /// A page with its title and an introductory sentence.
    pub fn new(title: &str, lead: &str) -> Self {
        let (title, lead) = (title.to_owned(), lead.to_owned());
        let [navigation, verdict, errors, notes] = [const { String::new() }; 4];
        let (checks, parts) = (Vec::new(), PageParts::default());
        Self {
            title,
            navigation,
            lead,
            verdict,
            errors,
            notes,
            checks,
            parts,
            part: PagePart::Results,
        }
    }

    /// Adds links to other pages of a site above the title: paths relative to the page, with
    /// their names.
    pub fn navigation(&mut self, links: &[(String, String)]) {
        let links: Vec<String> = links
            .iter()
            .map(|(path, name)| format!("<a href=\"{}\">{}</a>", escape(path), escape(name)))
            .collect();
        self.navigation = format!("<p class=\"files\">{}</p>\n", links.join(" · "));
    }

    /// Adds a gallery of cards, with a box and buttons that filter them.
    pub fn gallery(&mut self, cards: &[GalleryCard]) {
        self.push(&gallery::html(cards));
    }

    /// Sets the verdict: the answer in a sentence, above everything else. The default is the result
    /// of the checks.
    pub fn verdict(&mut self, sentence: &str) {
        sentence.clone_into(&mut self.verdict);
    }

    /// Adds an error, above the verdict.
    pub fn error(&mut self, text: &str) {
        let _ = writeln!(self.errors, "<p class=\"note error\">{}</p>", escape(text));
    }

    /// Adds a highlighted note below the verdict, such as a caveat.
    pub fn note(&mut self, text: &str) {
        let _ = writeln!(self.notes, "<p class=\"note\">{}</p>", escape(text));
    }

    /// Continues in another part of the page. Pages begin with [`PagePart::Results`].
    pub fn part(&mut self, part: PagePart) {
        self.part = part;
    }

    /// Adds a heading; one without content before the next is left out.
    pub fn heading(&mut self, text: &str) {
        self.parts.heading(self.part, 2, text);
    }

    /// Adds a subheading; one without content before the next is left out.
    pub fn subheading(&mut self, text: &str) {
        self.parts.heading(self.part, 3, text);
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.push(&format!("<p>{}</p>\n", prose(text)));
    }

    /// Adds the commands that run it again, to their own part of the page.
    pub fn code(&mut self, text: &str) {
        self.parts
            .push(PagePart::Again, &format!("<pre>{}</pre>\n", escape(text)));
    }

    /// Adds a file that opens on demand, to the part with the commands.
    pub fn folded(&mut self, title: &str, text: &str) {
        let html = format!(
            "<details>\n<summary>{}</summary>\n<pre>{}</pre>\n</details>\n",
            escape(title),
            escape(text)
        );
        self.parts.push(PagePart::Again, &html);
    }

    /// Adds links to files, by their path relative to the page, to the part with the data.
    pub fn links<'a>(&mut self, paths: impl IntoIterator<Item = &'a str>) {
        let links: Vec<String> = paths.into_iter().map(link).collect();
        self.parts.push(
            PagePart::Data,
            &format!("<p class=\"files\">{}</p>\n", links.join(" · ")),
        );
    }

    /// Adds a table of files, by their path relative to the page, and what they hold, to the part
    /// with the data.
    pub fn files(&mut self, files: &[(String, String)]) {
        let mut html =
            "<div class=\"wide\"><table>\n<tr><th>file</th><th>content</th></tr>\n".to_owned();
        for (path, content) in files {
            let _ = writeln!(
                html,
                "<tr><td>{}</td><td class=\"text\">{}</td></tr>",
                link(path),
                escape(content)
            );
        }
        html.push_str("</table></div>\n");
        self.parts.push(PagePart::Data, &html);
    }

    /// Adds SVG pictures, each with a caption.
    pub fn pictures(&mut self, layout: Layout, pictures: &[(&str, &str)]) {
        let figures = pictures
            .iter()
            .map(|(svg, caption)| figure(svg, &escape(caption)));
        let figures: String = figures.collect();
        self.push(&format!(
            "<div class=\"{}\">\n{figures}</div>\n",
            layout.class()
        ));
    }

    /// Adds charts side by side, each with its caption and a link to its data.
    pub fn charts(&mut self, charts: &[DataChart]) {
        if charts.is_empty() {
            return;
        }
        let figures = charts.iter().map(|chart| {
            let caption = escape(&chart.caption);
            let caption = match (chart.file.as_str(), chart.caption.as_str()) {
                ("", _) => caption,
                (file, "") => link(file),
                (file, _) => format!("{}. {caption}", link(file)),
            };
            figure(&chart.svg, &caption)
        });
        let figures: String = figures.collect();
        self.push(&format!(
            "<div class=\"{}\">\n{figures}</div>\n",
            Layout::Beside.class()
        ));
    }

    /// Adds an animation from the data that `carom-runs` records, to a part of its own.
    pub fn animation(&mut self, animation: &str, caption: &str) {
        // In a JSON string this has the same meaning and cannot close an element of the page.
        let animation = animation.replace('<', "\\u003c");
        let html = format!(
            "<figure class=\"animation\">\n<div class=\"views\"></div>\n<div class=\"controls\"></div>\n\
             <figcaption>{}</figcaption>\n<script type=\"application/json\">{animation}</script>\n</figure>\n\
             <script>\n{PLAYER}</script>\n",
            escape(caption),
        );
        self.parts.push(PagePart::Motion, &html);
    }

    /// Adds a table of two columns.
    pub fn facts(&mut self, facts: &[(&str, String)]) {
        let html = facts_html(facts);
        self.push(&html);
    }

    /// Adds a table of any number of columns: the first is text; the others are numbers, or text
    /// where longer than a number.
    pub fn table(&mut self, header: &[&str], rows: &[Vec<String>]) {
        self.push(&table_html(header, rows));
    }

    /// Adds a table of figures with units and errors, and with predictions and their sources where
    /// there are any.
    pub fn figures(&mut self, figures: &[Figure]) {
        let are_predicted = figures.iter().any(|figure| figure.prediction.is_some());
        let [predicted, source] = if are_predicted {
            ["<th>predicted</th>", "<th>source of the prediction</th>"]
        } else {
            [""; 2]
        };
        let has_tests = figures
            .iter()
            .any(|figure| figure.smallest_difference.is_some());
        let least = if has_tests {
            "<th>smallest difference that would have been found</th>"
        } else {
            ""
        };
        let mut html = format!(
            "<div class=\"wide\"><table>\n<tr><th>figure (unit)</th><th>measured</th>\
             {predicted}{least}{source}</tr>\n"
        );
        for figure in figures {
            let mut measured = grouped(&with_error(figure.value, figure.standard_error));
            if figure
                .stationarity
                .is_some_and(|found| !found.is_stationary)
            {
                measured += "<br>not stationary";
            }
            let value = figure.prediction.map_or_else(
                || "–".to_owned(),
                |value| grouped(&predicted_value(value, figure)),
            );
            let source = escape(figure.source.as_deref().unwrap_or(""));
            let [value, source] = if are_predicted {
                [
                    format!("<td class=\"number\">{value}</td>"),
                    format!("<td class=\"source\">{source}</td>"),
                ]
            } else {
                [String::new(), String::new()]
            };
            let least = figure
                .smallest_difference
                .map(|least| grouped(&with_error(two_digits(least), None)));
            let least = least.unwrap_or_else(|| "–".to_owned());
            let least = if has_tests {
                format!("<td class=\"number\">{least}</td>")
            } else {
                String::new()
            };
            let _ = writeln!(
                html,
                "<tr><td class=\"name\">{}</td><td class=\"number\">{measured}</td>\
                 {value}{least}{source}</tr>",
                escape(&named(&figure.name, &figure.unit)),
            );
        }
        html.push_str("</table></div>\n");
        self.push(&html);
    }

    /// Adds the totals of a run, to the part with the checks.
    pub fn totals(&mut self, totals: &Totals) {
        let number = |value: f64| with_error(value, None);
        let html = facts_html(&[
            ("simulated time", number(totals.simulated_time)),
            ("collisions", totals.collisions.to_string()),
            (
                "collisions per processor second",
                format!("{:.0}", totals.collisions_per_second),
            ),
            ("energy drift, relative", number(totals.energy_drift)),
            ("overlapping pairs", totals.overlapping_pairs.to_string()),
            ("deepest overlap (diameters)", number(totals.max_overlap)),
        ]);
        self.parts.push(PagePart::Checks, &html);
    }

    /// Adds a table of the runs of a campaign.
    pub fn runs(&mut self, runs: &[OneRun]) {
        let row = |run: &OneRun| {
            let rate = run.collisions as f64 / run.cpu_seconds / 1e6;
            let (seconds, rate) = (format!("{:.1}", run.cpu_seconds), format!("{rate:.2}"));
            vec![run.name.clone(), run.collisions.to_string(), seconds, rate]
        };
        let header = [
            "run",
            "collisions",
            "processor time (s)",
            "collisions (millions per second)",
        ];
        let html = table_html(&header, &runs.iter().map(row).collect::<Vec<_>>());
        // The times differ between runs of the same bits.
        self.push(&html.replace("<tr><td", "<tr class=\"speed\"><td"));
    }

    /// Adds a table of checks, to a part of its own.
    pub fn checks(&mut self, checks: &[Check]) {
        let mut html =
            "<div class=\"wide\"><table>\n<tr><th>check</th><th>found</th><th>at most</th><th>result</th></tr>\n"
                .to_owned();
        for check in checks {
            let (class, word) = if check.passed {
                ("good", "passed")
            } else {
                ("bad", "failed")
            };
            let [found, allowed] =
                [check.found, check.allowed].map(|value| grouped(&with_error(value, None)));
            let _ = writeln!(
                html,
                "<tr><td>{}</td><td class=\"number\">{found}</td><td class=\"number\">{allowed}</td>\
                 <td class=\"{class}\">{word}</td></tr>",
                escape(&check.name.replace('_', " ")),
            );
        }
        html.push_str("</table></div>\n");
        self.parts.push(PagePart::Checks, &html);
        self.checks.extend_from_slice(checks);
    }

    /// Returns the complete file.
    pub fn html(&self) -> String {
        let mut body = self.navigation.clone();
        let _ = writeln!(body, "<h1>{}</h1>", escape(&self.title));
        body.push_str(&self.errors);
        let verdict = match self.verdict.as_str() {
            "" if self.checks.is_empty() => String::new(),
            "" => checks_in_words(&self.checks),
            words => words.to_owned(),
        };
        if !verdict.is_empty() {
            let _ = writeln!(body, "<p class=\"verdict\">{}</p>", prose(&verdict));
        }
        body.push_str(&self.notes);
        if !self.lead.is_empty() {
            let _ = writeln!(body, "<p class=\"lead\">{}</p>", escape(&self.lead));
        }
        body.push_str(&self.parts.html());
        laid_out(&escape(&self.title), &body)
    }

    fn push(&mut self, html: &str) {
        self.parts.push(self.part, html);
    }
}

impl Layout {
    fn class(self) -> &'static str {
        match self {
            Self::Full => "pictures full",
            Self::Beside => "pictures",
        }
    }
}

/// A cell with more characters than this is text and may break into lines. Less: numbers with their
/// errors break. More: text makes the table wider than the page.
const MAX_NUMBER: usize = 24;

/// The scripts of a page.
const THEME: &str = include_str!("theme.js");
const PLAYER: &str = include_str!("animation.js");

/// The page with this title and these elements.
fn laid_out(title: &str, body: &str) -> String {
    // The body comes last: its text is not searched for further names.
    include_str!("page.html")
        .replace("{{policy}}", &policy(body))
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
        .replace("{{theme}}", THEME)
        .replace("{{title}}", &title.replace("{{", "{ {"))
        .replace("{{body}}", body)
}

/// The Content-Security-Policy of a page: no script but its own runs, whatever the files hold from
/// which it is made, and nothing is loaded. Scripts are named by their hashes, so that a page made
/// again has the same bytes. The hash is that of the whole text of the element.
fn policy(body: &str) -> String {
    let of_gallery = body.contains(gallery::SCRIPT).then_some(gallery::SCRIPT);
    let scripts: Vec<String> = [THEME, PLAYER]
        .into_iter()
        .chain(of_gallery)
        .map(|script| hash_source(&format!("\n{script}")))
        .collect();
    format!(
        "default-src 'none'; script-src {}; style-src 'unsafe-inline'; img-src data:; \
         base-uri 'none'; form-action 'none'",
        scripts.join(" ")
    )
}

/// The hash of a script as a source of a Content-Security-Policy: `'sha256-…'`.
fn hash_source(script: &str) -> String {
    format!(
        "'sha256-{}'",
        BASE64_STANDARD.encode(Sha256::digest(script))
    )
}

/// Sets the content of a page, which this or an earlier version wrote, in the present layout;
/// `None` if it is not such a page.
pub fn relaid(html: &str) -> Option<String> {
    let (_, title) = html.split_once("<title>")?;
    let (title, _) = title.split_once("</title>")?;
    let (_, main) = html.split_once("<main>")?;
    let (main, _) = main.rsplit_once("<footer>")?;
    let (_, body) = main.split_once("</button>")?;
    Some(laid_out(
        title,
        &format!("{}\n", with_present_player(body.trim())),
    ))
}

/// Elements of a page with the player of this version: the policy of the page allows no other.
fn with_present_player(body: &str) -> String {
    const BEGIN: &str = "<script>";
    let mut pieces = body.split(BEGIN);
    let mut all = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let after = piece.split_once("</script>").map_or("", |(_, after)| after);
        let _ = write!(all, "{BEGIN}\n{PLAYER}</script>{after}");
    }
    all
}

/// The result of all checks in a sentence, which names those that failed.
pub fn checks_in_words(checks: &[Check]) -> String {
    let failed: Vec<&Check> = checks.iter().filter(|check| !check.passed).collect();
    let count = checks.len();
    match failed.as_slice() {
        [] if count == 0 => "Nothing was checked.".to_owned(),
        [] if count == 1 => "The check passed.".to_owned(),
        [] => format!("All {count} checks passed."),
        [first, rest @ ..] => {
            let [found, allowed] =
                [first.found, first.allowed].map(|value| with_error(value, None));
            let others = if rest.is_empty() { "" } else { " first" };
            let name = first.name.replace('_', " ");
            format!(
                "FAILED: {} of {count} checks,{others} \u{201c}{name}\u{201d} with {found}, at most {allowed} is allowed.",
                failed.len()
            )
        }
    }
}

/// Text with grouped digits, and per cent signs that stay with their numbers.
fn prose(text: &str) -> String {
    escape(&grouped(text)).replace(" %", "\u{202f}%")
}

fn link(path: &str) -> String {
    format!("<a href=\"{0}\">{0}</a>", escape(path))
}

/// A picture without what stands before its element, or the reason for which it is not shown.
fn picture(svg: &str) -> String {
    let svg = &svg[svg.find("<svg").unwrap_or(0)..];
    match inert_svg::fault(svg) {
        None => svg.to_owned(),
        Some(fault) => {
            format!(
                "<p class=\"note error\">This picture is not shown: {}.</p>",
                escape(&fault)
            )
        }
    }
}

/// A picture with a caption in HTML.
fn figure(svg: &str, caption: &str) -> String {
    let svg = picture(svg);
    let caption = if caption.is_empty() {
        String::new()
    } else {
        format!("<figcaption>{caption}</figcaption>\n")
    };
    format!("<figure>\n<div class=\"picture\">{svg}</div>\n{caption}</figure>\n")
}

/// A longer header gets a wide column: in a narrow one it would be a tower of single words.
const LONG_HEADER: usize = 28;

/// A table; see [`Page::table`].
fn table_html(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut html = "<div class=\"wide\"><table>\n<tr>".to_owned();
    for name in header {
        let class = if name.chars().count() > LONG_HEADER {
            " class=\"long\""
        } else {
            ""
        };
        let _ = write!(html, "<th{class}>{}</th>", escape(&in_parentheses(name)));
    }
    for row in rows {
        html.push_str("</tr>\n<tr>");
        for (column, cell) in row.iter().enumerate() {
            let is_text = cell.chars().count() > MAX_NUMBER;
            let class = match (column, is_text) {
                (_, true) => " class=\"text\"",
                (0, false) => "",
                (_, false) => " class=\"number\"",
            };
            // Seeds are names, which a reader copies.
            let is_name = header.get(column).is_some_and(|name| name.contains("seed"));
            let cell = if is_name { cell.clone() } else { grouped(cell) };
            let _ = write!(html, "<td{class}>{}</td>", escape(&cell));
        }
    }
    html.push_str("</tr>\n</table></div>\n");
    html
}

fn facts_html(facts: &[(&str, String)]) -> String {
    let mut html = "<div class=\"wide\"><table class=\"facts\">\n".to_owned();
    for (name, value) in facts {
        let (name, value) = (escape(name), escape(&grouped(value)));
        let _ = writeln!(html, "<tr><th>{name}</th><td>{value}</td></tr>");
    }
    html.push_str("</table></div>\n");
    html
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
    use carom_tables::allowed_drift;

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
        let row = [
            "name",
            "350.62 ± 0.12",
            "no end in the processor time allowed",
        ]
        .map(str::to_owned);
        page.table(&["a", "b", "c"], &[row.to_vec()]);
        let cells = "<td>name</td><td class=\"number\">350.62 ± 0.12</td><td class=\"text\">no end";
        assert!(page.html().contains(cells));
    }

    #[test]
    fn the_verdict_comes_first_and_the_checks_last_whatever_the_order_of_writing() {
        let mut page = Page::new("Title", "Lead");
        page.checks(&[Check::at_most("one_thing", 0.0, 0.0)]);
        page.links(["data.csv"]);
        page.code("carom run");
        page.animation("{}", "moving");
        page.heading("Results");
        page.paragraph("12345678 collisions");
        page.part(PagePart::Answer);
        page.table(
            &["seed", "count"],
            &[vec!["12345".to_owned(), "12345".to_owned()]],
        );
        page.note("A note.");
        page.error("An error.");
        page.verdict("All is well.");
        let html = page.html();
        let order = [
            "An error.",
            "All is well.",
            "A note.",
            "Lead",
            "<td>12345</td><td class=\"number\">12\u{202f}345</td>",
            "Moving picture",
            "<h2>Results",
            "12\u{202f}345\u{202f}678",
            "<h2>Data",
            "<h2>Run it again",
            "<h2>Checks",
            "one thing",
        ];
        let places: Vec<usize> = order
            .iter()
            .map(|text| html.find(text).unwrap_or_else(|| panic!("no {text}")))
            .collect();
        assert!(places.is_sorted(), "{places:?}");
    }

    #[test]
    fn hashes_of_scripts_are_those_of_the_standard() {
        // Content Security Policy Level 2, section 7.17.
        let source = "'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng='";
        assert_eq!(hash_source("alert('Hello, world.');"), source);
    }

    #[test]
    fn the_policy_allows_the_scripts_of_the_page_and_no_other() {
        let mut page = Page::new("Title", "Lead");
        page.animation("{}", "moving");
        let html = page.html();
        let (_, policy) = html
            .split_once("Content-Security-Policy\" content=\"")
            .unwrap();
        let policy = policy.split_once('"').unwrap().0;
        assert!(
            policy.contains("default-src 'none'") && !policy.contains("script-src 'unsafe"),
            "{policy}"
        );
        let scripts: Vec<&str> = html
            .split("<script>")
            .skip(1)
            .filter_map(|rest| Some(rest.split_once("</script>")?.0))
            .collect();
        assert_eq!(scripts.len(), 2);
        for script in scripts {
            assert!(policy.contains(&hash_source(script)), "{script}");
        }
        assert_eq!(policy.matches("sha256-").count(), 2);
        // Before everything that comes from files.
        assert!(html.find("Content-Security-Policy") < html.find("<title>"));
    }

    #[test]
    fn a_picture_with_a_script_is_not_shown() {
        let mut page = Page::new("Title", "Lead");
        let evil = "<?xml?><svg><script>alert(1)</script></svg>";
        page.charts(&[DataChart {
            svg: evil.to_owned(),
            caption: String::new(),
            file: "a.svg".to_owned(),
        }]);
        page.pictures(Layout::Full, &[("<svg onload=\"alert(1)\"></svg>", "")]);
        let html = page.html();
        assert!(!html.contains("alert(1)"), "{html}");
        assert!(
            html.contains("not shown: it has the element &lt;script&gt;"),
            "{html}"
        );
        assert!(
            html.contains("not shown: it has the attribute onload"),
            "{html}"
        );
    }

    #[test]
    fn a_page_laid_out_again_gets_the_player_of_this_version() {
        let mut page = Page::new("Title", "Lead");
        page.animation("{}", "moving");
        let html = page.html();
        let old = html.replace(PLAYER, "// An older player.\n");
        assert!(old.contains("older player"));
        assert_eq!(relaid(&old), Some(html.clone()));
        let evil = html.replacen("<h1>", "<script>alert(1)</script><h1>", 1);
        assert!(!relaid(&evil).unwrap().contains("alert(1)"));
    }

    #[test]
    fn a_page_can_be_laid_out_again() {
        let mut page = Page::new("A & B", "Lead");
        page.paragraph("<footer> in a text");
        let html = page.html();
        assert_eq!(relaid(&html).as_deref(), Some(html.as_str()));
        let old = html.replace(".verdict", ".old");
        assert_eq!(relaid(&old), Some(html));
        assert_eq!(relaid("<html>another</html>"), None);
    }

    #[test]
    fn a_failed_check_is_named_in_words() {
        let checks = [
            Check::at_most("energy_drift", 0.0, allowed_drift(0, None)),
            Check::at_most("overlapping_pairs", 2.0, 0.0),
        ];
        assert_eq!(checks_in_words(&checks[..1]), "The check passed.");
        let words = checks_in_words(&checks);
        assert!(
            words.starts_with("FAILED: 1 of 2 checks, \u{201c}overlapping pairs\u{201d} with 2"),
            "{words}"
        );
    }
}
