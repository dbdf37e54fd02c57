//! Where a sweep's plan and results are: a folder, flushed to disk with each write, or an object store (`s3://bucket/prefix`, feature
//! `s3`). Objects appear whole or not at all, and of several that write the same one the first wins.

use std::path::PathBuf;
use std::sync::Arc;

use object_store::local::LocalFileSystem;
use object_store::path::Path as Key;
use object_store::{Error, ObjectStore, ObjectStoreExt, PutMode, PutOptions, PutPayload};
use tokio::runtime::{Builder, Runtime};

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
        let runtime = Builder::new_current_thread().enable_all().build().map_err(|error| wrong(error.to_string()))?;
        let (objects, prefix, folder): (Arc<dyn ObjectStore>, Key, _) = if place.contains("://") {
            let (objects, prefix) = remote(place).map_err(wrong)?;
            (objects, prefix, None)
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
        let options = PutOptions { mode: PutMode::Create, ..PutOptions::default() };
        match self.runtime.block_on(self.objects.put_opts(&self.key(name), PutPayload::from(bytes), options)) {
            Ok(_) => Ok(true),
            Err(Error::AlreadyExists { .. }) => Ok(false),
            Err(error) => Err(self.wrong(name, &error)),
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

    fn key(&self, name: &str) -> Key {
        name.split('/').fold(self.prefix.clone(), |key, part| key.join(part))
    }

    fn wrong(&self, name: &str, error: &Error) -> StoreError {
        StoreError { place: format!("{}/{name}", self.place.trim_end_matches('/')), message: reason(error) }
    }
}

/// The innermost cause, which says the most.
fn reason(error: &Error) -> String {
    let mut cause: &dyn std::error::Error = error;
    while let Some(inner) = cause.source() {
        cause = inner;
    }
    cause.to_string()
}

/// The store at an address, with what comes after the bucket.
#[cfg(feature = "s3")]
fn remote(place: &str) -> Result<(Arc<dyn ObjectStore>, Key), String> {
    let address = url::Url::parse(place).map_err(|error| format!("this is no address: {error}"))?;
    if address.scheme() != "s3" {
        return Err(format!("`{}` is no kind of store that is known here: a folder, or `s3://BUCKET/PREFIX`", address.scheme()));
    }
    let bucket = address.host_str().ok_or("this names no bucket: write `s3://BUCKET/PREFIX`")?;
    let objects = object_store::aws::AmazonS3Builder::from_env()
        .with_bucket_name(bucket)
        // Writes if nothing is there; S3 has had it since 2024.
        .with_conditional_put(object_store::aws::S3ConditionalPut::ETagMatch)
        .build()
        .map_err(|error| reason(&error))?;
    Ok((Arc::new(objects), Key::from(address.path())))
}

#[cfg(not(feature = "s3"))]
fn remote(_place: &str) -> Result<(Arc<dyn ObjectStore>, Key), String> {
    Err("this program was built without the feature `s3`: name a folder, or build with `cargo build --release --features s3`"
        .into())
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
