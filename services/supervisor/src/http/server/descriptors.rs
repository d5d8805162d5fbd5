//! File descriptors: how many connections a process can have open.

use rustix::process::{Resource, Rlimit, setrlimit};

/// File descriptors reserved for the database, MQTT and files at least.
const RESERVE_MIN: u64 = 256;
/// File descriptors for connections at least, so that some clients are served under the smallest limits.
const CONNECTIONS_MIN: u64 = 16;

/// Raises the process's soft limit of file descriptors to its hard limit, and returns the limit in effect, or `None` if
/// the system does not tell it. Soft limits are low because of programs that use `select`; this process starts none.
pub(crate) fn raise_limit() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let (soft, hard) = open_files(&limits)?;
    if soft >= hard {
        return Some(soft);
    }
    let raised = setrlimit(Resource::Nofile, Rlimit { current: Some(hard), maximum: Some(hard) });
    match raised {
        Ok(()) => Some(hard),
        Err(problem) => {
            tracing::debug!(%problem, soft, hard, "cannot raise the limit of file descriptors");
            Some(soft)
        }
    }
}

/// Soft and hard limit of open files in the text of `/proc/self/limits`.
fn open_files(limits: &str) -> Option<(u64, u64)> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max open files"))?;
    let mut words = line.split_whitespace().map(|word| if word == "unlimited" { Ok(u64::MAX) } else { word.parse() });
    Some((words.next()?.ok()?, words.next()?.ok()?))
}

/// Number of connections that may be open: the configured one, or fewer if the process has too few file descriptors.
pub(super) fn connections_max(configured: u32, descriptors: Option<u64>) -> u32 {
    let Some(descriptors) = descriptors else { return configured };
    let possible = descriptors.saturating_sub(RESERVE_MIN.max(descriptors / 4)).max(CONNECTIONS_MIN);
    configured.min(u32::try_from(possible).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_read_from_what_linux_writes() {
        let line = |limits: &str| {
            format!(
                "Limit                     Soft Limit           Hard Limit           Units     \nMax open files            {limits}               files     \nMax locked memory         8388608\n"
            )
        };
        assert_eq!(open_files(&line("1024                 524288")), Some((1024, 524_288)));
        assert_eq!(open_files(&line("1024                 unlimited")), Some((1024, u64::MAX)));
        assert_eq!(open_files("Max locked memory 1 1"), None);
        assert_eq!(open_files("Max open files"), None);
    }

    #[test]
    fn connections_leave_descriptors_for_everything_else() {
        for (configured, descriptors, expected) in [
            (2048, Some(1_048_576), 2048),
            (2048, Some(1024), 768),
            (20_000, Some(20_000), 15_000),
            (2048, Some(64), 16),
            (2048, None, 2048),
        ] {
            assert_eq!(connections_max(configured, descriptors), expected, "{configured} of {descriptors:?}");
        }
    }

    #[test]
    fn the_limit_of_this_process_is_known() {
        let first = raise_limit();
        assert!(first.is_some_and(|limit| limit >= 16), "{first:?}");
        assert_eq!(raise_limit(), first);
    }
}
