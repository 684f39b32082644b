//! A scene into files, without a window: the app is stepped by hand, one update a picture.

use std::{collections::BTreeMap, path::PathBuf};

use bevy::{
    asset::RenderAssetUsages,
    log::{Level, LogPlugin},
    prelude::*,
    render::{
        RenderPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::{Extent3d, PollType, TextureDimension, TextureFormat, TextureUsages},
        renderer::RenderDevice,
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    window::ExitCondition,
    winit::WinitPlugin,
};

use super::picture;

/// Updates before the first picture: meshes, textures and pipelines are made in the first few, and
/// what it took to draw them is told some updates later.
const WARM_UP: u32 = 7;
/// Updates to wait for a picture to come back from the device.
const PATIENCE: u32 = 100;

/// Pictures that have come back from the device, by number.
#[derive(Resource, Default)]
struct Captured(BTreeMap<u32, Image>);

/// What the cameras draw into.
#[derive(Resource, Clone)]
pub struct Target(pub Handle<Image>);

/// An app without a window.
pub struct Studio {
    pub app: App,
    target: Handle<Image>,
}

impl Studio {
    /// Bevy, and what the example adds. The cameras are to draw into [`Target`].
    pub fn new((width, height): (u32, u32), add: impl FnOnce(&mut App)) -> Self {
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
        .init_resource::<Captured>();
        add(&mut app);
        app.finish();
        app.cleanup();

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
        app.insert_resource(Target(target.clone()));
        Self { app, target }
    }

    /// Draws `frames` pictures, each after `set` has done to the app what belongs to it, and writes
    /// them as they come back. The error is one line for the user.
    pub fn film(
        &mut self,
        frames: u32,
        mut set: impl FnMut(&mut App, u32),
        name: impl Fn(u32) -> PathBuf,
        written: impl Fn(u32),
    ) -> Result<(), String> {
        set(&mut self.app, 0);
        for _ in 0..WARM_UP {
            self.update();
        }
        let (mut done, mut waited) = (0, 0);
        for update in 0.. {
            if update < frames {
                set(&mut self.app, update);
                self.capture(update);
            } else {
                waited += 1;
            }
            self.update();
            let captured = std::mem::take(&mut self.app.world_mut().resource_mut::<Captured>().0);
            for (frame, image) in captured {
                picture::save(&image, &name(frame))?;
                done += 1;
                written(done);
            }
            if done == frames {
                break;
            }
            if waited > PATIENCE {
                return Err("the graphics device gave no picture back".into());
            }
        }
        Ok(())
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
