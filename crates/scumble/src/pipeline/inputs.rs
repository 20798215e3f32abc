//! What the host feeds: textures of its own, by the names of the graph's `inputs`.

use super::build::Wire;
use super::{Built, NameError, Pipeline};
use crate::diagnostics::hint;
use crate::signal::Signal;

impl Pipeline {
    /// Feeds an input of the graph with a texture that is known to carry `signal`: [`Pipeline::bind_input`], and a texture of another
    /// signal is refused even where its format fits (a distance is no `view_z`).
    ///
    /// # Errors
    /// No such input, or a texture of another signal, format, shape or usage. One of the wrong size is an error of the next frame,
    /// since [`Pipeline::resize`] may come between.
    ///
    /// ```
    /// # use scumble::{Camera, Registry};
    /// # fn engine(
    /// #     (device, queue): (wgpu::Device, wgpu::Queue),
    /// #     registry: Registry,
    /// #     [noisy, depth, normals, motion]: [wgpu::Texture; 4],
    /// #     [camera, previous_camera]: [Camera; 2],
    /// # ) -> Result<(), Box<dyn std::error::Error>> {
    /// use scumble::{Edits, FrameInput, Host, Pipeline, resolve, signal};
    ///
    /// let graph = resolve("graphs/denoise-svgf.ron", &registry, &Edits::default())?;
    /// let mut host = Host::new();
    /// let mut pipeline = Pipeline::new(&device, &queue, &registry, graph, &host, [1920, 1080])?;
    /// // Once: the engine goes on writing these textures, frame after frame.
    /// pipeline.bind_signal("radiance", signal::RADIANCE, &noisy)?;
    /// pipeline.bind_signal("view_z", signal::VIEW_Z, &depth)?;
    /// pipeline.bind_signal("normal", signal::NORMAL, &normals)?;
    /// pipeline.bind_signal("motion", signal::MOTION, &motion)?;
    /// // `albedo` and other optional inputs stay unbound where the engine has none.
    ///
    /// let mut encoder = device.create_command_encoder(&Default::default());
    /// let input = FrameInput { frame: 1, previous_camera, ..FrameInput::still(camera) };
    /// pipeline.render(&mut encoder, &input, &mut host)?;
    /// queue.submit([encoder.finish()]);
    /// let denoised = pipeline.output("linear");
    /// # Ok(())
    /// # }
    /// ```
    pub fn bind_signal(
        &mut self,
        name: &str,
        signal: Signal,
        texture: &wgpu::Texture,
    ) -> Result<(), NameError> {
        let takes = self.resolved.inputs[self.find_input(name)?].signal;
        if takes != signal {
            return Err(refused(
                name,
                format!("it takes {takes}, and the texture carries {signal}"),
            ));
        }
        self.bind_input(name, texture)
    }

    /// Feeds an input no longer: an optional one is as if it were not wired, any other is an error of the next frame.
    ///
    /// # Errors
    /// No such input.
    pub fn unbind_input(&mut self, name: &str) -> Result<(), NameError> {
        let i = self.find_input(name)?;
        if self.inputs[i].take().is_some() {
            self.input_changed(i);
        }
        Ok(())
    }

    pub(super) fn find_input(&self, name: &str) -> Result<usize, NameError> {
        let inputs = &self.resolved.inputs;
        let found = inputs.iter().position(|input| input.name == name);
        found.ok_or_else(|| NameError::Unknown {
            kind: "graph input",
            name: name.to_owned(),
            hint: hint(name, inputs.iter().map(|input| input.name.as_str())),
        })
    }

    /// What reads an input has another source upstream.
    pub(super) fn input_changed(&mut self, i: usize) {
        let wired = Some(Wire::Input(i));
        let reads = |built: &Built| built.wires.contains(&wired);
        let readers: Vec<usize> = (0..self.passes.len())
            .filter(|&p| reads(&self.passes[p]))
            .collect();
        let what = format!("graph input {}", self.resolved.inputs[i].name);
        self.revisions.source_changed(&readers, &what);
    }
}

/// Whether a texture is of the shape and format of a signal; why not, otherwise.
pub(super) fn check_texture(signal: Signal, texture: &wgpu::Texture) -> Result<(), String> {
    if texture.format() != signal.format() && texture.format() != signal.precise_format() {
        return Err(format!(
            "it carries {signal}, which is {:?}, and not {:?}",
            signal.format(),
            texture.format()
        ));
    }
    if texture.dimension() != wgpu::TextureDimension::D2 || texture.depth_or_array_layers() != 1 {
        return Err("the texture is not a single 2D image".to_owned());
    }
    if texture.sample_count() != 1 {
        return Err(format!(
            "the texture has {} samples per texel; resolve it first",
            texture.sample_count()
        ));
    }
    if !texture
        .usage()
        .contains(wgpu::TextureUsages::TEXTURE_BINDING)
    {
        return Err("the texture lacks the usage TEXTURE_BINDING".to_owned());
    }
    Ok(())
}

pub(super) fn refused(name: &str, message: String) -> NameError {
    NameError::Texture {
        name: name.to_owned(),
        message,
    }
}
