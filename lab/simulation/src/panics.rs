//! Panics of the program in a simulation. Tokio catches those of tasks, so that nobody would see them.

use std::cell::RefCell;
use std::sync::Once;

thread_local! {
    /// The panics in this thread, while they are watched.
    static SEEN: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Runs `work`; returns its result, and the panics in this thread meanwhile, which are not printed.
pub fn watched<T>(work: impl FnOnce() -> T) -> (T, Vec<String>) {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let is_watched =
                SEEN.with_borrow_mut(|seen| seen.as_mut().map(|seen| seen.push(panic.to_string())).is_some());
            if !is_watched {
                usual(panic);
            }
        }));
    });
    SEEN.set(Some(Vec::new()));
    let done = work();
    (done, SEEN.take().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_a_task_is_seen() {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let work = || runtime.block_on(async { vibrissa_host::task::spawn(async { panic!("a task") }).await }).is_err();
        let (failed, panics) = watched(work);
        assert!(failed && panics.len() == 1 && panics[0].contains("a task"), "{panics:?}");
        assert!(watched(|| ()).1.is_empty());
    }
}
