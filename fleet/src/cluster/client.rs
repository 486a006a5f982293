//! A session whose queries run on a cluster.

use super::{ClusterError, config};
use crate::session::{self, Settings};
use crate::stores;
use ballista::prelude::SessionContextExt as _;
use datafusion::execution::session_state::SessionStateBuilder;
use datafusion::prelude::SessionContext;
use std::time::Duration;
use tokio::net::TcpStream;
use url::Url;

/// Time limit for reaching the scheduler.
const PATIENCE: Duration = Duration::from_secs(5);

/// The default port of schedulers.
pub const PORT: u16 = 50050;

/// A session on the cluster whose scheduler has this address.
///
/// # Errors
/// [`ClusterError`] if the address is wrong or no scheduler answers.
pub async fn connect(address: &str, settings: &Settings) -> Result<SessionContext, ClusterError> {
    let (host, port) = parse(address)?;
    reach(&host, port).await?;
    let runtime = stores::runtime(settings.memory)?;
    let builder = SessionStateBuilder::new().with_config(config(settings)).with_runtime_env(runtime);
    let state = builder.with_default_features().build();
    let remote = SessionContext::remote_with_state(&format!("df://{host}:{port}"), state).await?;
    Ok(session::complete(remote))
}

/// Parses `df://HOST:PORT` into host and port.
fn parse(address: &str) -> Result<(String, u16), ClusterError> {
    let url = Url::parse(address).ok().filter(|url| url.scheme() == "df" && matches!(url.path(), "" | "/"));
    let host = url.as_ref().and_then(Url::host_str).map(str::to_owned);
    match (host, url) {
        (Some(host), Some(url)) => Ok((host, url.port().unwrap_or(PORT))),
        _ => Err(ClusterError::Address(address.to_owned())),
    }
}

/// Checks that a scheduler answers, so that an error appears at once and not during a query.
async fn reach(host: &str, port: u16) -> Result<(), ClusterError> {
    let address = format!("{host}:{port}");
    let unreachable = |reason: String| ClusterError::Unreachable { address: address.clone(), reason };
    match tokio::time::timeout(PATIENCE, TcpStream::connect(&address)).await {
        Ok(Ok(_)) => Ok(()),
        Ok(Err(error)) => Err(unreachable(error.to_string())),
        Err(_) => Err(unreachable(format!("nothing came within {} s", PATIENCE.as_secs()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_as_typed() {
        assert_eq!(parse("df://localhost:1234").unwrap(), ("localhost".to_owned(), 1234));
        assert_eq!(parse("df://10.0.0.7").unwrap(), ("10.0.0.7".to_owned(), PORT));
        assert_eq!(parse("df://[::1]:7").unwrap(), ("[::1]".to_owned(), 7));
        for wrong in ["", "localhost:50050", "http://localhost", "df://", "df://a:b", "df://a/b"] {
            assert!(matches!(parse(wrong), Err(ClusterError::Address(_))), "{wrong}");
        }
    }
}
