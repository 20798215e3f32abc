//! A browser that does as it is told: the part of the WebDriver protocol (W3C 2018) that the tests need, over HTTP/1.1.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Without a network, a profile, a sandbox (containers forbid it) or a GPU.
const ARGUMENTS: [&str; 9] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1280,1400",
];

/// What the protocol calls an element in JSON.
const ELEMENT: &str = "element-6066-11e4-a52e-4f735466cecf";

/// Chromium, driven by its own driver.
pub struct Browser {
    driver: Child,
    port: u16,
    session: String,
    _profile: tempfile::TempDir,
}

impl Browser {
    /// Starts one; `None`, with a word of why, where there is none.
    pub fn start() -> Option<Browser> {
        let started = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .spawn();
        let mut driver = match started {
            Ok(driver) => driver,
            Err(error) => {
                eprintln!("SKIPPED: there is no chromedriver ({error}): the viewer was not tried");
                return None;
            }
        };
        let lines = BufReader::new(driver.stdout.take().unwrap()).lines();
        let said = lines
            .map_while(Result::ok)
            .find(|line| line.contains("successfully on port"));
        let said = said.unwrap();
        let port = said
            .trim_end_matches('.')
            .rsplit(' ')
            .next()
            .unwrap()
            .parse()
            .unwrap();
        let profile = tempfile::tempdir().unwrap();
        let mut arguments: Vec<String> = ARGUMENTS.map(String::from).into();
        arguments.push(format!("--user-data-dir={}", profile.path().display()));
        let mut browser = Browser {
            driver,
            port,
            session: String::new(),
            _profile: profile,
        };
        let wanted = json!({"capabilities": {"alwaysMatch": {
            "goog:chromeOptions": {"args": arguments},
            "goog:loggingPrefs": {"browser": "ALL"},
        }}});
        let answer = browser.ask("POST", "/session", &wanted);
        match answer["sessionId"].as_str() {
            Some(session) => browser.session = session.to_owned(),
            None => {
                eprintln!("SKIPPED: Chromium does not start ({answer}): the viewer was not tried");
                return None;
            }
        }
        Some(browser)
    }

    /// One request; gives the `value` of what is answered.
    fn ask(&self, method: &str, path: &str, body: &Value) -> Value {
        let body = if method != "POST" {
            String::new()
        } else {
            body.to_string()
        };
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(120)))
            .unwrap();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
            body.len()
        )
        .unwrap();
        let mut stream = BufReader::new(stream);
        let mut length = 0;
        loop {
            let mut line = String::new();
            stream.read_line(&mut line).unwrap();
            if let Some(n) = line.to_ascii_lowercase().strip_prefix("content-length:") {
                length = n.trim().parse().unwrap();
            }
            if line.trim().is_empty() {
                break;
            }
        }
        let mut answer = vec![0; length];
        stream.read_exact(&mut answer).unwrap();
        serde_json::from_slice::<Value>(&answer).unwrap()["value"].take()
    }

    fn command(&self, path: &str, body: Value) -> Value {
        let answer = self.ask("POST", &format!("/session/{}/{path}", self.session), &body);
        assert!(answer.get("error").is_none(), "{path} {body}: {answer}");
        answer
    }

    pub fn open(&self, page: &Path) {
        self.command("url", json!({"url": format!("file://{}", page.display())}));
    }

    /// What a function body of JavaScript returns.
    pub fn run(&self, script: &str) -> Value {
        self.command("execute/sync", json!({"script": script, "args": []}))
    }

    /// Waits until an expression is true.
    pub fn wait(&self, condition: &str) {
        let start = Instant::now();
        while self.run(&format!("return Boolean({condition})")) != json!(true) {
            // Rendering takes milliseconds; a busy machine may take many.
            assert!(
                start.elapsed() < Duration::from_secs(60),
                "it never was that {condition}"
            );
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    fn element(&self, selector: &str) -> String {
        let found = self.command(
            "element",
            json!({"using": "css selector", "value": selector}),
        );
        found[ELEMENT].as_str().unwrap().to_owned()
    }

    pub fn click(&self, selector: &str) {
        let element = self.element(selector);
        self.command(&format!("element/{element}/click"), json!({}));
    }

    /// Types into a control.
    pub fn send(&self, selector: &str, keys: &str) {
        let element = self.element(selector);
        self.command(&format!("element/{element}/value"), json!({"text": keys}));
    }

    /// Presses a key, `shift` held or not, wherever the focus is.
    pub fn press(&self, key: &str, shift: bool) {
        let action = |kind: &str, key: &str| json!({"type": kind, "value": key});
        let mut actions = vec![action("keyDown", key), action("keyUp", key)];
        if shift {
            actions.insert(0, action("keyDown", SHIFT));
            actions.push(action("keyUp", SHIFT));
        }
        self.command(
            "actions",
            json!({"actions": [{"type": "key", "id": "keys", "actions": actions}]}),
        );
    }

    /// Moves the pointer to places relative to the middle of an element, with the button held from the first on.
    pub fn drag(&self, selector: &str, places: &[[i32; 2]]) {
        self.point(selector, places, true);
    }

    /// Moves the pointer.
    pub fn hover(&self, selector: &str, place: [i32; 2]) {
        self.point(selector, &[place], false);
    }

    fn point(&self, selector: &str, places: &[[i32; 2]], held: bool) {
        let origin = json!({ELEMENT: self.element(selector)});
        let mut actions = Vec::new();
        for (i, [x, y]) in places.iter().enumerate() {
            actions.push(
                json!({"type": "pointerMove", "duration": 0, "x": x, "y": y, "origin": origin}),
            );
            if held && i == 0 {
                actions.push(json!({"type": "pointerDown", "button": 0}));
            }
        }
        if held {
            actions.push(json!({"type": "pointerUp", "button": 0}));
        }
        self.command(
            "actions",
            json!({"actions": [{"type": "pointer", "id": "mouse", "actions": actions}]}),
        );
    }

    /// Turns the wheel over a place of an element.
    pub fn wheel(&self, selector: &str, [x, y]: [i32; 2], delta: i32) {
        let origin = json!({ELEMENT: self.element(selector)});
        let action = json!({"type": "scroll", "x": x, "y": y, "deltaX": 0, "deltaY": delta, "duration": 0, "origin": origin});
        self.command(
            "actions",
            json!({"actions": [{"type": "wheel", "id": "wheel", "actions": [action]}]}),
        );
    }

    /// A command of the DevTools protocol.
    pub fn devtools(&self, cmd: &str, params: Value) {
        self.command("goog/cdp/execute", json!({"cmd": cmd, "params": params}));
    }

    /// What the console said since the last time.
    pub fn console(&self) -> Value {
        self.command("se/log", json!({"type": "browser"}))
    }

    pub fn screenshot(&self, path: &Path) {
        let picture = self.ask(
            "GET",
            &format!("/session/{}/screenshot", self.session),
            &Value::Null,
        );
        let bytes = BASE64_STANDARD.decode(picture.as_str().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// The key by its number in the protocol, as are the arrows.
const SHIFT: &str = "\u{e008}";
pub const LEFT: &str = "\u{e012}";
pub const UP: &str = "\u{e013}";
pub const RIGHT: &str = "\u{e014}";
pub const DOWN: &str = "\u{e015}";

impl Drop for Browser {
    fn drop(&mut self) {
        if !self.session.is_empty() {
            self.ask(
                "DELETE",
                &format!("/session/{}", self.session),
                &Value::Null,
            );
        }
        // It may have ended already.
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}
