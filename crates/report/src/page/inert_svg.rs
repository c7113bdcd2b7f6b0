//! Verifies that an SVG picture only draws: a page embeds pictures from folders that others may
//! have
//! written.
//!
//! Allowed are the elements and attributes with which programs of this project draw, and nothing
//! else:
//! a list of what is dangerous would never be complete.

/// Elements that draw.
const ELEMENTS: [&str; 16] = [
    "circle", "clipPath", "defs", "desc", "ellipse", "g", "line", "path", "polygon", "polyline",
    "rect", "style", "svg", "text", "title", "tspan",
];

/// Returns the reason for which a picture must not be embedded in a page; `None` if it only draws.
pub(super) fn fault(svg: &str) -> Option<String> {
    let mut rest = svg.trim();
    let mut open: Vec<&str> = Vec::new();
    if !rest.starts_with("<svg") {
        return Some("it does not begin with <svg>".to_owned());
    }
    loop {
        let (text, after) = rest.split_once('<').unwrap_or((rest, ""));
        if open.last() == Some(&"style") && !is_plain_style(text) {
            return Some("its style loads other files".to_owned());
        }
        if rest.len() == text.len() {
            return open
                .last()
                .map(|name| format!("its element <{name}> has no end"));
        }
        if let Some(closing) = after.strip_prefix('/') {
            let Some((name, after)) = closing.split_once('>') else {
                return Some("it is truncated".to_owned());
            };
            if open.pop() != Some(name.trim_end()) {
                return Some(format!("its element </{}> was not open", shown(name)));
            }
            rest = after;
        } else {
            let name = &after[..after
                .find(|c: char| !(c.is_ascii_alphanumeric() || ":-".contains(c)))
                .unwrap_or(after.len())];
            let name_in_list = ELEMENTS.iter().find(|element| **element == name);
            let Some(&name) = name_in_list else {
                return Some(format!("it has the element <{}>", shown(after)));
            };
            let (is_whole, after) = match attributes(&after[name.len()..]) {
                Ok(end) => end,
                Err(reason) => return Some(reason),
            };
            if !is_whole {
                open.push(name);
            }
            rest = after;
        }
        if open.is_empty() {
            return (!rest.trim().is_empty()).then(|| "it continues after its end".to_owned());
        }
    }
}

/// Reads attributes up to the end of the tag: whether it closes its element, and what follows.
fn attributes(mut rest: &str) -> Result<(bool, &str), String> {
    loop {
        rest = rest.trim_start();
        if let Some(after) = rest.strip_prefix("/>") {
            return Ok((true, after));
        }
        if let Some(after) = rest.strip_prefix('>') {
            return Ok((false, after));
        }
        let malformed = || format!("it has a malformed attribute: {}", shown(rest));
        let (name, after) = rest.split_once('=').ok_or_else(malformed)?;
        let name = name.trim_end();
        let is_name = |c: char| c.is_ascii_alphanumeric() || "-:".contains(c);
        let after = after.trim_start();
        let quote = after
            .chars()
            .next()
            .filter(|c| "\"'".contains(*c))
            .ok_or_else(malformed)?;
        let (value, after) = after[1..].split_once(quote).ok_or_else(malformed)?;
        if name.is_empty() || !name.chars().all(is_name) || value.contains('<') {
            return Err(malformed());
        }
        let lower = name.to_ascii_lowercase();
        let is_namespace = lower == "xmlns" || lower.starts_with("xmlns:");
        let is_link = ["href", "src"].contains(&lower.rsplit(':').next().unwrap_or(&lower));
        if lower.starts_with("on") || is_link || (!is_namespace && !is_plain_style(value)) {
            return Err(format!("it has the attribute {}", shown(name)));
        }
        rest = after;
    }
}

/// Whether a style, or an attribute that may hold one, refers to nothing outside of the picture.
fn is_plain_style(text: &str) -> bool {
    let lower: String = text
        .to_ascii_lowercase()
        .chars()
        .filter(|c| !c.is_whitespace())
        .collect();
    // An escape could hide a word.
    let is_escaped = lower.contains('\\') || lower.contains("&#");
    let is_script = lower.contains("javascript:") || lower.contains("expression(");
    let loads =
        lower.contains("@import") || lower.matches("url(").count() > lower.matches("url(#").count();
    !(is_escaped || is_script || loads || lower.contains("image-set"))
}

/// The first word of a text, for a message.
fn shown(text: &str) -> String {
    text.chars()
        .take_while(|c| !c.is_whitespace() && !"<>=".contains(*c))
        .take(20)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_this_project_are_accepted() {
        for svg in [
            "<svg></svg>",
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width='3' viewBox=\"0 0 1 1\">\n\
             <rect width=\"100%\" fill=\"white\"/><text x=\"1\">a &lt; b, a=b, x > y</text></svg>\n",
            "<svg><style>.a{fill:var(--b)}</style><clipPath id=\"p0\"><rect/></clipPath>\
             <g clip-path=\"url(#p0)\"><path d=\"M0 0l1 1z\" class=\"a b\"/></g></svg>",
            "<svg><svg x=\"1\"><circle r=\"2\" style=\"fill: red\" /></svg></svg>",
        ] {
            assert_eq!(fault(svg), None, "{svg}");
        }
    }

    #[test]
    fn pictures_that_do_more_than_draw_are_refused_by_name() {
        for (inner, reason) in [
            ("<script>alert(1)</script>", "<script>"),
            ("<SCRIPT>alert(1)</SCRIPT>", "<SCRIPT>"),
            ("<svg:script/>", "<svg:script/>"),
            ("<g onclick=\"alert(1)\"/>", "onclick"),
            ("<g OnLoad='alert(1)'/>", "OnLoad"),
            ("<g\nonload=alert(1)>", "malformed"),
            ("<g/onload=\"alert(1)\"/>", "malformed"),
            ("<foreignObject><p>x</p></foreignObject>", "<foreignObject>"),
            ("<image href=\"http://a/b\"/>", "<image>"),
            ("<a href=\"javascript:alert(1)\">x</a>", "<a>"),
            ("<use xlink:href=\"#a\"/>", "<use>"),
            ("<g xlink:href=\"http://a\"/>", "xlink:href"),
            ("<animate attributeName=\"href\"/>", "<animate>"),
            ("<set attributeName=\"onload\" to=\"alert(1)\"/>", "<set>"),
            ("<rect fill=\"url(http://a/b)\"/>", "fill"),
            ("<rect style=\"fill: u\\72l(http://a)\"/>", "style"),
            ("<rect style=\"fill:&#117;rl(http://a)\"/>", "style"),
            ("<style>@import 'http://a';</style>", "style loads"),
            (
                "<style>a{background:url( 'http://a')}</style>",
                "style loads",
            ),
            ("<!-- --><script/>", "<!-->"),
            ("<![CDATA[<script>]]>", "<![CDATA[>"),
            ("<?xml-stylesheet href='a'?>", "<?xml-stylesheet>"),
            ("<iframe src=\"a\"></iframe>", "<iframe>"),
            ("</svg></div><svg>", "continues after its end"),
            ("</p>", "was not open"),
            ("<g>", "was not open"),
        ] {
            let found = fault(&format!("<svg>{inner}</svg>"));
            assert!(
                found.as_ref().is_some_and(|words| words.contains(reason)),
                "{inner}: {found:?}"
            );
        }
        for svg in [
            "",
            "text",
            "<svg",
            "<svg>",
            "<svg></svg",
            "<svg></svg><script></script>",
            "<svgx></svgx>",
        ] {
            assert!(fault(svg).is_some(), "{svg}");
        }
    }
}
