//! Where a sweep's plan and results are: a folder, flushed to disk with each write, or an object store (`s3://bucket/prefix`, feature
//! `s3`). Objects appear whole or not at all, and of several that write the same one the first wins.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use object_store::local::LocalFileSystem;
use object_store::path::Path as Key;
use object_store::{Error, ObjectStore, ObjectStoreExt, PutMode, PutOptions, PutPayload};
use tokio::runtime::{Builder, Runtime};

#[cfg(feature = "s3")]
mod s3;

/// How often an object is written to an object store whose answers get lost.
const REMOTE_TRIES: u32 = 3;

/// A folder or object store.
#[derive(Debug)]
pub struct Store {
    place: String,
    folder: Option<PathBuf>,
    objects: Arc<dyn ObjectStore>,
    prefix: Key,
    runtime: Runtime,
}

/// Why a store cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {message}")]
pub struct StoreError {
    /// The folder, the address, or the object.
    pub place: String,
    /// What is wrong.
    pub message: String,
}

/// An object's bytes.
pub type Bytes = bytes::Bytes;

impl Store {
    /// Opens the store at `place`: a folder, which is made where it is missing, or an address with `://`.
    ///
    /// # Errors
    /// Where it cannot be reached, or this program was built without what it needs.
    pub fn open(place: &str) -> Result<Self, StoreError> {
        let wrong = |message: String| StoreError { place: place.to_owned(), message };
        let remote = place.contains("://");
        let runtime = runtime(remote).map_err(|error| wrong(error.to_string()))?;
        let (objects, prefix, folder): (Arc<dyn ObjectStore>, Key, _) = if remote {
            match s3::open(place, &runtime) {
                Ok((objects, prefix)) => (objects, prefix, None),
                Err(message) => {
                    // A name that is still being looked up is not waited for.
                    runtime.shutdown_background();
                    return Err(wrong(message));
                }
            }
        } else {
            let folder = PathBuf::from(place);
            std::fs::create_dir_all(&folder).map_err(|error| wrong(format!("this folder cannot be made: {error}")))?;
            let files = LocalFileSystem::new_with_prefix(&folder).map_err(|error| wrong(reason(&error)))?;
            (Arc::new(files.with_fsync(true)), Key::default(), Some(folder))
        };
        Ok(Self { place: place.to_owned(), folder, objects, prefix, runtime })
    }

    /// Its folder or address.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// Its folder, if it is one.
    pub fn folder(&self) -> Option<&std::path::Path> {
        self.folder.as_deref()
    }

    /// Writes an object unless there is one of this name; whether it did.
    ///
    /// # Errors
    /// Where it cannot be written: a full disk, no right to.
    pub fn create(&self, name: &str, bytes: Vec<u8>) -> Result<bool, StoreError> {
        let (key, payload) = (self.key(name), PutPayload::from(bytes));
        let mut tries = if self.folder.is_none() { REMOTE_TRIES } else { 1 };
        loop {
            tries -= 1;
            let options = PutOptions { mode: PutMode::Create, ..PutOptions::default() };
            match self.runtime.block_on(self.objects.put_opts(&key, payload.clone(), options)) {
                Ok(_) => return Ok(true),
                // S3 also says so where two write at once, and then perhaps neither has.
                Err(Error::AlreadyExists { .. }) => {
                    let missing = || matches!(self.runtime.block_on(self.objects.head(&key)), Err(Error::NotFound { .. }));
                    if tries == 0 || !missing() {
                        return Ok(false);
                    }
                }
                // Perhaps it is written: then the next try finds it there, as if another had written it, which is no harm.
                Err(error) if tries > 0 && s3::is_open(&error) => {}
                Err(error) => return Err(self.wrong(name, &error)),
            }
        }
    }

    /// Writes an object in the place of any of this name.
    ///
    /// # Errors
    /// As [`Store::create`].
    pub fn replace(&self, name: &str, bytes: Vec<u8>) -> Result<(), StoreError> {
        let written = self.runtime.block_on(self.objects.put(&self.key(name), PutPayload::from(bytes)));
        written.map(|_| ()).map_err(|error| self.wrong(name, &error))
    }

    /// An object's bytes; `None` where there is none of this name.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn get(&self, name: &str) -> Result<Option<Bytes>, StoreError> {
        let got = self.runtime.block_on(async { self.objects.get(&self.key(name)).await?.bytes().await });
        match got {
            Ok(bytes) => Ok(Some(bytes)),
            Err(Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(self.wrong(name, &error)),
        }
    }

    /// Names of all objects within a folder of the store, `parts` say, in their order.
    ///
    /// # Errors
    /// Where the store cannot be read.
    pub fn list(&self, folder: &str) -> Result<Vec<String>, StoreError> {
        use futures_util::TryStreamExt;
        let found = self.runtime.block_on(self.objects.list(Some(&self.key(folder))).try_collect::<Vec<_>>());
        let found = found.map_err(|error| self.wrong(folder, &error))?;
        let name = |key: &Key| key.filename().map(|name| format!("{folder}/{name}"));
        let mut names: Vec<String> = found.iter().filter_map(|object| name(&object.location)).collect();
        names.sort();
        Ok(names)
    }

    /// Takes an object away; one that is not there is no error.
    ///
    /// # Errors
    /// Where it cannot be taken away.
    pub fn delete(&self, name: &str) -> Result<(), StoreError> {
        match self.runtime.block_on(self.objects.delete(&self.key(name))) {
            Ok(()) | Err(Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(self.wrong(name, &error)),
        }
    }

    /// Takes away what writers left half written in a folder of the store at least so long ago. Object stores have no such thing. What
    /// cannot be taken away stays: it is in nobody's way.
    pub fn tidy(&self, folder: &str, age: Duration) {
        let Some(root) = &self.folder else { return };
        let half_written = |name: &str| {
            name.rsplit_once('#').is_some_and(|(_, digits)| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
        };
        for entry in std::fs::read_dir(root.join(folder)).into_iter().flatten().flatten() {
            let old = || entry.metadata().ok()?.modified().ok()?.elapsed().ok();
            if half_written(&entry.file_name().to_string_lossy()) && old().is_some_and(|old| old >= age) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    fn key(&self, name: &str) -> Key {
        name.split('/').fold(self.prefix.clone(), |key, part| key.join(part))
    }

    fn wrong(&self, name: &str, error: &Error) -> StoreError {
        StoreError { place: format!("{}/{name}", self.place.trim_end_matches('/')), message: reason(error) }
    }
}

/// What waits for a store's answers. Connections want to be looked after between two requests, or one that was closed since is noticed
/// only by the next; files do not.
fn runtime(remote: bool) -> std::io::Result<Runtime> {
    #[cfg(feature = "s3")]
    if remote {
        return Builder::new_multi_thread().worker_threads(1).enable_all().build();
    }
    let _ = remote;
    Builder::new_current_thread().enable_all().build()
}

/// The innermost cause, which says the most; of a document in S3's form its code and message.
fn reason(error: &Error) -> String {
    let mut cause: &dyn std::error::Error = error;
    while let Some(inner) = cause.source() {
        cause = inner;
    }
    let text = cause.to_string();
    let element = |name: &str| {
        let (_, rest) = text.split_once(&format!("<{name}>"))?;
        Some(rest.split_once("</")?.0.to_owned())
    };
    match (element("Code"), element("Message")) {
        (Some(code), Some(message)) => format!("{code}: {message}"),
        (Some(code), None) => code,
        // In one line, whatever a server says.
        _ => text.split_whitespace().collect::<Vec<_>>().join(" "),
    }
}

#[cfg(not(feature = "s3"))]
mod s3 {
    //! What a program without the feature says.
    use super::{Arc, Error, Key, ObjectStore, Runtime};

    pub(super) fn open(_place: &str, _runtime: &Runtime) -> Result<(Arc<dyn ObjectStore>, Key), String> {
        Err("this program was built without the feature `s3`: name a folder, or build with `cargo build --release --features s3`"
            .into())
    }

    pub(super) fn is_open(_error: &Error) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_writer_wins_and_nothing_is_half_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(&folder.path().join("new/one").display().to_string()).expect("a store");
        assert!(store.create("parts/a", b"first".to_vec()).expect("written"));
        assert!(!store.create("parts/a", b"second".to_vec()).expect("there already"));
        assert_eq!(store.get("parts/a").expect("read").as_deref(), Some(b"first".as_slice()));
        store.replace("parts/a", b"third".to_vec()).expect("replaced");
        assert_eq!(store.get("parts/a").expect("read").as_deref(), Some(b"third".as_slice()));
        // What a killed process leaves of a write is not listed.
        std::fs::write(folder.path().join("new/one/parts/b#1"), b"ha").expect("a file");
        assert_eq!(store.list("parts").expect("listed"), ["parts/a"]);
        assert_eq!(store.list("none").expect("listed"), Vec::<String>::new());
        // It goes when it is old, whole objects do not.
        let half = folder.path().join("new/one/parts/b#1");
        store.tidy("parts", Duration::from_secs(3600));
        assert!(half.exists());
        store.tidy("parts", Duration::ZERO);
        assert!(!half.exists());
        assert_eq!(store.list("parts").expect("listed"), ["parts/a"]);
        store.delete("parts/a").expect("gone");
        store.delete("parts/a").expect("gone already");
        assert_eq!(store.get("parts/a").expect("read"), None);
    }

    #[test]
    #[cfg(not(feature = "s3"))]
    fn what_cannot_be_reached_is_named() {
        let error = Store::open("s3://bucket/prefix").expect_err("no S3 here").to_string();
        assert!(error.contains("s3://bucket/prefix") && error.contains("feature"), "{error}");
        let file = tempfile::NamedTempFile::new().expect("a file");
        assert!(Store::open(&file.path().display().to_string()).is_err());
    }
}
