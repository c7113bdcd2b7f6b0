//! Memory that a process can still take: the least of what the machine has, what its control groups
//! (Linux cgroups, as of Slurm and of containers) allow, and what the limits of the process allow.

use std::{fs, path::Path};

use super::AvailableMemory;

/// The machine.
const MACHINE: &str = "this machine";

/// A control group.
const CONTROL_GROUP: &str = "the control group of this process";

/// Address space.
const ADDRESS_SPACE: &str = "the limit of address space (`ulimit -v`)";

/// Data segment.
const DATA_SEGMENT: &str = "the limit of data (`ulimit -d`)";

/// The limits of a process (bytes): of its address space and of its data; `None` without a limit.
#[derive(Debug, Clone, Copy, Default)]
struct ProcessLimits {
    address_space: Option<u64>,
    data: Option<u64>,
}

/// The memory that this process can still take, swap space of the machine included; `None` where
/// the system does not say.
pub fn available() -> Option<AvailableMemory> {
    least(Path::new("/"), process_limits())
}

#[cfg(unix)]
fn process_limits() -> ProcessLimits {
    use rustix::process::{Resource, getrlimit};
    ProcessLimits {
        address_space: getrlimit(Resource::As).current,
        data: getrlimit(Resource::Data).current,
    }
}

#[cfg(not(unix))]
fn process_limits() -> ProcessLimits {
    ProcessLimits::default()
}

/// The least memory of all, from the files of Linux below `root`.
fn least(root: &Path, limits: ProcessLimits) -> Option<AvailableMemory> {
    let machine = fs::read_to_string(root.join("proc/meminfo")).ok();
    let machine = machine.as_deref();
    let swap = machine
        .and_then(|text| entry(text, "SwapFree"))
        .unwrap_or(0);
    let status = fs::read_to_string(root.join("proc/self/status")).unwrap_or_default();
    let rest = |limit: Option<u64>, used: &str| {
        limit.map(|limit| limit.saturating_sub(entry(&status, used).unwrap_or(0)))
    };
    let all = [
        (
            machine.and_then(|text| Some(entry(text, "MemAvailable")?.saturating_add(swap))),
            MACHINE,
        ),
        (
            of_groups(root).map(|bytes| bytes.saturating_add(swap)),
            CONTROL_GROUP,
        ),
        (rest(limits.address_space, "VmSize"), ADDRESS_SPACE),
        (rest(limits.data, "VmData"), DATA_SEGMENT),
    ];
    let known = all
        .into_iter()
        .filter_map(|(bytes, of)| Some(AvailableMemory { bytes: bytes?, of }));
    known.min_by_key(|available| available.bytes)
}

/// The value of a line such as `SwapFree:  1024 kB` (bytes).
fn entry(text: &str, name: &str) -> Option<u64> {
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    let kibibytes = line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?;
    Some(kibibytes.saturating_mul(1024))
}

/// Names of the files of a control group: limit, use, and the line of `memory.stat` that counts
/// what can be dropped from the cache of files.
struct GroupFiles {
    limit: &'static str,
    used: &'static str,
    cache: &'static str,
}

const VERSION_1: GroupFiles = GroupFiles {
    limit: "memory.limit_in_bytes",
    used: "memory.usage_in_bytes",
    cache: "total_inactive_file",
};
const VERSION_2: GroupFiles = GroupFiles {
    limit: "memory.max",
    used: "memory.current",
    cache: "inactive_file",
};

/// The least memory (bytes) that the control groups of this process and those above them still
/// give, without swap space; `None` without a limit.
fn of_groups(root: &Path) -> Option<u64> {
    let lines = fs::read_to_string(root.join("proc/self/cgroup")).ok()?;
    let groups = lines.lines().filter_map(|line| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?);
        let path = Path::new(path.trim_start_matches('/'));
        if controllers.is_empty() {
            Some((root.join("sys/fs/cgroup"), path.to_owned(), &VERSION_2))
        } else {
            let has_memory = controllers.split(',').any(|name| name == "memory");
            has_memory.then(|| {
                (
                    root.join("sys/fs/cgroup/memory"),
                    path.to_owned(),
                    &VERSION_1,
                )
            })
        }
    });
    groups
        .filter_map(|(mount, path, files)| of_group_and_parents(&mount, &path, files))
        .min()
}

/// The least memory of a group and those above it. In a container, the path may be that outside;
/// the group of the container is then the root.
fn of_group_and_parents(mount: &Path, path: &Path, files: &GroupFiles) -> Option<u64> {
    path.ancestors()
        .filter_map(|group| of_group(&mount.join(group), files))
        .min()
}

/// The memory of one group; `None` if it has no limit.
fn of_group(group: &Path, files: &GroupFiles) -> Option<u64> {
    let read = |name: &str| fs::read_to_string(group.join(name)).ok();
    let number = |name: &str| read(name)?.trim().parse::<u64>().ok();
    let limit = number(files.limit)?;
    let stat = read("memory.stat").unwrap_or_default();
    let cache = stat
        .lines()
        .find_map(|line| line.strip_prefix(files.cache)?.trim().parse::<u64>().ok());
    Some(
        limit
            .saturating_sub(number(files.used).unwrap_or(0))
            .saturating_add(cache.unwrap_or(0))
            .min(limit),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEMINFO: &str = "MemTotal:       24000000 kB\nMemFree:         1000000 kB\nMemAvailable:    2000000 kB\n\
                           SwapTotal:        500000 kB\nSwapFree:         400000 kB\n";
    const MACHINE_BYTES: u64 = 2_400_000 * 1024;
    const SWAP: u64 = 400_000 * 1024;

    /// A root with these files.
    fn root(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        for (name, text) in [("proc/meminfo", MEMINFO)].iter().chain(files) {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        root
    }

    fn found(files: &[(&str, &str)], limits: ProcessLimits) -> AvailableMemory {
        least(root(files).path(), limits).unwrap()
    }

    #[test]
    fn the_memory_of_the_machine_is_read() {
        let of = |text: &str| found(&[("proc/meminfo", text)], ProcessLimits::default());
        assert_eq!(
            of(MEMINFO),
            AvailableMemory {
                bytes: MACHINE_BYTES,
                of: MACHINE
            }
        );
        assert_eq!(
            of(&MEMINFO.replace("SwapFree", "Other")).bytes,
            2_000_000 * 1024
        );
        for text in ["MemTotal: 1 kB\n", &MEMINFO.replace("2000000", "many")] {
            let root = root(&[("proc/meminfo", text)]);
            assert_eq!(least(root.path(), ProcessLimits::default()), None);
        }
    }

    #[test]
    fn the_least_limit_of_all_control_groups_counts() {
        let slurm = "0::/system.slice/job_7/step_0\n";
        let files = [
            ("proc/self/cgroup", slurm),
            (
                "sys/fs/cgroup/system.slice/job_7/step_0/memory.max",
                "max\n",
            ),
            (
                "sys/fs/cgroup/system.slice/job_7/memory.max",
                "1000000000\n",
            ),
            (
                "sys/fs/cgroup/system.slice/job_7/memory.current",
                "300000000\n",
            ),
            (
                "sys/fs/cgroup/system.slice/job_7/memory.stat",
                "anon 200000000\ninactive_file 100000000\n",
            ),
            ("sys/fs/cgroup/system.slice/memory.max", "1900000000\n"),
        ];
        let expected = AvailableMemory {
            bytes: 800_000_000 + SWAP,
            of: CONTROL_GROUP,
        };
        assert_eq!(found(&files, ProcessLimits::default()), expected);
        // In a container, the path is that of the machine outside.
        let container = [
            ("proc/self/cgroup", slurm),
            ("sys/fs/cgroup/memory.max", "500000000\n"),
        ];
        assert_eq!(
            found(&container, ProcessLimits::default()).bytes,
            500_000_000 + SWAP
        );
    }

    #[test]
    fn control_groups_of_the_first_version_are_read() {
        let files = |limit: &'static str| {
            [
                (
                    "proc/self/cgroup",
                    "5:cpu,cpuacct:/\n4:memory:/job/7\n0::/\n",
                ),
                ("sys/fs/cgroup/memory/job/7/memory.limit_in_bytes", limit),
                (
                    "sys/fs/cgroup/memory/job/7/memory.usage_in_bytes",
                    "250000000\n",
                ),
                (
                    "sys/fs/cgroup/memory/job/7/memory.stat",
                    "cache 9\ntotal_inactive_file 50000000\n",
                ),
            ]
        };
        let limited = found(&files("1000000000\n"), ProcessLimits::default());
        assert_eq!(
            limited,
            AvailableMemory {
                bytes: 800_000_000 + SWAP,
                of: CONTROL_GROUP
            }
        );
        // What this version writes where there is no limit.
        let free = found(&files("9223372036854771712\n"), ProcessLimits::default());
        assert_eq!(
            free,
            AvailableMemory {
                bytes: MACHINE_BYTES,
                of: MACHINE
            }
        );
    }

    #[test]
    fn limits_of_the_process_count_what_it_has() {
        let files = [(
            "proc/self/status",
            "Name:\tcarom\nVmSize:\t  100000 kB\nVmData:\t   50000 kB\n",
        )];
        let of = |address_space, data| {
            found(
                &files,
                ProcessLimits {
                    address_space,
                    data,
                },
            )
        };
        assert_eq!(
            of(Some(1 << 30), None),
            AvailableMemory {
                bytes: (1 << 30) - 100_000 * 1024,
                of: ADDRESS_SPACE
            }
        );
        assert_eq!(
            of(Some(1 << 30), Some(1 << 29)),
            AvailableMemory {
                bytes: (1 << 29) - 50_000 * 1024,
                of: DATA_SEGMENT
            }
        );
        assert_eq!(of(Some(1000), None).bytes, 0);
        assert_eq!(of(None, None).of, MACHINE);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_machine_says_what_it_has() {
        assert!(available().is_some_and(|available| available.bytes > 0));
    }
}
