//! The steps of the search on standard error, for who works on it.

/// True if COURIER_DIAGNOSIS_TRACE asks for the search's steps on standard error.
pub fn tracing() -> bool {
    std::env::var_os("COURIER_DIAGNOSIS_TRACE").is_some()
}

/// One step of the search, where that was asked for.
pub fn log(text: &str) {
    if tracing() {
        eprintln!("{text}");
    }
}
