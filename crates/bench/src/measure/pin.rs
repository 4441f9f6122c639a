//! Pins threads to one core.

/// Keeps threads on one core while it lives.
pub(crate) struct Pinned {
    #[cfg(target_os = "linux")]
    before: Option<libc::cpu_set_t>,
    #[cfg(target_os = "linux")]
    threads: Threads,
}

#[derive(Clone, Copy)]
#[cfg_attr(not(target_os = "linux"), allow(dead_code))]
enum Threads {
    Caller,
    All,
}

impl Pinned {
    /// Pins the calling thread to the `number`-th core that it may use, modulo their number. If the
    /// system refuses, the thread goes on unpinned. Threads that it starts meanwhile are pinned as
    /// well, so none should be started.
    pub(crate) fn to(number: usize) -> Self {
        Self::pin(Threads::Caller, number)
    }

    /// Pins all threads of the process, and those that are started meanwhile: a thread that spins
    /// while it waits would otherwise slow down the working one where two cores share hardware.
    pub(crate) fn all_to(number: usize) -> Self {
        Self::pin(Threads::All, number)
    }

    #[cfg(target_os = "linux")]
    fn pin(threads: Threads, number: usize) -> Self {
        // SAFETY: a set of processors is plain bits; all zeros is the empty set.
        let mut before: libc::cpu_set_t = unsafe { std::mem::zeroed() };
        // SAFETY: the variable is live and has the size that is passed; 0 is the calling thread.
        if unsafe { libc::sched_getaffinity(0, size_of::<libc::cpu_set_t>(), &mut before) } != 0 {
            return Self { before: None, threads };
        }
        // SAFETY: every number is below the size of the set.
        let allowed: Vec<usize> =
            (0..libc::CPU_SETSIZE as usize).filter(|&core| unsafe { libc::CPU_ISSET(core, &before) }).collect();
        let Some(&core) = allowed.get(number % allowed.len().max(1)) else { return Self { before: None, threads } };
        // SAFETY: as above.
        let mut one: libc::cpu_set_t = unsafe { std::mem::zeroed() };
        // SAFETY: the number is below the size of the set.
        unsafe { libc::CPU_SET(core, &mut one) };
        threads.keep_to(&one);
        Self { before: Some(before), threads }
    }

    #[cfg(not(target_os = "linux"))]
    fn pin(_: Threads, _: usize) -> Self {
        Self {}
    }
}

#[cfg(target_os = "linux")]
impl Threads {
    /// A thread that the system refuses to move stays where it is.
    fn keep_to(self, cores: &libc::cpu_set_t) {
        let caller = 0;
        let all = match self {
            Self::Caller => vec![caller],
            Self::All => std::fs::read_dir("/proc/self/task").map_or(vec![caller], |tasks| {
                tasks.flatten().filter_map(|task| task.file_name().to_str()?.parse().ok()).collect()
            }),
        };
        for thread in all {
            // SAFETY: the set is live and has the size that is passed.
            unsafe { libc::sched_setaffinity(thread, size_of::<libc::cpu_set_t>(), cores) };
        }
    }
}

#[cfg(target_os = "linux")]
impl Drop for Pinned {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            self.threads.keep_to(before);
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    fn cores_of_a_new_thread() -> usize {
        std::thread::spawn(|| std::thread::available_parallelism().map_or(1, |cores| cores.get())).join().unwrap()
    }

    #[test]
    fn threads_that_are_started_meanwhile_stay_there_too_and_are_free_afterwards() {
        let before = cores_of_a_new_thread();
        let pinned = Pinned::to(0);
        assert_eq!(cores_of_a_new_thread(), 1);
        drop(pinned);
        assert_eq!(cores_of_a_new_thread(), before);
    }
}
