//! The scene into files, without a window: the app is stepped by hand, one update a picture.

use std::{collections::BTreeMap, path::PathBuf, process::ExitCode};

use bevy::{
    asset::RenderAssetUsages,
    camera::RenderTarget,
    log::{Level, LogPlugin},
    prelude::*,
    render::{
        RenderPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::{Extent3d, PollType, TextureDimension, TextureFormat, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    window::ExitCondition,
    winit::WinitPlugin,
};
use indicatif::{ProgressBar, ProgressStyle};

use crate::{
    args::{Args, Pictures},
    picture,
    scene::SceneTime,
    settings,
};

/// Updates before the first picture: meshes, textures and pipelines are made in the first few.
const WARM_UP: u32 = 4;
/// Updates to wait for a picture to come back from the device.
const PATIENCE: u32 = 100;

/// Pictures that have come back from the device, by number.
#[derive(Resource, Default)]
struct Captured(BTreeMap<u32, Image>);

pub fn run(args: &Args) -> ExitCode {
    match draw(args) {
        Ok(line) => {
            println!("{line}");
            ExitCode::SUCCESS
        }
        Err((line, code)) => {
            eprintln!("teapot: {line}");
            ExitCode::from(code)
        }
    }
}

/// The line that says where the pictures are; or what went wrong, and the exit code.
fn draw(args: &Args) -> Result<String, (String, u8)> {
    let mut studio = Studio::new(args);
    let offered = settings::supported_samples(studio.app.world().resource::<RenderAdapter>());
    let samples = args.settings().samples;
    if !offered.contains(&samples) {
        return Err((
            format!("--msaa: this device has {offered:?}, not {samples}"),
            2,
        ));
    }
    match args.pictures() {
        Pictures::One(path) => {
            studio.film(args.time, 1, 1.0, |_| path.clone(), |_| ())?;
            Ok(format!("The picture is in {}", picture::absolute(&path)))
        }
        Pictures::Film {
            frames,
            fps,
            folder,
        } => {
            let bar = ProgressBar::new(frames.into()).with_style(
                ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} to go")
                    .expect("the template is well formed"),
            );
            let name = |frame| folder.join(format!("frame-{frame:05}.png"));
            studio.film(args.time, frames, fps, name, |done| {
                bar.set_position(done.into())
            })?;
            bar.finish_and_clear();
            Ok(format!(
                "{frames} pictures, {fps} a second, are in {}",
                picture::absolute(&folder.join("frame-*.png"))
            ))
        }
    }
}

struct Studio {
    app: App,
    target: Handle<Image>,
}

impl Studio {
    fn new(args: &Args) -> Self {
        let mut app = App::new();
        app.add_plugins(
            DefaultPlugins
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                })
                .set(RenderPlugin {
                    synchronous_pipeline_compilation: true,
                    ..default()
                })
                .set(LogPlugin {
                    level: Level::WARN,
                    ..default()
                })
                .disable::<WinitPlugin>()
                // Or an update would return before its picture is drawn.
                .disable::<PipelinedRenderingPlugin>(),
        )
        .insert_resource(args.settings())
        .init_resource::<Captured>()
        .add_plugins(crate::common_plugin);
        app.finish();
        app.cleanup();

        let (width, height) = args.size;
        let mut target = Image::new_uninit(
            Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            TextureDimension::D2,
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::RENDER_WORLD,
        );
        target.texture_descriptor.usage |= TextureUsages::RENDER_ATTACHMENT;
        let target = app.world_mut().resource_mut::<Assets<Image>>().add(target);
        let image = target.clone();
        app.add_systems(
            PostStartup,
            move |mut commands: Commands, camera: Single<Entity, With<Camera3d>>| {
                commands
                    .entity(*camera)
                    .insert(RenderTarget::Image(image.clone().into()));
            },
        );
        Self { app, target }
    }

    /// Draws `frames` pictures from `start` on, and writes each as it comes back.
    fn film(
        &mut self,
        start: f32,
        frames: u32,
        fps: f32,
        name: impl Fn(u32) -> PathBuf,
        written: impl Fn(u32),
    ) -> Result<(), (String, u8)> {
        self.set_time(start);
        for _ in 0..WARM_UP {
            self.update();
        }
        let (mut done, mut waited) = (0, 0);
        for update in 0.. {
            if update < frames {
                self.set_time(start + update as f32 / fps);
                self.capture(update);
            } else {
                waited += 1;
            }
            self.update();
            let captured = std::mem::take(&mut self.app.world_mut().resource_mut::<Captured>().0);
            for (frame, image) in captured {
                picture::save(&image, &name(frame)).map_err(|line| (line, 1))?;
                done += 1;
                written(done);
            }
            if done == frames {
                break;
            }
            if waited > PATIENCE {
                return Err(("the graphics device gave no picture back".into(), 1));
            }
        }
        Ok(())
    }

    fn set_time(&mut self, seconds: f32) {
        self.app.insert_resource(SceneTime {
            jump: seconds,
            light: seconds,
        });
    }

    /// Asks for a picture of the next update.
    fn capture(&mut self, frame: u32) {
        self.app
            .world_mut()
            .spawn(Screenshot::image(self.target.clone()))
            .observe(
                move |event: On<ScreenshotCaptured>, mut captured: ResMut<Captured>| {
                    captured.0.insert(frame, event.image.clone());
                },
            );
    }

    fn update(&mut self) {
        self.app.update();
        let device = self.app.world().resource::<RenderDevice>().wgpu_device();
        // Errors show in the picture that does not come back.
        let _ = device.poll(PollType::wait_indefinitely());
    }
}
