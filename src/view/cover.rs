//! What is seen of mirrors past what stands before them; what is hidden needs no view.
//!
//! The answer is this frame's and certain, so that a mirror is never late: hidden is what opaque
//! meshes of few triangles, as walls and doors are, hide together. Of everything else it is not
//! known whether it will be drawn, opaque and in this place, so it hides nothing.

use bevy::{
    asset::{Assets, RenderAssetUsages, VisitAssetDependencies},
    camera::{
        primitives::Aabb,
        visibility::{InheritedVisibility, RenderLayers, VisibilityRange},
    },
    ecs::{prelude::*, query::QueryData, system::SystemParam},
    image::Image,
    material::{AlphaMode, OpaqueRendererMethod},
    mesh::{Mesh, Mesh3d, PrimitiveTopology, morph::MeshMorphWeights, skinning::SkinnedMesh},
    pbr::{DefaultOpaqueRendererMethod, MeshMaterial3d, StandardMaterial},
    reflect::tuple_struct::GetTupleStructField,
    render::render_resource::Face,
    transform::components::GlobalTransform,
};
use glam::{DMat4, DVec4};

use super::{bounds::WorldBox, decide::CameraInput};
use crate::{
    math::{Cover, CoverView, ReflectedViewPlan, ViewInput, VisiblePolygon, edge_sides},
    mirror::PlanarMirror,
};

/// A mesh of more triangles is no wall, and would cost as much as the view that it might spare.
const MOST_TRIANGLES: usize = 128;
/// Of so many faces before a mirror no more are looked at.
const MOST_FACES: usize = 512;
/// The radius of what may hide a mirror, at least, as a share of half the picture's height. What is
/// smaller hides none but the smallest mirrors.
const LEAST_SIZE: f32 = 1.0 / 16.0;

/// Everything that may hide a mirror.
#[derive(SystemParam)]
pub struct Walls<'w, 's> {
    objects: Query<'w, 's, Wall, Rigid>,
    meshes: Option<Res<'w, Assets<Mesh>>>,
    materials: Option<Res<'w, Assets<StandardMaterial>>>,
    images: Option<Res<'w, Assets<Image>>>,
    default_method: Option<Res<'w, DefaultOpaqueRendererMethod>>,
}

#[derive(QueryData)]
struct Wall {
    entity: Entity,
    transform: &'static GlobalTransform,
    bounds: &'static Aabb,
    mesh: &'static Mesh3d,
    material: &'static MeshMaterial3d<StandardMaterial>,
    visibility: &'static InheritedVisibility,
    layers: Option<&'static RenderLayers>,
}

/// What is drawn where its transform says, as often as it is there.
type Rigid = (
    Without<PlanarMirror>,
    Without<SkinnedMesh>,
    Without<MeshMorphWeights>,
    Without<VisibilityRange>,
);

/// What one camera's mirrors may be hidden by. Kept to use its memory again.
#[derive(Default)]
pub struct WallsInView {
    /// Whether they have been looked for: only if there is a mirror to hide.
    is_known: bool,
    /// The largest on the screen come first, so that small things do not cut in pieces what a large
    /// one hides.
    walls: Vec<WallInView>,
    sides: Vec<DVec4>,
    cover: Cover,
}

struct WallInView {
    entity: Entity,
    bounds: WorldBox,
    /// Its radius as a share of half the picture's height; infinite around the eye.
    size: f32,
    /// Which of its faces are drawn: those whose vertices turn to the left, to the right, or all.
    drawn: Option<Turn>,
}

#[derive(Clone, Copy, PartialEq)]
enum Turn {
    Left,
    Right,
}

impl Walls<'_, '_> {
    /// Whether it is drawn, and all of its pixels are in the depth that mirrors are tested against.
    fn is_opaque(&self, material: &StandardMaterial) -> bool {
        material.alpha_mode == AlphaMode::Opaque
            && material.specular_transmission == 0.0
            && material.depth_bias == 0.0
            && self.is_forward(material)
            && self.is_loaded(material)
    }

    /// What is to be drawn deferred is not drawn by a forward camera, and others see no mirrors.
    fn is_forward(&self, material: &StandardMaterial) -> bool {
        match material.opaque_render_method {
            OpaqueRendererMethod::Forward => true,
            OpaqueRendererMethod::Deferred => false,
            OpaqueRendererMethod::Auto => self
                .default_method
                .as_ref()
                .is_none_or(|method| method.get_field(0) != Some(&OpaqueRendererMethod::Deferred)),
        }
    }

    /// The engine does not draw what a texture is missing of.
    fn is_loaded(&self, material: &StandardMaterial) -> bool {
        let mut is_loaded = true;
        material.visit_dependencies(&mut |id| {
            let texture = id.try_typed::<Image>().ok().zip(self.images.as_ref());
            is_loaded &= texture.is_some_and(|(id, images)| images.contains(id));
        });
        is_loaded
    }
}

impl WallsInView {
    /// Begins with another camera.
    pub fn forget(&mut self) {
        self.is_known = false;
    }

    /// What the camera sees of the mirror it looks at; `None` if the walls hide all of it.
    pub fn seen(
        &mut self,
        walls: Option<&Walls>,
        camera: &CameraInput,
        look: &ViewInput,
        plan: &ReflectedViewPlan,
    ) -> Option<&Cover> {
        self.cover.begin(&plan.polygon);
        if let Some(walls) = walls {
            self.take_away(walls, camera, look, plan);
        }
        (!self.cover.is_whole()).then_some(&self.cover)
    }

    fn take_away(
        &mut self,
        walls: &Walls,
        camera: &CameraInput,
        look: &ViewInput,
        plan: &ReflectedViewPlan,
    ) {
        let (Some(meshes), Some(materials)) = (&walls.meshes, &walls.materials) else {
            return;
        };
        if !self.is_known {
            self.is_known = true;
            self.find(walls, meshes, materials, camera, look);
        }
        if self.walls.is_empty() {
            return;
        }
        let Some(view) = CoverView::new(look, plan) else {
            return;
        };
        let view_from_world = DMat4::from(look.world_from_view.inverse());
        self.sides.clear();
        self.sides.push(look.plane.covector());
        self.sides.extend(
            edge_sides(&plan.polygon, &look.clip_from_view, look.viewport_size)
                .map(|side| view_from_world.transpose() * side),
        );
        let mut faces = 0;
        for wall in &self.walls {
            let is_beside = |side: &DVec4| wall.bounds.range(*side).1 < 0.0;
            if self.sides.iter().any(is_beside) {
                continue;
            }
            let Ok(object) = walls.objects.get(wall.entity) else {
                continue;
            };
            let Some(Ok(triangles)) = meshes.get(object.mesh).map(Mesh::triangles) else {
                continue;
            };
            let world_from_local = object.transform.affine().as_daffine3();
            for triangle in triangles {
                let corners = triangle.vertices.map(|corner| corner.as_dvec3());
                let Some(face) = view.face(corners, &world_from_local) else {
                    continue;
                };
                if !wall.shows(&face) {
                    continue;
                }
                self.cover.take_away(&face, look.viewport_size);
                faces += 1;
                let is_done = self.cover.is_whole() || !self.cover.is_open();
                if is_done || faces == MOST_FACES {
                    return;
                }
            }
        }
    }

    /// Looks for what is large enough on the screen, opaque for sure and drawn by this camera.
    fn find(
        &mut self,
        walls: &Walls,
        meshes: &Assets<Mesh>,
        materials: &Assets<StandardMaterial>,
        camera: &CameraInput,
        look: &ViewInput,
    ) {
        self.walls.clear();
        let default_layers = RenderLayers::default();
        // Roughly: what is left out here hides nothing, and the rest is looked at more closely.
        let clip_from_world = look.clip_from_view * DMat4::from(look.world_from_view.inverse());
        let [up, depth] = [1, 3].map(|row| clip_from_world.row(row).as_vec4());
        let [up_length, depth_length] = [up, depth].map(|row| row.truncate().length());
        for wall in &walls.objects {
            let radius = wall.transform.radius_vec3a(wall.bounds.half_extents);
            let center = wall
                .transform
                .affine()
                .transform_point3a(wall.bounds.center);
            let w = depth.dot(center.extend(1.0));
            let size = if w > 0.0 {
                radius * up_length / w
            } else {
                f32::INFINITY
            };
            let is_behind = w <= -radius * depth_length;
            if size < LEAST_SIZE || is_behind || !wall.visibility.get() {
                continue;
            }
            let layers = wall.layers.unwrap_or(&default_layers);
            let (Some(mesh), Some(material)) =
                (meshes.get(wall.mesh), materials.get(wall.material))
            else {
                continue;
            };
            if camera.layers.intersects(layers) && is_simple(mesh) && walls.is_opaque(material) {
                self.walls.push(WallInView {
                    entity: wall.entity,
                    bounds: WorldBox::new(wall.transform, wall.bounds),
                    size,
                    drawn: drawn_faces(material.cull_mode, camera.inverts_culling),
                });
            }
        }
        self.walls
            .sort_unstable_by(|a, b| b.size.total_cmp(&a.size).then(a.entity.cmp(&b.entity)));
    }
}

impl WallInView {
    /// Whether a face as it is seen by the camera is drawn.
    fn shows(&self, face: &VisiblePolygon) -> bool {
        let turn = if face.twice_area() > 0.0 {
            Turn::Left
        } else {
            Turn::Right
        };
        self.drawn.is_none_or(|drawn| drawn == turn)
    }
}

/// Whether it is drawn as it is here, and worth to be looked at.
fn is_simple(mesh: &Mesh) -> bool {
    mesh.asset_usage.contains(RenderAssetUsages::RENDER_WORLD)
        && mesh.primitive_topology() == PrimitiveTopology::TriangleList
        && mesh
            .try_indices()
            .is_ok_and(|indices| indices.len() <= 3 * MOST_TRIANGLES)
}

/// How the vertices turn of the faces that a material shows; `None` for all.
fn drawn_faces(culled: Option<Face>, is_inverted: bool) -> Option<Turn> {
    let front = if is_inverted { Turn::Right } else { Turn::Left };
    let back = if is_inverted { Turn::Left } else { Turn::Right };
    culled.map(|culled| match culled {
        Face::Front => back,
        Face::Back => front,
    })
}
