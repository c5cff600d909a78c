//! Work for a thread pool, which stays with the caller where the pool has no more than one thread: to hand it over takes as long as to
//! refine a small mesh, and what the caller has in its caches is far from there.

use rayon::prelude::*;

/// True where a pool's only thread would do what the caller can.
pub(crate) fn is_alone() -> bool {
    rayon::current_num_threads() == 1
}

/// Does `work` on all items; each thread has what `init` makes.
pub(crate) fn for_each_init<I: Send, M>(
    items: Vec<I>,
    init: impl Fn() -> M + Sync + Send,
    work: impl Fn(&mut M, I) + Sync + Send,
) {
    if items.len() <= 1 || is_alone() {
        let mut memory = init();
        return items.into_iter().for_each(|item| work(&mut memory, item));
    }
    items.into_par_iter().for_each_init(init, work);
}

/// The same without anything made for each thread.
pub(crate) fn for_each<I: Send>(items: Vec<I>, work: impl Fn(I) + Sync + Send) {
    for_each_init(items, || (), |(), item| work(item));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thread_and_several_do_all_that_there_is() {
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut squares: Vec<u64> = (0..100).collect();
            pool.install(|| {
                assert_eq!(is_alone(), threads == 1);
                for_each_init(squares.iter_mut().collect(), || 2, |power, x: &mut u64| *x = x.pow(*power));
            });
            assert!(squares.iter().zip(0..).all(|(&square, x)| square == x * x));
        }
    }
}
