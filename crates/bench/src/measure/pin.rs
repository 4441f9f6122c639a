//! Keeping a thread on one core.

/// As long as it lives, this thread stays on one core. Threads that are started meanwhile would stay there too, so none are.
pub(crate) struct Pinned {
    #[cfg(target_os = "linux")]
    before: Option<libc::cpu_set_t>,
}

#[cfg(target_os = "linux")]
impl Pinned {
    /// To the `number`-th core of those that the thread may use; it begins again when there are fewer. When the system refuses, the thread goes
    /// on unpinned.
    pub(crate) fn to(number: usize) -> Self {
        // SAFETY: a set of processors is plain bits, for which zero is a value: none.
        let mut before: libc::cpu_set_t = unsafe { std::mem::zeroed() };
        let size = size_of::<libc::cpu_set_t>();
        // SAFETY: the place is live and has the size that is given; 0 is the calling thread.
        if unsafe { libc::sched_getaffinity(0, size, &mut before) } != 0 {
            return Self { before: None };
        }
        // SAFETY: every number is below the size of the set.
        let allowed: Vec<usize> =
            (0..libc::CPU_SETSIZE as usize).filter(|&core| unsafe { libc::CPU_ISSET(core, &before) }).collect();
        let Some(&core) = allowed.get(number % allowed.len().max(1)) else { return Self { before: None } };
        // SAFETY: as above.
        let mut one: libc::cpu_set_t = unsafe { std::mem::zeroed() };
        // SAFETY: the number is below the size of the set.
        unsafe { libc::CPU_SET(core, &mut one) };
        // SAFETY: the set is live and has the size that is given.
        let pinned = unsafe { libc::sched_setaffinity(0, size, &one) } == 0;
        Self { before: pinned.then_some(before) }
    }
}

#[cfg(not(target_os = "linux"))]
impl Pinned {
    /// Not on this system.
    pub(crate) fn to(_: usize) -> Self {
        Self {}
    }
}

#[cfg(target_os = "linux")]
impl Drop for Pinned {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            // SAFETY: the set is live and has the size that is given. Should it fail, the thread stays where it is.
            unsafe { libc::sched_setaffinity(0, size_of::<libc::cpu_set_t>(), before) };
        }
    }
}
