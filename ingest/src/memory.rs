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

/// A quarter of this machine's memory, in bytes; two gigabytes where the system does not tell (`MemTotal` of `/proc/meminfo`, in
/// KiB, is Linux).
#[must_use]
pub fn quarter_of_memory() -> u64 {
    let told = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
        line.trim().trim_end_matches(" kB").parse::<u64>().ok()
    });
    told.map_or(2 << 30, |kibibytes| kibibytes * 1024 / 4)
}
