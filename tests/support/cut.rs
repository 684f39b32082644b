//! Triangle meshes cut at a plane on the CPU, in f64.

use bevy::{
    asset::RenderAssetUsages,
    math::{DAffine3, DVec3},
    mesh::{Indices, Mesh, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues},
};

/// The plane `normal.p + d = 0` in the world; what has `normal.p + d > 0` is kept.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub normal: DVec3,
    pub d: f64,
}

impl Plane {
    pub fn through(point: DVec3, normal: DVec3) -> Self {
        let normal = normal.normalize();
        Self {
            normal,
            d: -normal.dot(point),
        }
    }

    pub fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) + self.d
    }

    /// Householder: the mirror image of a point.
    pub fn reflect(&self, point: DVec3) -> DVec3 {
        point - 2.0 * self.height(point) * self.normal
    }

    /// The mirror image of a direction.
    pub fn reflect_direction(&self, direction: DVec3) -> DVec3 {
        direction - 2.0 * self.normal.dot(direction) * self.normal
    }
}

/// What is left of a mesh.
pub enum Cut {
    /// All of it: nothing is behind the plane.
    Whole,
    Part(Box<Mesh>),
    Nothing,
}

/// One corner: all attributes one after the other.
type Corner = Vec<f64>;

/// Cuts off what is behind the plane. New corners have their attributes interpolated along the edge;
/// old ones keep theirs to the bit.
pub fn cut(mesh: &Mesh, world_from_local: DAffine3, plane: Plane) -> Cut {
    assert_eq!(
        mesh.primitive_topology(),
        PrimitiveTopology::TriangleList,
        "only lists of triangles are cut"
    );
    let attributes: Vec<(MeshVertexAttribute, Vec<Vec<f64>>)> = mesh
        .attributes()
        .map(|(attribute, values)| (*attribute, floats(values)))
        .collect();
    let position = attributes
        .iter()
        .find(|(attribute, _)| attribute.id == Mesh::ATTRIBUTE_POSITION.id)
        .map(|(_, values)| values)
        .expect("a mesh has positions");
    let heights: Vec<f64> = position
        .iter()
        .map(|p| plane.height(world_from_local.transform_point3(DVec3::from_slice(p))))
        .collect();
    if heights.iter().all(|height| *height >= 0.0) {
        return Cut::Whole;
    }
    let corner = |vertex: usize| -> (f64, Corner) {
        let values = attributes
            .iter()
            .flat_map(|(_, values)| values[vertex].iter().copied());
        (heights[vertex], values.collect())
    };
    let indices: Vec<usize> = match mesh.indices() {
        Some(indices) => indices.iter().collect(),
        None => (0..mesh.count_vertices()).collect(),
    };
    let mut corners: Vec<Corner> = Vec::new();
    for triangle in indices.as_chunks::<3>().0 {
        let polygon = in_front(triangle.map(corner));
        for i in 2..polygon.len() {
            corners.extend([0, i - 1, i].map(|i| polygon[i].clone()));
        }
    }
    if corners.is_empty() {
        return Cut::Nothing;
    }
    let count = corners.len() as u32;
    let mut part = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    );
    let mut start = 0;
    for (attribute, values) in attributes {
        let end = start + values[0].len();
        part.insert_attribute(
            attribute,
            packed(corners.iter().map(|corner| &corner[start..end])),
        );
        start = end;
    }
    part.insert_indices(Indices::U32((0..count).collect()));
    Cut::Part(Box::new(part))
}

/// Sutherland and Hodgman, one plane: the part of a triangle whose height is not negative.
fn in_front(triangle: [(f64, Corner); 3]) -> Vec<Corner> {
    let mut polygon = Vec::new();
    for i in 0..3 {
        let ((height, here), (next_height, next)) = (&triangle[i], &triangle[(i + 1) % 3]);
        if *height >= 0.0 {
            polygon.push(here.clone());
        }
        if (*height >= 0.0) != (*next_height >= 0.0) {
            let t = height / (height - next_height);
            polygon.push(
                here.iter()
                    .zip(next)
                    .map(|(a, b)| a + (b - a) * t)
                    .collect(),
            );
        }
    }
    polygon
}

fn floats(values: &VertexAttributeValues) -> Vec<Vec<f64>> {
    fn widen<const N: usize>(values: &[[f32; N]]) -> Vec<Vec<f64>> {
        values
            .iter()
            .map(|value| value.iter().map(|v| f64::from(*v)).collect())
            .collect()
    }
    match values {
        VertexAttributeValues::Float32x2(values) => widen(values),
        VertexAttributeValues::Float32x3(values) => widen(values),
        VertexAttributeValues::Float32x4(values) => widen(values),
        other => panic!("{other:?} cannot be interpolated here"),
    }
}

fn packed<'a>(corners: impl ExactSizeIterator<Item = &'a [f64]> + Clone) -> VertexAttributeValues {
    fn narrow<'a, const N: usize>(corners: impl Iterator<Item = &'a [f64]>) -> Vec<[f32; N]> {
        corners
            .map(|corner| std::array::from_fn(|i| corner[i] as f32))
            .collect()
    }
    match corners.clone().next().map(<[f64]>::len) {
        Some(2) => VertexAttributeValues::Float32x2(narrow(corners)),
        Some(3) => VertexAttributeValues::Float32x3(narrow(corners)),
        _ => VertexAttributeValues::Float32x4(narrow(corners)),
    }
}
