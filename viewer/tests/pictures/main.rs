//! Tests of pictures against references, and of picking against known poses. They need a software
//! adapter; without one, each of them is listed as ignored.
//!
//! The references were rendered by Mesa's llvmpipe. After an intended visual change, update them,
//! and check each of them by eye: `REGATTA_UPDATE_PICTURES=1 cargo test -p regatta-viewer --test
//! pictures`.

mod fleet;
mod jams;
mod levels;
mod live;
mod memory;
mod motion;
mod order;
mod picking;
mod references;

use libtest_mimic::{Arguments, Trial};
use regatta_gpu::device::Gpu;

/// A test that renders.
type Test = fn(&Gpu);

fn main() -> std::process::ExitCode {
    let arguments = Arguments::from_args();
    let gpu = Gpu::software().ok();
    let tests = references::TESTS
        .iter()
        .chain(jams::TESTS)
        .chain(picking::TESTS)
        .chain(motion::TESTS)
        .chain(order::TESTS)
        .chain(levels::TESTS)
        .chain(live::TESTS)
        .chain(memory::TESTS);
    let mut trials: Vec<_> = tests
        .map(|(name, test)| {
            let device = gpu.clone();
            let run = move || {
                device.iter().for_each(test);
                Ok(())
            };
            Trial::test(*name, run)
                .with_ignored_flag(gpu.is_none())
                .with_kind("needs a software adapter")
        })
        .collect();
    trials.push(Trial::test("references_are_told_apart", || {
        references::references_are_told_apart();
        Ok(())
    }));
    libtest_mimic::run(&arguments, trials).exit_code()
}
