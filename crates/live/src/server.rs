//! The server: one page and one socket, behind a random token, for requests from this page alone.
//!
//! A request is refused unless its path begins with the token and its `Host` is this machine, by a
//! name that no other site can take (DNS rebinding); a socket moreover needs the `Origin` of the
//! page. Nothing is loaded from elsewhere: the page forbids it (`Content-Security-Policy`).

use std::{
    net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, UdpSocket},
    path::Path,
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{SyncSender, TrySendError, sync_channel},
    },
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, Result, ensure};
use axum::{
    Router,
    body::Bytes,
    extract::{
        State,
        ws::{Message as Packet, WebSocket, WebSocketUpgrade},
    },
    http::{HeaderMap, Method, StatusCode, Uri, header},
    response::{IntoResponse, Response},
};
use carom::Scene;
use carom_runs::interruption::Signals;
use serde_json::json;
use tokio::sync::Notify;

use crate::{
    connections,
    engine_thread::{EngineThread, LaboratoryEnd, panicked},
    gallery,
    laboratory::Message,
    page::{self, PageEngine},
    requests::{self, hello},
    saved_runs::SavedRuns,
    viewers::{MAX_VIEWERS, Outgoing, Viewer, Viewers},
};

/// Time between two pings of a page, and the longest time without an answer: then it loses its
/// connection, and the right to edit passes on.
const PING: Duration = Duration::from_secs(5);
const SILENCE: Duration = Duration::from_secs(20);

/// First part of the path of an address for once, and how long it is valid.
const ONCE: &str = "open";
const TICKET: Duration = Duration::from_mins(1);

/// Largest message of a page (bytes).
const MAX_REQUEST: usize = 1 << 18;

/// Interval of automatic saves, the most that is lost if the program is killed.
pub const SAVE_INTERVAL: Duration = Duration::from_secs(30);

/// Requests that wait for the engine. More are refused.
const MAX_WAITING: usize = 256;

/// Where the pictures of the gallery are.
const THUMBNAILS: &str = "thumbnail/";

/// What the page may load and do.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                      connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A server that is bound to its address.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: String,
    door: Arc<Door>,
    saved_runs: SavedRuns,
    signals: Signals,
}

/// What requests must have.
#[derive(Debug)]
struct Door {
    token: String,
    /// Whether hosts may name any address of this machine, not the loopback address alone.
    is_open: bool,
    /// The last part of an address that leads to the page once, and until when.
    ticket: Mutex<Option<(String, Instant)>>,
}

/// What requests share.
#[derive(Debug)]
struct Shared {
    door: Arc<Door>,
    viewers: Arc<Viewers>,
    messages: SyncSender<Message>,
}

impl Door {
    /// Whether a request names this machine and has the token; `Err` is the refusal.
    fn admits(&self, uri: &Uri, headers: &HeaderMap) -> Result<(), (StatusCode, &'static str)> {
        let host = headers
            .get(header::HOST)
            .and_then(|host| host.to_str().ok())
            .unwrap_or("");
        if !self.knows(host) {
            return Err((StatusCode::FORBIDDEN, "This host name is not served."));
        }
        let token = uri.path().split('/').nth(1).unwrap_or("");
        if !is_same(token, &self.token) {
            return Err((
                StatusCode::FORBIDDEN,
                "The address lacks the token that carom live has printed.",
            ));
        }
        Ok(())
    }

    /// Redirects the first request with a valid ticket to the page; refuses later ones.
    fn redeem(&self, word: &str, headers: &HeaderMap) -> Response {
        let host = headers
            .get(header::HOST)
            .and_then(|host| host.to_str().ok())
            .unwrap_or("");
        let mut ticket = self.ticket.lock().unwrap_or_else(PoisonError::into_inner);
        let is_valid = self.knows(host)
            && ticket
                .as_ref()
                .is_some_and(|(known, until)| is_same(word, known) && Instant::now() < *until);
        if !is_valid {
            return (
                StatusCode::FORBIDDEN,
                "Open the address that carom live has printed.",
            )
                .into_response();
        }
        *ticket = None;
        let headers = [
            (header::LOCATION, format!("/{}/", self.token)),
            (header::CACHE_CONTROL, "no-store".to_owned()),
            (header::REFERRER_POLICY, "no-referrer".to_owned()),
        ];
        (StatusCode::SEE_OTHER, headers).into_response()
    }

    /// Whether a host, with or without port, is this machine.
    fn knows(&self, host: &str) -> bool {
        let name = match host.rsplit_once(':') {
            Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
            _ => host,
        };
        let name = name.trim_start_matches('[').trim_end_matches(']');
        let address = name.parse::<IpAddr>();
        name == "localhost" || address.is_ok_and(|address| self.is_open || address.is_loopback())
    }

    /// Whether a socket is opened by the page of this server.
    fn admits_origin(headers: &HeaderMap) -> bool {
        let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
        match (text(header::ORIGIN), text(header::HOST)) {
            (Some(origin), Some(host)) => origin == format!("http://{host}"),
            _ => false,
        }
    }
}

/// The address under which pages reach a server that listens on `address`. For all addresses of
/// this machine (0.0.0.0), that towards other networks, or the loopback address if there is none.
fn named_address(address: IpAddr) -> IpAddr {
    if !address.is_unspecified() {
        return address;
    }
    let (loopback, elsewhere): (IpAddr, &str) = match address {
        IpAddr::V4(_) => (Ipv4Addr::LOCALHOST.into(), "192.0.2.1:9"),
        IpAddr::V6(_) => (Ipv6Addr::LOCALHOST.into(), "[2001:db8::1]:9"),
    };
    // Nothing is sent: this only chooses a route, to an address for documentation (RFC 5737, 3849).
    let towards = UdpSocket::bind((address, 0)).and_then(|socket| {
        socket.connect(elsewhere)?;
        socket.local_addr()
    });
    towards.map_or(loopback, |local| local.ip())
}

/// Compares in a time that does not depend on where the words differ.
fn is_same(one: &str, other: &str) -> bool {
    let differ = one
        .bytes()
        .zip(other.bytes())
        .fold(0, |differ, (a, b)| differ | (a ^ b));
    one.len() == other.len() && differ == 0
}

impl Server {
    /// Binds a server to an address; saved runs go into `folder`, into which it tries to write. The
    /// run is saved automatically every [`SAVE_INTERVAL`].
    ///
    /// # Errors
    /// The address cannot be used, runs cannot be saved in `folder`, or there are no random bytes
    /// for the token.
    pub fn bind(address: SocketAddr, folder: &Path, signals: Signals) -> Result<Self> {
        let listener =
            TcpListener::bind(address).with_context(|| format!("cannot listen on {address}"))?;
        listener.set_nonblocking(true).context("cannot listen")?;
        let token = random_word()?;
        let shown = listener.local_addr().context("cannot listen")?;
        let named = SocketAddr::new(named_address(shown.ip()), shown.port());
        let address = format!("http://{named}/{token}/");
        let door = Door {
            token,
            is_open: !shown.ip().is_loopback(),
            ticket: Mutex::new(None),
        };
        let door = Arc::new(door);
        let saved_runs = SavedRuns::open(folder, SAVE_INTERVAL)?;
        Ok(Self {
            listener,
            address,
            door,
            saved_runs,
            signals,
        })
    }

    /// The server with another interval of automatic saves.
    #[must_use]
    pub fn saving_every(mut self, interval: Duration) -> Self {
        self.saved_runs.set_interval(interval);
        self
    }

    /// The folder of the automatic saves of this session.
    pub fn automatic_folder(&self) -> &Path {
        self.saved_runs.automatic_folder()
    }

    /// The address of the page, with its token.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// An address that leads to the page once, within a minute, and replaces the one before.
    ///
    /// All users of a machine can read the arguments of a process. A browser that is started with
    /// this address does not show them the token. If another user opens it first, that user gets
    /// the page and the browser gets a refusal. A private file that redirects would have no such
    /// race, but browsers in a sandbox of their own (snap, Flatpak) cannot read it.
    ///
    /// # Errors
    /// There are no random bytes.
    pub fn address_for_once(&self) -> Result<String> {
        let word = random_word()?;
        let address = self.address.replace(
            &format!("/{}/", self.door.token),
            &format!("/{ONCE}/{word}"),
        );
        let mut ticket = self
            .door
            .ticket
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        *ticket = Some((word, Instant::now() + TICKET));
        Ok(address)
    }

    /// Serves until a signal is received. The scene is opened first, and waits for its first page.
    ///
    /// # Errors
    /// The scene is invalid, the server fails, or the run cannot be saved. A panic of the engine is
    /// an error too; it names the saved run.
    pub fn serve(self, scene: Option<(String, Scene)>) -> Result<LaboratoryEnd> {
        let viewers = Arc::new(Viewers::default());
        let (messages, received) = sync_channel(MAX_WAITING);
        let shared = Arc::new(Shared {
            door: self.door,
            viewers: Arc::clone(&viewers),
            messages,
        });
        let ended = Arc::new(Notify::new());
        let has_ended = Arc::clone(&ended);
        let (saved_runs, signals) = (self.saved_runs, self.signals);
        let reserve = saved_runs.reserve();
        let engine = thread::Builder::new().name("engine".to_owned());
        let engine = engine.spawn(move || {
            // A panic ends the server as well.
            let _ends = Ends {
                ended: has_ended,
                viewers: Arc::clone(&viewers),
            };
            EngineThread::new(viewers, saved_runs, signals).run(scene, &received)
        });
        let engine = engine.context("the system has no thread for the engine")?;
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .context("no runtime")?;
        let served = runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener)?;
            let router = Router::new().fallback(answer).with_state(shared);
            let server = tokio::spawn(connections::serve(listener, router, reserve));
            ended.notified().await;
            server.abort();
            Ok::<(), std::io::Error>(())
        });
        // Connections end with the runtime.
        runtime.shutdown_timeout(Duration::from_millis(200));
        let ended = engine.join().map_err(|_| panicked())?;
        served.context("the server")?;
        ended
    }
}

/// Ends the server when the engine ends.
struct Ends {
    ended: Arc<Notify>,
    viewers: Arc<Viewers>,
}

impl Drop for Ends {
    fn drop(&mut self) {
        self.viewers.all().iter().for_each(|viewer| viewer.close());
        self.ended.notify_one();
    }
}

/// Answers every request: the page, the socket, or a refusal.
async fn answer(
    State(shared): State<Arc<Shared>>,
    method: Method,
    uri: Uri,
    headers: HeaderMap,
    upgrade: Result<WebSocketUpgrade, axum::extract::ws::rejection::WebSocketUpgradeRejection>,
) -> Response {
    if let Some(("", path)) = uri.path().split_once('/')
        && let Some((ONCE, word)) = path.split_once('/')
    {
        if method != Method::GET {
            // Some programs ask for the type of a page before a browser opens it.
            return (StatusCode::METHOD_NOT_ALLOWED, "GET opens the page.").into_response();
        }
        return shared.door.redeem(word, &headers);
    }
    if let Err(refusal) = shared.door.admits(&uri, &headers) {
        return refusal.into_response();
    }
    let rest = uri.path().splitn(3, '/').nth(2).unwrap_or("");
    if let Some(name) = rest
        .strip_prefix(THUMBNAILS)
        .and_then(|name| name.strip_suffix(".svg"))
    {
        return thumbnail(name.to_owned()).await;
    }
    match (rest, upgrade) {
        ("", _) => page(),
        ("socket", Ok(upgrade)) if Door::admits_origin(&headers) => {
            let upgrade = upgrade
                .max_message_size(MAX_REQUEST)
                .max_frame_size(MAX_REQUEST);
            upgrade.on_upgrade(move |socket| talk(socket, shared))
        }
        ("socket", Ok(_)) => (StatusCode::FORBIDDEN, "A page of another origin.").into_response(),
        _ => (StatusCode::NOT_FOUND, "There is no such page.").into_response(),
    }
}

/// The picture of a scene of the gallery, which may have to be placed first.
async fn thumbnail(name: String) -> Response {
    let drawn = tokio::task::spawn_blocking(move || gallery::thumbnail(&name)).await;
    match drawn {
        Ok(Ok(Some(picture))) => {
            let headers = [
                (header::CONTENT_TYPE, "image/svg+xml"),
                (header::CACHE_CONTROL, "private, max-age=3600"),
                (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
            ];
            (headers, picture).into_response()
        }
        Ok(Ok(None)) => (StatusCode::NOT_FOUND, "There is no such picture.").into_response(),
        Ok(Err(_)) | Err(_) => (
            StatusCode::INTERNAL_SERVER_ERROR,
            "The picture could not be drawn.",
        )
            .into_response(),
    }
}

fn page() -> Response {
    let headers = [
        (header::CONTENT_TYPE, "text/html; charset=utf-8"),
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::CACHE_CONTROL, "no-store"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    ];
    (headers, page::page(PageEngine::Server)).into_response()
}

/// Passes messages between a page and the engine until either ends.
async fn talk(mut socket: WebSocket, shared: Arc<Shared>) {
    let Some(viewer) = shared.viewers.join() else {
        sent(&mut socket, Packet::text(full().to_string())).await;
        return;
    };
    viewer.answer(&hello(shared.viewers.is_writer(viewer.id)));
    let mut pings = tokio::time::interval(PING);
    let mut heard = Instant::now();
    loop {
        tokio::select! {
            outgoing = viewer.next() => {
                let packet = match outgoing {
                    None => break,
                    Some(Outgoing::Text(text)) => Packet::text(text),
                    Some(Outgoing::Binary(bytes)) => Packet::binary(bytes.to_vec()),
                };
                if !sent(&mut socket, packet).await {
                    break;
                }
            }
            incoming = socket.recv() => {
                heard = Instant::now();
                match incoming {
                    Some(Ok(Packet::Text(text))) => receive(text.as_str(), &viewer, &shared),
                    Some(Ok(Packet::Ping(_) | Packet::Pong(_))) => {}
                    // The end, a fault, or what no page of this server sends.
                    _ => break,
                }
            }
            _ = pings.tick() => {
                if heard.elapsed() > SILENCE || !sent(&mut socket, Packet::Ping(Bytes::new())).await {
                    break;
                }
            }
        }
    }
    shared.viewers.leave(viewer.id);
}

/// Sends a packet; returns whether the page has taken it in time.
async fn sent(socket: &mut WebSocket, packet: Packet) -> bool {
    matches!(
        tokio::time::timeout(SILENCE, socket.send(packet)).await,
        Ok(Ok(()))
    )
}

/// What a page receives for which there is no room.
fn full() -> serde_json::Value {
    json!({ "full": format!("{MAX_VIEWERS} pages watch this run, the most that it serves. Close one of them.") })
}

/// Passes a request on to the engine, or answers it.
fn receive(text: &str, viewer: &Viewer, shared: &Shared) {
    requests::receive(text, viewer, &shared.viewers, |message| {
        shared
            .messages
            .try_send(message)
            .map_err(|error| match error {
                TrySendError::Full(_) => "the engine is busy: try again",
                TrySendError::Disconnected(_) => "the engine has ended",
            })
    });
}

/// A random word of 32 hexadecimal digits.
///
/// # Errors
/// The operating system gives no random bytes.
fn random_word() -> Result<String> {
    let mut bytes = [0_u8; 16];
    getrandom::fill(&mut bytes)
        .map_err(anyhow::Error::msg)
        .context("no random bytes for the token")?;
    ensure!(
        bytes != [0; 16],
        "the random bytes of the operating system are all 0"
    );
    Ok(format!("{:032x}", u128::from_le_bytes(bytes)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_this_machine_are_served() {
        let closed = Door {
            token: "abc".to_owned(),
            is_open: false,
            ticket: Mutex::new(None),
        };
        for host in [
            "127.0.0.1:80",
            "localhost",
            "localhost:9999",
            "[::1]:80",
            "127.0.0.2",
        ] {
            assert!(closed.knows(host), "{host}");
        }
        for host in [
            "evil.example",
            "localhost.evil.example",
            "192.168.1.2:80",
            "127.0.0.1.evil",
            "",
            ":80",
            "a:b",
        ] {
            assert!(!closed.knows(host), "{host}");
        }
        let open = Door {
            token: "abc".to_owned(),
            is_open: true,
            ticket: Mutex::new(None),
        };
        assert!(open.knows("192.168.1.2:80") && !open.knows("evil.example:80"));
    }

    #[test]
    fn the_printed_address_is_one_that_can_be_opened() {
        for address in ["127.0.0.1", "192.168.1.2", "::1"] {
            let address = address.parse().unwrap();
            assert_eq!(named_address(address), address);
        }
        for all in ["0.0.0.0", "::"] {
            let named = named_address(all.parse().unwrap());
            assert!(!named.is_unspecified(), "{named}");
        }
    }

    #[test]
    fn words_are_the_same_only_as_a_whole() {
        assert!(is_same("abc", "abc"));
        for other in ["", "ab", "abcd", "abd"] {
            assert!(!is_same("abc", other), "{other}");
        }
        let word = random_word().unwrap();
        assert!(word.len() == 32 && word != random_word().unwrap());
    }
}
