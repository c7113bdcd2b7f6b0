//! A fuzzer of nothing, whose cases panic, hang or take too much memory: it shows that the worker
//! survives them.

use anyhow::Result;

use super::subject::{Report, Subject};

/// What a case does, by the remainder of its seed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Planted;

/// More than a worker may take (bytes).
const TOO_MUCH: usize = 1 << 40;

impl Subject for Planted {
    type Case = u64;
    const NAME: &'static str = "planted";
    const TIME_LIMIT: u64 = 1;

    fn draw(&self, seed: u64) -> u64 {
        seed
    }

    fn check(&self, case: &u64) -> Report {
        match case % 4 {
            0 => {}
            1 => panic!("planted"),
            2 => loop {
                std::thread::park();
            },
            _ => {
                // Kept from being optimised away.
                std::hint::black_box(Vec::<u8>::with_capacity(TOO_MUCH));
            }
        }
        let mut report = Report::default();
        report.count("sound", 1);
        report
    }

    fn simpler(&self, _: &u64) -> Vec<u64> {
        vec![]
    }

    fn write(&self, case: &u64) -> (String, Vec<u8>) {
        ("seed".to_owned(), case.to_string().into_bytes())
    }

    fn read(&self, _: &str, bytes: &[u8]) -> Result<u64> {
        Ok(std::str::from_utf8(bytes)?.parse()?)
    }
}
