//! The connections of the server: their number and the time until their request are bounded, so
//! that no other program on the machine can keep a page out or take all file descriptors.

use std::{collections::VecDeque, sync::Arc, time::Duration};

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::{
    rt::{TokioIo, TokioTimer},
    service::TowerToHyperService,
};
use tokio::{
    net::{TcpListener, TcpStream},
    task::JoinHandle,
    time::{sleep, timeout},
};

use crate::reserve::Reserve;

/// Largest number of connections that have not become sockets; a further one ends the oldest.
/// Sockets are bounded by [`MAX_VIEWERS`](crate::viewers::MAX_VIEWERS).
const MAX_CONNECTIONS: usize = 64;

/// Longest time until the headers of a request have arrived.
const HEADER_TIME: Duration = Duration::from_secs(10);

/// Longest time of a connection that does not become a socket, for a page on a slow line.
const CONNECTION_TIME: Duration = Duration::from_mins(1);

/// Pause until a connection can be accepted again: while a run is saved, and where no file
/// descriptor is left.
const PAUSE: Duration = Duration::from_millis(20);

/// Accepts connections and answers their requests until it is aborted.
pub async fn serve(listener: TcpListener, router: Router, reserve: Arc<Reserve>) {
    let mut open: VecDeque<JoinHandle<()>> = VecDeque::new();
    loop {
        let is_held = reserve.restore();
        if is_held.is_err() {
            end_oldest(&mut open);
        }
        if !is_held.unwrap_or(false) {
            sleep(PAUSE).await;
            continue;
        }
        let accepted = listener.accept().await;
        open.retain(|connection| !connection.is_finished());
        if let Ok((stream, _)) = accepted {
            if open.len() >= MAX_CONNECTIONS {
                end_oldest(&mut open);
            }
            open.push_back(tokio::spawn(answer(stream, router.clone())));
        } else {
            // No descriptor is left, or the other side has gone.
            end_oldest(&mut open);
            sleep(PAUSE).await;
        }
    }
}

/// Ends the connection that has been open for longest.
fn end_oldest(open: &mut VecDeque<JoinHandle<()>>) {
    if let Some(oldest) = open.pop_front() {
        oldest.abort();
    }
}

/// Answers the requests of a connection. That of a page continues as a socket, without these
/// limits.
async fn answer(stream: TcpStream, router: Router) {
    let mut server = http1::Builder::new();
    server
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIME);
    let service = TowerToHyperService::new(router.into_service::<hyper::body::Incoming>());
    let connection = server
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    // A connection that fails concerns its own page alone, which connects again.
    let _ = timeout(CONNECTION_TIME, connection).await;
}
