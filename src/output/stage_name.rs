//! Names for what is not finished yet, and whose process is dead.

use std::fs;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::path::{Path, PathBuf};
use std::process;

use xxhash_rust::xxh3::xxh3_64;

/// A name beside `path`, hidden and nobody else's: `.NAME.WHAT-MACHINE-PROCESS-RANDOM`.
///
/// Random, because the other two may be the same in a copy of a virtual machine, and where the machine does not tell.
pub(super) fn beside(path: &Path, what: &str) -> PathBuf {
    let machine = machine().unwrap_or_else(|| "unknown".to_owned());
    let random = RandomState::new().build_hasher().finish() as u32;
    path.with_file_name(format!("{}{machine}-{}-{random:08x}", beginning(path, what), process::id()))
}

/// Whether [`beside`] gave this name in a process that has ended. No, where that cannot be known: on another machine, in
/// another container, in an earlier boot, without `/proc`.
pub(super) fn is_of_the_dead(name: &str, path: &Path, what: &str) -> bool {
    let process = || {
        let rest = name.strip_prefix(&beginning(path, what))?.strip_prefix(&machine()?)?.strip_prefix('-')?;
        rest.split_once('-')?.0.parse::<u32>().ok()
    };
    process().is_some_and(|process| !Path::new("/proc").join(process.to_string()).exists())
}

fn beginning(path: &Path, what: &str) -> String {
    format!(".{}.{what}-", path.file_name().unwrap_or_default().to_string_lossy())
}

/// Eight digits for this boot of this machine and the namespace of process numbers: where both are the same, a number is the
/// same process. `None` where `/proc` does not show the numbers of all processes as this one knows them.
fn machine() -> Option<String> {
    let shows_this = fs::read_link("/proc/self").is_ok_and(|number| number == Path::new(&process::id().to_string()));
    // The first process always lives; where it is not seen, other users' processes are hidden.
    if !shows_this || !Path::new("/proc/1").exists() {
        return None;
    }
    let boot = fs::read("/proc/sys/kernel/random/boot_id").ok()?;
    let namespace = fs::read_link("/proc/self/ns/pid").ok()?;
    let both = [&boot, namespace.as_os_str().as_encoded_bytes()].concat();
    // The upper half: eight of the sixteen digits.
    Some(format!("{:08x}", xxh3_64(&both) >> 32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_names_are_the_same() {
        let name = || beside(Path::new("out/straight"), "tmp");
        assert_ne!(name(), name());
        assert_eq!(name().parent(), Some(Path::new("out")));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn only_what_a_process_of_this_machine_has_left_is_of_the_dead() {
        let path = Path::new("out/straight");
        let mine = beside(path, "tmp").file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        let is = |name: &str| is_of_the_dead(name, path, "tmp");
        assert!(!is(&mine), "this process lives");
        // No process has this number: Linux stops at 2^22.
        let dead = mine.replace(&format!("-{}-", process::id()), "-4294967295-");
        assert!(is(&dead), "{dead}");
        assert!(!is(&dead.replace(&machine().expect("a machine"), "00000000")), "another machine's");
        assert!(!is(&dead.replace("straight", "other")) && !is_of_the_dead(&dead, path, "old"));
        for other in ["", ".straight.tmp-", ".straight.tmp-4294967295", "straight"] {
            assert!(!is(other), "{other}");
        }
    }
}
