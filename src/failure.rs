//! Errors for the user.

/// An error for the user: one line with the problem and its solution. `-v` also prints its
/// sources.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Converts an error of `regatta_plugin`, which doesn't implement [`std::error::Error`]; its
/// message is already one line.
pub fn plugin_failure(error: regatta_plugin::Error) -> Failure {
    error.to_string().into()
}

/// Prints an error in one line, followed by its sources if `verbose`.
pub fn print_failure(failure: &(dyn std::error::Error + 'static), verbose: bool) {
    regatta_plugin::tell!("regatta: {failure}");
    let causes = std::iter::successors(failure.source(), |cause| cause.source());
    for cause in causes.take_while(|_| verbose) {
        regatta_plugin::tell!("  because: {cause}");
    }
}
