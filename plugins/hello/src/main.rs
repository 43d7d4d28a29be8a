//! `hello` as a program of its own; `regatta plugin hello` is the same.

fn main() -> regatta_plugin::Result {
    regatta_plugin::run(regatta_hello::Centre)
}
