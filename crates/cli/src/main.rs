//! The `pickline` program: parse, run, exit. Everything else is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    pickline_cli::main()
}
