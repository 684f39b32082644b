//! An app without a window that draws into images, is stepped by hand, and fails on whatever goes wrong in it.

use std::{
    cell::RefCell,
    fmt,
    rc::{Rc, Weak},
    sync::{Arc, Mutex, MutexGuard},
};

use bevy::{
    asset::RenderAssetUsages,
    ecs::schedule::MainThreadExecutor,
    log::{Level, LogPlugin},
    prelude::*,
    render::{
        Render, RenderApp, RenderPlugin, RenderSystems,
        error_handler::{RenderErrorHandler, RenderErrorPolicy},
        pipelined_rendering::PipelinedRenderingPlugin,
        render_asset::RenderAssets,
        render_resource::{
            BufferDescriptor, BufferUsages, CachedPipelineState, CommandEncoderDescriptor,
            Extent3d, MapMode, PipelineCache, PipelineDescriptor, PollType, TexelCopyBufferInfo,
            TexelCopyBufferLayout, Texture, TextureDimension, TextureFormat, TextureUsages,
        },
        renderer::{RenderDevice, RenderQueue},
        settings::WgpuSettings,
        texture::GpuImage,
    },
    tasks::ComputeTaskPool,
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
    /// What a renderer on a thread of its own has made known; `None` if it is in reach.
    published: Option<Arc<Mutex<Published>>>,
    /// How many updates there were.
    updates: u64,
    _turn: Rc<Turn>,
}

/// What is to be known of a renderer, as it was at the end of a frame.
#[derive(Default)]
struct Published {
    frames: u64,
    waiting: usize,
    labels: Vec<String>,
    entities: u32,
    targets: Vec<(AssetId<Image>, Texture)>,
}

/// In the render world of an app whose renderer has a thread of its own.
#[derive(Resource)]
struct Publisher(Arc<Mutex<Published>>);

/// The end of each frame.
fn publish(world: &mut World) {
    let entities = world.entities().count_spawned();
    let cache = world.resource::<PipelineCache>();
    let images = world.resource::<RenderAssets<GpuImage>>().iter();
    let targets = images
        .map(|(id, image)| (id, image.texture.clone()))
        .filter(|(_, texture)| texture.usage().contains(TextureUsages::COPY_SRC))
        .collect();
    let publisher = world.resource::<Publisher>();
    let mut published = publisher.0.lock().expect("nobody panics with it");
    *published = Published {
        frames: published.frames + 1,
        waiting: waiting(cache),
        labels: labels(cache),
        entities,
        targets,
    };
}

fn waiting(cache: &PipelineCache) -> usize {
    let unready = |state: &CachedPipelineState| !matches!(state, CachedPipelineState::Ok(_));
    let pipelines = cache.pipelines();
    pipelines
        .filter(|pipeline| unready(&pipeline.state))
        .count()
}

fn labels(cache: &PipelineCache) -> Vec<String> {
    let pipelines = cache.pipelines();
    pipelines
        .map(|pipeline| match &pipeline.descriptor {
            PipelineDescriptor::RenderPipelineDescriptor(it) => it.label.clone(),
            PipelineDescriptor::ComputePipelineDescriptor(it) => it.label.clone(),
        })
        .map(|label| label.unwrap_or_default().into_owned())
        .collect()
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
        Self::build(wgpu, false, add)
    }

    /// Bevy as games run it: pipelines are compiled in the background, and the renderer has a thread
    /// of its own. There is no [`Self::render_world`] then.
    pub fn as_games_run(add: impl FnOnce(&mut App)) -> Self {
        Self::build(WgpuSettings::default(), true, add)
    }

    /// [`Self::as_games_run`] with the mirrors.
    pub fn game_with_mirrors() -> Self {
        Self::as_games_run(|app| {
            app.add_plugins(PlanarMirrorPlugin::default());
        })
    }

    fn build(wgpu: WgpuSettings, as_game: bool, add: impl FnOnce(&mut App)) -> Self {
        let turn = Turn::take();
        log::install();
        log::take();
        let mut app = App::new();
        let plugins = DefaultPlugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(RenderPlugin {
                render_creation: wgpu.into(),
                synchronous_pipeline_compilation: !as_game,
                ..default()
            })
            .disable::<WinitPlugin>()
            .disable::<LogPlugin>();
        app.add_plugins(if as_game {
            plugins
        } else {
            // The render world stays in reach, and a picture is that of the update before.
            plugins.disable::<PipelinedRenderingPlugin>()
        });
        // The error is in the log by then, and the log is read after each update.
        app.insert_resource(RenderErrorHandler(|_, _, _| {
            RenderErrorPolicy::StopRendering
        }));
        app.insert_resource(ClearColor(Color::BLACK));
        add(&mut app);
        let published = as_game.then(Arc::<Mutex<Published>>::default);
        if let (Some(published), Some(render)) = (&published, app.get_sub_app_mut(RenderApp)) {
            render
                .insert_resource(Publisher(published.clone()))
                .add_systems(Render, publish.in_set(RenderSystems::PostCleanup));
        }
        app.finish();
        app.cleanup();
        assert!(
            app.world().contains_resource::<RenderDevice>(),
            "no graphics adapter: picture tests need a Vulkan driver, a software one will do"
        );
        Self {
            app,
            log: Vec::new(),
            published,
            updates: 0,
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
        self.updates += 1;
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
        // Where pipelines come late, so does what the GPU counts, as the lamps in a cluster.
        let enough = if self.published.is_some() { 5 } else { 1 };
        let (mut last, mut same) = (None, 0);
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
            same = if now.is_some() && now == last {
                same + 1
            } else {
                0
            };
            if same == enough {
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
        self.of_renderer(
            |world| labels(world.resource()),
            |published| published.labels.clone(),
        )
    }

    /// Pipelines that are asked for and not compiled yet.
    pub fn waiting_pipelines(&self) -> usize {
        self.of_renderer(
            |world| waiting(world.resource()),
            |published| published.waiting,
        )
    }

    /// Entities that the renderer has.
    pub fn render_entities(&self) -> u32 {
        self.of_renderer(
            |world| world.entities().count_spawned(),
            |published| published.entities,
        )
    }

    /// Something of the renderer, in its world or as it made it known at the end of this frame.
    fn of_renderer<T>(
        &self,
        in_reach: impl FnOnce(&World) -> T,
        known: impl FnOnce(&Published) -> T,
    ) -> T {
        let Some(published) = &self.published else {
            return in_reach(self.app.sub_app(RenderApp).world());
        };
        let main_thread = self.app.world().resource::<MainThreadExecutor>().clone();
        let start = std::time::Instant::now();
        loop {
            let published = published.lock().expect("nobody panics with it");
            if published.frames >= self.updates {
                return known(&published);
            }
            drop(published);
            assert!(
                start.elapsed().as_secs() < 60,
                "the renderer does not finish"
            );
            // It may wait for this thread to do something.
            ComputeTaskPool::get().scope_with_executor(true, Some(&*main_thread.0), |scope| {
                scope.spawn(async {});
            });
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
    }

    /// The target as it is now.
    pub fn read(&self, target: &Handle<Image>, size: UVec2) -> Result<Picture, NoPicture> {
        let texture = self.of_renderer(
            |world| {
                let images = world.resource::<RenderAssets<GpuImage>>();
                images.get(target).map(|image| image.texture.clone())
            },
            |published| {
                let mut targets = published.targets.iter();
                let found = targets.find(|(id, _)| *id == target.id());
                found.map(|(_, texture)| texture.clone())
            },
        );
        let texture = texture.ok_or(NoPicture::Missing)?;
        let world = self.app.world();
        let (device, queue) = (
            world.resource::<RenderDevice>(),
            world.resource::<RenderQueue>(),
        );
        let actual = UVec2::new(texture.width(), texture.height());
        if actual != size {
            return Err(NoPicture::WrongSize {
                actual,
                expected: size,
            });
        }
        let Some(decode) = decoder(texture.format()) else {
            return Err(NoPicture::NotReadable(format!(
                "{:?} is not known here",
                texture.format()
            )));
        };
        let pixel = texture.format().block_copy_size(None).unwrap_or(0);
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
            texture.as_image_copy(),
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
