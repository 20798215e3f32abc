//! Posing a scene: transforms, deformed meshes, the top level of the BVH, lights.

use super::geometry::{self, Tree, check_depth, leaf_triangles, posed, vertex_records};
use super::layout::{Info, InstanceRecord, NONE, rows};
use super::lights::{LightList, Lights};
use super::{Draw, GpuScene, GpuSceneError, State, materials};
use crate::bvh::{BuildQuality, Bvh, NODE_BYTES, transformed_bounds};
use crate::check::keeps_volume;
use crate::{Deformed, Light, Mesh, Pose};
use glam::{Affine3A, Vec3};

/// `FIRST_INSTANCE` of `scene/trace.wgsl`.
const FIRST_INSTANCE: u32 = 1 << 31;

/// Bytes of a word of `scene_data`.
const WORD: u64 = 16;

impl GpuScene {
    /// Poses the scene at `time` seconds and remembers where it was before.
    ///
    /// Call it once a frame: between two calls lies what the motion vectors show, so calling it
    /// again with the same time brings everything to rest. The first call after
    /// [`new`](Self::new) shows no motion but that of
    /// [`Instance::previous_transform`](crate::Instance::previous_transform).
    ///
    /// # Errors
    /// When a deformed mesh or the instances do not fit the device, or `time` is not finite.
    pub fn update(&mut self, time: f32) -> Result<(), GpuSceneError> {
        if !time.is_finite() {
            return Err(GpuSceneError::Invalid(format!("time is {time}")));
        }
        let fresh = std::mem::take(&mut self.state.fresh);
        if time == self.state.time {
            if !fresh && self.state.moving {
                self.come_to_rest();
            }
            return Ok(());
        }
        let pose = self.scene.pose(time);
        let before = std::mem::take(&mut self.state);
        let (previous_transforms, previous_deformed) = if fresh {
            (pose.instances.clone(), pose.deformed.clone())
        } else {
            (before.transforms, before.deformed)
        };
        self.apply(time, pose, previous_transforms, &previous_deformed)?;
        self.revision += 1;
        Ok(())
    }

    /// Places the instances and the lights, for a host that moves them itself, as many as the scene has; what deforms stays as
    /// it is.
    ///
    /// Call it once a frame, in place of [`update`](Self::update): the motion vectors show what lies between two calls, so
    /// calling it again with the same places brings everything to rest.
    ///
    /// # Errors
    /// When there are more or fewer of them, when one moves that [`new`](Self::new) put into the BVH of what stands still
    /// ([`GpuSceneOptions::still_triangles`](super::GpuSceneOptions::still_triangles) 0 keeps all free to move), or when they do
    /// not fit the device.
    pub fn place(&mut self, instances: &[Affine3A], lights: &[Light]) -> Result<(), GpuSceneError> {
        let state = &self.state;
        let counts = [instances.len(), lights.len()];
        let expected = [state.transforms.len(), state.lights.len()];
        if counts != expected {
            return Err(GpuSceneError::Invalid(format!(
                "{} instances and {} lights are placed, and the scene has {} and {}",
                counts[0], counts[1], expected[0], expected[1]
            )));
        }
        let changed = |i: &usize| state.transforms[*i] != instances[*i];
        if let Some(i) = (0..instances.len()).find(|i| self.still[*i] && changed(i)) {
            return Err(GpuSceneError::Invalid(format!(
                "instance {i} was put among what stands still, and moves: make the scene with still_triangles 0"
            )));
        }
        let same_places = state.transforms == instances;
        if same_places && state.lights == lights {
            if state.moving && !std::mem::take(&mut self.state.fresh) {
                self.come_to_rest();
            }
            return Ok(());
        }
        let before = std::mem::take(&mut self.state);
        let pose = Pose {
            instances: instances.to_vec(),
            deformed: before.deformed.clone(),
            lights: lights.to_vec(),
            cameras: before.cameras,
        };
        self.apply(before.time, pose, before.transforms, &before.deformed)?;
        self.revision += 1;
        Ok(())
    }

    /// Puts the first pose, that of time 0, on the GPU.
    pub(super) fn pose_first(&mut self, pose: Pose) -> Result<(), GpuSceneError> {
        let previous = self
            .scene
            .instances
            .iter()
            .zip(&pose.instances)
            .map(|(instance, now)| match instance.node {
                None => instance.previous_transform,
                Some(_) => *now,
            })
            .collect();
        let deformed = pose.deformed.clone();
        self.apply(0.0, pose, previous, &deformed)?;
        self.state.fresh = true;
        Ok(())
    }

    /// Puts a pose on the GPU.
    fn apply(
        &mut self,
        time: f32,
        pose: Pose,
        previous_transforms: Vec<Affine3A>,
        previous_deformed: &[Deformed],
    ) -> Result<(), GpuSceneError> {
        let mut tail = Vec::new();
        for deformed in &pose.deformed {
            self.upload_deformed(deformed, &mut tail)?;
        }
        self.upload_previous(previous_deformed);
        let moving =
            previous_transforms != pose.instances || previous_deformed != pose.deformed.as_slice();
        self.state = State {
            time,
            fresh: false,
            moving,
            transforms: pose.instances,
            previous_transforms,
            deformed: pose.deformed,
            lights: pose.lights,
            cameras: pose.cameras,
        };

        let mut records = self.instance_records();
        let tlas_root = self.build_top(&mut tail, &mut records)?;
        let first = u64::from(self.still_nodes) * NODE_BYTES;
        let bytes: &[u8] = bytemuck::cast_slice(&tail);
        let needed = first + bytes.len() as u64;
        if self.nodes.reserve(&self.device, &self.queue, needed)? {
            self.rebind();
        }
        self.nodes.write(&self.queue, first, bytes);

        let lights = self.collect_lights(&mut records);
        let at = u64::from(self.sections.lights) * WORD;
        self.data
            .write(&self.queue, at, bytemuck::cast_slice(&lights.words));
        self.instances
            .write(&self.queue, 0, bytemuck::cast_slice(&records));
        self.upload_info(tlas_root, &lights);
        self.draws = self.collect_draws(&records);
        Ok(())
    }

    /// Nothing moved since the last frame any more.
    fn come_to_rest(&mut self) {
        self.state.previous_transforms = self.state.transforms.clone();
        self.state.moving = false;
        let offset = std::mem::offset_of!(InstanceRecord, previous_world_from_object) as u64;
        for (i, transform) in self.state.transforms.iter().enumerate() {
            let at = (i * size_of::<InstanceRecord>()) as u64 + offset;
            self.instances
                .write(&self.queue, at, bytemuck::bytes_of(&rows(transform)));
        }
        self.upload_previous(&self.state.deformed);
    }

    fn upload_deformed(
        &mut self,
        deformed: &Deformed,
        tail: &mut Vec<u32>,
    ) -> Result<(), GpuSceneError> {
        let mesh = &self.scene.meshes[deformed.mesh as usize];
        let place = &mut self.places[deformed.mesh as usize];
        let quality = BuildQuality::VeryFast;
        let Some(tree) = Bvh::over_triangles(&deformed.positions, &mesh.indices, quality) else {
            return Ok(());
        };
        check_depth(&mesh.name, 0, tree.depth)?;
        let first = place.first_leaf;
        place.tree = Some(Tree {
            root: tree.append_to(tail, self.still_nodes, first),
            bounds: tree.bounds,
            depth: tree.depth,
        });
        let triangles = leaf_triangles(
            &tree,
            &deformed.positions,
            &mesh.indices,
            place.first_triangle,
            materials::flags(&self.scene.materials[mesh.material as usize]),
        );
        self.triangles.write(
            &self.queue,
            u64::from(first) * geometry::TRIANGLE_BYTES,
            bytemuck::cast_slice(&triangles),
        );
        let vertices: Vec<_> =
            vertex_records(&deformed.positions, &deformed.normals, &mesh.uvs).collect();
        self.vertices.write(
            &self.queue,
            u64::from(place.first_vertex) * geometry::VERTEX_BYTES,
            bytemuck::cast_slice(&vertices),
        );
        if place.tangents != NONE && deformed.tangents.len() == mesh.tangents.len() {
            let at = u64::from(self.sections.tangents + place.tangents) * WORD;
            self.data
                .write(&self.queue, at, bytemuck::cast_slice(&deformed.tangents));
        }
        Ok(())
    }

    fn upload_previous(&self, previous: &[Deformed]) {
        for deformed in previous {
            let place = &self.places[deformed.mesh as usize];
            let positions: Vec<[f32; 4]> = deformed
                .positions
                .iter()
                .map(|p| p.extend(1.0).to_array())
                .collect();
            let at = u64::from(self.sections.previous + place.previous) * WORD;
            self.data
                .write(&self.queue, at, bytemuck::cast_slice(&positions));
        }
    }

    /// The instances, with neither lights nor top level.
    fn instance_records(&self) -> Vec<InstanceRecord> {
        let transforms = self
            .state
            .transforms
            .iter()
            .zip(&self.state.previous_transforms);
        self.scene
            .instances
            .iter()
            .zip(transforms)
            .zip(&self.still)
            .map(|((instance, (now, previous)), still)| {
                let mesh = &self.scene.meshes[instance.mesh as usize];
                let place = &self.places[instance.mesh as usize];
                let offset = |base: u32, at: u32| if at == NONE { NONE } else { base + at };
                let root = if *still {
                    self.still_root
                } else {
                    place.tree.map_or(NONE, |tree| tree.root)
                };
                let seen = root != NONE && keeps_volume(now);
                InstanceRecord {
                    object_from_world: if seen {
                        rows(&now.inverse())
                    } else {
                        [[0.0; 4]; 3]
                    },
                    world_from_object: rows(now),
                    previous_world_from_object: rows(previous),
                    root: if seen { root } else { NONE },
                    first_triangle: place.first_triangle,
                    triangle_count: place.triangle_count,
                    material: mesh.material,
                    flags: materials::flags(&self.scene.materials[mesh.material as usize]),
                    first_light: NONE,
                    first_vertex: place.first_vertex,
                    previous_vertices: offset(self.sections.previous, place.previous),
                    tangents: offset(self.sections.tangents, place.tangents),
                    tlas_instance: NONE,
                    padding: [0; 2],
                }
            })
            .collect()
    }

    /// Builds the BVH over the instances; the index of its root, or `NONE`.
    fn build_top(
        &self,
        tail: &mut Vec<u32>,
        records: &mut [InstanceRecord],
    ) -> Result<u32, GpuSceneError> {
        let (mut seen, mut boxes, mut deepest) = (Vec::new(), Vec::new(), 0);
        for (i, record) in records.iter().enumerate() {
            let tree = self.places[self.scene.instances[i].mesh as usize].tree;
            if let Some(tree) = tree.filter(|_| record.root != NONE && !self.still[i]) {
                seen.push(i as u32);
                boxes.push(transformed_bounds(&tree.bounds, &self.state.transforms[i]));
                deepest = deepest.max(tree.depth);
            }
        }
        let Some(top) = Bvh::over_boxes(&boxes, BuildQuality::Medium) else {
            return Ok(NONE);
        };
        check_depth("the instances", top.depth, deepest)?;
        for (leaf, &i) in top.order.iter().enumerate() {
            records[leaf].tlas_instance = seen[i as usize];
        }
        Ok(top.append_to(tail, self.still_nodes, FIRST_INSTANCE))
    }

    fn collect_lights(&self, records: &mut [InstanceRecord]) -> LightList {
        let mut lights = Lights::new(self.radius);
        for (i, record) in records.iter_mut().enumerate() {
            let mesh_index = self.scene.instances[i].mesh as usize;
            let mesh = &self.scene.meshes[mesh_index];
            let material = &self.scene.materials[mesh.material as usize];
            if !material.is_emissive() {
                continue;
            }
            record.first_light = lights.len();
            let transform = &self.state.transforms[i];
            let mirrored = transform.matrix3.determinant() < 0.0;
            let positions = self.positions(mesh_index, mesh);
            let mean = material
                .emissive_texture
                .map_or(Vec3::ONE, |t| self.emissive_means[t.texture as usize]);
            for (triangle, corners) in (record.first_triangle..).zip(&mesh.indices) {
                let corners = corners.map(|v| transform.transform_point3(positions[v as usize]));
                lights.triangle(corners, [i as u32, triangle], material, mean, mirrored);
            }
        }
        for light in &self.state.lights {
            lights.punctual(light);
        }
        lights.finish(self.sky_data.luminance_integral)
    }

    fn positions<'a>(&'a self, index: usize, mesh: &'a Mesh) -> &'a [Vec3] {
        posed(&self.state.deformed, index).map_or(&mesh.positions, |d| &d.positions)
    }

    fn upload_info(&self, tlas_root: u32, lights: &LightList) {
        let sections = &self.sections;
        let info = Info {
            tlas_root,
            still_root: self.still_root,
            materials: sections.materials,
            texture_slots: sections.slots,
            lights: sections.lights,
            light_count: lights.count,
            sky_cells: sections.sky_cells,
            sky_probability: lights.sky_probability,
            sky_grid: self.sky_data.grid,
            sky_turn: self.sky_data.turn,
            sky_factor: self.sky_data.factor.to_array(),
            bounds_radius: self.radius,
        };
        self.queue
            .write_buffer(&self.info, 0, bytemuck::bytes_of(&info));
    }

    fn collect_draws(&self, records: &[InstanceRecord]) -> Vec<Draw> {
        records
            .iter()
            .enumerate()
            .filter(|(_, record)| record.root != NONE)
            .map(|(i, record)| {
                let mesh = &self.scene.meshes[self.scene.instances[i].mesh as usize];
                Draw {
                    instance: i as u32,
                    vertex_count: 3 * record.triangle_count,
                    first_index: 3 * record.first_triangle,
                    double_sided: self.scene.materials[mesh.material as usize].double_sided,
                    mirrored: self.state.transforms[i].matrix3.determinant() < 0.0,
                }
            })
            .collect()
    }
}
