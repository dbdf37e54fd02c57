//! A folder to run the program in, and what it said.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// No call of these tests takes longer than a few seconds; one that does hangs.
const PATIENCE: Duration = Duration::from_secs(120);

/// As on a machine without a graphics adapter: neither name of the variable finds a driver, and a backend that is not built in
/// keeps out whatever else there is.
pub(crate) const NO_ADAPTER: [(&str, &str); 3] =
    [("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent"), ("WGPU_BACKEND", "noop")];

/// A folder that goes when it is dropped.
pub(crate) struct Workshop(tempfile::TempDir);

/// A call that ended.
#[derive(Debug)]
pub(crate) struct Ran {
    /// Exit code; `None` for one that was killed.
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// A call under way.
pub(crate) struct Running {
    child: Child,
    stdout: PathBuf,
    stderr: PathBuf,
}

/// A run that lasts long enough to be interrupted on any machine.
pub(crate) fn long(name: &str) -> String {
    scenario(name, 12.0)
}

/// A robot that drives `length_m` less the half metre at either end, and must arrive.
pub(crate) fn scenario(name: &str, length_m: f64) -> String {
    format!(
        r#"format = 1
kind = "scenario"
name = "{name}"
time_limit_s = 60.0
[duct]
width_m = 0.5
height_m = 0.3
run = [{{ straight_m = {length_m:?} }}]
[pass]
completed = true
collisions = 0
"#
    )
}

impl Workshop {
    /// With one scenario in it: `short.toml`, a run of 0.6 m.
    pub(crate) fn new() -> Self {
        let workshop = Self(tempfile::tempdir().expect("a folder"));
        workshop.write("short.toml", scenario("short", 1.6));
        workshop
    }

    pub(crate) fn path(&self, below: &str) -> PathBuf {
        self.0.path().join(below)
    }

    /// Writes a file; folders above it are made.
    pub(crate) fn write(&self, below: &str, text: impl AsRef<[u8]>) {
        let path = self.path(below);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }

    pub(crate) fn read(&self, below: &str) -> String {
        fs::read_to_string(self.path(below)).unwrap_or_else(|error| panic!("{below}: {error}"))
    }

    /// Every file below a folder by its path in it, hidden ones too. A folder that is not there holds none.
    pub(crate) fn files(&self, below: &str) -> BTreeMap<String, Vec<u8>> {
        fn walk(folder: &Path, prefix: &str, files: &mut BTreeMap<String, Vec<u8>>) {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
                if entry.path().is_dir() {
                    walk(&entry.path(), &format!("{name}/"), files);
                } else {
                    files.insert(name, fs::read(entry.path()).unwrap_or_default());
                }
            }
        }
        let mut files = BTreeMap::new();
        walk(&self.path(below), "", &mut files);
        files
    }

    /// What is in a folder, hidden things too.
    pub(crate) fn names(&self, below: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(below)).into_iter().flatten().flatten();
        let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Whether `out/NAME` is a run's folder with everything in it.
    #[track_caller]
    pub(crate) fn assert_whole(&self, name: &str) {
        let files = self.files(&format!("out/{name}"));
        for file in ["frames.parquet", "manifest.json", "report.html", "scenario.toml", "summary.json"] {
            assert!(files.get(file).is_some_and(|bytes| !bytes.is_empty()), "{file} of {name}: {:?}", files.keys());
        }
        assert!(files.keys().any(|file| file.starts_with("frames/") && file.ends_with(".png")), "{:?}", files.keys());
        // Each ends as its format does, so it is not cut off.
        assert!(files["frames.parquet"].ends_with(b"PAR1"));
        assert!(files["report.html"].trim_ascii_end().ends_with(b"</html>"));
        for document in ["manifest.json", "summary.json"] {
            serde_json::from_slice::<Value>(&files[document]).expect(document);
        }
    }

    fn command<S: AsRef<OsStr>>(&self, args: impl IntoIterator<Item = S>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ductloop"));
        command.args(args).current_dir(self.0.path()).stdin(Stdio::null());
        // Mesa complains where it is unset.
        command.env("XDG_RUNTIME_DIR", self.0.path());
        command
    }

    /// Starts the program.
    pub(crate) fn start(&self, args: &[&str]) -> Running {
        self.start_with(self.command(args))
    }

    fn start_with(&self, mut command: Command) -> Running {
        // Into files: a pipe that nobody empties would stop the program.
        let streams = tempfile::tempdir_in(self.0.path()).expect("a folder").keep();
        let hidden = streams.with_file_name(format!(".streams-{}", streams.file_name().expect("a name").to_string_lossy()));
        fs::rename(&streams, &hidden).expect("a folder");
        let (stdout, stderr) = (hidden.join("stdout"), hidden.join("stderr"));
        command.stdout(File::create(&stdout).expect("a file")).stderr(File::create(&stderr).expect("a file"));
        Running { child: command.spawn().expect("the program starts"), stdout, stderr }
    }

    /// Runs the program to its end.
    pub(crate) fn run(&self, args: &[&str]) -> Ran {
        self.start(args).wait()
    }

    /// The same with environment variables.
    pub(crate) fn run_with(&self, variables: &[(&str, &str)], args: &[&str]) -> Ran {
        let mut command = self.command(args);
        command.envs(variables.iter().copied());
        self.start_with(command).wait()
    }

    /// The same on another processor: `emulator` and its arguments, then the program's. `None` where there is no such emulator.
    pub(crate) fn run_on(&self, emulator: &[&str], args: &[&str]) -> Option<Ran> {
        let mut command = Command::new(emulator[0]);
        command.args(&emulator[1..]).arg(env!("CARGO_BIN_EXE_ductloop")).args(args).current_dir(self.0.path());
        if Command::new(emulator[0]).arg("--version").output().is_err() {
            return None;
        }
        Some(self.start_with(command).wait())
    }

    /// The same with standard output going to `path`.
    pub(crate) fn run_into(&self, path: &str, args: &[&str]) -> Ran {
        let stderr = self.path(".stderr");
        let mut command = self.command(args);
        command.stdout(File::options().write(true).open(path).expect(path)).stderr(File::create(&stderr).expect("a file"));
        Running { child: command.spawn().expect("the program starts"), stdout: PathBuf::from("/dev/null"), stderr }.wait()
    }
}

impl Running {
    /// Waits for the end.
    #[track_caller]
    pub(crate) fn wait(mut self) -> Ran {
        let started = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                break status;
            }
            if started.elapsed() > PATIENCE {
                let _ = self.child.kill();
                panic!("it hangs; so far it said {}", self.said());
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let read = |path: &Path| fs::read_to_string(path).expect("UTF-8");
        Ran { code: status.code(), stdout: read(&self.stdout), stderr: read(&self.stderr) }
    }

    /// What it has said on standard error so far.
    pub(crate) fn said(&self) -> String {
        fs::read_to_string(&self.stderr).unwrap_or_default()
    }

    /// Waits until something is the case while the program runs.
    #[track_caller]
    pub(crate) fn until(&mut self, what: &str, mut is: impl FnMut(&Self) -> bool) {
        let started = Instant::now();
        while !is(self) {
            let ended = self.child.try_wait().expect("a child");
            assert!(ended.is_none(), "it ended before {what}: {ended:?}, having said {}", self.said());
            assert!(started.elapsed() < PATIENCE, "{what} never came; it said {}", self.said());
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Waits until it simulates: it says what renders, and a moment later frames are being made.
    #[track_caller]
    pub(crate) fn until_it_simulates(&mut self) {
        self.until("rendering", |running| running.said().contains("rendering with"));
        std::thread::sleep(Duration::from_millis(300));
    }

    /// Whether it still runs.
    pub(crate) fn is_alive(&mut self) -> bool {
        self.child.try_wait().expect("a child").is_none()
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sends a signal: `INT`, `KILL`.
    pub(crate) fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([format!("-{name}"), self.child.id().to_string()]).status().expect("kill");
        assert!(sent.success(), "kill -{name}");
    }
}

impl Ran {
    /// The exit code must be this.
    #[track_caller]
    pub(crate) fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "stdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }

    /// Standard error must hold all of these.
    #[track_caller]
    pub(crate) fn saying(self, words: &[&str]) -> Self {
        for word in words {
            assert!(self.stderr.contains(word), "`{word}` is not in: {}", self.stderr);
        }
        self
    }

    /// The one document on standard output.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {}", self.stdout))
    }
}

/// The keys of an object, in their order.
#[track_caller]
pub(crate) fn keys(object: &Value) -> Vec<&str> {
    object.as_object().unwrap_or_else(|| panic!("an object: {object}")).keys().map(String::as_str).collect()
}
