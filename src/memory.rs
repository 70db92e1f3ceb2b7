//! Memory as a bound that is known before work begins: what a stage will take is estimated from its sizes, and what is
//! more than may be taken is refused. The bound never changes a result.

use std::fmt;

#[cfg(feature = "system-memory")]
use sysinfo::{MemoryRefreshKind, System};

/// The share of what the system has that work may take unless somebody says otherwise: the rest is left to others, to the
/// system's own buffers, and to the error of estimates.
#[cfg(feature = "system-memory")]
const USUAL_SHARE: f64 = 0.7;

/// Address space that a thread sets aside besides what it works on, bytes: its stack, and the arena that an allocator such
/// as glibc's gives it (64 MiB).
#[cfg(feature = "system-memory")]
const ADDRESSES_A_THREAD: u64 = 72 << 20;

/// What work takes at the most, and in which of its stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Bytes at once.
    pub bytes: u64,
    /// What takes them.
    pub stage: &'static str,
    /// What would make it less.
    pub remedy: &'static str,
}

impl Need {
    /// `bytes`, which may be any number, of a stage; whoever has too few can do as `remedy` says.
    pub fn new(bytes: f64, stage: &'static str, remedy: &'static str) -> Self {
        // What is beyond the range is at its end.
        Self { bytes: bytes as u64, stage, remedy }
    }

    /// The larger of two that do not come at the same time.
    pub fn or(self, other: Self) -> Self {
        if other.bytes > self.bytes { other } else { self }
    }
}

impl fmt::Display for Need {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&said(self.bytes))
    }
}

/// Bytes as a person reads them.
pub fn said(bytes: u64) -> String {
    match bytes as f64 {
        few if few < 1e9 => format!("{:.0} MB", (few / 1e6).ceil()),
        many => format!("{:.1} GB", (many / 1e8).ceil() / 10.0),
    }
}

/// The most memory that work may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLimit(u64);

impl MemoryLimit {
    /// As much as there is, and more.
    pub const NONE: Self = Self(u64::MAX);

    /// This many bytes.
    pub const fn of_bytes(bytes: u64) -> Self {
        Self(bytes)
    }

    /// The usual bound for work on `threads` threads: 70 % of the least of the machine's memory, the control group's limit
    /// and the limit on the process's addresses, as far as the system tells them.
    #[cfg(feature = "system-memory")]
    pub fn of_system(threads: usize) -> Self {
        let mut system = System::new();
        system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
        // A system that tells nothing says 0, and is not asked for its groups, since that would panic.
        let machine = Some(system.total_memory()).filter(|bytes| *bytes > 0);
        let group = machine.and_then(|_| system.cgroup_limits()).map(|group| group.total_memory);
        let addresses =
            address_space().map(|all| all.saturating_sub(ADDRESSES_A_THREAD.saturating_mul(threads as u64)));
        let least = [machine, group].into_iter().flatten().filter(|bytes| *bytes > 0).chain(addresses).min();
        Self(least.map_or(u64::MAX, |bytes| (USUAL_SHARE * bytes as f64) as u64))
    }

    /// How many bytes.
    pub fn bytes(self) -> u64 {
        self.0
    }

    /// Refuses work that needs more.
    ///
    /// # Errors
    /// It needs more.
    pub fn admit(self, need: Need) -> Result<(), TooMuchMemory> {
        if need.bytes <= self.0 { Ok(()) } else { Err(TooMuchMemory { need, limit: self.0 }) }
    }
}

/// What the process may address, bytes, if there is a limit.
#[cfg(feature = "system-memory")]
fn address_space() -> Option<u64> {
    #[cfg(unix)]
    {
        rustix::process::getrlimit(rustix::process::Resource::As).current
    }
    #[cfg(not(unix))]
    {
        None
    }
}

/// Work that would take more memory than it may.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{} would take about {need} of memory, and no more than {} may be taken: {}, or allow more with --memory",
    need.stage, said(*limit), need.remedy
)]
pub struct TooMuchMemory {
    /// What it would take.
    pub need: Need,
    /// What it may take, bytes.
    pub limit: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_is_admitted_and_what_does_not_is_refused_with_figures_and_remedy() {
        let need = Need::new(3.21e9, "the relief", "lower --grid");
        assert_eq!(MemoryLimit::of_bytes(3_300_000_000).admit(need), Ok(()));
        assert_eq!(MemoryLimit::NONE.admit(Need::new(f64::INFINITY, "all", "less")), Ok(()));
        let refused = MemoryLimit::of_bytes(500_000_000).admit(need).unwrap_err().to_string();
        for part in ["the relief", "3.3 GB", "500 MB", "lower --grid", "--memory"] {
            assert!(refused.contains(part), "{refused}");
        }
        assert_eq!(need.or(Need::new(1.0, "little", "")), need);
    }

    #[test]
    fn the_usual_bound_is_less_than_what_the_machine_has() {
        let usual = MemoryLimit::of_system(1);
        let mut system = System::new();
        system.refresh_memory();
        assert!(usual.bytes() > 0 && (system.total_memory() == 0 || usual.bytes() < system.total_memory()));
        assert!(MemoryLimit::of_system(1000).bytes() <= usual.bytes());
    }
}
