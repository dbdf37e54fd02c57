//! Object stores that speak S3, named by the environment's usual variables (`AWS_…`). Files of profiles (`~/.aws`) are not read.
//!
//! One is asked what is there before anything runs, with little patience, so that a wrong name, key or endpoint is told of within
//! seconds. Later, in mid-sweep, a store that does not answer is given about a minute.

use std::sync::Arc;
use std::time::Duration;

use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey, S3ConditionalPut};
use object_store::client::{HttpError, HttpErrorKind};
use object_store::path::Path as Key;
use object_store::{ClientConfigKey, Error, ObjectStore, RetryConfig};
use tokio::runtime::Runtime;

use super::reason;

/// How long a store may take to answer for the first time, and each try of it.
const FIRST_ANSWER: Duration = Duration::from_secs(15);
const FIRST_TRY: &str = "6s";

/// The store at an address, with what comes after the bucket.
pub(super) fn open(place: &str, runtime: &Runtime) -> Result<(Arc<dyn ObjectStore>, Key), String> {
    let address = url::Url::parse(place).map_err(|error| format!("this is no address: {error}"))?;
    if address.scheme() != "s3" {
        return Err(format!("`{}` is no kind of store that is known here: a folder, or `s3://BUCKET/PREFIX`", address.scheme()));
    }
    let bucket = address.host_str().filter(|name| !name.is_empty()).ok_or("this names no bucket: write `s3://BUCKET/PREFIX`")?;
    let prefix = Key::from_url_path(address.path()).map_err(|error| error.to_string())?;
    let builder = AmazonS3Builder::from_env()
        .with_bucket_name(bucket)
        // Writes if nothing is there; S3 has had it since 2024.
        .with_conditional_put(S3ConditionalPut::ETagMatch)
        // One by one, which every store can do.
        .with_disable_bulk_delete(true);
    let answered = runtime.block_on(async { tokio::time::timeout(FIRST_ANSWER, ask(builder.clone(), &prefix)).await });
    answered.unwrap_or_else(|_| Err(format!("no answer within {} s{}", FIRST_ANSWER.as_secs(), endpoint(&builder))))?;
    let objects = builder.build().map_err(|error| reason(&error))?;
    Ok((Arc::new(objects), prefix))
}

/// Asks what is there: whoever answers knows the bucket, and this user in it.
async fn ask(builder: AmazonS3Builder, prefix: &Key) -> Result<(), String> {
    let endpoint = endpoint(&builder);
    let signs = !builder.get_config_value(&AmazonS3ConfigKey::SkipSignature).is_some_and(|skip| skip == "true");
    let objects = builder
        .with_config(AmazonS3ConfigKey::Client(ClientConfigKey::Timeout), FIRST_TRY)
        .with_retry(RetryConfig { max_retries: 1, retry_timeout: FIRST_ANSWER, ..RetryConfig::default() })
        .build()
        .map_err(|error| reason(&error))?;
    if signs && let Err(error) = objects.credentials().get_credential().await {
        return Err(format!(
            "there are no keys for it: AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY are not set, and this machine is given none ({})",
            reason(&error)
        ));
    }
    let listed = objects.list_with_delimiter(Some(prefix)).await;
    listed.map(|_| ()).map_err(|error| format!("{}{endpoint}", reason(&error)))
}

/// Where it was asked, to be said after what went wrong.
fn endpoint(builder: &AmazonS3Builder) -> String {
    let named = [AmazonS3ConfigKey::S3Endpoint, AmazonS3ConfigKey::Endpoint].iter().find_map(|key| builder.get_config_value(key));
    named.map_or(String::new(), |endpoint| format!(" (at {endpoint})"))
}

/// Whether it is not known if a request was carried out: its answer was lost.
pub(super) fn is_open(error: &Error) -> bool {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(inner) = cause {
        if let Some(http) = inner.downcast_ref::<HttpError>() {
            return matches!(http.kind(), HttpErrorKind::Timeout | HttpErrorKind::Interrupted);
        }
        cause = inner.source();
    }
    false
}
