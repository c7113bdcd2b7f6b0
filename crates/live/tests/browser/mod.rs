//! A browser without a window that is driven while a page runs, by the protocol of its developer
//! tools.

use std::{
    io::{BufRead as _, BufReader, Read as _, Write as _},
    net::TcpStream,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, stream::MaybeTlsStream};

/// Longest wait for the browser.
const PATIENCE: Duration = Duration::from_secs(90);

/// A browser with one page.
pub struct Browser {
    process: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    next: u64,
    /// Errors and warnings of the page so far.
    pub faults: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Browser {
    /// Opens an empty page.
    pub fn start(program: &str) -> Self {
        let profile = tempfile::tempdir().unwrap();
        let mut process = Command::new(program)
            .args([
                "--headless",
                "--no-sandbox",
                "--remote-debugging-port=0",
                "--window-size=1300,850",
            ])
            // A graphics card is drawn by software where there is none.
            .args([
                "--use-gl=angle",
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
            ])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the browser can be started");
        let mut lines = BufReader::new(process.stderr.take().unwrap()).lines();
        let found = lines.by_ref().map_while(Result::ok).find_map(|line| {
            let address = line.strip_prefix("DevTools listening on ws://")?;
            address.split('/').next().map(str::to_owned)
        });
        let host = found.expect("the browser prints the address of its tools");
        // The pipe must not fill.
        thread::spawn(move || lines.for_each(drop));
        let begun = Instant::now();
        let address = loop {
            let pages = pages(&host);
            let page = pages
                .as_array()
                .into_iter()
                .flatten()
                .find(|page| page["type"] == "page");
            match page.and_then(|page| page["webSocketDebuggerUrl"].as_str()) {
                Some(address) => break address.to_owned(),
                None => assert!(
                    begun.elapsed() < PATIENCE,
                    "the browser has no page: {pages}"
                ),
            }
            thread::sleep(Duration::from_millis(50));
        };
        let (socket, _) = tungstenite::connect(address).unwrap();
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
        }
        let mut browser = Self {
            process,
            socket,
            next: 0,
            faults: Vec::new(),
            _profile: profile,
        };
        for domain in ["Runtime", "Log", "Page"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        browser
    }

    /// Calls a method and returns its result.
    pub fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.next += 1;
        let text = json!({ "id": self.next, "method": method, "params": parameters }).to_string();
        self.socket.send(Message::text(text)).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else {
                continue;
            };
            let mut message: Value = serde_json::from_str(text.as_str()).unwrap();
            if message["id"] == self.next {
                assert!(message["error"].is_null(), "{method}: {}", message["error"]);
                return message["result"].take();
            }
            let parameters = &message["params"];
            let fault = match message["method"].as_str() {
                Some("Runtime.exceptionThrown") => Some(&parameters["exceptionDetails"]),
                Some("Runtime.consoleAPICalled")
                    if ["error", "warning", "assert"]
                        .map(Value::from)
                        .contains(&parameters["type"]) =>
                {
                    Some(&parameters["args"])
                }
                Some("Log.entryAdded")
                    if ["error", "warning"]
                        .map(Value::from)
                        .contains(&parameters["entry"]["level"]) =>
                {
                    Some(&parameters["entry"]["text"])
                }
                _ => None,
            };
            self.faults.extend(fault.map(Value::to_string));
        }
    }

    /// The value of an expression, or of the promise that it is.
    pub fn eval(&mut self, expression: &str) -> Value {
        let asked =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut result = self.call("Runtime.evaluate", &asked);
        assert!(
            result["exceptionDetails"].is_null(),
            "{expression}: {result}"
        );
        result["result"]["value"].take()
    }

    /// Waits until an expression is true.
    pub fn until(&mut self, expression: &str) {
        let begun = Instant::now();
        while self.eval(expression) != true {
            let state = "document.getElementById('message').textContent + document.getElementById('numbers').innerText";
            assert!(
                begun.elapsed() < PATIENCE,
                "not true: {expression}; {}",
                self.eval(state)
            );
            thread::sleep(Duration::from_millis(50));
        }
    }

    /// The size of the page, and whether it is dark.
    pub fn show(&mut self, [width, height]: [u32; 2], is_dark: bool) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
        self.call("Emulation.setDeviceMetricsOverride", &size);
        let scheme = if is_dark { "dark" } else { "light" };
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.call(
            "Emulation.setEmulatedMedia",
            &json!({ "features": features }),
        );
    }
}

/// The pages of a browser.
fn pages(host: &str) -> Value {
    let mut stream = TcpStream::connect(host).unwrap();
    write!(
        stream,
        "GET /json/list HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
    )
    .unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(2)))
        .unwrap();
    let mut bytes = Vec::new();
    let _ = stream.read_to_end(&mut bytes);
    let text = String::from_utf8_lossy(&bytes).into_owned();
    text.split_once("\r\n\r\n")
        .and_then(|(_, body)| serde_json::from_str(body).ok())
        .unwrap_or(Value::Null)
}
