//! Mutations and reductions of texts and bytes.

use crate::fuzz::random::FuzzDraw;

/// Boundary values for numbers in files, as text.
const NUMBERS: [&str; 34] = [
    "nan",
    "inf",
    "-inf",
    "NaN",
    "0",
    "0.0",
    "-0.0",
    "1",
    "-1",
    "1.0",
    "-1.0",
    "0.5",
    "2",
    "3",
    "1e-300",
    "5e-324",
    "1e-60",
    "1e-61",
    "1e-30",
    "1e-12",
    "1e-6",
    "1e6",
    "1e20",
    "1e60",
    "1.1e60",
    "1e154",
    "1e308",
    "1e400",
    "-1e400",
    "9223372036854775807",
    "9223372036854775808",
    "134217729",
    "\"\"",
    "true",
];

/// Applies one to four mutations to a text: numbers, lines and bytes are changed, removed,
/// duplicated or swapped.
pub fn text(draw: &mut FuzzDraw, text: &str) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..draw.integer(1, 4) {
        bytes = match draw.index(10) {
            0..=4 => with_number(draw, &bytes),
            5 => with_lines(draw, &bytes),
            6 | 7 => with_number_nearby(draw, &bytes),
            _ => self::bytes(draw, &bytes),
        };
    }
    bytes
}

/// Applies one change to bytes: one is flipped, replaced, removed or duplicated, or eight become a
/// number.
pub fn bytes(draw: &mut FuzzDraw, bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if bytes.is_empty() {
        return vec![draw.bits() as u8];
    }
    let at = draw.index(bytes.len());
    match draw.index(6) {
        0 => bytes[at] ^= 1 << draw.index(8),
        1 => bytes[at] = draw.bits() as u8,
        2 => drop(bytes.remove(at)),
        3 => bytes.insert(at, draw.bits() as u8),
        4 => bytes.truncate(at),
        _ => {
            let number = if draw.happens(0.3) {
                f64::from_bits(draw.bits())
            } else {
                draw.one_of(&crate::fuzz::detection::bad_numbers::NASTY)
            };
            for (byte, new) in bytes[at..].iter_mut().zip(number.to_le_bytes()) {
                *byte = new;
            }
        }
    }
    bytes
}

/// Ranges of the numbers in a text.
fn numbers(bytes: &[u8]) -> Vec<(usize, usize)> {
    let part = |byte: u8| byte.is_ascii_digit() || b".+-eE".contains(&byte);
    let mut list = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let begin = at;
        while at < bytes.len() && part(bytes[at]) {
            at += 1;
        }
        let begins_word =
            begin > 0 && (bytes[begin - 1].is_ascii_alphabetic() || bytes[begin - 1] == b'_');
        if at > begin && !begins_word && bytes[begin..at].iter().any(u8::is_ascii_digit) {
            list.push((begin, at));
        }
        at = at.max(begin + 1);
    }
    list
}

fn replaced(bytes: &[u8], (begin, end): (usize, usize), new: &str) -> Vec<u8> {
    [&bytes[..begin], new.as_bytes(), &bytes[end..]].concat()
}

fn with_number(draw: &mut FuzzDraw, bytes: &[u8]) -> Vec<u8> {
    let numbers = numbers(bytes);
    if numbers.is_empty() {
        return bytes.to_vec();
    }
    let place = numbers[draw.index(numbers.len())];
    let new = if draw.happens(0.3) {
        format!("{:e}", draw.sign() * libm::exp(draw.between(-160.0, 160.0)))
    } else {
        draw.one_of(&NUMBERS).to_owned()
    };
    replaced(bytes, place, &new)
}

/// Multiplies a number by a factor: the result is accepted more often.
fn with_number_nearby(draw: &mut FuzzDraw, bytes: &[u8]) -> Vec<u8> {
    let numbers = numbers(bytes);
    if numbers.is_empty() {
        return bytes.to_vec();
    }
    let (begin, end) = numbers[draw.index(numbers.len())];
    let Some(number) = std::str::from_utf8(&bytes[begin..end])
        .ok()
        .and_then(|text| text.parse::<f64>().ok())
    else {
        return bytes.to_vec();
    };
    let factor = draw.one_of(&[-1.0, 0.5, 2.0, 10.0, 0.1, 1e3, 1e-3, 1.0 + 1e-15, 1e-9]);
    replaced(bytes, (begin, end), &(factor * number).to_string())
}

fn with_lines(draw: &mut FuzzDraw, bytes: &[u8]) -> Vec<u8> {
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    if lines.is_empty() {
        return bytes.to_vec();
    }
    let (at, other) = (draw.index(lines.len()), draw.index(lines.len()));
    match draw.index(3) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(other, lines[at]),
        _ => lines.swap(at, other),
    }
    lines.concat()
}

/// Texts with fewer lines, then with fewer bytes.
pub fn with_less_text(bytes: &[u8]) -> Vec<Vec<u8>> {
    let lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    let mut list = Vec::new();
    for width in [lines.len() / 2, lines.len() / 4, 4, 1] {
        for begin in (0..lines.len()).step_by(width.max(1)) {
            let end = (begin + width.max(1)).min(lines.len());
            list.push([&lines[..begin], &lines[end..]].concat().concat());
        }
    }
    if bytes.len() < 600 {
        for place in numbers(bytes) {
            if place.1 - place.0 > 1 {
                list.push(replaced(bytes, place, "1"));
            }
        }
        list.extend((0..bytes.len()).map(|at| [&bytes[..at], &bytes[at + 1..]].concat()));
    }
    list.retain(|less| less.len() < bytes.len());
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_a_text_are_found() {
        let text = b"x1 = [1.5, -2e-3]\nname = \"rod:16\"";
        let found: Vec<&[u8]> = numbers(text)
            .into_iter()
            .map(|(begin, end)| &text[begin..end])
            .collect();
        assert_eq!(found, [&b"1.5"[..], b"-2e-3", b"16"]);
    }

    #[test]
    fn smaller_texts_are_smaller() {
        let text = b"a = 10\nb = 2\nc = 3\n";
        let smaller = with_less_text(text);
        assert!(smaller.iter().all(|less| less.len() < text.len()));
        assert!(smaller.contains(&b"b = 2\nc = 3\n".to_vec()));
    }

    #[test]
    fn most_mutations_change_something() {
        let draw = &mut FuzzDraw::new(1);
        let text = "[box]\nsides = [1.0, 2.0]\n";
        let changed = (0..100)
            .filter(|_| self::text(draw, text) != text.as_bytes())
            .count();
        assert!(changed > 85, "{changed}");
    }
}
