//! The meshes of a glTF file.
//!
//! A primitive takes the vertices that its indices name, whatever else its accessors hold. Primitives
//! of a mesh share them.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use glam::{DAffine3, DVec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Mesh};

use super::attribute;
use super::buffers::{Buffers, Elements};
use super::pose::{Displacement, Influences, Pose, has_joints, influence_accessors, turn};
use crate::error::{Fault, check_position};
use crate::normals::NO_NORMAL;
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use crate::skipped::Skipped;

/// Reads meshes, each once. What is looked up for an accessor is looked up once a file.
pub(super) struct MeshReader<'a> {
    buffers: &'a Buffers<'a>,
    vectors: HashMap<usize, Rc<Elements<'a, 3>>>,
    /// Vertices by the accessors that their positions are made of, the first of which holds them.
    positions: HashMap<Vec<usize>, Table>,
    normals: HashMap<Vec<usize>, Table>,
    /// Accessors whose indices have been used; of primitives without any that of the positions.
    used: HashSet<(bool, usize)>,
    /// The number of the mesh that is read.
    part: u32,
    /// Vertices of primitives that are points or lines.
    pub(super) points: usize,
    pub(super) report: LoadReport,
    pub(super) skipped: Skipped,
}

/// Where the elements of accessors are in a mesh.
struct Table {
    /// The mesh that last used an element, and its number there.
    slots: Vec<(u32, u32)>,
}

/// No mesh.
const UNUSED: u32 = u32::MAX;

impl Table {
    fn new(count: usize) -> Table {
        Table {
            slots: vec![(UNUSED, 0); count],
        }
    }

    /// The number of an element in a mesh's array; `make` makes it if it is not there yet.
    fn number(
        &mut self,
        element: usize,
        part: u32,
        array: &mut Vec<DVec3>,
        make: impl FnOnce() -> Result<DVec3, String>,
    ) -> Result<u32, String> {
        let slot = &mut self.slots[element];
        if slot.0 != part {
            let number = u32::try_from(array.len());
            let number = number.map_err(|_| "the mesh has too many vertices".to_owned())?;
            array.push(make()?);
            *slot = (part, number);
        }
        Ok(slot.1)
    }
}

/// What the vertices of a primitive are made of.
struct Recipe<'a> {
    positions: Rc<Elements<'a, 3>>,
    normals: Option<Rc<Elements<'a, 3>>>,
    displacements: Vec<Displacement<'a>>,
    influences: Option<Influences<'a>>,
    /// The accessors that positions and normals are made of.
    position_key: Vec<usize>,
    normal_key: Vec<usize>,
}

impl<'a> MeshReader<'a> {
    pub(super) fn new(buffers: &'a Buffers<'a>, skipped: Skipped) -> MeshReader<'a> {
        MeshReader {
            buffers,
            vectors: HashMap::new(),
            positions: HashMap::new(),
            normals: HashMap::new(),
            used: HashSet::new(),
            part: 0,
            points: 0,
            report: LoadReport::default(),
            skipped,
        }
    }

    /// Reads a mesh with all its primitives, in this pose.
    pub(super) fn read(
        &mut self,
        index: usize,
        mesh: &Mesh,
        pose: &Pose,
    ) -> Result<RawMesh, Fault> {
        let mut part = Part::default();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let named = |what: String| {
                let name = mesh.name.as_deref().unwrap_or_default();
                Fault::Content(format!("mesh {index} {name:?}, primitive {number}: {what}"))
            };
            if let Err(wrong) = self.add(primitive, pose, &mut part, &named) {
                match wrong {
                    Wrong::Primitive(what) => self.skipped.skip("the primitive", named(what))?,
                    Wrong::File(fault) => return Err(fault),
                }
            }
        }
        self.part += 1;
        let mut raw = part.raw;
        raw.normal_corners = (!raw.normals.is_empty()).then_some(part.normal_corners);
        Ok(raw)
    }

    /// Elements of accessors that no primitive names.
    pub(super) fn unused_vertices(&self) -> u64 {
        let mut used: HashMap<usize, Vec<bool>> = HashMap::new();
        for (key, table) in &self.positions {
            let used = used.entry(key[0]).or_default();
            used.resize(table.slots.len(), false);
            for (used, slot) in used.iter_mut().zip(&table.slots) {
                *used |= slot.0 != UNUSED;
            }
        }
        let unused = |used: &Vec<bool>| used.iter().filter(|used| !**used).count() as u64;
        used.values().map(unused).sum()
    }

    fn add(
        &mut self,
        primitive: &Primitive,
        pose: &Pose,
        part: &mut Part,
        named: &dyn Fn(String) -> Fault,
    ) -> Result<(), Wrong> {
        let Checked::Valid(mode) = primitive.mode else {
            return Err("its mode is unknown".to_owned().into());
        };
        if !matches!(
            mode,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            self.report.skipped_elements += 1;
            if let Some(positions) = attribute(primitive, Semantic::Positions)
                && let Ok(positions) = self.vectors(positions)
            {
                self.points += positions.len();
            }
            return Ok(());
        }
        let recipe = self.recipe(primitive, pose)?;
        let order = self.order(primitive, recipe.positions.len(), recipe.position_key[0])?;
        let left_over = order.len() % 3;
        if mode == Mode::Triangles && left_over != 0 {
            let what = format!("its {} corners are no whole triangles", order.len());
            self.skipped
                .skip(&format!("the last {left_over}"), named(what))?;
        }
        for triangle in triangles(mode, &order) {
            if let Err(what) = self.triangle(triangle, &recipe, part) {
                self.skipped.skip("the triangle", named(what))?;
            }
        }
        Ok(())
    }

    fn triangle(
        &mut self,
        triangle: [u32; 3],
        recipe: &Recipe<'_>,
        part: &mut Part,
    ) -> Result<(), String> {
        let count = recipe.positions.len();
        if let Some(index) = triangle.iter().find(|&&i| i as usize >= count) {
            return Err(format!(
                "it names vertex {index}, but there are only {count} (0 is the first)"
            ));
        }
        let mut corners = [0; 3];
        let mut normals = [NO_NORMAL; 3];
        for (k, element) in triangle.map(|i| i as usize).into_iter().enumerate() {
            let table = self.positions.get_mut(&recipe.position_key);
            let table = table.ok_or("its positions have no table")?;
            corners[k] = table.number(element, self.part, &mut part.raw.positions, || {
                recipe.position(element)
            })?;
            let Some(of_normals) = &recipe.normals else {
                continue;
            };
            let table = self.normals.get_mut(&recipe.normal_key);
            let table = table.ok_or("its normals have no table")?;
            normals[k] = table.number(element, self.part, &mut part.raw.normals, || {
                recipe.normal(element, of_normals)
            })?;
        }
        if recipe.is_mirrored(triangle[0] as usize) {
            corners.swap(1, 2);
            normals.swap(1, 2);
        }
        part.raw.corners.push(corners);
        part.normal_corners.push(normals);
        self.report.polygons += 1;
        Ok(())
    }

    /// The elements that a primitive's corners name, one after the other.
    fn order(
        &mut self,
        primitive: &Primitive,
        count: usize,
        positions: usize,
    ) -> Result<Vec<u32>, String> {
        let Some(accessor) = primitive.indices else {
            if !self.used.insert((false, positions)) {
                self.buffers.allow_again(count)?;
            }
            let count = u32::try_from(count);
            let count = count.map_err(|_| "the mesh has too many vertices".to_owned())?;
            return Ok((0..count).collect());
        };
        let indices = self.buffers.elements::<1>(accessor, Type::Scalar)?;
        let named = |what| format!("accessor {}: {what}", accessor.value());
        if self.used.insert((true, self.buffers.first_same(accessor))) {
            self.buffers.allow(indices.len(), 1).map_err(named)?;
        } else {
            self.buffers.allow_again(indices.len()).map_err(named)?;
        }
        // Whole numbers of 32 bits are exact in double precision.
        let index = |[i]: [f64; 1]| (i >= 0.0 && i.fract() == 0.0).then_some(i as u32);
        let all = (0..indices.len()).map(|k| index(indices.get(k)));
        all.collect::<Option<_>>()
            .ok_or_else(|| named("an index is negative or no whole number".into()))
    }

    /// What the vertices of a primitive are made of.
    fn recipe(&mut self, primitive: &Primitive, pose: &Pose) -> Result<Recipe<'a>, String> {
        let of_positions = attribute(primitive, Semantic::Positions);
        let of_positions = of_positions.ok_or("it has no positions")?;
        let positions = self.vectors(of_positions)?;
        let count = positions.len();
        let mut position_key = vec![self.buffers.first_same(of_positions)];
        let of_normals = attribute(primitive, Semantic::Normals);
        let normals = of_normals.map(|n| self.vectors(n)).transpose()?;
        let mut normal_key: Vec<usize> = Vec::new();
        normal_key.extend(of_normals.map(|n| self.buffers.first_same(n)));
        if let Some(normals) = &normals
            && normals.len() != count
        {
            let normals = normals.len();
            return Err(format!("it has {normals} normals for {count} positions"));
        }
        let mut displacements = Vec::new();
        let targets = primitive.targets.iter().flatten();
        for (target, &weight) in targets.zip(&pose.weights) {
            if weight == 0.0 {
                continue;
            }
            let positions = target.positions.map(|p| self.vectors(p)).transpose()?;
            let normals = target.normals.map(|n| self.vectors(n)).transpose()?;
            for elements in positions.iter().chain(&normals) {
                if elements.len() != count {
                    let length = elements.len();
                    return Err(format!(
                        "a morph target has {length} elements for {count} positions"
                    ));
                }
            }
            let number = |accessor: Option<Index<Accessor>>| {
                accessor.map_or(usize::MAX, |accessor| accessor.value())
            };
            position_key.push(number(target.positions));
            normal_key.push(number(target.normals));
            displacements.push(Displacement {
                weight,
                positions,
                normals,
            });
        }
        let influences = match &pose.skin {
            None => None,
            Some(skin) => {
                for accessors in influence_accessors(primitive) {
                    let accessors = accessors.map(|accessor| accessor.value());
                    position_key.extend(accessors);
                    normal_key.extend(accessors);
                }
                let matrices = match has_joints(primitive) {
                    true => skin.matrices.clone(),
                    false => Rc::from([skin.node]),
                };
                let buffers = self.buffers;
                Some(Influences::new(primitive, count, matrices, buffers)?)
            }
        };
        self.make_tables(
            count,
            &position_key,
            normals.is_some().then_some(&normal_key),
        )?;
        Ok(Recipe {
            positions,
            normals,
            displacements,
            influences,
            position_key,
            normal_key,
        })
    }

    fn make_tables(
        &mut self,
        count: usize,
        position_key: &Vec<usize>,
        normal_key: Option<&Vec<usize>>,
    ) -> Result<(), String> {
        let tables = [
            (&mut self.positions, Some(position_key)),
            (&mut self.normals, normal_key),
        ];
        for (tables, key) in tables {
            if let Some(key) = key
                && !tables.contains_key(key)
            {
                let named = |what| format!("accessor {}: {what}", key[0]);
                self.buffers.allow(count, 3).map_err(named)?;
                tables.insert(key.clone(), Table::new(count));
            }
        }
        Ok(())
    }

    fn vectors(&mut self, accessor: Index<Accessor>) -> Result<Rc<Elements<'a, 3>>, String> {
        let number = self.buffers.first_same(accessor);
        if let Some(known) = self.vectors.get(&number) {
            return Ok(known.clone());
        }
        let elements = Rc::new(self.buffers.elements(accessor, Type::Vec3)?);
        self.vectors.insert(number, elements.clone());
        Ok(elements)
    }
}

impl Recipe<'_> {
    fn position(&self, element: usize) -> Result<DVec3, String> {
        let mut position = DVec3::from(self.positions.get(element));
        for displacement in &self.displacements {
            if let Some(positions) = &displacement.positions {
                position += displacement.weight * DVec3::from(positions.get(element));
            }
        }
        if let Some(matrix) = self.matrix(element)? {
            position = matrix.transform_point3(position);
        }
        match check_position(element, position) {
            Ok(()) => Ok(position),
            Err(wrong) => Err(wrong.to_string()),
        }
    }

    fn normal(&self, element: usize, normals: &Elements<'_, 3>) -> Result<DVec3, String> {
        let stored = DVec3::from(normals.get(element));
        let mut normal = stored;
        for displacement in &self.displacements {
            if let Some(normals) = &displacement.normals {
                normal += displacement.weight * DVec3::from(normals.get(element));
            }
        }
        if !self.displacements.is_empty() {
            // As long as it was: its length is checked later.
            normal = normal.normalize_or_zero() * stored.length();
        }
        Ok(match self.matrix(element)? {
            Some(matrix) => turn(&matrix, normal),
            None => normal,
        })
    }

    fn matrix(&self, element: usize) -> Result<Option<DAffine3>, String> {
        let influences = self.influences.as_ref();
        influences.map(|all| all.matrix(element)).transpose()
    }

    /// Whether what moves a vertex mirrors: then the triangle winds the other way, so that its front
    /// stays the front.
    fn is_mirrored(&self, element: usize) -> bool {
        let matrix = self.matrix(element);
        matches!(matrix, Ok(Some(matrix)) if matrix.matrix3.determinant() < 0.0)
    }
}

/// A mesh on its way.
#[derive(Default)]
struct Part {
    raw: RawMesh,
    normal_corners: Vec<[u32; 3]>,
}

/// What ends the reading of a primitive.
enum Wrong {
    /// The primitive is wrong.
    Primitive(String),
    /// The file is refused.
    File(Fault),
}

impl From<String> for Wrong {
    fn from(what: String) -> Wrong {
        Wrong::Primitive(what)
    }
}

impl From<Fault> for Wrong {
    fn from(fault: Fault) -> Wrong {
        Wrong::File(fault)
    }
}

/// The triangles of vertices in a row.
pub(super) fn triangles(mode: Mode, order: &[u32]) -> Vec<[u32; 3]> {
    let windows = || order.windows(3).enumerate();
    match mode {
        Mode::TriangleStrip => windows()
            .map(|(k, w)| {
                if k % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[1], w[0], w[2]]
                }
            })
            // Two equal corners only turn the strip.
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect(),
        Mode::TriangleFan => order
            .get(1..)
            .unwrap_or_default()
            .windows(2)
            .map(|w| [order[0], w[0], w[1]])
            .collect(),
        _ => order.as_chunks::<3>().0.to_vec(),
    }
}
