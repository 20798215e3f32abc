//! All material textures in the layers of one texture array.
//!
//! Adapters without binding arrays can still address any texture from any ray: each image is a
//! rectangle on a page, and the shader does the wrapping and filtering (`scene/texture.wgsl`).

use super::GpuSceneError;
use crate::{Scene, TextureImage};
use std::borrow::Cow;

/// Pages are never larger: a page is the granularity of waste.
const MAX_PAGE: u32 = 2048;

/// Where an image lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    pub page: u32,
    pub origin: [u32; 2],
    pub size: [u32; 2],
}

/// The atlas texture and where each image of the scene is in it.
pub(crate) struct Atlas {
    pub texture: wgpu::Texture,
    /// By texture of the scene; `None` when no material uses it.
    pub places: Vec<Option<Place>>,
    pub warnings: Vec<String>,
}

impl Atlas {
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
    ) -> Result<Self, GpuSceneError> {
        let limits = device.limits();
        let largest = MAX_PAGE.min(limits.max_texture_dimension_2d);
        let mut used = vec![false; scene.textures.len()];
        for reference in scene.materials.iter().flat_map(|m| m.texture_refs()) {
            used[reference.texture as usize] = true;
        }
        let mut warnings = Vec::new();
        let mut images: Vec<Option<Cow<TextureImage>>> = Vec::new();
        for (image, used) in scene.textures.iter().zip(used) {
            images.push(used.then(|| fit(image, largest, &mut warnings)));
        }

        let sizes: Vec<Option<[u32; 2]>> = images
            .iter()
            .map(|image| image.as_ref().map(|i| [i.width, i.height]))
            .collect();
        let (page, pages, places) = pack(&sizes, largest);
        if pages > limits.max_texture_array_layers {
            return Err(GpuSceneError::TooManyTextures {
                pages,
                size: page,
                limit: limits.max_texture_array_layers,
            });
        }
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("scene atlas"),
            size: wgpu::Extent3d {
                width: page,
                height: page,
                depth_or_array_layers: pages,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (image, place) in images.iter().zip(&places) {
            if let (Some(image), Some(place)) = (image, place) {
                upload(queue, &texture, image, place);
            }
        }
        Ok(Self {
            texture,
            places,
            warnings,
        })
    }

    pub fn bytes(&self) -> u64 {
        let size = self.texture.size();
        4 * u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers)
    }
}

fn upload(queue: &wgpu::Queue, texture: &wgpu::Texture, image: &TextureImage, place: &Place) {
    queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d {
                x: place.origin[0],
                y: place.origin[1],
                z: place.page,
            },
            aspect: wgpu::TextureAspect::All,
        },
        &image.rgba8,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * image.width),
            rows_per_image: None,
        },
        wgpu::Extent3d {
            width: image.width,
            height: image.height,
            depth_or_array_layers: 1,
        },
    );
}

/// Shelf packing, tallest first: the size of a page, the number of pages, and the places.
///
/// A page is a power of two, the smallest that needs one page only, else `largest`.
fn pack(sizes: &[Option<[u32; 2]>], largest: u32) -> (u32, u32, Vec<Option<Place>>) {
    let widest = sizes.iter().flatten().flatten().copied().max().unwrap_or(1);
    let mut page = widest.next_power_of_two().min(largest);
    let mut order: Vec<usize> = (0..sizes.len()).filter(|&i| sizes[i].is_some()).collect();
    order.sort_by_key(|&i| {
        let [w, h] = sizes[i].unwrap_or_default();
        std::cmp::Reverse((h, w))
    });
    loop {
        let (pages, places) = shelves(sizes, &order, page);
        if pages == 1 || page == largest {
            return (page, pages, places);
        }
        page = (2 * page).min(largest);
    }
}

fn shelves(
    sizes: &[Option<[u32; 2]>],
    order: &[usize],
    page_size: u32,
) -> (u32, Vec<Option<Place>>) {
    let mut places = vec![None; sizes.len()];
    let (mut page, mut x, mut y, mut shelf) = (0, 0, 0, 0);
    for &i in order {
        let Some([w, h]) = sizes[i] else { continue };
        if x + w > page_size {
            y += shelf;
            (x, shelf) = (0, 0);
        }
        if y + h > page_size {
            page += 1;
            (x, y, shelf) = (0, 0, 0);
        }
        places[i] = Some(Place {
            page,
            origin: [x, y],
            size: [w, h],
        });
        x += w;
        shelf = shelf.max(h);
    }
    (page + 1, places)
}

/// The image, or where it is larger than a page the mean of its blocks, in linear light.
fn fit<'a>(
    image: &'a TextureImage,
    largest: u32,
    warnings: &mut Vec<String>,
) -> Cow<'a, TextureImage> {
    let k = image.width.max(image.height).div_ceil(largest);
    if k <= 1 {
        return Cow::Borrowed(image);
    }
    let (width, height) = (image.width.div_ceil(k), image.height.div_ceil(k));
    warnings.push(format!(
        "texture '{}' of {} x {} texels is larger than {largest} and was reduced to {width} x {height}",
        image.name, image.width, image.height
    ));
    let mut rgba8 = Vec::with_capacity(4 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let mut sum = [0.0_f32; 4];
            let mut count = 0.0;
            for v in y * k..((y + 1) * k).min(image.height) {
                for u in x * k..((x + 1) * k).min(image.width) {
                    let texel = linear_texel(image, u, v);
                    for (s, t) in sum.iter_mut().zip(texel) {
                        *s += t;
                    }
                    count += 1.0;
                }
            }
            for (c, s) in sum.iter().enumerate() {
                let mean = s / count;
                let coded = if image.srgb && c < 3 {
                    linear_to_srgb(mean)
                } else {
                    mean
                };
                rgba8.push((coded * 255.0).round() as u8);
            }
        }
    }
    Cow::Owned(TextureImage {
        name: image.name.clone(),
        width,
        height,
        rgba8,
        ..*image
    })
}

/// A texel as linear values in [0, 1].
pub(crate) fn linear_texel(image: &TextureImage, x: u32, y: u32) -> [f32; 4] {
    let at = 4 * (y as usize * image.width as usize + x as usize);
    std::array::from_fn(|c| {
        let coded = f32::from(image.rgba8[at + c]) / 255.0;
        if image.srgb && c < 3 {
            srgb_to_linear(coded)
        } else {
            coded
        }
    })
}

fn srgb_to_linear(c: f32) -> f32 {
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

fn linear_to_srgb(c: f32) -> f32 {
    if c <= 0.0031308 {
        c * 12.92
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn packed_images_stay_on_their_page_and_apart(
            sizes in proptest::collection::vec((1_u32..200, 1_u32..200), 0..40),
        ) {
            let sizes: Vec<Option<[u32; 2]>> = sizes.iter().map(|&(w, h)| Some([w, h])).collect();
            let (page, pages, places) = pack(&sizes, 256);
            let places: Vec<Place> = places.into_iter().flatten().collect();
            prop_assert_eq!(places.len(), sizes.len());
            for (i, a) in places.iter().enumerate() {
                prop_assert!(a.page < pages);
                prop_assert!((0..2).all(|k| a.origin[k] + a.size[k] <= page));
                for b in &places[..i] {
                    let apart = a.page != b.page
                        || (0..2).any(|k| a.origin[k] + a.size[k] <= b.origin[k]
                            || b.origin[k] + b.size[k] <= a.origin[k]);
                    prop_assert!(apart, "{a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn an_image_larger_than_a_page_is_reduced_to_block_means() {
        let image = TextureImage {
            name: "checker".into(),
            width: 4,
            height: 2,
            rgba8: [[0, 0, 0, 255], [255, 255, 255, 255]].concat().repeat(4),
            ..TextureImage::default()
        };
        let mut warnings = Vec::new();
        let reduced = fit(&image, 2, &mut warnings);
        assert_eq!((reduced.width, reduced.height), (2, 1));
        assert_eq!(reduced.rgba8, [128, 128, 128, 255].repeat(2));
        assert_eq!(warnings.len(), 1);
    }
}
