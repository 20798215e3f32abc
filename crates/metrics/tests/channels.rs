//! Every channel of a file, by its name.

use scumble_metrics::{
    Channel, Channels, Image, MetricsError, read_channels, write_exr_channels, write_pfm, write_png,
};

fn channel(name: &str, values: &[f32]) -> Channel {
    Channel {
        name: name.to_owned(),
        values: values.to_vec(),
    }
}

#[test]
fn what_is_written_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let channels = Channels {
        width: 2,
        height: 1,
        list: vec![
            channel("R", &[0.5, f32::INFINITY]),
            channel("ViewLayer.Depth.Z", &[1e10, -2.0]),
            channel("nn.X", &[0.1, 7e4]),
        ],
        encoded: false,
    };
    write_exr_channels(&path, &channels).unwrap();
    assert_eq!(read_channels(&path).unwrap(), channels);
    let short = Channels {
        height: 2,
        ..channels
    };
    let error = write_exr_channels(&path, &short).unwrap_err();
    assert!(matches!(error, MetricsError::WrongLength { found: 2, .. }));
}

#[test]
fn other_files_are_three_channels() {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::from_fn(2, 2, |x, y| [x as f32, y as f32, 1.0]);
    let [pfm, png] = ["a.pfm", "a.png"].map(|name| folder.path().join(name));
    write_pfm(&pfm, &image).unwrap();
    write_png(&png, &image).unwrap();
    for (path, encoded) in [(&pfm, false), (&png, true)] {
        let found = read_channels(path).unwrap();
        assert_eq!(found.encoded, encoded);
        // 0 and 1 are what they are in 8 bits, too.
        assert_eq!(found.get("R"), Some(&[0.0, 1.0, 0.0, 1.0][..]));
        assert_eq!(found.get("G"), Some(&[0.0, 0.0, 1.0, 1.0][..]));
    }
    let error = read_channels(folder.path().join("a.tif")).unwrap_err();
    assert!(matches!(error, MetricsError::UnknownFormat { .. }));
}

/// Parts have names of their own, and may cover a part of the image or more than it.
#[test]
fn parts_stand_where_they_are_in_the_image() {
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image as Exr, ImageAttributes, Layer,
        LayerAttributes, Vec2, WritableImage,
    };
    let part = |name: &str, at: (i32, i32), size: (usize, usize), values: Vec<f32>| {
        let mut attributes = LayerAttributes::named(name);
        attributes.layer_position = Vec2(at.0, at.1);
        let list = [AnyChannel::new("Z", FlatSamples::F32(values))];
        let channels = AnyChannels::sort(list.into_iter().collect());
        Layer::new(size, attributes, Encoding::UNCOMPRESSED, channels)
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parts.exr");
    let parts = vec![
        part("inside", (1, 1), (2, 1), vec![5.0, 6.0]),
        part(
            "around",
            (-1, 0),
            (5, 2),
            (0..10).map(|v| v as f32).collect(),
        ),
    ];
    let image = Exr::from_layers(ImageAttributes::with_size((3, 2)), parts);
    image.write().to_file(&path).unwrap();
    let found = read_channels(&path).unwrap();
    assert_eq!((found.width, found.height), (3, 2));
    assert_eq!(
        found.get("inside.Z"),
        Some(&[0.0, 0.0, 0.0, 0.0, 5.0, 6.0][..])
    );
    assert_eq!(
        found.get("around.Z"),
        Some(&[1.0, 2.0, 3.0, 6.0, 7.0, 8.0][..])
    );
}
