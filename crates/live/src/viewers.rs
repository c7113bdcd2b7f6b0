//! The pages that are connected: what each shows, and what waits to be sent to it.
//!
//! What waits is bounded: one frame, one list of bodies, one status and one report of measures,
//! each replaced by its successor, and a few answers. A page that reads slowly misses frames.

use std::{
    collections::VecDeque,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use serde::Serialize;
#[cfg(feature = "server")]
use tokio::sync::Notify;

use crate::protocol::VisibleWindow;

/// Largest number of pages. More: the engine spends its time on frames.
pub const MAX_VIEWERS: usize = 8;

/// Largest number of answers that wait. A page with more does not read, and is disconnected.
const MAX_ANSWERS: usize = 256;

/// Largest number of frames that have been sent and not drawn. More: a slow page lags. Fewer: the
/// way there and back limits the frames of a second.
const MAX_UNSEEN: u32 = 3;

/// A message to a page.
#[derive(Debug)]
pub enum Outgoing {
    /// JSON.
    Text(String),
    /// A frame or a list of bodies.
    Binary(Arc<Vec<u8>>),
}

/// The connection ends.
#[derive(Debug)]
pub struct Closed;

/// What waits to be sent to a page.
#[derive(Debug, Default)]
struct Outbox {
    answers: VecDeque<String>,
    body_list: Option<Arc<Vec<u8>>>,
    status: Option<String>,
    measures: Option<String>,
    frame: Option<Arc<Vec<u8>>>,
    /// Number of the last frame sent, and of the last that the page has drawn.
    sent: u32,
    seen: u32,
    has_overflowed: bool,
    is_closed: bool,
}

/// A connected page.
#[derive(Debug)]
pub struct Viewer {
    /// Number of the page.
    pub id: u64,
    outbox: Mutex<Outbox>,
    /// What the page shows, and a number that changes with it.
    window: Mutex<(Option<VisibleWindow>, u64)>,
    /// Whether the engine has yet to hear of a body that the page has chosen.
    chooses: AtomicBool,
    /// Something waits to be sent.
    #[cfg(feature = "server")]
    ready: Notify,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Viewer {
    /// What the page shows, if it has said so, and a number that changes with it.
    pub fn window(&self) -> (Option<VisibleWindow>, u64) {
        *lock(&self.window)
    }

    /// Changes what the page shows.
    pub fn set_window(&self, window: VisibleWindow) {
        let mut shown = lock(&self.window);
        *shown = (Some(window), shown.1 + 1);
    }

    /// The page chooses a body; returns whether the engine has heard of its last choice. A page
    /// that only watches could otherwise fill the queue of the page that edits.
    pub fn begins_to_choose(&self) -> bool {
        !self.chooses.swap(true, Ordering::Relaxed)
    }

    /// The engine has heard of the choice.
    pub fn has_chosen(&self) {
        self.chooses.store(false, Ordering::Relaxed);
    }

    /// The page has drawn the frame of this number.
    pub fn has_seen(&self, number: u32) {
        let mut outbox = lock(&self.outbox);
        outbox.seen = number.min(outbox.sent).max(outbox.seen);
    }

    /// The number of the next frame, if the page can take one.
    pub fn next_frame(&self) -> Option<u32> {
        let outbox = lock(&self.outbox);
        let waits = outbox.frame.is_some() || outbox.sent - outbox.seen >= MAX_UNSEEN;
        (!waits && !outbox.is_closed).then_some(outbox.sent + 1)
    }

    fn put(&self, put: impl FnOnce(&mut Outbox)) {
        put(&mut lock(&self.outbox));
        #[cfg(feature = "server")]
        self.ready.notify_one();
    }

    /// Sends a frame; one that waits is replaced.
    pub fn send_frame(&self, frame: Vec<u8>) {
        self.put(|outbox| outbox.frame = Some(Arc::new(frame)));
    }

    /// Sends the list of bodies.
    pub fn send_body_list(&self, body_list: Arc<Vec<u8>>) {
        self.put(|outbox| outbox.body_list = Some(body_list));
    }

    /// Sends the state of the run.
    pub fn send_status(&self, status: String) {
        self.put(|outbox| outbox.status = Some(status));
    }

    /// Removes the state of the run that waits to be sent.
    pub fn drop_status(&self) {
        lock(&self.outbox).status = None;
    }

    /// Sends the results of the measures.
    pub fn send_measures(&self, measures: String) {
        self.put(|outbox| outbox.measures = Some(measures));
    }

    /// Sends a text that must arrive.
    pub fn send_text(&self, text: String) {
        self.put(|outbox| {
            outbox.has_overflowed |= outbox.answers.len() >= MAX_ANSWERS;
            if !outbox.has_overflowed {
                outbox.answers.push_back(text);
            }
        });
    }

    /// Sends an answer.
    pub fn answer(&self, answer: &impl Serialize) {
        self.send_text(json(answer));
    }

    /// Ends the connection.
    #[cfg(feature = "server")]
    pub fn close(&self) {
        self.put(|outbox| outbox.is_closed = true);
    }

    /// Waits for the next message; `None` ends the connection.
    #[cfg(feature = "server")]
    pub async fn next(&self) -> Option<Outgoing> {
        loop {
            match self.take() {
                Ok(None) => {}
                message => return message.ok().flatten(),
            }
            self.ready.notified().await;
        }
    }

    /// The next message, if one waits. A list of bodies comes before the frames that belong to it.
    ///
    /// # Errors
    /// The connection ends.
    pub fn take(&self) -> Result<Option<Outgoing>, Closed> {
        let mut outbox = lock(&self.outbox);
        if outbox.is_closed || outbox.has_overflowed {
            return Err(Closed);
        }
        if let Some(text) = outbox.answers.pop_front() {
            return Ok(Some(Outgoing::Text(text)));
        }
        if let Some(body_list) = outbox.body_list.take() {
            return Ok(Some(Outgoing::Binary(body_list)));
        }
        if let Some(text) = outbox.status.take() {
            return Ok(Some(Outgoing::Text(text)));
        }
        if let Some(text) = outbox.measures.take() {
            return Ok(Some(Outgoing::Text(text)));
        }
        let Some(frame) = outbox.frame.take() else {
            return Ok(None);
        };
        outbox.sent += 1;
        Ok(Some(Outgoing::Binary(frame)))
    }
}

/// JSON of a message.
pub fn json(message: &impl Serialize) -> String {
    serde_json::to_string(message).unwrap_or_default()
}

/// All connected pages. The one that has been connected for longest may write.
#[derive(Debug, Default)]
pub struct Viewers {
    list: Mutex<(Vec<Arc<Viewer>>, u64)>,
}

/// What a page receives when its rights change.
#[cfg(feature = "server")]
#[derive(Debug, Serialize)]
struct Rights {
    writer: bool,
}

impl Viewers {
    /// Adds a page; `None` if there are too many.
    pub fn join(&self) -> Option<Arc<Viewer>> {
        let mut list = lock(&self.list);
        if list.0.len() >= MAX_VIEWERS {
            return None;
        }
        list.1 += 1;
        let viewer = Arc::new(Viewer {
            id: list.1,
            outbox: Mutex::default(),
            window: Mutex::default(),
            chooses: AtomicBool::new(false),
            #[cfg(feature = "server")]
            ready: Notify::new(),
        });
        list.0.push(Arc::clone(&viewer));
        Some(viewer)
    }

    /// Removes a page. If it was the writer, the next one is.
    #[cfg(feature = "server")]
    pub fn leave(&self, id: u64) {
        let mut list = lock(&self.list);
        let was_writer = list.0.first().is_some_and(|first| first.id == id);
        list.0.retain(|viewer| viewer.id != id);
        if was_writer && let Some(next) = list.0.first() {
            next.answer(&Rights { writer: true });
        }
    }

    /// Whether this page may write.
    pub fn is_writer(&self, id: u64) -> bool {
        lock(&self.list)
            .0
            .first()
            .is_some_and(|first| first.id == id)
    }

    /// All pages.
    pub fn all(&self) -> Vec<Arc<Viewer>> {
        lock(&self.list).0.clone()
    }

    /// The page of this number.
    pub fn get(&self, id: u64) -> Option<Arc<Viewer>> {
        lock(&self.list)
            .0
            .iter()
            .find(|viewer| viewer.id == id)
            .cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_does_not_read_holds_one_frame_and_ends_after_many_answers() {
        let viewers = Viewers::default();
        let viewer = viewers.join().unwrap();
        for _ in 0..10_000 {
            viewer.send_frame(vec![1; 100]);
            viewer.send_status("old".to_owned());
        }
        viewer.send_frame(vec![2]);
        viewer.send_status("new".to_owned());
        assert!(matches!(viewer.take(), Ok(Some(Outgoing::Text(text))) if text == "new"));
        assert!(matches!(viewer.take(), Ok(Some(Outgoing::Binary(frame))) if *frame == [2]));
        assert!(matches!(viewer.take(), Ok(None)));
        viewer.send_status("older than an answer".to_owned());
        viewer.drop_status();
        assert!(matches!(viewer.take(), Ok(None)));
        // Frames that are not acknowledged stop at a few.
        let mut sent = 1;
        while let Some(number) = viewer.next_frame() {
            assert_eq!(number, sent + 1);
            viewer.send_frame(vec![0]);
            assert!(viewer.next_frame().is_none(), "one waits");
            let _ = viewer.take();
            sent = number;
        }
        assert_eq!(sent, MAX_UNSEEN);
        viewer.has_seen(2);
        assert_eq!(viewer.next_frame(), Some(sent + 1));
        viewer.has_seen(u32::MAX);
        assert_eq!(
            viewer.next_frame(),
            Some(sent + 1),
            "a number from the future counts as the last sent"
        );
        for _ in 0..=MAX_ANSWERS {
            viewer.send_text(String::new());
        }
        assert!(matches!(viewer.take(), Err(Closed)), "the connection ends");
    }

    #[test]
    fn the_first_page_writes_and_the_next_follows_it() {
        let viewers = Viewers::default();
        let pages: Vec<_> = (0..MAX_VIEWERS).map(|_| viewers.join().unwrap()).collect();
        assert!(viewers.join().is_none());
        assert!(viewers.is_writer(pages[0].id) && !viewers.is_writer(pages[1].id));
        viewers.leave(pages[0].id);
        assert!(viewers.is_writer(pages[1].id));
        let Ok(Some(Outgoing::Text(text))) = pages[1].take() else {
            panic!("no message")
        };
        assert_eq!(text, r#"{"writer":true}"#);
    }
}
