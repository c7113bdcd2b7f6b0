//! Numbers of a scene file that are written as expressions: `"sqrt(3)/2"`, `"2*pi/7"`.

use std::{f64::consts::PI, ops::Range};

use toml::de::{DeTable, DeValue};

/// Keys whose text, or list of texts, is a name that a user chooses, and never a number.
const NAMES: [&str; 10] = [
    "tags", "tag", "name", "of", "between", "observe", "remove", "lock", "unlock", "figure",
];

/// The table whose `from` is the name of a file; that of a wall is a place.
const WITH_FILE: &str = "start";

/// Longer texts are no expressions. Longer: hostile files take long.
const MAX_LENGTH: usize = 200;

/// Deepest nesting of parentheses, signs and powers.
const MAX_DEPTH: usize = 32;

/// Largest whole number that is written without a point.
const MAX_WHOLE: f64 = 9_007_199_254_740_992.0;

/// The text of a scene file in which all expressions are replaced by their values. Lines stay as
/// they are, so that messages name the right ones. A text that is not TOML is returned as it is.
pub(crate) fn evaluated(text: &str) -> String {
    let Ok(table) = DeTable::parse(text) else {
        return text.to_owned();
    };
    let mut found = Vec::new();
    in_table(table.get_ref(), "", &mut found);
    found.sort_by_key(|(span, _)| span.start);
    let (mut all, mut done) = (String::with_capacity(text.len()), 0);
    for (span, value) in found {
        all.push_str(&text[done..span.start]);
        all.push_str(&value);
        done = span.end;
    }
    all.push_str(&text[done..]);
    all
}

fn in_table(table: &DeTable<'_>, name: &str, found: &mut Vec<(Range<usize>, String)>) {
    for (key, value) in table {
        let key = key.get_ref().as_ref();
        let may_be_name = NAMES.contains(&key) || (key == "from" && name == WITH_FILE);
        if !(may_be_name && is_text(value.get_ref())) {
            in_value(value.get_ref(), key, value.span(), found);
        }
    }
}

/// Whether a value is a text or a list of texts.
fn is_text(value: &DeValue<'_>) -> bool {
    match value {
        DeValue::String(_) => true,
        DeValue::Array(list) => list
            .iter()
            .all(|entry| matches!(entry.get_ref(), DeValue::String(_))),
        _ => false,
    }
}

fn in_value(
    value: &DeValue<'_>,
    name: &str,
    span: Range<usize>,
    found: &mut Vec<(Range<usize>, String)>,
) {
    match value {
        DeValue::String(text) => found.extend(value_of(text).map(|number| (span, literal(number)))),
        DeValue::Array(list) => {
            list.iter()
                .for_each(|entry| in_value(entry.get_ref(), name, entry.span(), found));
        }
        DeValue::Table(table) => in_table(table, name, found),
        _ => {}
    }
}

/// A number as TOML; whole ones without a point, so that they can be counts.
fn literal(number: f64) -> String {
    if number.fract() == 0.0 && number.abs() <= MAX_WHOLE {
        format!("{number:.0}")
    } else {
        format!("{number:?}")
    }
}

/// What an expression may hold, for messages.
pub(crate) const WORDS: &str =
    "numbers, pi, + - * / ^, parentheses, sqrt, exp, ln, sin, cos, tan (radians)";

/// The value of an expression of [`WORDS`]; `**` is a power, too. `None` if it is none, or has no
/// finite value.
pub(crate) fn value_of(text: &str) -> Option<f64> {
    let mut parser = Parser::new(text)?;
    let value = parser.sum()?;
    (parser.next().is_none() && value.is_finite()).then_some(value)
}

/// Why a text that stands where a number is expected has no value, as a clause.
pub(crate) fn problem_of(text: &str) -> String {
    let Some(mut parser) = Parser::new(text) else {
        return format!("it is longer than {MAX_LENGTH} bytes");
    };
    match (parser.sum(), parser.problem.take(), parser.next()) {
        (_, Some(problem), _) => problem,
        (None, _, None) => "it ends too early".to_owned(),
        (_, _, Some(character)) => format!("`{character}` is not understood there"),
        (Some(value), _, None) => format!("its value is {value}"),
    }
}

struct Parser<'a> {
    rest: &'a str,
    depth: usize,
    /// The first problem that is found, as a clause.
    problem: Option<String>,
}

impl<'a> Parser<'a> {
    /// Reads a text, unless it is too long.
    fn new(text: &'a str) -> Option<Self> {
        (text.len() <= MAX_LENGTH).then_some(Self {
            rest: text,
            depth: 0,
            problem: None,
        })
    }
}

impl Parser<'_> {
    /// The next character that is not blank.
    fn next(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    /// Takes the next character, if it is this one.
    fn take(&mut self, requested: char) -> bool {
        let found = self.next() == Some(requested);
        if found {
            self.rest = &self.rest[requested.len_utf8()..];
        }
        found
    }

    /// Takes this text, if it comes next.
    fn take_text(&mut self, requested: &str) -> bool {
        self.rest = self.rest.trim_start();
        let after = self.rest.strip_prefix(requested);
        self.rest = after.unwrap_or(self.rest);
        after.is_some()
    }

    /// Terms with + or − between them.
    fn sum(&mut self) -> Option<f64> {
        let mut value = self.product()?;
        loop {
            if self.take('+') {
                value += self.product()?;
            } else if self.take('-') {
                value -= self.product()?;
            } else {
                return Some(value);
            }
        }
    }

    fn product(&mut self) -> Option<f64> {
        let mut value = self.signed()?;
        loop {
            if self.take('*') {
                value *= self.signed()?;
            } else if self.take('/') {
                value /= self.signed()?;
            } else {
                return Some(value);
            }
        }
    }

    fn signed(&mut self) -> Option<f64> {
        self.deeper(|parser| {
            if parser.take('-') {
                return Some(-parser.signed()?);
            }
            let base = parser.atom()?;
            // −2^2 is −4, and 2^3^2 is 2^9, as in mathematics.
            if parser.take('^') || parser.take_text("**") {
                Some(base.powf(parser.signed()?))
            } else {
                Some(base)
            }
        })
    }

    /// A number, a name, or an expression in parentheses.
    fn atom(&mut self) -> Option<f64> {
        if self.take('(') {
            let value = self.deeper(Self::sum)?;
            return self.take(')').then_some(value);
        }
        let name = self.taken(char::is_alphabetic);
        if name.is_empty() {
            return self.number();
        }
        let function: fn(f64) -> f64 = match name.as_str() {
            "pi" | "π" => return Some(PI),
            "sqrt" => f64::sqrt,
            "exp" => libm::exp,
            "ln" => libm::log,
            "sin" => libm::sin,
            "cos" => libm::cos,
            "tan" => libm::tan,
            _ => {
                let problem = match name.as_str() {
                    "log" => "`log` is not known: the natural logarithm is `ln`".to_owned(),
                    _ => format!("`{name}` is not known"),
                };
                self.problem.get_or_insert(problem);
                return None;
            }
        };
        if !self.take('(') {
            return None;
        }
        let value = self.deeper(Self::sum)?;
        self.take(')').then(|| function(value))
    }

    fn number(&mut self) -> Option<f64> {
        let mut digits = self.taken(|c| c.is_ascii_digit() || c == '.');
        if self.rest.starts_with(['e', 'E']) && !digits.is_empty() {
            self.rest = &self.rest[1..];
            let sign = if self.rest.starts_with(['-', '+']) {
                &self.rest[..1]
            } else {
                ""
            };
            self.rest = &self.rest[sign.len()..];
            digits = format!("{digits}e{sign}{}", self.taken(|c| c.is_ascii_digit()));
        }
        let value = digits.parse().ok();
        if value.is_none() && !digits.is_empty() {
            self.problem
                .get_or_insert_with(|| format!("`{digits}` is no number"));
        }
        value
    }

    /// Takes the characters of a kind.
    fn taken(&mut self, of: impl Fn(char) -> bool) -> String {
        self.rest = self.rest.trim_start();
        let end = self.rest.find(|c| !of(c)).unwrap_or(self.rest.len());
        let (taken, rest) = self.rest.split_at(end);
        self.rest = rest;
        taken.to_owned()
    }

    fn deeper(&mut self, parse: impl FnOnce(&mut Self) -> Option<f64>) -> Option<f64> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            self.problem
                .get_or_insert_with(|| "it is nested too deeply".to_owned());
        }
        let value = (self.depth <= MAX_DEPTH).then(|| parse(self)).flatten();
        self.depth -= 1;
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn expressions_have_their_values() {
        for (text, value) in [
            ("sqrt(3)/2", 3f64.sqrt() / 2.0),
            ("2*pi/7", 2.0 * PI / 7.0),
            (" 1 + 2 * 3 ", 7.0),
            ("-2^2", -4.0),
            ("2^3^2", 512.0),
            ("2**3**2*2", 1024.0),
            ("2*π", 2.0 * PI),
            ("2^-1", 0.5),
            ("(1 + 2) * -3", -9.0),
            ("1e-3*2", 2e-3),
            ("8 - 2 - 1", 5.0),
            ("exp(ln(5))", 5.0),
            ("cos(0) + sin(0) + tan(0)", 1.0),
        ] {
            assert!(
                (value_of(text).unwrap() - value).abs() < 1e-15 * value.abs().max(1.0),
                "{text}"
            );
        }
        let deep = "(".repeat(60) + "1" + &")".repeat(60);
        for text in [
            "", "disc", "rod:9", "1/0", "sqrt(-1)", "2 3", "1..2", "e", "sqrt 2", "(1", "1)", "1e",
            &deep,
        ] {
            assert_eq!(value_of(text), None, "{text}");
        }
    }

    #[test]
    fn what_is_no_expression_is_told_why() {
        for (text, problem) in [
            (
                "log(2)",
                "`log` is not known: the natural logarithm is `ln`",
            ),
            ("2*tau", "`tau` is not known"),
            ("disc", "`disc` is not known"),
            ("1/0", "its value is inf"),
            ("2*", "it ends too early"),
            ("0,01", "`,` is not understood there"),
            ("1.2.3", "`1.2.3` is no number"),
            (&"(".repeat(60), "it is nested too deeply"),
            ("sqrt 2", "`2` is not understood there"),
            (&"1".repeat(300), "it is longer than 200 bytes"),
        ] {
            assert_eq!(problem_of(text), problem, "{text}");
        }
    }

    #[test]
    fn texts_keep_their_lines_and_names() {
        let text = "[box]\nsides = [\"sqrt(3)\", 1]\n[[gas]]\ntags = [\"12\"]\ncount = \"3*4\" # twelve\nshape = \"rod:3\"\n";
        let expected = format!(
            "[box]\nsides = [{:?}, 1]\n[[gas]]\ntags = [\"12\"]\ncount = 12 # twelve\nshape = \"rod:3\"\n",
            3f64.sqrt()
        );
        assert_eq!(evaluated(text), expected);
        assert_eq!(evaluated("no = = toml"), "no = = toml");
        for (text, expected) in [
            ("lock = [\"1\", \"pi\"]", "lock = [\"1\", \"pi\"]"),
            ("[start]\nfrom = \"1\"", "[start]\nfrom = \"1\""),
            (
                "[[wall]]\nfrom = [\"1/2\", \"1/4\"]",
                "[[wall]]\nfrom = [0.5, 0.25]",
            ),
            (
                "[[stage]]\ntag = [{ name = \"1\", count = \"3*4\" }]",
                "[[stage]]\ntag = [{ name = \"1\", count = 12 }]",
            ),
        ] {
            assert_eq!(evaluated(text), expected);
        }
        let inline = "x = { y = [\"1/4\", { z = \"pi\" }], of = \"1\" }";
        assert_eq!(
            evaluated(inline),
            format!("x = {{ y = [0.25, {{ z = {PI:?} }}], of = \"1\" }}")
        );
    }

    proptest! {
        #[test]
        fn no_text_hangs_or_panics(text in "[-+*/^()0-9.epi sqrtlog]{0,80}") {
            let value = value_of(&text);
            prop_assert!(value.is_none_or(f64::is_finite));
            prop_assert!(!problem_of(&text).is_empty());
        }
    }
}
