//! `carom live`: a page in the browser on which a simulation runs, to watch, measure and edit it.
//!
//! Internal: a part of the program `carom`. Its public items serve the other crates of it, and
//! change without notice.
//!
//! One [`laboratory`](self) owns the simulation. The page sends it commands and receives frames.
//! Two engines drive it:
//! - With the feature `server`, a thread of a program: a server passes the messages of the pages.
//!   Commands come through a bounded queue, and frames go through a slot of one, whose content is
//!   replaced, so that no browser can make the engine wait.
//! - Without it, [`LaboratoryOfPage`]: a laboratory for one page, without threads, files and
//!   sockets, for WebAssembly.

mod body_list;
#[cfg(feature = "server")]
mod command;
#[cfg(feature = "server")]
mod connections;
#[cfg(feature = "server")]
mod engine_thread;
mod follower;
mod frame;
mod gallery;
mod heating;
mod laboratory;
mod laboratory_of_page;
mod measured_files;
mod pace;
mod page;
mod protocol;
mod report;
mod requests;
#[cfg(feature = "server")]
mod reserve;
mod rules;
mod run_store;
#[cfg(feature = "server")]
mod saved_runs;
#[cfg(feature = "server")]
mod server;
mod triangles;
mod viewers;
mod zip_file;

#[cfg(feature = "server")]
pub use {
    command::{LiveOptions, run},
    engine_thread::LaboratoryEnd,
    server::{SAVE_INTERVAL, Server},
};

pub use gallery::{EXHIBITS, Exhibit, thumbnail};
pub use laboratory_of_page::LaboratoryOfPage;
pub use page::{PageEngine, page};
pub use viewers::Outgoing;
