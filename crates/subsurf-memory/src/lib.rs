//! Large arrays in huge pages, where the system has them.
//!
//! Memory that a program has just been given costs a page fault for every 4 KiB that it touches first: on common Linux
//! machines four times what it costs to fill those bytes. Pages of 2 MiB make that cost small, and spare the
//! processor most of its look-ups of addresses afterwards. Many systems hand them out only where a program says
//! that it wants them (`/sys/kernel/mm/transparent_hugepage/enabled` reads `madvise`).
//!
//! That is all this crate does: it says so about the memory of a [`Vec`], or about memory for several ([`reserve`],
//! [`reserve_whole_pages`]). Contents never change, and no more memory is used than what the allocator has asked the system
//! for. On other systems, where huge pages are switched off, or for arrays of less than 2 MiB nothing happens.
//!
//! ```
//! let mut squares = subsurf_memory::with_capacity(1 << 20);
//! squares.extend((0..1u64 << 20).map(|i| i * i));
//! assert_eq!(squares[1000], 1_000_000);
//! ```

/// Bytes of a huge page. Systems with larger ones ignore the hint or round it to theirs.
const HUGE_PAGE: usize = 2 << 20;

/// An empty vector with room for exactly `capacity` values, in huge pages where the system has them.
///
/// # Panics
///
/// Where [`Vec::with_capacity`] does: if the size in bytes does not fit `isize`.
#[must_use]
pub fn with_capacity<T>(capacity: usize) -> Vec<T> {
    let mut values = Vec::with_capacity(capacity);
    advise(&mut values);
    values
}

/// `len` copies of the value whose bytes are all zero, in huge pages where the system has them: memory that comes
/// zeroed is not written here.
#[must_use]
pub fn zeroed<T: Zero>(len: usize) -> Vec<T> {
    let mut values = vec![T::ZERO; len];
    advise(&mut values);
    values
}

/// Asks for huge pages behind all the memory of `values`, used or not. Worth it before that memory is first touched;
/// pages that have been touched stay as they are.
pub fn advise<T>(values: &mut Vec<T>) {
    let bytes = values.capacity() * size_of::<T>();
    if bytes >= HUGE_PAGE {
        system::advise(values.as_mut_ptr().cast(), bytes);
    }
}

/// Asks for huge pages behind `bytes` bytes that are about to be handed out as several arrays, by asking for them as one and
/// giving that back. An allocator that keeps it and cuts the arrays from it, as glibc's does up to some tens of megabytes once
/// it has seen arrays of that size, thereby hands out huge pages; elsewhere nothing is gained.
///
/// Arrays of a megabyte cannot be advised one by one: a huge page that several share has been touched, by the allocator's own
/// numbers between them, before the last one is known.
pub fn reserve(bytes: usize) {
    let mut all = Vec::<u8>::new();
    let keeps = cfg!(all(target_os = "linux", target_env = "gnu"));
    // To the end of the last page, wherever the first one begins.
    if keeps && bytes >= HUGE_PAGE && all.try_reserve_exact(bytes.saturating_add(HUGE_PAGE)).is_ok() {
        advise(&mut all);
    }
}

/// As [`reserve`], from the first huge page on: what lies before it would come in ordinary pages. That is handed out here, unused,
/// and to be dropped when the arrays are there.
#[must_use]
pub fn reserve_whole_pages(bytes: usize) -> Vec<u8> {
    let mut all = Vec::<u8>::new();
    let keeps = cfg!(all(target_os = "linux", target_env = "gnu"));
    if !keeps || bytes < HUGE_PAGE || all.try_reserve_exact(bytes.saturating_add(2 * HUGE_PAGE)).is_err() {
        return Vec::new();
    }
    advise(&mut all);
    let start = all.as_ptr().addr();
    drop(all);
    Vec::with_capacity(start.next_multiple_of(HUGE_PAGE) - start)
}

/// A number whose zero is all bits zero, so that a vector of it can come from memory that the system has cleared.
pub trait Zero: Copy {
    /// Zero.
    const ZERO: Self;
}

macro_rules! zero {
    ($($number:ty)*) => { $(impl Zero for $number { const ZERO: Self = 0 as $number; })* };
}

zero!(u8 u16 u32 u64 usize i8 i16 i32 i64 isize f32 f64);

/// The pages of `page` bytes, a power of two, that `bytes` bytes from address `start` touch: bytes before `start`, and all bytes.
#[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "only systems with the hint need it"))]
fn pages_touched(start: usize, bytes: usize, page: usize) -> (usize, usize) {
    let before = start & (page - 1);
    (before, (before + bytes).next_multiple_of(page))
}

#[cfg(target_os = "linux")]
mod system {
    /// Advises the system to use huge pages for the pages that `bytes` bytes from `start` touch. What lies beside the array in
    /// its first and last page, the allocator's own numbers mostly, comes along: an array then begins in the huge page
    /// that its mapping begins with.
    #[expect(unsafe_code, reason = "calls of the system")]
    pub fn advise(start: *mut u8, bytes: usize) {
        // SAFETY: asks for a constant of the system.
        let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
        let Some(page) = usize::try_from(page).ok().filter(|page| page.is_power_of_two()) else { return };
        let (before, bytes) = super::pages_touched(start.addr(), bytes, page);
        // SAFETY: MADV_HUGEPAGE reads and writes no memory of ours and changes no contents or access rights, whatever the
        // addresses are. What it returns does not matter: a kernel without huge pages refuses, and nothing is lost.
        unsafe {
            libc::madvise(start.wrapping_sub(before).cast(), bytes, libc::MADV_HUGEPAGE);
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    pub fn advise(_start: *mut u8, _bytes: usize) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_cover_the_array_and_nothing_else() {
        for (start, bytes) in [(0, 4096), (16, 4096), (16, 4080), (4095, 1), (8192, 1), (12_289, 99_999)] {
            let (before, all) = pages_touched(start, bytes, 4096);
            let (from, to) = (start - before, start - before + all);
            assert!(from % 4096 == 0 && to % 4096 == 0);
            assert!(from <= start && start < from + 4096);
            assert!(start + bytes <= to && to < start + bytes + 4096);
        }
    }

    #[test]
    fn more_than_there_is_can_be_asked_for() {
        reserve(usize::MAX);
        reserve(isize::MAX as usize);
        reserve(64 << 20);
        assert_eq!(reserve_whole_pages(usize::MAX).capacity(), 0);
        assert!(reserve_whole_pages(64 << 20).capacity() < HUGE_PAGE);
    }

    #[test]
    fn contents_stay() {
        let mut numbers: Vec<u32> = (0..3 << 20).collect();
        advise(&mut numbers);
        assert!(numbers.iter().zip(0..).all(|(&a, b)| a == b));
        assert!(zeroed::<f64>(1 << 20).iter().all(|&x| x == 0.0));
        assert_eq!(with_capacity::<u16>(0).len(), 0);
    }

    /// What `/proc/self/smaps` says of the mapping round `address`: kB in huge pages.
    #[cfg(target_os = "linux")]
    fn kb_in_huge_pages(address: usize) -> Option<usize> {
        let maps = std::fs::read_to_string("/proc/self/smaps").ok()?;
        let mut inside = false;
        for line in maps.lines() {
            let first = line.split_whitespace().next()?;
            if let Some((from, to)) = first.split_once('-') {
                let bounds = (usize::from_str_radix(from, 16), usize::from_str_radix(to, 16));
                inside = matches!(bounds, (Ok(from), Ok(to)) if (from..to).contains(&address));
            } else if inside && first == "AnonHugePages:" {
                return line.split_whitespace().nth(1)?.parse().ok();
            }
        }
        None
    }

    #[cfg(target_os = "linux")]
    #[test]
    #[ignore = "needs a system that grants huge pages on request, and has some free"]
    fn large_arrays_lie_in_huge_pages() {
        let mut large = with_capacity::<u8>(64 << 20);
        large.resize(64 << 20, 1);
        let address = large.as_ptr().addr() + (32 << 20);
        assert!(kb_in_huge_pages(address) > Some(48 << 10));
    }
}
