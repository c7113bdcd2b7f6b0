//! A fuzzer whose cases panic, hang or exhaust memory, to test that the worker survives them.

use anyhow::Result;

use super::subject::{Report, Subject};

/// Behaviour of a case, by the remainder of its seed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Planted;

/// More memory than a worker may allocate (bytes).
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
                // Prevents optimisation.
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
