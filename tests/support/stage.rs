//! An app without a window that draws into images, is stepped by hand, and fails on whatever goes wrong in it.

use std::{
    cell::RefCell,
    fmt,
    rc::{Rc, Weak},
    sync::{Arc, Mutex, MutexGuard},
};

use bevy::{
    asset::RenderAssetUsages,
    log::{Level, LogPlugin},
    prelude::*,
    render::{
        RenderApp, RenderPlugin,
        error_handler::{RenderErrorHandler, RenderErrorPolicy},
        pipelined_rendering::PipelinedRenderingPlugin,
        render_asset::RenderAssets,
        render_resource::{
            BufferDescriptor, BufferUsages, CachedPipelineState, CommandEncoderDescriptor,
            Extent3d, MapMode, PipelineCache, PipelineDescriptor, PollType, TexelCopyBufferInfo,
            TexelCopyBufferLayout, TextureDimension, TextureFormat, TextureUsages,
        },
        renderer::{RenderDevice, RenderQueue},
        settings::WgpuSettings,
        texture::GpuImage,
    },
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_planar_mirror::PlanarMirrorPlugin;

use super::{
    log::{self, Line},
    picture::Picture,
};

/// Updates after which a picture that is still not there, or still changes, is given up.
const PATIENCE: usize = 200;

/// A row of a texture that is copied to a buffer starts at a multiple of this many bytes.
const ROW_ALIGNMENT: u32 = 256;

/// An app under test. While one lives no other thread has one, so that what is logged is known to
/// come from it; a test that fails drops it.
pub struct Stage {
    app: App,
    log: Vec<Line>,
    _turn: Rc<Turn>,
}

/// Why there is no picture.
#[derive(Debug, PartialEq, Eq)]
pub enum NoPicture {
    /// The target was never given to the GPU.
    Missing,
    /// It has been, in another size than was asked for.
    WrongSize { actual: UVec2, expected: UVec2 },
    /// Pipelines still wait, or the picture still changes.
    NeverSettled { waiting: usize },
    /// The driver did not hand the pixels over.
    NotReadable(String),
}

impl Stage {
    /// Bevy with the mirrors.
    pub fn with_mirrors() -> Self {
        Self::new(|app| {
            app.add_plugins(PlanarMirrorPlugin::default());
        })
    }

    /// Bevy without them: what other pictures are measured by.
    pub fn stock() -> Self {
        Self::new(|_| {})
    }

    /// Bevy, and what the test adds before the app is finished.
    ///
    /// Panics without a graphics adapter: a machine that cannot draw must not pass for one that can.
    pub fn new(add: impl FnOnce(&mut App)) -> Self {
        Self::with_wgpu(WgpuSettings::default(), add)
    }

    /// [`Self::new`] on a device as these settings ask for it.
    pub fn with_wgpu(wgpu: WgpuSettings, add: impl FnOnce(&mut App)) -> Self {
        let turn = Turn::take();
        log::install();
        log::take();
        let mut app = App::new();
        app.add_plugins(
            DefaultPlugins
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                })
                .set(RenderPlugin {
                    render_creation: wgpu.into(),
                    synchronous_pipeline_compilation: true,
                    ..default()
                })
                .disable::<WinitPlugin>()
                .disable::<LogPlugin>()
                // The render world stays in reach, and a picture is that of the update before.
                .disable::<PipelinedRenderingPlugin>(),
        );
        // The error is in the log by then, and the log is read after each update.
        app.insert_resource(RenderErrorHandler(|_, _, _| {
            RenderErrorPolicy::StopRendering
        }));
        app.insert_resource(ClearColor(Color::BLACK));
        add(&mut app);
        app.finish();
        app.cleanup();
        assert!(
            app.get_sub_app(RenderApp)
                .is_some_and(|render| render.world().contains_resource::<RenderDevice>()),
            "no graphics adapter: picture tests need a Vulkan driver, a software one will do"
        );
        Self {
            app,
            log: Vec::new(),
            _turn: turn,
        }
    }

    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    #[allow(
        dead_code,
        reason = "the report asks whether it was interrupted, the tests do not"
    )]
    pub fn app(&mut self) -> &mut App {
        &mut self.app
    }

    pub fn render_world(&mut self) -> &mut World {
        self.app.sub_app_mut(RenderApp).world_mut()
    }

    /// Adds an image that cameras can draw into.
    pub fn target(&mut self, size: UVec2) -> Handle<Image> {
        self.target_of(size, TextureFormat::Rgba8UnormSrgb)
    }

    /// [`Self::target`] of another format; one that [`Self::read`] knows.
    pub fn target_of(&mut self, size: UVec2, format: TextureFormat) -> Handle<Image> {
        let mut image = Image::new_uninit(
            extent(size),
            TextureDimension::D2,
            format,
            RenderAssetUsages::default(),
        );
        image.texture_descriptor.usage |=
            TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        self.world().resource_mut::<Assets<Image>>().add(image)
    }

    /// One update, drawn to its end. Panics if the renderer or anything else reports an error.
    #[track_caller]
    pub fn frame(&mut self) {
        if let Err(error) = self.try_frame(App::update) {
            panic!("{error}");
        }
    }

    /// One update as `step` does it, drawn to its end; or what was reported as an error.
    pub fn try_frame(&mut self, step: impl FnOnce(&mut App)) -> Result<(), String> {
        step(&mut self.app);
        let device = self.app.world().resource::<RenderDevice>().clone();
        if let Err(error) = device.wgpu_device().poll(PollType::wait_indefinitely()) {
            return Err(format!("the device did not finish the frame: {error}"));
        }
        self.log.extend(log::take());
        let errors: Vec<_> = self
            .log
            .iter()
            .filter(|line| line.level == Level::ERROR)
            .map(|line| &*line.text)
            .collect();
        if errors.is_empty() {
            return Ok(());
        }
        Err(format!("the app reports errors:\n{}", errors.join("\n")))
    }

    /// What is logged as an error in these updates, which are meant to go wrong.
    pub fn errors_while(&mut self, steps: impl FnOnce(&mut App)) -> Vec<Line> {
        self.log.extend(log::take());
        steps(&mut self.app);
        let (errors, others) = log::take()
            .into_iter()
            .partition(|line| line.level == Level::ERROR);
        self.log.extend::<Vec<Line>>(others);
        errors
    }

    /// What was logged as a warning since the stage was built.
    pub fn warnings(&self) -> impl Iterator<Item = &Line> {
        self.log.iter().filter(|line| line.level == Level::WARN)
    }

    /// Steps until no pipeline waits and the picture stands still, and reads it.
    pub fn settle(&mut self, target: &Handle<Image>, size: UVec2) -> Result<Picture, NoPicture> {
        let mut last = None;
        // Assets, extraction and retained phases take a few updates to come through.
        for _ in 0..3 {
            self.frame();
        }
        for _ in 0..PATIENCE {
            self.frame();
            let now = self
                .read(target, size)
                .ok()
                .filter(|_| self.waiting_pipelines() == 0);
            if now.is_some() && now == last {
                return now.ok_or(NoPicture::Missing);
            }
            last = now;
        }
        self.read(target, size)?;
        Err(NoPicture::NeverSettled {
            waiting: self.waiting_pipelines(),
        })
    }

    /// [`Self::settle`], for tests that need a picture to go on; it must show something.
    #[track_caller]
    pub fn picture(&mut self, target: &Handle<Image>, size: UVec2) -> Picture {
        match self.settle(target, size) {
            Ok(picture) => {
                picture.assert_shows_something();
                picture
            }
            Err(reason) => panic!("{reason}"),
        }
    }

    /// The labels of all pipelines asked for so far, in that order.
    pub fn pipeline_labels(&self) -> Vec<String> {
        let render = self.app.sub_app(RenderApp).world();
        let pipelines = render.resource::<PipelineCache>().pipelines();
        pipelines
            .map(|pipeline| match &pipeline.descriptor {
                PipelineDescriptor::RenderPipelineDescriptor(it) => it.label.clone(),
                PipelineDescriptor::ComputePipelineDescriptor(it) => it.label.clone(),
            })
            .map(|label| label.unwrap_or_default().into_owned())
            .collect()
    }

    /// Pipelines that are asked for and not compiled yet.
    pub fn waiting_pipelines(&self) -> usize {
        let cache = self
            .app
            .sub_app(RenderApp)
            .world()
            .resource::<PipelineCache>();
        let unready = |state: &CachedPipelineState| !matches!(state, CachedPipelineState::Ok(_));
        cache
            .pipelines()
            .filter(|pipeline| unready(&pipeline.state))
            .count()
    }

    /// The target as it is now.
    pub fn read(&self, target: &Handle<Image>, size: UVec2) -> Result<Picture, NoPicture> {
        let render = self.app.sub_app(RenderApp).world();
        let (device, queue) = (
            render.resource::<RenderDevice>(),
            render.resource::<RenderQueue>(),
        );
        let images = render.resource::<RenderAssets<GpuImage>>();
        let image = images.get(target).ok_or(NoPicture::Missing)?;
        let actual = UVec2::new(image.texture.width(), image.texture.height());
        if actual != size {
            return Err(NoPicture::WrongSize {
                actual,
                expected: size,
            });
        }
        let Some(decode) = decoder(image.texture.format()) else {
            return Err(NoPicture::NotReadable(format!(
                "{:?} is not known here",
                image.texture.format()
            )));
        };
        let pixel = image.texture.format().block_copy_size(None).unwrap_or(0);
        let row = (size.x * pixel).next_multiple_of(ROW_ALIGNMENT);
        let buffer = device.create_buffer(&BufferDescriptor {
            label: Some("picture"),
            size: u64::from(row) * u64::from(size.y),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor {
            label: Some("read_picture"),
        });
        encoder.copy_texture_to_buffer(
            image.texture.as_image_copy(),
            TexelCopyBufferInfo {
                buffer: &buffer,
                layout: TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            extent(size),
        );
        queue.submit([encoder.finish()]);
        let mapped = Arc::new(Mutex::new(None));
        let answer = mapped.clone();
        buffer.slice(..).map_async(MapMode::Read, move |result| {
            *answer.lock().expect("no panic while the answer is stored") = Some(result);
        });
        let not_readable = |reason: &dyn fmt::Display| NoPicture::NotReadable(reason.to_string());
        device
            .wgpu_device()
            .poll(PollType::wait_indefinitely())
            .map_err(|error| not_readable(&error))?;
        match mapped
            .lock()
            .expect("no panic while the answer is stored")
            .take()
        {
            Some(Ok(())) => {}
            Some(Err(error)) => return Err(not_readable(&error)),
            None => return Err(not_readable(&"the device never answered")),
        }
        let bytes = buffer.slice(..).get_mapped_range();
        let pixels = bytes
            .chunks_exact(row as usize)
            .flat_map(|row| row[..(size.x * pixel) as usize].chunks_exact(pixel as usize))
            .map(decode)
            .collect();
        Picture::new(size, pixels).ok_or(NoPicture::Missing)
    }
}

/// How the bytes of a pixel become four levels; of floats, those from 0 to 1 are told apart.
fn decoder(format: TextureFormat) -> Option<fn(&[u8]) -> [u8; 4]> {
    match format {
        TextureFormat::Rgba8UnormSrgb | TextureFormat::Rgba8Unorm => {
            Some(|bytes| std::array::from_fn(|i| bytes[i]))
        }
        TextureFormat::Bgra8UnormSrgb | TextureFormat::Bgra8Unorm => {
            Some(|bytes| [2, 1, 0, 3].map(|i| bytes[i]))
        }
        TextureFormat::Rgba16Float => Some(|bytes| {
            let [r, g, b, a] = std::array::from_fn(|i| half([bytes[2 * i], bytes[2 * i + 1]]));
            LinearRgba::new(r, g, b, a).to_u8_array()
        }),
        _ => None,
    }
}

/// A float of 16 bits.
fn half(bytes: [u8; 2]) -> f32 {
    let bits = u16::from_le_bytes(bytes);
    let (exponent, fraction) = (
        i32::from((bits >> 10) & 0x1f),
        f32::from(bits & 0x3ff) / 1024.0,
    );
    let magnitude = match exponent {
        0 => fraction * 2.0_f32.powi(-14),
        31 if fraction == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        _ => (1.0 + fraction) * 2.0_f32.powi(exponent - 15),
    };
    if bits >> 15 == 0 {
        magnitude
    } else {
        -magnitude
    }
}

fn extent(size: UVec2) -> Extent3d {
    Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: 1,
    }
}

impl fmt::Display for NoPicture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str("the picture never came"),
            Self::WrongSize { actual, expected } => {
                write!(f, "the target is {actual} and not {expected}")
            }
            Self::NeverSettled { waiting } => {
                write!(f, "the picture never stood still; {waiting} pipelines wait")
            }
            Self::NotReadable(reason) => write!(f, "the picture cannot be read: {reason}"),
        }
    }
}

/// The right to have a stage. A thread that has it may have more stages than one.
struct Turn {
    _guard: MutexGuard<'static, ()>,
}

impl Turn {
    fn take() -> Rc<Self> {
        static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
        thread_local! {
            static MINE: RefCell<Weak<Turn>> = const { RefCell::new(Weak::new()) };
        }
        MINE.with_borrow_mut(|mine| {
            mine.upgrade().unwrap_or_else(|| {
                // A test that failed with the guard in hand left nothing behind that matters.
                let guard = ONE_AT_A_TIME
                    .lock()
                    .unwrap_or_else(|poisoned| poisoned.into_inner());
                let turn = Rc::new(Turn { _guard: guard });
                *mine = Rc::downgrade(&turn);
                turn
            })
        })
    }
}
