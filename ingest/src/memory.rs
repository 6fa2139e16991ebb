//! What the operating system says of this process.

/// The most memory that this process had at once, in bytes; None where the system does not tell (`VmHWM` of
/// `/proc/self/status`, in KiB, is Linux).
#[must_use]
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kibibytes * 1024)
}
