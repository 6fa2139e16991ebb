//! The program while it runs.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

pub(crate) fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_terrain-server"))
}

/// A server that runs until it is dropped.
pub(crate) struct Running {
    pub(crate) process: Child,
    pub(crate) host: String,
}

impl Running {
    pub(crate) fn start(arguments: &[&str], archives: &Path) -> Self {
        let mut command = program();
        command.arg(archives).args(["--listen", "127.0.0.1:0"]).args(arguments);
        Self::of(command)
    }

    pub(crate) fn of(mut command: Command) -> Self {
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(process.stdout.as_mut().unwrap())
            .lines()
            .map_while(Result::ok);
        let page = lines.find(|line| line.starts_with("http://")).unwrap();
        let host = page.trim_start_matches("http://").trim_end_matches('/').to_owned();
        Self { process, host }
    }

    pub(crate) fn signal(&self, name: &str) {
        let id = self.process.id().to_string();
        assert!(Command::new("kill").args([name, &id]).status().unwrap().success());
    }

    /// What is sent goes as it is; the reply is all that comes until the end.
    pub(crate) fn send(&self, request: &str) -> String {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).unwrap();
        let mut reply = String::new();
        stream.read_to_string(&mut reply).unwrap();
        reply
    }

    pub(crate) fn get(&self, path: &str) -> String {
        self.send(&format!(
            "GET {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n",
            self.host
        ))
    }

    pub(crate) fn connect(&self) -> TcpStream {
        TcpStream::connect(&self.host).unwrap()
    }

    /// Exit code, and what was said on standard error.
    pub(crate) fn end(mut self) -> (Option<i32>, String) {
        let code = self.process.wait().unwrap().code();
        let mut said = String::new();
        self.process.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        (code, said)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        drop(self.process.kill());
    }
}
