//! What the command lines of the examples share.

use std::{ops::RangeInclusive, process::ExitCode, str::FromStr};

use argh::FromArgs;

/// Reads the command line. `Err` has said on the terminal what there was to say.
pub fn parse<T: FromArgs>() -> Result<T, ExitCode> {
    let given: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|arg| arg.to_string_lossy().into_owned())
        .collect();
    let given: Vec<&str> = given.iter().map(String::as_str).collect();
    T::from_args(&[env!("CARGO_CRATE_NAME")], &given).map_err(|exit| match exit.status {
        Ok(()) => {
            println!("{}", exit.output.trim_end());
            ExitCode::SUCCESS
        }
        Err(()) => complain(&exit.output),
    })
}

/// One line on the terminal, and the exit code for arguments that make no sense.
pub fn complain(text: &str) -> ExitCode {
    say(&format!("{text} (--help lists all)"));
    ExitCode::from(2)
}

/// Says what came of it, and gives the exit code.
pub fn tell(outcome: Result<String, (String, u8)>) -> ExitCode {
    match outcome {
        Ok(line) => {
            println!("{line}");
            ExitCode::SUCCESS
        }
        Err((line, code)) => {
            say(&line);
            ExitCode::from(code)
        }
    }
}

/// One line of what went wrong.
pub fn say(text: &str) {
    let line: Vec<&str> = text.split_whitespace().collect();
    eprintln!("{}: {}", env!("CARGO_CRATE_NAME"), line.join(" "));
}

/// A value of a range.
pub fn within<T: FromStr + PartialOrd>(
    text: &str,
    range: RangeInclusive<T>,
    expected: &str,
) -> Result<T, String> {
    let value: Option<T> = text.parse().ok();
    value
        .filter(|value| range.contains(value))
        .ok_or_else(|| format!("expected {expected}"))
}
