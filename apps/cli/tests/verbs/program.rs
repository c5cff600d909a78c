//! Runs the program in an empty folder of its own.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder that goes with the test.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new() -> Self {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        let name = format!("subsurf-cli-{}-{}", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    /// All names, hidden ones included, in order.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs the program here with arguments divided by blanks.
    pub fn run(&self, args: &str) -> Run {
        self.run_with(&args.split_whitespace().collect::<Vec<_>>(), "")
    }

    pub fn run_with(&self, args: &[&str], input: &str) -> Run {
        let mut child = Command::new(env!("CARGO_BIN_EXE_subsurf"))
            .args(args)
            .current_dir(&self.0)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let input = input.to_owned();
        // The program may well end without reading.
        let writer = std::thread::spawn(move || drop(stdin.write_all(input.as_bytes())));
        let output = child.wait_with_output().unwrap();
        writer.join().unwrap();
        Run::new(args.join(" "), output)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

/// What a run left.
pub struct Run {
    pub args: String,
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    fn new(args: String, output: Output) -> Self {
        let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
        let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
        assert!(!stderr.contains("panicked"), "{args}: {stderr}");
        Self { status: output.status.code().expect("no signal"), args, stdout, stderr }
    }

    /// A run that went well.
    pub fn done(self) -> Self {
        assert_eq!(self.status, 0, "{}: {}", self.args, self.stderr);
        self
    }

    /// A run that failed with one message on standard error, which names all of `words`.
    pub fn failed(&self, words: &[&str]) {
        assert_eq!(self.status, 1, "{}: {}{}", self.args, self.stdout, self.stderr);
        assert_eq!(self.stdout, "", "{}", self.args);
        let message = self.stderr.strip_prefix("error: ").unwrap_or_else(|| panic!("{}: {}", self.args, self.stderr));
        assert_eq!(message.lines().count(), 1, "{}: {message}", self.args);
        assert!(words.iter().all(|word| message.contains(word)), "{}: {message} (wanted {words:?})", self.args);
    }

    /// The object on standard output.
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{}: {error}: {}", self.args, self.stdout))
    }
}

/// The path of one of the tests' meshes.
pub fn data(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name).display().to_string()
}

/// A mesh that was written as OBJ.
pub fn mesh(text: &str) -> subsurf_io::Scene {
    subsurf_io::read_obj(text.as_bytes(), "output", &subsurf_io::ReadOptions::default()).unwrap()
}

/// The larger of two errors; none is larger than one that is not a number.
pub fn worse(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// Largest distance of points in order.
pub fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).flat_map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).abs())).fold(0.0, worse)
}
