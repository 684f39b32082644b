//! Failures that must not end the report: a technique that cannot run is a row with the reason.

use std::{
    panic::{self, AssertUnwindSafe},
    sync::{
        Mutex, MutexGuard, Once, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
};

/// What the last panic said.
static SAID: Mutex<String> = Mutex::new(String::new());
/// How many attempts are under way: only then are panics kept quiet.
static ATTEMPTS: AtomicUsize = AtomicUsize::new(0);

/// Runs `work`; a panic in it, on whatever thread, becomes an error with what it said.
pub fn attempt<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let loud = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if ATTEMPTS.load(Ordering::SeqCst) == 0 {
                loud(info);
            } else {
                let text = info.payload_as_str().unwrap_or("failed without a word");
                text.clone_into(&mut said());
            }
        }));
    });
    ATTEMPTS.fetch_add(1, Ordering::SeqCst);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    ATTEMPTS.fetch_sub(1, Ordering::SeqCst);
    result.unwrap_or_else(|_| Err(said().clone()))
}

fn said() -> MutexGuard<'static, String> {
    SAID.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_words() {
        let failed: Result<(), String> = attempt(|| panic!("no {}", "adapter"));
        assert_eq!(failed, Err("no adapter".to_owned()));
        assert_eq!(attempt(|| Ok(3)), Ok(3));
        assert_eq!(
            attempt(|| Err::<(), _>("plainly".into())),
            Err("plainly".into())
        );
    }
}
