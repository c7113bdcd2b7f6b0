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

/// The attribute of the page that names its engine, with both values.
const OF_SERVER: &str = r#"<html lang="en" data-engine="server">"#;
const OF_WORKER: &str = r#"<html lang="en" data-engine="worker">"#;

/// The text of the page, HTML.
pub fn page(engine: PageEngine) -> String {
    match engine {
        PageEngine::Server => PAGE.to_owned(),
        PageEngine::Worker => PAGE.replacen(OF_SERVER, OF_WORKER, 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pages_differ_in_the_engine_alone() {
        let [server, worker] = [PageEngine::Server, PageEngine::Worker].map(page);
        assert!(worker.contains(OF_WORKER));
        assert_eq!(worker.replacen("worker", "server", 1), server);
    }
}
