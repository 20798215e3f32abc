//! Values on the command line that are more than one word or number.

use scumble_lab::Shard;

pub fn parse_shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').map(|(i, n)| (i.parse(), n.parse()));
    match numbers {
        Some((Ok(index), Ok(count))) if (1..=count).contains(&index) => Ok(Shard { index, count }),
        _ => Err("give the part and how many there are, such as 1/4".into()),
    }
}

pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let form = || "give width and height in pixels, such as 1280x720".to_owned();
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(form)?;
    let side = |text: &str| text.parse::<u32>().map_err(|_| form());
    let size = [side(width)?, side(height)?];
    if size.contains(&0) {
        return Err("width and height must be at least 1".into());
    }
    Ok(size)
}

pub fn parse_step(text: &str) -> Result<[f32; 3], String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if x.is_finite() && y.is_finite() && z.is_finite() => Ok([x, y, z]),
        _ => Err("give three numbers: x,y,z".into()),
    }
}

pub fn parse_seconds(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(seconds) if seconds.is_finite() && seconds >= 0.0 => Ok(seconds),
        _ => Err("give seconds, 0 or more".into()),
    }
}

pub fn parse_positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a number above 0".into()),
    }
}

pub fn parse_port(text: &str) -> Result<String, String> {
    match text.split_once('.') {
        Some((pass, port)) if !pass.is_empty() && !port.is_empty() => Ok(text.to_owned()),
        _ => Err("give pass.port, such as gbuffer.normal".into()),
    }
}

pub fn parse_map(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("give input=file, such as radiance=beauty.####.exr".into()),
    }
}

pub fn parse_fov(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(fov) if fov > 0.0 && fov < 180.0 => Ok(fov),
        _ => Err("give degrees between 0 and 180".into()),
    }
}

pub fn parse_set(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !value.trim().is_empty() && name.contains('.') => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("give pass.parameter=value, such as sparse-indirect.spacing=8".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        assert_eq!(
            parse_size("0x0").unwrap_err(),
            "width and height must be at least 1"
        );
        for text in ["", "640", "x", "-1x2", "1x2x3", "99999999999x1"] {
            assert!(
                parse_size(text).unwrap_err().contains("such as 1280x720"),
                "{text}"
            );
        }
    }

    #[test]
    fn steps() {
        assert_eq!(parse_step("0.5, -1,0"), Ok([0.5, -1.0, 0.0]));
        for text in ["", "1", "1,2", "1,2,3,4", "1,2,inf", "1,2,3,x", "a,b,c"] {
            assert!(parse_step(text).is_err(), "{text}");
        }
    }

    #[test]
    fn shards() {
        assert_eq!(parse_shard("2/4"), Ok(Shard { index: 2, count: 4 }));
        for text in ["", "0/4", "5/4", "1/0", "1", "a/b"] {
            assert!(parse_shard(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sets() {
        assert_eq!(
            parse_set("e/jbu.lambda_z = 5"),
            Ok(("e/jbu.lambda_z".into(), "5".into()))
        );
        for text in ["", "a.b", "a.b=", "b=1"] {
            assert!(parse_set(text).is_err(), "{text}");
        }
    }
}
