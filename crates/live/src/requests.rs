//! The first message to a page, and the way of its requests to the engine.

use carom_runs::measures::{KINDS, Span};
use serde_json::json;

use crate::{
    gallery::EXHIBITS,
    laboratory::Message,
    protocol::{self, LiveAnswer, LiveCommand, LiveRequest},
    viewers::{Viewer, Viewers},
};

/// What a page receives first.
pub fn hello(is_writer: bool) -> serde_json::Value {
    let measures = KINDS.iter().filter(|kind| kind.span != Span::EveryContact);
    let measures = measures.map(|kind| {
        let parameters = kind.all_parameters().map(|parameter| {
            json!({
                "name": parameter.name,
                "about": parameter.about,
                "default": parameter.default.to_string(),
            })
        });
        json!({
            "name": kind.name,
            "about": kind.summary,
            "usage": kind.usage(),
            "parameters": parameters.collect::<Vec<_>>(),
        })
    });
    json!({
        "hello": carom::VERSION,
        "writer": is_writer,
        "gallery": EXHIBITS,
        "measures": measures.collect::<Vec<_>>(),
    })
}

/// Answers a request of a page, or passes it on to the engine; `pass` returns why it cannot.
pub fn receive(
    text: &str,
    viewer: &Viewer,
    viewers: &Viewers,
    pass: impl FnOnce(Message) -> Result<(), &'static str>,
) {
    let request = match protocol::read(text) {
        Ok(request) => request,
        Err(refusal) => return viewer.answer(&refusal),
    };
    let id = request.id;
    match request.command {
        LiveCommand::View(window) if window.is_valid() => viewer.set_window(window),
        LiveCommand::View(_) => refuse(
            viewer,
            id,
            "the window must have finite borders and an area",
        ),
        LiveCommand::Seen(number) => viewer.has_seen(number),
        command if !matches!(command, LiveCommand::Choose(_)) && !viewers.is_writer(viewer.id) => {
            refuse(
                viewer,
                id,
                "another page controls the run; this one can only watch",
            );
        }
        LiveCommand::Choose(_) if !viewer.begins_to_choose() => {
            refuse(
                viewer,
                id,
                "the engine is busy with the choice before: try again",
            );
        }
        command => {
            let message = Message {
                viewer: viewer.id,
                request: LiveRequest { id, command },
            };
            if let Err(reason) = pass(message) {
                viewer.has_chosen();
                refuse(viewer, id, reason);
            }
        }
    }
}

/// Sends a refusal.
fn refuse(viewer: &Viewer, id: u64, reason: &str) {
    viewer.answer(&LiveAnswer::new(id, Err(reason.to_owned())));
}
