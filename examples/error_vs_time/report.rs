//! Draws every scene with every technique, times them in turn, and compares their pictures.

use bevy::prelude::*;
use indicatif::{ProgressBar, ProgressStyle};

use crate::{
    args::Plan,
    attempt::attempt,
    coded::Coder,
    edge, errors,
    frames::{self, FrameTimes},
    memory::Memory,
    png,
    row::{Measured, Row},
    scenes::Case,
    sheet,
    spans::{Reader, Spans},
    stats::Summary,
    support::{picture::Picture, scene::Scene, stage::Stage},
    techniques::{self, Kind, Setting, Technique},
    truth::{Painter, Truth},
};

/// Pictures of the sheet are magnified up to this many pixels.
const SHEET_PX: u32 = 1600;

/// The apps of all techniques, which stay up from scene to scene.
pub struct Report<'a> {
    plan: &'a Plan,
    players: Vec<Player>,
    painter: Painter,
    bar: ProgressBar,
    interrupted: bool,
}

/// One technique with its app, and what it has measured in the scene at hand.
struct Player {
    technique: Technique,
    stage: Option<Stage>,
    outcome: Result<Found, String>,
}

/// Of one technique in one scene.
#[derive(Default)]
struct Found {
    frames: Vec<FrameTimes>,
    spans: Vec<Spans>,
    memory: Option<u64>,
    errors: Option<errors::Errors>,
    things: Option<errors::Things>,
    cut: Option<edge::Found>,
}

impl<'a> Report<'a> {
    pub fn new(plan: &'a Plan) -> Self {
        let techniques = techniques::all();
        let steps = plan.cases.len() * (techniques.len() * 2 + plan.frames as usize + 1);
        let style = ProgressStyle::with_template("{bar:40} {percent:>3} %, {eta} to go: {msg}")
            .expect("the template is well formed");
        Self {
            plan,
            players: techniques
                .into_iter()
                .map(|technique| Player {
                    technique,
                    stage: None,
                    outcome: Err(String::new()),
                })
                .collect(),
            painter: Painter::new(),
            bar: ProgressBar::new(steps as u64).with_style(style),
            interrupted: false,
        }
    }

    /// Whether the user has asked to stop. What is measured by then is good.
    pub fn interrupted(&self) -> bool {
        self.interrupted
    }

    /// An app without a mirror, for whoever wants to ask it about the machine.
    pub fn plain_stage(&mut self) -> Result<&mut Stage, String> {
        let player = &mut self.players[0];
        if player.stage.is_none() {
            player.stage = Some(attempt(|| player.technique.start())?);
        }
        player.stage.as_mut().ok_or_else(String::new)
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// The rows of one scene; of an interrupted one, what there is of it.
    pub fn scene(&mut self, case: &Case) -> Result<Vec<Row>, String> {
        self.bar.set_message(format!("{}: reference", case.name));
        let truth = attempt(|| Ok(self.painter.truth(case)))?;
        self.bar.inc(1);
        for index in 0..self.players.len() {
            self.step(case, index, "first frames", |player, plan| {
                player.set_up(case, &truth, plan)
            });
        }
        self.time(case);
        let coded = Coder::new(&case.scene).scene(&case.scene);
        let longest = case.scene.size.max_element();
        let magnification = (SHEET_PX / longest).clamp(1, 4);
        let sheet = sheet::sheet(&case.scene, case.exact(), magnification);
        for index in 0..self.players.len() {
            self.step(case, index, "things and edges", |player, plan| {
                player.inspect(case, &truth, &coded, sheet.as_ref(), plan)
            });
        }
        Ok(self.rows(case, &truth))
    }

    /// One step of one technique; if it fails, so has the technique in this scene.
    fn step(
        &mut self,
        case: &Case,
        index: usize,
        what: &str,
        work: impl FnOnce(&mut Player, &Plan) -> Result<(), String>,
    ) {
        let player = &mut self.players[index];
        self.bar.inc(1);
        if self.interrupted {
            return;
        }
        let kind = player.technique.kind;
        self.bar
            .set_message(format!("{}: {what}, {kind}", case.name));
        if let Err(reason) = attempt(|| work(player, self.plan)) {
            player.fail(reason);
        }
        self.interrupted |= player.exits();
    }

    /// Frame by frame in turn, so that a machine that slows down slows all alike.
    fn time(&mut self, case: &Case) {
        self.bar.set_message(format!("{}: timing", case.name));
        let mut readers: Vec<Reader> = self.players.iter().map(|_| Reader::default()).collect();
        for _ in 0..self.plan.frames {
            self.bar.inc(1);
            for (player, reader) in self.players.iter_mut().zip(&mut readers) {
                if self.interrupted {
                    return;
                }
                if let Err(reason) = attempt(|| player.time_frame(reader)) {
                    player.fail(reason);
                }
                self.interrupted |= player.exits();
            }
        }
    }

    fn rows(&self, case: &Case, truth: &Truth) -> Vec<Row> {
        let of = |kind, samples| -> Option<&Found> {
            let player = self
                .players
                .iter()
                .find(|it| it.technique.is(kind, samples))?;
            player.outcome.as_ref().ok()
        };
        self.players
            .iter()
            .filter(|player| player.technique.is_row())
            // An interrupted run has techniques it did not come to: they have no reason either.
            .filter(|player| !matches!(&player.outcome, Err(reason) if reason.is_empty()))
            .map(|player| {
                let samples = player.technique.samples;
                let against = Against {
                    none: of(Kind::NoMirror, samples),
                    bound: of(Kind::Bound, samples),
                    idle: of(Kind::BoundIdle, samples),
                };
                Row {
                    scene: case.name.clone(),
                    technique: player.technique,
                    share: truth.share(),
                    outcome: match &player.outcome {
                        Ok(found) => Ok(found.measured(player.technique, &against)),
                        Err(reason) => Err(reason.clone()),
                    },
                }
            })
            .collect()
    }
}

impl Player {
    fn fail(&mut self, reason: String) {
        self.outcome = Err(reason);
        // Whatever state its app is in, the next scene shall not inherit it.
        self.stage = None;
    }

    fn exits(&mut self) -> bool {
        let stage = self.stage.as_mut();
        stage.is_some_and(|stage| stage.app().should_exit().is_some())
    }

    /// Draws the scene as it is, and compares.
    fn set_up(&mut self, case: &Case, truth: &Truth, plan: &Plan) -> Result<(), String> {
        self.outcome = Ok(Found::default());
        if self.stage.is_none() {
            self.stage = Some(self.technique.start()?);
        }
        let picture = self.draw(case, &case.scene, truth.bounds)?;
        self.save(plan, case, "scene", &picture)?;
        let (Some(stage), Ok(found)) = (&mut self.stage, &mut self.outcome) else {
            return Ok(());
        };
        found.errors = errors::errors(&picture, truth);
        found.memory = Memory::of(stage).map(|memory| memory.bytes);
        Ok(())
    }

    fn time_frame(&mut self, reader: &mut Reader) -> Result<(), String> {
        let (Some(stage), Ok(found)) = (&mut self.stage, &mut self.outcome) else {
            return Ok(());
        };
        found.frames.push(frames::timed(stage)?);
        found.spans.extend(reader.read(stage.world().resource()));
        Ok(())
    }

    /// Draws the scene in code, and the sheet.
    fn inspect(
        &mut self,
        case: &Case,
        truth: &Truth,
        coded: &Scene,
        sheet: Option<&(Scene, sheet::Cut)>,
        plan: &Plan,
    ) -> Result<(), String> {
        if self.outcome.is_err() || !self.technique.is_row() {
            return Ok(());
        }
        let picture = self.draw(case, coded, truth.bounds)?;
        self.save(plan, case, "code", &picture)?;
        let things = errors::things(&picture, truth);
        let mut cut = None;
        // Only cameras behind the mirror see the sheet, and this technique has none.
        let sheet = sheet.filter(|_| self.technique.kind != Kind::ScreenSpace);
        if let Some((scene, expected)) = sheet {
            let magnification = expected.magnification as u32;
            let (low, high) = truth.bounds;
            let picture = self.draw(case, scene, (low * magnification, high * magnification))?;
            self.save(plan, case, "sheet", &picture)?;
            cut = edge::locate(&picture, expected);
        }
        if let Ok(found) = &mut self.outcome {
            found.things = Some(things);
            found.cut = cut;
        }
        Ok(())
    }

    fn draw(
        &mut self,
        case: &Case,
        scene: &Scene,
        bounds: (UVec2, UVec2),
    ) -> Result<Picture, String> {
        let stage = self.stage.as_mut().ok_or("has no app")?;
        let setting = Setting {
            scene,
            camera_scale: case.camera_scale,
            bounds,
        };
        let target = self.technique.set_up(stage, &setting)?;
        frames::settle(stage)?;
        let picture = stage
            .read(&target, scene.size)
            .map_err(|reason| reason.to_string())?;
        Ok(if self.technique.is_flipped() {
            picture.flipped()
        } else {
            picture
        })
    }

    fn save(&self, plan: &Plan, case: &Case, what: &str, picture: &Picture) -> Result<(), String> {
        if !plan.pictures {
            return Ok(());
        }
        let kind = self
            .technique
            .kind
            .to_string()
            .replace([',', ' ', '/'], "-");
        let name = format!(
            "{}-{kind}-{}x-{what}.png",
            case.name, self.technique.samples
        );
        png::write(picture, &plan.out.join("pictures").join(name))
    }
}

/// What a technique is measured by: other techniques with as many samples.
struct Against<'a> {
    none: Option<&'a Found>,
    bound: Option<&'a Found>,
    idle: Option<&'a Found>,
}

impl Against<'_> {
    /// What the bound takes beyond its own app, by one clock.
    fn bound_alone(&self, clock: impl Fn(&Found) -> Option<f64>) -> Option<f64> {
        Some((clock(self.bound?)? - clock(self.idle?)?).max(0.0))
    }

    /// The least that a frame with a mirror takes, by one clock.
    fn least(&self, clock: impl Fn(&Found) -> Option<f64>) -> Option<f64> {
        Some(clock(self.none?)? + self.bound_alone(&clock)?)
    }
}

impl Found {
    fn clock(&self, time: impl Fn(&FrameTimes) -> Option<f64>) -> Option<Summary> {
        Summary::of(&self.frames.iter().filter_map(time).collect::<Vec<_>>())
    }

    fn span_clock(&self, time: impl Fn(&Spans) -> Option<f64>) -> Option<Summary> {
        Summary::of(&self.spans.iter().filter_map(time).collect::<Vec<_>>())
    }

    fn frame(&self) -> Option<Summary> {
        self.clock(|times| Some(times.whole))
    }

    fn gpu(&self) -> Option<Summary> {
        self.span_clock(Spans::gpu)
    }

    fn measured(&self, technique: Technique, against: &Against) -> Measured {
        let whole = |found: &Found| found.frame().map(|frame| frame.median);
        let gpu = |found: &Found| found.gpu().map(|gpu| gpu.median);
        let is_bound = technique.kind == Kind::Bound;
        // Of the bound, the frame is the one with nothing but the bound in it.
        let with_median = |summary: Option<Summary>, median: Option<f64>| {
            let (summary, median) = (summary?, median?);
            Some(Summary { median, ..summary })
        };
        let (frame, all_passes) = if is_bound {
            (
                with_median(self.frame(), against.least(whole)),
                with_median(self.gpu(), against.least(gpu)),
            )
        } else {
            (self.frame(), self.gpu())
        };
        let ratio = |to: Option<f64>| Some(frame?.median / to?);
        let none_gpu = against.none.and_then(gpu);
        let of_none = against.none.and_then(|none| none.memory);
        let pass = |clock: fn(&crate::spans::Span) -> Option<f64>| {
            let name = technique.pass()?;
            self.span_clock(|spans| clock(&spans.get(name)?))
        };
        Measured {
            frame,
            gpu: all_passes,
            gpu_mirror: match technique.kind {
                Kind::NoMirror => None,
                Kind::Bound => against.bound_alone(gpu),
                Kind::Ours(_) | Kind::ScreenSpace => pass(|span| span.gpu).map(|it| it.median),
                _ => all_passes
                    .zip(none_gpu)
                    .map(|(all, none)| all.median - none),
            },
            cpu_main: self.clock(|times| Some(times.main)),
            cpu_extract: self.clock(|times| Some(times.extract)),
            cpu_render: self.clock(|times| Some(times.render)),
            cpu_plugin: self.clock(|times| times.plugin),
            cpu_pass: pass(|span| Some(span.cpu)),
            to_none: ratio(against.none.and_then(whole)),
            to_bound: ratio(against.least(whole)),
            memory: self
                .memory
                .zip(of_none)
                .filter(|_| !is_bound)
                .map(|(own, none)| own as i64 - none as i64),
            errors: self.errors,
            things: self.things,
            cut: self.cut,
        }
    }
}
