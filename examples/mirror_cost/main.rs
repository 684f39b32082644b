//! What a mirror costs: ratios of frame times, measured on this machine.
//!
//! `cargo run --release --example mirror_cost` prints one table and writes `mirror_cost.csv`;
//! `-- --quick` draws smaller pictures and fewer of them, `-- --help` lists the rest.
//!
//! | file | question it answers |
//! |---|---|
//! | `rows.rs` | what is compared with what |
//! | `rooms.rs`, `crowd.rs` | in which scenes |
//! | `systems.rs`, `maths.rs` | how long the plugin's own systems take, and its maths |
//! | `contest.rs` | how long the frames of several apps take, in turn |
//! | `estimate.rs` | what ratio that is, and how sure |
//! | `told.rs` | the table and the CSV |
//!
//! Times are of frames that are not pipelined: an update of the app until the last pixel is drawn.
//! The apps of a row are alive at once and take turns frame by frame, forth and back, so that a
//! machine that slows down slows all alike; halfway they are started anew, in the other order.
//! Nothing moves. The row `control` compares an app with its like: other ratios are no surer than
//! that one is near 1.

use std::process::ExitCode;

#[path = "../../tests/support/alone.rs"]
mod alone;
mod args;
#[path = "../error_vs_time/attempt.rs"]
mod attempt;
#[path = "../teapot/bezier.rs"]
#[expect(dead_code, reason = "the teapot example needs more of it")]
mod bezier;
mod contest;
mod crowd;
mod estimate;
#[path = "../error_vs_time/frames.rs"]
#[expect(dead_code, reason = "error_vs_time needs more of it")]
mod frames;
#[path = "../error_vs_time/lens.rs"]
#[allow(dead_code, reason = "error_vs_time and the tests need more of it")]
mod lens;
#[path = "../error_vs_time/machine.rs"]
mod machine;
mod maths;
#[path = "../error_vs_time/png.rs"]
mod png;
#[path = "../error_vs_time/pyramid.rs"]
mod pyramid;
#[path = "../error_vs_time/quad.rs"]
mod quad;
#[path = "../error_vs_time/techniques/rival.rs"]
mod rival;
mod rooms;
mod rows;
#[path = "../error_vs_time/scenes/mod.rs"]
#[expect(dead_code, reason = "error_vs_time needs more of it")]
mod scenes;
#[path = "../shared/mod.rs"]
#[expect(dead_code, reason = "other examples need more of it")]
mod shared;
#[path = "../error_vs_time/spans.rs"]
#[allow(dead_code, reason = "error_vs_time and the tests need more of it")]
mod spans;
#[path = "../error_vs_time/stats.rs"]
mod stats;
#[path = "../../tests/support/mod.rs"]
#[expect(
    dead_code,
    unused_imports,
    reason = "the picture tests need more of it"
)]
mod support;
mod systems;
mod told;

use indicatif::{ProgressBar, ProgressStyle};

use crate::{
    args::Plan, attempt::attempt, contest::Failure, shared::cli::say, support::stage::Stage,
    told::Told,
};

fn main() -> ExitCode {
    let plan = match args::parse() {
        Ok(plan) => plan,
        Err(code) => return code,
    };
    run(&plan).unwrap_or_else(|reason| {
        say(&reason);
        ExitCode::FAILURE
    })
}

fn run(plan: &Plan) -> Result<ExitCode, String> {
    let about = attempt(|| Ok(machine::about(&mut Stage::stock(), &plan.about())))?;
    println!("{}\n", about.join("\n"));
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} rows: {msg}")
        .expect("the template is well formed");
    let bar = ProgressBar::new(plan.rows.len() as u64).with_style(style);
    let mut told = Told::new(&about);
    let mut interrupted = false;
    for row in &plan.rows {
        bar.set_message(row.name);
        // What panics is a row with the reason, as whatever else fails.
        let outcome = attempt(|| Ok((row.measure)(plan)))
            .unwrap_or_else(|reason| Err(Failure::Reason(reason)));
        if matches!(outcome, Err(Failure::Interrupted)) {
            interrupted = true;
            break;
        }
        told.add(row, &outcome);
        for (name, picture) in outcome.iter().flat_map(|measured| &measured.pictures) {
            let name = format!("{}-{name}.png", row.name).replace([' ', ','], "-");
            png::write(picture, &plan.out.join("pictures").join(name))?;
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    print!("{}", told.table());
    let path = plan.out.join("mirror_cost.csv");
    told.write_csv(&path)
        .map_err(|error| format!("{}: {error}", path.display()))?;
    println!("\n{} holds the times as well.", path.display());
    if interrupted {
        say("interrupted; what was measured by then is kept");
        return Ok(ExitCode::from(130));
    }
    Ok(ExitCode::SUCCESS)
}
