//! What each way of drawing a mirror costs, and how wrong it is: error against run time.
//!
//! `cargo run --release --example error_vs_time` draws every scene of the report with every
//! technique on this machine, and writes a table, `error_vs_time.csv` and a chart (SVG and PNG).
//! `-- --quick` does a few scenes in small pictures, `-- --help` lists the rest.
//!
//! | file | question it answers |
//! |---|---|
//! | `scenes/` | what is drawn |
//! | `techniques/` | how: the plugin, its rivals, the least that it could cost |
//! | `truth.rs` | what a mirror must show |
//! | `pyramid.rs` | what of an object is seen in it at all |
//! | `errors.rs`, `flip.rs` | how far a picture is from that |
//! | `coded.rs` | which pixels show a thing that they must not |
//! | `sheet.rs`, `edge.rs` | where things are cut, to a fraction of a pixel |
//! | `frames.rs`, `spans.rs`, `memory.rs`, `stats.rs` | what a frame costs |
//! | `report.rs` | all of it, technique by technique in turn |
//! | `table.rs`, `verdict.rs`, `csv.rs`, `chart/` | how it is told |
//! | `leave_out.rs` | what does not exist where a scene does not need it |
//!
//! Times are of frames that are not pipelined: an update of the app until the last pixel is drawn.
//! Every technique has an app of its own, and they take turns frame by frame. The error is taken
//! over the pixels of the mirror less one at its edge. A technique with one sample a pixel is as
//! wrong as its jagged edges are, whatever draws the mirror: compare it with the physical bound,
//! which has the same.

use std::process::ExitCode;

mod args;
mod attempt;
#[path = "../teapot/bezier.rs"]
#[expect(dead_code, reason = "the teapot example needs more of it")]
mod bezier;
mod chart;
mod coded;
mod color;
mod csv;
mod edge;
mod errors;
mod flip;
mod frames;
mod frontier;
mod leave_out;
mod lens;
mod machine;
mod memory;
mod png;
mod pyramid;
mod quad;
mod report;
mod row;
mod scenes;
#[path = "../shared/mod.rs"]
#[expect(dead_code, reason = "other examples need more of it")]
mod shared;
mod sheet;
mod spans;
mod stats;
#[path = "../../tests/support/mod.rs"]
#[expect(
    dead_code,
    unused_imports,
    reason = "the picture tests need more of it"
)]
mod support;
mod table;
mod techniques;
mod truth;
mod verdict;

use crate::{args::Plan, attempt::attempt, report::Report, shared::cli::say};

fn main() -> ExitCode {
    let plan = match args::parse() {
        Ok(plan) => plan,
        Err(code) => return code,
    };
    match attempt(|| run(&plan)) {
        Ok(code) => code,
        Err(reason) => {
            say(&reason);
            ExitCode::FAILURE
        }
    }
}

fn run(plan: &Plan) -> Result<ExitCode, String> {
    let told = |error: std::io::Error| format!("{}: {error}", plan.out.display());
    std::fs::create_dir_all(&plan.out).map_err(told)?;
    let mut report = Report::new(plan);
    let about = machine::about(report.plain_stage()?, &plan.about());
    println!("{}\n", about.join("\n"));
    let file = plan.out.join("error_vs_time.csv");
    let mut csv = csv::Csv::create(&file, &about).map_err(told)?;

    let mut rows = Vec::new();
    for case in &plan.cases {
        let of_scene = report.scene(case)?;
        csv.write(&of_scene).map_err(told)?;
        rows.extend(of_scene);
        if report.interrupted() {
            break;
        }
    }
    report.finish();
    for of_scene in rows.chunk_by(|a, b| a.scene == b.scene) {
        let case = plan
            .cases
            .iter()
            .find(|case| case.name == of_scene[0].scene);
        let about = case.map_or("", |case| &case.about);
        let share = of_scene[0].share * 100.0;
        println!(
            "{}: {about} ({share:.0} % of the picture)",
            of_scene[0].scene
        );
        println!("{}", table::scene(of_scene));
    }
    println!("ours, automatic, against the second camera 1/1:");
    println!("{}", verdict::verdict(&rows));
    chart::write(&rows, &about, &plan.out)?;
    println!(
        "{0}/error_vs_time.csv, {0}/error_vs_time.svg and {0}/error_vs_time.png hold the rest.",
        plan.out.display()
    );
    if report.interrupted() {
        eprintln!("error_vs_time: interrupted; what was measured by then is kept");
        return Ok(ExitCode::from(130));
    }
    drop(report);
    println!("\nWhat does not exist where a scene does not need it:");
    println!("{}", leave_out::table(&plan.out)?);
    Ok(ExitCode::SUCCESS)
}
