#![allow(missing_docs, dead_code)]
#[path = "../../../xtask/src/repository.rs"]
mod repository;
#[path = "../../../xtask/src/site/mod.rs"]
mod site;
use carom_runs::console::{Console, Program};
use clap::Parser;
#[derive(Debug, Parser)]
#[command(name = "cargo xtask site")]
struct Cli {
    #[command(flatten)]
    options: site::SiteOptions,
    #[command(flatten)]
    console: Console,
}
impl Program for Cli {
    fn console(&self) -> Console {
        self.console
    }
    fn run(&self) -> anyhow::Result<carom_tables::Verdict> {
        site::run(&self.options)
    }
}
fn main() -> std::process::ExitCode {
    carom_runs::console::main::<Cli>()
}
