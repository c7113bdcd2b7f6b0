//! The page, for either engine.

/// What the page talks to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PageEngine {
    /// The server that sends it.
    Server,
    /// A worker of the browser, with the engine in WebAssembly.
    Worker,
}

/// The page of the server.
const PAGE: &str = include_str!("page.html");

/// The beginning of the page, which names its engine.
const OF_SERVER: &str =
    "<html lang=\"en\" data-engine=\"server\">\n<head>\n<meta charset=\"utf-8\">\n";

/// What a page that stands alone may load and do: the server sends such a policy in a header.
/// Nothing is loaded from elsewhere or sent.
const POLICY: &str = "default-src 'none'; \
                      script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval' blob:; \
                      worker-src 'self' blob:; style-src 'unsafe-inline'; connect-src 'self'; \
                      img-src 'self' data:; base-uri 'none'; form-action 'none'";

/// The text of the page, HTML.
pub fn page(engine: PageEngine) -> String {
    match engine {
        PageEngine::Server => PAGE.to_owned(),
        PageEngine::Worker => PAGE.replacen(OF_SERVER, &beginning_of_worker(), 1),
    }
}

/// The beginning of a page that stands alone.
fn beginning_of_worker() -> String {
    format!(
        "{}<meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n",
        OF_SERVER.replacen("server", "worker", 1)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pages_differ_in_their_beginning_alone() {
        let [server, worker] = [PageEngine::Server, PageEngine::Worker].map(page);
        let own = beginning_of_worker();
        assert!(server.contains(OF_SERVER) && worker.contains(&own));
        assert_eq!(worker.replacen(&own, OF_SERVER, 1), server);
    }
}
